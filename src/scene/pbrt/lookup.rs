//! What a statement gives for the name of a parameter: the shape's own value, the material's, or a texture's.

use super::parameters::{Family, Parameter, Parameters, Values};
use super::spectra::{self, Tone};
use super::textures::{Range, Textures};
use super::tokens::{Place, quote};
use crate::scene::error::SceneError;
use crate::scene::library::Library;
use crate::scene::suggest::nearest;
use std::cell::{Cell, RefCell};
use std::path::PathBuf;

/// The data files of a scene, and what was wrong with it so far.
pub(super) struct Files {
    pub(super) library: Library,
    /// The directory of the scene file.
    pub(super) root: PathBuf,
    pub(super) warnings: Warnings,
}

/// Warnings, the first of them in full.
#[derive(Default)]
pub(super) struct Warnings {
    told: RefCell<Vec<String>>,
    more: Cell<usize>,
}

/// Warnings that are told in full.
const MOST_WARNINGS: usize = 100;

impl Warnings {
    pub(super) fn add(&self, place: &Place, what: impl Into<String>) {
        self.add_with(place, || what.into());
    }

    /// The same for a warning that takes time to word: those that are only counted are not.
    pub(super) fn add_with(&self, place: &Place, what: impl FnOnce() -> String) {
        if self.told.borrow().len() >= MOST_WARNINGS {
            self.more.set(self.more.get() + 1);
        } else {
            self.note(format!("{}: {}", place.label(), what()));
        }
    }

    /// A warning about the scene as a whole.
    pub(super) fn note(&self, what: impl Into<String>) {
        self.told.borrow_mut().push(what.into());
    }

    pub(super) fn into_list(self) -> Vec<String> {
        let mut list = self.told.into_inner();
        match self.more.get() {
            0 => {}
            more => list.push(format!("{more} more warnings like these")),
        }
        list
    }
}

/// Where names are looked up.
pub(super) struct Given<'a> {
    /// The parameters of a shape, which come before those of its material.
    pub(super) shape: Option<&'a Parameters>,
    pub(super) own: &'a Parameters,
    pub(super) textures: &'a Textures,
    pub(super) files: &'a Files,
}

/// A number, or the numbers of a texture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scalar<'a> {
    pub(super) range: Range,
    /// Which declaration of a texture, where it varies over the surface.
    pub(super) texture: Option<usize>,
    /// `None` for a default.
    pub(super) parameter: Option<&'a Parameter>,
}

/// A colour; `None` where it varies over the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tint<'a> {
    pub(super) tone: Option<Tone>,
    /// `None` for a default.
    pub(super) parameter: Option<&'a Parameter>,
}

impl<'a> Given<'a> {
    /// The first of a texture and a value of `family`, in the parameters of the shape and then of the material.
    fn find(&self, name: &str, family: Family) -> Option<&'a Parameter> {
        let lists = self.shape.into_iter().chain([self.own]);
        let mut found = lists.flat_map(|list| [list.get(name, Family::Texture), list.get(name, family)]);
        found.find_map(|parameter| parameter)
    }

    /// The number called `name`; of several the first counts, as in pbrt.
    pub(super) fn scalar(&self, name: &str) -> Result<Option<Scalar<'a>>, SceneError> {
        let Some(parameter) = self.find(name, Family::Float) else {
            return Ok(None);
        };
        if parameter.kind.family() == Family::Float {
            let [value, rest @ ..] = parameter.numbers()? else {
                return Err(parameter.refuse(format!("is not allowed: {} is a number", parameter.declared)));
            };
            if !rest.is_empty() {
                let more = format!("{} has more than one value: the first counts", parameter.declared);
                self.files.warnings.add(&parameter.place, more);
            }
            return Ok(Some(Scalar {
                range: Range::single(*value),
                texture: None,
                parameter: Some(parameter),
            }));
        }
        let texture = self.textures.scalars.get(parameter.string()?);
        let Some(texture) = texture else {
            let names = self.textures.scalars.names();
            let message = format!(
                "is not allowed: no float texture has that name{}",
                hint(parameter.string()?, names)
            );
            return Err(parameter.refuse(message));
        };
        Ok(Some(Scalar {
            range: texture.range,
            texture: (!texture.range.is_single()).then_some(texture.id),
            parameter: Some(parameter),
        }))
    }

    /// The numbers called `name` as far as they can be told without an error; any texture may hold what an image does.
    pub(super) fn about(&self, name: &str, default: f64) -> Range {
        let Some(parameter) = self.find(name, Family::Float) else {
            return Range::single(default);
        };
        match (&parameter.values, parameter.as_str()) {
            (Values::Numbers(numbers), _) => Range::single(numbers.first().copied().unwrap_or(default)),
            (_, texture) => {
                let texture = texture.and_then(|name| self.textures.scalars.get(name));
                texture.map_or(Range::UNIT, |texture| texture.range)
            }
        }
    }

    /// The colour called `name`.
    pub(super) fn tint(&self, name: &str) -> Result<Option<Tint<'a>>, SceneError> {
        let Some(parameter) = self.find(name, Family::Colour) else {
            return Ok(None);
        };
        if parameter.kind.family() == Family::Colour {
            return Ok(Some(Tint {
                tone: Some(spectra::tone(parameter, self.files)?),
                parameter: Some(parameter),
            }));
        }
        let texture = self.textures.tones.get(parameter.string()?);
        let Some(tone) = texture else {
            // tables do not depend on most colours, so that this is in nobody's way; pbrt goes on with the default, too
            let name = parameter.string()?;
            self.files.warnings.add_with(&parameter.place, || {
                let hint = hint(name, self.textures.tones.names());
                format!(
                    "{} names no spectrum texture: its default counts{hint}",
                    parameter.declared
                )
            });
            return Ok(None);
        };
        Ok(Some(Tint {
            tone: *tone,
            parameter: Some(parameter),
        }))
    }

    /// The flag called `name`.
    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        self.plain(name, Family::Bool).map_or(Ok(default), Parameter::flag)
    }

    /// The string called `name`.
    pub(super) fn string(&self, name: &str) -> Result<Option<(&'a str, &'a Parameter)>, SceneError> {
        let parameter = self.plain(name, Family::String);
        parameter
            .map(|parameter| Ok((parameter.string()?, parameter)))
            .transpose()
    }

    fn plain(&self, name: &str, family: Family) -> Option<&'a Parameter> {
        let lists = self.shape.into_iter().chain([self.own]);
        lists.map(|list| list.get(name, family)).find_map(|parameter| parameter)
    }
}

/// Names that are compared with one that is not known: with all of a large scene each miss would take as long as the scene.
const MOST_COMPARED: usize = 256;

/// `; did you mean "near"?`
pub(super) fn hint<'n>(name: &str, names: impl Iterator<Item = &'n str>) -> String {
    // in an order of their own, so that the same scene gets the same message
    let mut names: Vec<&str> = names.take(MOST_COMPARED + 1).collect();
    if names.len() > MOST_COMPARED {
        return String::new();
    }
    names.sort_unstable();
    nearest(name, names).map_or(String::new(), |near| format!("; did you mean \"{}\"?", quote(near)))
}
