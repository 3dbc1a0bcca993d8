//! `furnace shader`

mod profile;

use super::bake::parse_profile;
use super::{Failure, Shape, format, in_pool, load, number, output_directory};
use clap::Args;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use whitefurnace::engine::{Profile, Sizes};
use whitefurnace::export::manifest::{AxisEntry, FILE_NAME, Manifest};
use whitefurnace::export::read::{Contents, read_exr};
use whitefurnace::export::write::{check_replaceable, write_whole};
use whitefurnace::integrate::{answers, fill};
use whitefurnace::plan::{Economy, Plan, Request};
use whitefurnace::shader::{Language, SceneShader};
use whitefurnace::table::axis::{Axis, Mapping, TexelRule};

/// Arguments of `furnace shader`.
#[derive(Debug, Args)]
#[command(after_help = "\
For every table a function sample_TABLE that looks it up; for every material albedo_reflection_MATERIAL and \
albedo_transmission_MATERIAL, base_MATERIAL, the diffuse base that eq. 28 couples to a lobe, and brdf_MATERIAL where all lobes \
are isotropic microfacets or Lambertian; and of the library, furnace_*, what these use. Functions, textures and constants alone: \
paste them into a shader. The comment at the head says which file belongs to which texture and where that is bound.

The axes of tables are those of a bake with --tables DIR. Without it they are chosen as `furnace bake` chooses them, which \
computes the tables; give the same options then.

Examples:
  furnace shader --tables outputs/default
  furnace shader scene.toml --tables tables --language glsl-es --out shaders
  furnace shader --profile generic --language hlsl
  furnace shader --profile three --tables outputs/three --language glsl-es
  furnace shader scene.toml --axis sqrt-mu --resolution 32 --language hlsl")]
pub(super) struct ShaderCommand {
    /// Scene file: TOML, glTF (.gltf, .glb) or pbrt-v3 (.pbrt); without one the built-in scene is used.
    scene: Option<PathBuf>,
    /// Language: wgsl, glsl-es (3.00), glsl (4.50), hlsl or msl.
    #[arg(long, default_value = "wgsl", value_name = "LANGUAGE", value_parser = language)]
    language: Language,
    /// The tables of an engine as `furnace bake --profile` writes them, instead of a scene: lookups, albedos and compensation. With
    /// --tables those that are in that directory, in their sizes; otherwise all, in the sizes of the engine.
    #[arg(long, value_name = "NAME", value_parser = parse_profile, conflicts_with = "scene")]
    profile: Option<Profile>,
    /// Directory of a bake of this scene or profile, whose manifest.json or profile.json tells the axes of the tables.
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    #[command(flatten)]
    shape: Shape,
    /// File to write, or a directory, where it is called as the scene; standard output by default.
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Threads to use, 1 to 1024; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = number::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Print JSON instead of text: the shader, and what its functions and textures are.
    #[arg(long)]
    json: bool,
}

fn language(text: &str) -> Result<Language, String> {
    Language::from_name(text).ok_or_else(|| {
        let names = Language::ALL.map(Language::name).join(", ");
        format!("a language is one of {names}")
    })
}

