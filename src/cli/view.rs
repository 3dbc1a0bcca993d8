//! `furnace view`

use super::{Failure, format, in_pool, load, number, output_directory, select};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use whitefurnace::export::write::{check_replaceable, write_whole};
use whitefurnace::scene::Scene;
use whitefurnace::table::names::file_stem;
use whitefurnace::view::{Cast, SIZES, TOLERANCE, html, sheets, work};

/// Arguments of `furnace view`.
#[derive(Debug, Args)]
#[command(after_help = "\
The page is one file without any network: open it in a browser with WebGL 2, from the disk or from a server. It shows each \
isotropic microfacet lobe of the scene, alone or coupled to a diffuse base, lit and in a white furnace, with the tables that it \
samples, what they err by, and what the furnace should read. Materials that it does not show are named with the reason.

Same scene, same version, same bytes, on any number of threads.

Examples:
  furnace view                              the built-in scene, as outputs/default/view.html
  furnace view scene.toml --out tables.html
  furnace view scene.gltf --material Fabric")]
pub(super) struct View {
    /// Scene file: TOML, glTF (.gltf, .glb) or pbrt-v3 (.pbrt); without one the built-in scene is used.
    scene: Option<PathBuf>,
    /// Only this material; may be given several times.
    #[arg(long, value_name = "NAME")]
    material: Vec<String>,
    /// The file; outputs/<scene>/view.html by default.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Threads to use, 1 to 1024; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = number::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

impl View {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = load(self.scene.as_deref())?;
        let cast = Cast::new(&select(&scene.materials, &self.material)?)?;
        // an unusable place is found before the work, not after it
        let path = self.path(&scene)?;
        let bar = format::progress_of(work(&cast), "computing", "integrals");
        let sheets = in_pool(self.threads, || Ok(sheets(&cast, &|done| bar.inc(done))?))?;
        bar.finish_and_clear();
        let page = html(&scene.name, &cast, &sheets)?;
        write_whole(&path, page.as_bytes())?;
        if self.json {
            self.tell_json(&scene, &cast, &path, page.len())?;
        } else {
            tell(&scene, &cast, &path, page.len());
        }
        Ok(())
    }

    /// The file to write, whose directory exists.
    fn path(&self, scene: &Scene) -> Result<PathBuf, Failure> {
        let path = match &self.out {
            Some(path) => path.clone(),
            None => Path::new("outputs").join(file_stem(&scene.name)).join("view.html"),
        };
        if path.is_dir() || path.file_name().is_none() {
            let path = path.display();
            return Err(
                format!("--out: {path} is a directory, where the name of a file is wanted: {path}/view.html").into(),
            );
        }
        check_replaceable(&path)?;
        match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => output_directory(parent)?,
            _ => {}
        }
        Ok(path)
    }

    fn tell_json(&self, scene: &Scene, cast: &Cast, path: &Path, bytes: usize) -> Result<(), Failure> {
        let left_out = cast
            .left_out
            .iter()
            .map(|left| json!({ "name": left.name, "reason": left.reason }));
        let value = json!({
            "scene": scene.name,
            "file": path.display().to_string(),
            "bytes": bytes,
            "materials": cast.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(),
            "left_out": left_out.collect::<Vec<_>>(),
            "sizes": SIZES,
            "tolerance": TOLERANCE,
        });
        format::say(serde_json::to_string_pretty(&value)?);
        Ok(())
    }
}

fn tell(scene: &Scene, cast: &Cast, path: &Path, bytes: usize) {
    let materials = match cast.parts.len() {
        1 => "1 material".to_owned(),
        count => format!("{count} materials"),
    };
    let kib = bytes.div_ceil(1024);
    format::say(format!("{}: {materials} in {}, {kib} KiB", scene.name, path.display()));
    for left in &cast.left_out {
        format::say(format!("  {} is not shown: {}", left.name, left.reason));
    }
    format::say("Open it in a browser; it needs no network.");
}
