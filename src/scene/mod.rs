//! Scenes: which materials there are, read from TOML or from the formats in which whole scenes are exchanged.
//!
//! The reader of TOML walks the spans of the TOML document itself rather than deriving serde types, because a derived error says
//! neither what is allowed nor, inside tagged tables, where. A scene is refused at its first error: later ones are often
//! consequences.

mod bxdfs;
mod calls;
mod describe;
mod effect;
mod error;
mod facets;
mod gltf;
mod library;
mod pbrt;
mod reader;
#[cfg(test)]
mod refusals;
mod spec;
mod suggest;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod vocabulary;

pub use effect::{Call, Effect, Gap};
pub use error::{Refusal, SceneError};
pub use spec::{DistributionSpec, ModelSpec, Roughness};

use std::ffi::OsStr;
use std::fs::File;
use std::io::{Cursor, Read};
use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

/// Largest scene file in bytes. Materials are a few hundred bytes each.
const LARGEST: usize = 16 << 20;

/// Most of the characters `[`, `{`, `,`, `.` and `=` in a scene.
///
/// Every value and every table of a TOML document comes with at least one of them, and what the parser builds for one takes up
/// to 1.2 kB: with this limit no scene needs more than about 1.2 GB, where 16 MiB of dots would need twelve times that. A
/// material of the richest kind has some 33, so that thirty thousand of them fit. Those in strings and comments count too: a
/// scan that knew them from others would have to be a parser.
const MOST_MARKS: usize = 1 << 20;

/// Most materials of a scene.
const MOST_MATERIALS: usize = 1 << 16;

/// Stack of the thread that reads a scene, in bytes; only what is touched gets memory.
///
/// The TOML parser allows 80 nested values and 80 dotted keys for each, and freeing such a tree recurses to 6400 levels:
/// more than a megabyte in optimised builds, where a thread commonly has two.
const STACK: usize = 64 << 20;

/// The materials that somebody wants tables for.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Name of the scene, free text; the stem of the file name unless the file gives one.
    pub name: String,
    /// The materials in use, in the order of the file, with different names.
    pub materials: Vec<Material>,
    /// Names of the materials that the file defines and nothing uses.
    pub unused: Vec<String>,
    /// Whether rho_hh of every lobe is wanted for itself, as in a scene that lists BxDFs, and not only where a diffuse base is
    /// coupled to the lobe.
    pub means: bool,
    /// What the reader had to look past: places that are wrong without being in the way.
    pub warnings: Vec<String>,
    /// The file, as messages name it.
    pub source: String,
}

/// A named model, and what it calls for.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Free text that is not empty.
    pub name: String,
    /// What it is made of; a sum of no parts for a surface that scatters no light.
    pub model: ModelSpec,
    /// Line of its definition, counted from 1, in formats that have lines.
    pub line: Option<usize>,
    /// What it calls for, each effect once, in the order of [`Effect::ALL`].
    pub calls: Vec<Call>,
    /// What it asks for and the model leaves out.
    pub gaps: Vec<Gap>,
    /// Whether no definition in the file but the rules of its format make it.
    pub implied: bool,
}

impl Material {
    /// A material with the effects that `model` has, called for by the properties of the model as a TOML scene names them.
    pub fn new(name: impl Into<String>, model: ModelSpec) -> Self {
        Self {
            name: name.into(),
            calls: model.calls(),
            model,
            line: None,
            gaps: Vec::new(),
            implied: false,
        }
    }
}

impl Scene {
    /// A scene of `materials` with different names, whose albedos and mean albedos are wanted.
    pub fn new(name: impl Into<String>, materials: Vec<Material>) -> Self {
        Self {
            name: name.into(),
            materials,
            unused: Vec::new(),
            means: true,
            warnings: Vec::new(),
            source: String::new(),
        }
    }

