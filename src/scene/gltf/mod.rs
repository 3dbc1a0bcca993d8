//! The materials of glTF 2.0 files, text and binary [Khronos 2021].
//!
//! Buffers and images are not looked for. What stands in the way of knowing a material that is in use is an error; what is
//! wrong without standing in the way is a warning, and the scene is read.
//!
//! | what is wrong | verdict |
//! | --- | --- |
//! | no UTF-8, no JSON, two values of one name, a number beyond f64, values nested 128 deep | error |
//! | a byte order mark | warning: text is allowed to be read without it |
//! | a `.glb` of another magic or version, without JSON first, or cut off before the end of its JSON | error |
//! | a `.glb` of another length than it states, chunks behind its JSON that are cut off, unaligned, unknown or repeated | warning |
//! | `asset`, its version or its `minVersion` missing, of the wrong kind or beyond glTF 2.0 | error |
//! | `materials`, `meshes` or what they hold of the wrong kind; an index of no material | error |
//! | a factor outside its range, or a property or known extension of the wrong kind, on which the model depends | error |
//! | the same where it has no effect: beside an unlit or specular-glossiness extension, behind a factor of 0, on the dielectric part of a metal, in how a surface glows, is bent, cut out or absorbs | warning |
//! | anything at all in a material that nothing uses | warning |
//! | a texture that is not there | warning: it counts as being there |
//! | an unknown extension of a material | gap of that material |
//! | an unknown extension that is required | warning |
//! | an extension that is not declared, declared twice, or of the wrong kind at the root | warning |
//! | an extension of materials on what is none, or beside specular-glossiness; a name that no material has | warning: passed over |
//! | no tangents for a material that is defined along them | warning |
//! | other parts of the file of the wrong kind, no materials at all | warning |
//!
//! An integer may be written as 1.0, an accessor may have no view, and required extensions of variants, textures and meshes
//! are none of a reader of materials' business: all of that is valid.
//!
//! [Khronos 2021]: crate#bibliography

mod container;
mod document;
mod material;
mod model;
mod node;
mod place;
mod surface;
#[cfg(test)]
mod tests;
mod uses;
mod vocabulary;
mod words;

pub(super) use container::MAGIC;

use super::error::{Refusal, SceneError};
use super::{MOST_MATERIALS, Material, Scene, stem, too_large};
use crate::parameter::ParameterError;
use document::{ROOT, document};
use material::Reader;
use model::made;
use node::{MOST_NODES, Node, Reading};
use place::{At, Notes, Problem};
use serde::de::DeserializeSeed;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::io::{Read, Seek};
use surface::Surface;
use uses::{Uses, uses};
use vocabulary::KNOWN;

/// Largest text file in bytes; they may embed what they show.
pub(super) const LARGEST: usize = 256 << 20;

/// Most bytes of JSON in a container, which keeps embedded data elsewhere.
const MOST_JSON: usize = 64 << 20;

/// Name of the material of primitives that have none.
const DEFAULT_MATERIAL: &str = "default material";

/// The scene in the text of a `.gltf`.
pub(super) fn scene(bytes: &[u8], source: &str) -> Result<Scene, SceneError> {
    parse(bytes, 0, source, Notes::default())
}

/// The scene in a `.glb`, of which no more than the JSON is read.
pub(super) fn binary(file: &mut (impl Read + Seek), source: &str) -> Result<Scene, SceneError> {
    let mut notes = Notes::default();
    let json = container::json(file, source, &mut notes)?;
    parse(&json, container::JSON_OFFSET, source, notes)
}

/// Reads JSON whose first byte is at `offset` of the file.
fn parse(bytes: &[u8], offset: u64, source: &str, mut notes: Notes) -> Result<Scene, SceneError> {
    let text = str::from_utf8(bytes).map_err(|error| SceneError::NotUtf8 {
        path: source.to_owned(),
        offset: offset as usize + error.valid_up_to(),
    })?;
    let text = match text.strip_prefix('\u{feff}') {
        Some(rest) => {
            notes.add(
                &format!("byte {offset}"),
                "begins a byte order mark, which is not allowed; it was passed over",
            );
            rest
        }
        None => text,
    };
    let root = read(text, offset > 0, source)?;
    let root = At::new(&root, "");
    let count = match root.get("materials") {
        Some(materials) => materials.elements().map_err(|problem| problem.of(source))?.len(),
        None => 0,
    };
    if count > MOST_MATERIALS {
        return Err(too_large(source, "materials", MOST_MATERIALS));
    }
    let mut scene = materials(&root, count, &mut notes).map_err(|problem| problem.of(source))?;
    if scene.materials.is_empty() {
        let what = if count == 0 {
            "has no materials"
        } else {
            "uses none of its materials"
        };
        notes.add("the file", &format!("{what}, so that there is nothing to compute"));
    }
    scene.name = stem(source);
    scene.source = source.to_owned();
    scene.warnings = notes.into_warnings();
    Ok(scene)
}

