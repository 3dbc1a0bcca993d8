//! The materials of pbrt 3 scene files.
//!
//! A scene is read statement by statement for the material that is current at each shape; meshes, lights and cameras are
//! passed over as they are read, so that a scene of tens of megabytes takes seconds and no memory to speak of.

mod build;
mod definitions;
mod directives;
mod lookup;
mod materials;
mod parameters;
mod scopes;
mod spectra;
mod statements;
#[cfg(test)]
mod tests;
mod textures;
mod tokens;
mod unread;

use super::error::SceneError;
use super::library::Library;
use super::{Material, Scene, read_at_most, too_large};
use crate::regular;
use definitions::Definition;
use lookup::{Files, Warnings};
use statements::Reader;
use std::collections::{HashMap, HashSet};
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use tokens::{Place, Source};

/// Largest scene in bytes, with all the files that it includes.
const LARGEST: usize = 64 << 20;

/// Whether the name of a file says that it is one of pbrt's.
pub(super) fn is_named(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("pbrt"))
}

/// Reads the pbrt scene file at `path`.
///
/// # Errors
/// [`SceneError`] when the file cannot be read, is larger than 64 MiB, is not UTF-8, or is refused by [`scene`].
pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    let source = path.display().to_string();
    let bytes = File::open(path).and_then(|file| read_at_most(Vec::new(), &file, LARGEST));
    let bytes = bytes.map_err(|reason| SceneError::Unreadable {
        path: source.clone(),
        reason,
    })?;
    let bytes = bytes.ok_or_else(|| too_large(&source, "bytes", LARGEST))?;
    scene(text_of(&bytes, &source)?, &source)
}

/// Reads a pbrt scene from its text; `source` is the name of its file, beside which are those that it names.
///
/// # Errors
/// [`SceneError::Refused`] for text that is no pbrt scene, unknown directives, names without a definition, files that cannot
/// be used, and parameters outside their legal ranges; [`SceneError::TooLarge`] beyond 64 MiB with all includes, or 65536
/// materials.
pub(super) fn scene(text: &str, source: &str) -> Result<Scene, SceneError> {
    let main = Source::new(source, text, false);
    let files = Files {
        library: Library::default(),
        root: main.directory().to_path_buf(),
        warnings: Warnings::default(),
    };
    let mut reader = Reader::new(&main, files)?;
    let path = Path::new(source);
    reader.read(
        main.clone(),
        fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()),
    )?;
    reader.end();
    let (materials, unused) = named_apart(&reader.definitions);
    let mut warnings = reader.files.warnings.into_list();
    if materials.is_empty() {
        warnings.push("no shape has a material: nothing is in use".to_owned());
    }
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(Scene {
        unused,
        means: false,
        warnings,
        source: source.to_owned(),
        ..Scene::new(name.unwrap_or_else(|| source.to_owned()), materials)
    })
}

fn text_of<'b>(bytes: &'b [u8], source: &str) -> Result<&'b str, SceneError> {
    str::from_utf8(bytes).map_err(|error| SceneError::NotUtf8 {
        path: source.to_owned(),
        offset: error.valid_up_to(),
    })
}

/// The file `name` that is included at `place`, and its true name. It lies beside the file that includes it or, as pbrt has it,
/// beside the scene file.
fn include(name: &str, place: &Place, root: &Path) -> Result<(Rc<Source>, PathBuf), SceneError> {
    let beside = place.directory().join(name);
    let candidates = [beside.clone(), root.join(name)];
    let path = candidates.into_iter().find(|path| path.exists()).unwrap_or(beside);
    let shown = path.display().to_string();
    let refused =
        |reason: std::io::Error| place.refuse(format!("\"{}\" cannot be included: {reason}", tokens::quote(name)));
    let (file, length) = regular::open(&path).map_err(refused)?;
    let mut bytes = Vec::new();
    if length <= LARGEST as u64 {
        file.take(LARGEST as u64 + 1).read_to_end(&mut bytes).map_err(refused)?;
    }
    if length > LARGEST as u64 || bytes.len() > LARGEST {
        return Err(too_large(&shown, "bytes", LARGEST));
    }
    let source = Source::new(&shown, text_of(&bytes, &shown)?, true);
    Ok((source, fs::canonicalize(&path).map_err(refused)?))
}

/// The materials in use and the names of the others, in the order of the scene; names that come again get a number.
fn named_apart(definitions: &[Rc<Definition>]) -> (Vec<Material>, Vec<String>) {
    let mut parts: Vec<&Rc<Definition>> = definitions.iter().filter(|it| it.used.get()).collect();
    // what a mixture in use is made of is in use, though not by itself
    let mut mixed = HashSet::new();
    while let Some(definition) = parts.pop() {
        for part in &definition.parts {
            if mixed.insert(Rc::as_ptr(part)) {
                parts.push(part);
            }
        }
    }
    let (mut materials, mut unused) = (Vec::new(), Vec::new());
    let (mut taken, mut counts) = (HashSet::new(), HashMap::new());
    for definition in definitions {
        if !definition.used.get() {
            if !definition.statement.implied && !mixed.contains(&Rc::as_ptr(definition)) {
                unused.push(definition.label.clone());
            }
            continue;
        }
        let name = unique(&definition.label, &mut taken, &mut counts);
        materials.push(Material {
            name,
            model: definition.outcome.model.clone(),
            line: (!definition.statement.implied).then_some(definition.statement.place.line),
            calls: definition.outcome.calls.clone(),
            gaps: definition.outcome.gaps.clone(),
            implied: definition.statement.implied,
        });
    }
    (materials, unused)
}

/// `label`, or `label (2)` and so on when it is taken.
fn unique(label: &str, taken: &mut HashSet<String>, counts: &mut HashMap<String, usize>) -> String {
    let mut name = label.to_owned();
    let count = counts.entry(label.to_owned()).or_insert(1);
    while !taken.insert(name.clone()) {
        *count += 1;
        name = format!("{label} ({count})");
    }
    name
}