    /// Reads the scene file at `path`.
    ///
    /// One whose name ends in `.pbrt` is a scene of pbrt 3. One that begins with `glTF`, or whose name ends in `.glb`, is binary
    /// glTF 2.0, and one that begins with a brace, or whose name ends in `.gltf`, is glTF 2.0 in text. Of all of these the
    /// materials are read that something uses, and no buffers, images or meshes are looked for. Any other file is TOML.
    ///
    /// It may be a pipe, of which no more is read than the format allows; the data files that a scene names are regular files.
    ///
    /// # Errors
    /// [`SceneError`] when the file cannot be read, is not UTF-8, is larger than 16 MiB or is refused by [`Scene::parse`]. Of
    /// glTF [`SceneError::Refused`] for what is not JSON, [`SceneError::Misfit`] for what keeps a material in use from being
    /// known, [`SceneError::TooLarge`] beyond 256 MiB of text, 64 MiB of JSON in a binary file, or 65536 materials. Scenes of
    /// pbrt have at most 64 MiB, with all that they include.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        if pbrt::is_named(path) {
            return pbrt::load(path);
        }
        let source = path.display().to_string();
        let unreadable = |reason| SceneError::Unreadable {
            path: source.clone(),
            reason,
        };
        let mut file = File::open(path).map_err(unreadable)?;
        let mut head = Vec::new();
        let longest = gltf::MAGIC.len() as u64;
        file.by_ref().take(longest).read_to_end(&mut head).map_err(unreadable)?;
        let format = Format::of(&head, path);
        let is_regular = file.metadata().map_err(unreadable)?.is_file();
        if format == Format::Glb && is_regular {
            return gltf::binary(&mut file, &source);
        }
        let limit = format.largest();
        let bytes = read_at_most(head, &file, limit).map_err(unreadable)?;
        let bytes = bytes.ok_or_else(|| too_large(&source, "bytes", limit))?;
        match format {
            Format::Toml => {
                let text = str::from_utf8(&bytes).map_err(|error| SceneError::NotUtf8 {
                    path: source.clone(),
                    offset: error.valid_up_to(),
                })?;
                Self::parse(text, &source)
            }
            Format::Gltf => Self::parse_gltf(&bytes, &source),
            // without the magic, too: its name calls for a message of what is missing
            Format::Glb => gltf::binary(&mut Cursor::new(bytes), &source),
        }
    }

    /// The scene that is used when none is given: the materials of [Mikkelsen 2009, figure 7], one of each further
    /// distribution, and one with a roughness axis.
    pub fn default_scene() -> Self {
        let text = include_str!("default.toml");
        Self::parse(text, "built-in scene").unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// Reads a scene from its text; `source` names it in messages.
    ///
    /// # Errors
    /// [`SceneError::Refused`] for text that is not TOML, for unknown, missing or duplicate names, and for parameters
    /// outside their legal ranges; [`SceneError::TooLarge`] beyond 16 MiB, 2^20 of the characters `[`, `{`, `,`, `.`, `=`
    /// together, or 65536 materials; [`SceneError::Unreadable`] when the system has no thread left to read it on.
    pub fn parse(text: &str, source: &str) -> Result<Self, SceneError> {
        if text.len() > LARGEST {
            return Err(too_large(source, "bytes", LARGEST));
        }
        if text.bytes().filter(|byte| b"[{,.=".contains(byte)).count() > MOST_MARKS {
            return Err(too_large(source, "of the characters [ { , . = together", MOST_MARKS));
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        on_a_deep_stack(source, || reader::scene(text, source))
    }

    /// Reads the materials of glTF 2.0 from the bytes of its file: binary when they begin with `glTF`, else text. `source` is the
    /// name of the file in messages, and its stem that of the scene; no other files are looked for.
    ///
    /// # Errors
    /// [`SceneError::NotUtf8`] and [`SceneError::Refused`] for what is not JSON, [`SceneError::Misfit`] for what keeps a material
    /// in use from being known and for a container without JSON, [`SceneError::TooLarge`] beyond 256 MiB, 64 MiB of JSON in a
    /// container, 65536 materials, or more values than describe so many.
    pub fn parse_gltf(bytes: &[u8], source: &str) -> Result<Self, SceneError> {
        if bytes.len() > gltf::LARGEST {
            return Err(too_large(source, "bytes", gltf::LARGEST));
        }
        if bytes.starts_with(gltf::MAGIC) {
            gltf::binary(&mut Cursor::new(bytes), source)
        } else {
            gltf::scene(bytes, source)
        }
    }

    /// Reads the materials of a scene of pbrt 3 from its text; `source` is the name of its file, after whose stem the scene is
    /// named and beside which the files are looked for that it includes or takes spectra from.
    ///
    /// # Errors
    /// [`SceneError::Refused`] for text that is no scene of pbrt, unknown directives, names without a definition, files that
    /// cannot be used, and parameters outside their legal ranges; [`SceneError::NotUtf8`] for an included file that is not;
    /// [`SceneError::TooLarge`] beyond 64 MiB with all includes, or 65536 materials.
    pub fn parse_pbrt(text: &str, source: &str) -> Result<Self, SceneError> {
        pbrt::scene(text, source)
    }
}

/// Runs `read` on a thread with [`STACK`] bytes of stack.
fn on_a_deep_stack(source: &str, read: impl FnOnce() -> Result<Scene, SceneError> + Send) -> Result<Scene, SceneError> {
    thread::scope(|scope| {
        let reader = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, read);
        let reader = reader.map_err(|reason| SceneError::Unreadable {
            path: source.to_owned(),
            reason,
        })?;
        reader.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

/// What a scene file is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    /// The format of this crate.
    Toml,
    /// glTF, text.
    Gltf,
    /// glTF, binary.
    Glb,
}

impl Format {
    /// That of the file at `path`, which begins with `head`.
    fn of(head: &[u8], path: &Path) -> Self {
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        match ending.as_deref().and_then(OsStr::to_str) {
            _ if head.starts_with(gltf::MAGIC) => Self::Glb,
            Some("glb") => Self::Glb,
            Some("gltf") => Self::Gltf,
            // no TOML begins so
            _ if head.trim_ascii_start().starts_with(b"{") => Self::Gltf,
            _ => Self::Toml,
        }
    }

    /// Largest file in bytes, of binary glTF one that comes through a pipe.
    fn largest(self) -> usize {
        match self {
            Self::Toml => LARGEST,
            Self::Gltf | Self::Glb => gltf::LARGEST,
        }
    }
}

/// The name of a scene whose file gives it none: that of the file.
fn stem(source: &str) -> String {
    let stem = Path::new(source).file_stem().map(|stem| stem.to_string_lossy());
    stem.map_or_else(|| source.to_owned(), |stem| stem.into_owned())
}

/// The bytes of a file that begins with `head` and goes on with `file`, `None` when there are more than `limit`.
fn read_at_most(head: Vec<u8>, file: &File, limit: usize) -> std::io::Result<Option<Vec<u8>>> {
    if file.metadata()?.len() > limit as u64 {
        return Ok(None);
    }
    let mut bytes = head;
    // pipes and devices do not say how long they are
    let most = (limit as u64 + 1).saturating_sub(bytes.len() as u64);
    file.take(most).read_to_end(&mut bytes)?;
    Ok((bytes.len() <= limit).then_some(bytes))
}

fn too_large(source: &str, what: &'static str, limit: usize) -> SceneError {
    SceneError::TooLarge {
        path: source.to_owned(),
        what,
        limit,
    }
}