/// The JSON in `text`, as far as it matters.
fn read(text: &str, in_chunk: bool, source: &str) -> Result<Node, SceneError> {
    let left = Cell::new(MOST_NODES);
    let mut json = serde_json::Deserializer::from_str(text);
    let reading = Reading {
        keep: ROOT,
        left: &left,
    };
    let read = reading
        .deserialize(&mut json)
        .and_then(|root| json.end().map(|()| root));
    read.map_err(|error| match left.get() {
        0 => too_large(
            source,
            "values that describe materials, meshes and what refers to them",
            MOST_NODES,
        ),
        _ => syntax_error(&error, text, in_chunk, source),
    })
}

/// The parser counts columns in bytes, and says at the end of its message where it is.
fn syntax_error(error: &serde_json::Error, text: &str, in_chunk: bool, source: &str) -> SceneError {
    let (line, column) = (error.line().max(1), error.column());
    let content = text.split('\n').nth(line - 1).unwrap_or_default();
    let content = content.strip_suffix('\r').unwrap_or(content);
    let before = &content[..content.floor_char_boundary(column.saturating_sub(1))];
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    let message = message.strip_suffix(&place).unwrap_or(&message);
    let of = if in_chunk { ", in the chunk of JSON" } else { "" };
    SceneError::Refused(Box::new(Refusal::new(
        source,
        (line, before.chars().count() + 1),
        content,
        1,
        format!("not valid JSON{of}: {message}"),
    )))
}

/// The materials of a file that has `count`, those in use first.
fn materials(root: &At<'_>, count: usize, notes: &mut Notes) -> Result<Scene, Problem> {
    let document = document(root, &KNOWN, notes)?;
    let uses = uses(root, count, notes)?;
    let mut scene = Scene::new("", Vec::new());
    scene.means = false;
    let mut names = Names::default();
    let mut told = HashSet::new();
    let elements = root.get("materials").map(|at| at.elements()).transpose()?;
    if let (Some(_), 0) = (&elements, count) {
        notes.add("materials", "is empty, which is not allowed");
    }
    for (index, at) in elements.into_iter().flatten().enumerate() {
        let name = names.of(&at, index, notes);
        let read = Reader::new(&document, notes, &mut told).surface(&at);
        let made =
            read.and_then(|surface| Ok((made(&surface).map_err(|error| unmade(&at, &error))?, surface.tangents)));
        match made {
            Err(problem) if uses.used[index] => return Err(problem),
            Err(problem) => {
                notes.excuse(&problem, "nothing uses the material");
                scene.unused.push(name);
            }
            Ok(_) if !uses.used[index] => scene.unused.push(name),
            Ok((made, tangents)) => {
                if let (true, Some(place)) = (tangents, &uses.without_tangents[index]) {
                    notes.add(place, &format!("has no tangents, along which {} is defined", at.place));
                }
                scene.materials.push(Material {
                    name,
                    model: made.model,
                    line: None,
                    calls: made.calls,
                    gaps: made.gaps,
                    implied: false,
                });
            }
        }
    }
    if uses.nameless > 0 {
        scene.materials.push(default_material(&uses, &mut names)?);
    }
    Ok(scene)
}

/// Properties that are legal make a model; should they not, that is told about the material.
fn unmade(at: &At<'_>, error: &ParameterError) -> Problem {
    Problem::new(&*at.place, format!("makes no model: {error}"))
}

/// What the primitives without a material have.
fn default_material(uses: &Uses, names: &mut Names) -> Result<Material, Problem> {
    let by = match uses.nameless {
        1 => "1 primitive that names no material".to_owned(),
        several => format!("{several} primitives that name no material"),
    };
    let made = made(&Surface::default());
    let made = made.map_err(|error| Problem::new(DEFAULT_MATERIAL, format!("makes no model: {error}")))?;
    let mut calls = made.calls;
    for call in &mut calls {
        call.by.clone_from(&by);
    }
    Ok(Material {
        name: names.unique(DEFAULT_MATERIAL.to_owned()),
        model: made.model,
        line: None,
        calls,
        gaps: made.gaps,
        implied: true,
    })
}

/// Names that were given away, with the number that the last of each base got.
#[derive(Default)]
struct Names(HashMap<String, usize>);

impl Names {
    /// The name of the material at `index`, or `material 3` when it has none.
    fn of(&mut self, at: &At<'_>, index: usize, notes: &mut Notes) -> String {
        let own = match at.get("name").map(|name| name.text().map(str::to_owned)) {
            Some(Ok(name)) => name,
            Some(Err(problem)) => {
                notes.excuse(&problem, "the material counts as having none");
                String::new()
            }
            None => String::new(),
        };
        let name = if own.trim().is_empty() {
            format!("material {index}")
        } else {
            own
        };
        self.unique(name)
    }

    /// `name`, with the first number behind it that makes it different from all others: `gold`, `gold (2)`.
    fn unique(&mut self, name: String) -> String {
        let mut number = *self.0.entry(name.clone()).and_modify(|count| *count += 1).or_insert(1);
        let mut unique = name.clone();
        while number > 1 {
            unique = format!("{name} ({number})");
            if !self.0.contains_key(&unique) {
                self.0.insert(unique.clone(), 1);
                break;
            }
            number += 1;
        }
        self.0.insert(name, number);
        unique
    }
}
