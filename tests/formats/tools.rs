//! Programs that read files. What is not installed is skipped, and the test says so.

use crate::skip::skip;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use whitefurnace::export::formats::{Format, facts, files};
use whitefurnace::table::texture::Texture;

/// Where `.ci/run` puts the packages of node and Python.
pub(crate) fn installed(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target").join(path)
}

/// The Python that has the packages, if they were installed beside it, or that of the system.
pub(crate) fn python() -> Command {
    let own = installed("python/bin/python3");
    Command::new(if own.exists() { own } else { "python3".into() })
}

/// What `command` prints; `None`, and a note, when the program or a module that it imports is not there.
pub(crate) fn output_of(command: &mut Command) -> Option<String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let Ok(output) = command.output() else {
        skip(format!("{program} is not installed"));
        return None;
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    if errors.contains("No module named") || errors.contains("ERR_MODULE_NOT_FOUND") {
        skip(errors.trim().lines().last().unwrap_or_default());
        return None;
    }
    let out = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command:?}: {errors}{out}");
    Some(out)
}

/// Writes each texture in `format`, and beside it `<id>.expected` with what a reader has to find.
pub(crate) fn written(directory: &Path, textures: impl Iterator<Item = Texture>, format: Format) -> Vec<Texture> {
    let write = |texture: Texture| {
        for (name, bytes) in files(&texture, format).unwrap() {
            fs::write(directory.join(name), bytes).unwrap();
        }
        let expected = json!({
            "axes": texture.axes.len(),
            "channels": texture.channels.len(),
            "size": texture.size(),
            "storage": texture.storage.name(),
            "values": texture.values,
            // layouts differ between formats, everything else does not
            "facts": facts::list(&texture, "").into_iter().filter(|(name, _)| name != "layout").collect::<Vec<_>>(),
        });
        let path = directory.join(format!("{}.expected", texture.id));
        fs::write(path, serde_json::to_string(&expected).unwrap()).unwrap();
        texture
    };
    textures.map(write).collect()
}

/// Runs a script of tests/formats on a directory; whether there was anything to run it with.
pub(crate) fn script(mut program: Command, name: &str, arguments: &[&Path]) -> bool {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(name);
    output_of(program.arg(path).args(arguments)).is_some_and(|out| {
        assert!(["48 textures", "24 textures"].contains(&out.trim()), "{out}");
        true
    })
}