impl ShaderCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let (shader, name) = match self.profile {
            Some(profile) => (self.of_profile(profile)?, profile.name().to_owned()),
            None => self.of_scene()?,
        };
        let text = shader.text(self.language)?;
        let path = match &self.out {
            Some(out) => Some(self.write(out, &name, &text)?),
            None => None,
        };
        if self.json {
            format::say(serde_json::to_string_pretty(&self.value(
                &shader,
                &text,
                path.as_deref(),
            ))?);
        } else if path.is_none() {
            format::say(text.trim_end());
        } else if let Some(path) = path {
            format::say(format!("{}: {} lines", path.display(), text.lines().count()));
        }
        Ok(())
    }

    /// The shader of a scene, and the name of its file.
    fn of_scene(&self) -> Result<(SceneShader, String), Failure> {
        if self.tables.is_some() {
            self.shape
                .refuse(|_| false, "--tables, whose manifest.json has the shape of each table")?;
        }
        let scene = load(self.scene.as_deref())?;
        let manifest = match &self.tables {
            Some(directory) => Some((directory, Manifest::read(&directory.join(FILE_NAME))?)),
            None => None,
        };
        let all_effects = manifest
            .as_ref()
            .map_or(self.shape.all_effects, |(_, manifest)| manifest.all_effects);
        let usual = Request::default();
        let request = Request {
            resolution: self.shape.resolution.unwrap_or(usual.resolution),
            roughness_resolution: self.shape.roughness_resolution.unwrap_or(usual.roughness_resolution),
            azimuth_resolution: self.shape.azimuth_resolution.unwrap_or(usual.azimuth_resolution),
            mapping: self.shape.axis.0,
            economy: if all_effects { Economy::NONE } else { Economy::FULL },
            // tables of another seed are as good
            seed: manifest.as_ref().map_or(usual.seed, |(_, manifest)| manifest.seed),
            ..usual
        };
        let mut plan = Plan::new(&scene, &request)?;
        match &manifest {
            Some((directory, manifest)) => of_bake(&mut plan, directory, manifest)?,
            None => in_pool(self.threads, || chosen(&mut plan))?,
        }
        Ok((SceneShader::new(&plan), plan.directory))
    }

    /// The shader of the tables of an engine.
    fn of_profile(&self, profile: Profile) -> Result<SceneShader, Failure> {
        let title = format!("Tables of the profile {}", profile.name());
        if let Some(directory) = &self.tables {
            self.shape
                .refuse(|_| false, "--tables, whose profile.json has the sizes of each table")?;
            return Ok(SceneShader::of_textures(
                &title,
                profile::layouts_in(directory, profile)?,
            ));
        }
        let sizes = ["--resolution", "--roughness-resolution"];
        self.shape
            .refuse(|option| sizes.contains(&option), "--profile, which fixes the layout")?;
        let sizes = Sizes {
            mu: self.shape.resolution,
            roughness: self.shape.roughness_resolution,
        };
        Ok(SceneShader::of_textures(&title, profile.layouts(sizes)?))
    }

    fn write(&self, out: &Path, name: &str, text: &str) -> Result<PathBuf, Failure> {
        // a file that is there is replaced, whatever it is called
        let is_directory = out.is_dir() || (out.extension().is_none() && fs::symlink_metadata(out).is_err());
        let path = match is_directory {
            true => {
                output_directory(out)?;
                out.join(format!("{name}.{}", self.language.extension()))
            }
            false => out.to_path_buf(),
        };
        check_replaceable(&path)?;
        match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => output_directory(parent)?,
            _ => {}
        }
        write_whole(&path, text.as_bytes())?;
        Ok(path)
    }

    fn value(&self, shader: &SceneShader, text: &str, path: Option<&Path>) -> Value {
        let tables = shader.tables.iter().map(|table| {
            let axes = table.layout.axes.iter().map(|axis| {
                json!({ "parameter": axis.axis.parameter, "min": axis.axis.min, "max": axis.axis.max,
                    "size": axis.axis.size, "coordinate": axis.shader_expression() })
            });
            let channels = table.layout.channels.iter();
            json!({
                "id": table.layout.id,
                "file": table.layout.file,
                "function": table.sampler.function,
                "arguments": table.sampler.arguments,
                "texture": table.sampler.texture,
                "sampler": format!("{}_sampler", table.sampler.texture),
                "index": table.sampler.index,
                "axes": axes.collect::<Vec<_>>(),
                "channels": channels.map(|channel| json!({ "name": channel.name, "meaning": channel.meaning })).collect::<Vec<_>>(),
            })
        });
        let materials = shader.materials.iter().map(|(name, functions)| {
            let functions = functions.iter().map(|function| {
                json!({ "name": function.name, "arguments": function.arguments, "meaning": function.meaning })
            });
            json!({ "name": name, "functions": functions.collect::<Vec<_>>() })
        });
        json!({
            "language": self.language.name(),
            "out": path.map(|path| path.display().to_string()),
            "tables": tables.collect::<Vec<_>>(),
            "materials": materials.collect::<Vec<_>>(),
            "text": text,
        })
    }
}

/// Gives the tables of `plan` the axes that they have in the directory of a bake.
fn of_bake(plan: &mut Plan, directory: &Path, manifest: &Manifest) -> Result<(), Failure> {
    let path = directory.join(FILE_NAME);
    for table in &mut plan.tables {
        let found = manifest.tables.iter().find(|entry| entry.id == table.id);
        let entry = found.ok_or_else(|| {
            let (path, scene) = (path.display(), &manifest.scene);
            format!(
                "{path} has no table {}: it is a bake of the scene \"{scene}\"; bake this one first",
                table.id
            )
        })?;
        let file = directory.join(&entry.file);
        let is_answer =
            matches!(read_exr(&file)?.contents, Contents::Table { table: found, .. } if answers(table, &found));
        if !is_answer {
            let (path, id, file) = (path.display(), &table.id, file.display());
            return Err(format!(
                "{path}: table {id}: {file} is of another model than this scene asks for: bake the scene again"
            )
            .into());
        }
        let axes: Result<Vec<Axis>, Failure> = entry.axes.iter().map(|axis| of_entry(axis, &path, &table.id)).collect();
        let axes = axes?;
        let names = |axes: &[Axis]| axes.iter().map(|axis| axis.parameter.clone()).collect::<Vec<_>>();
        let planned = table.alternatives.first().map_or(Vec::new(), |axes| names(axes));
        if names(&axes) != planned || entry.channels != table.channels.count() {
            let (path, id) = (path.display(), &table.id);
            return Err(format!(
                "{path}: table {id} has other axes or channels than this scene asks for: bake the scene again"
            )
            .into());
        }
        table.alternatives = vec![axes];
    }
    Ok(())
}

fn of_entry(entry: &AxisEntry, path: &Path, id: &str) -> Result<Axis, Failure> {
    let wrong = |what: &str| format!("{}: table {id}, axis {}: {what}", path.display(), entry.parameter);
    let mapping = Mapping::from_name(&entry.mapping)
        .ok_or_else(|| wrong(&format!("`{}` is not a mapping that this version knows", entry.mapping)))?;
    let rule = TexelRule::from_name(&entry.texel_rule)
        .ok_or_else(|| wrong(&format!("`{}` is not a texel rule: centres or ends", entry.texel_rule)))?;
    let axis = Axis::new(&entry.parameter, mapping, rule, [entry.min, entry.max], entry.size);
    Ok(axis.map_err(|error| wrong(&error.to_string()))?)
}

/// Settles which axes a bake would keep, where the plan leaves a choice.
fn chosen(plan: &mut Plan) -> Result<(), Failure> {
    for table in plan.tables.iter_mut().filter(|table| table.alternatives.len() > 1) {
        table.alternatives = vec![fill(table, &|_| {})?.axes];
    }
    Ok(())
}
