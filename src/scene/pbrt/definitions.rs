//! Materials as statements and shapes define them.

use super::build::{Build, Outcome, Statement};
use super::directives::string;
use super::lookup::{Files, Given, hint};
use super::materials::{self, material};
use super::parameters::{Family, Parameters, Unknown, parameters};
use super::statements::Reader;
use super::textures::Textures;
use super::tokens::{Lexer, Place, quote};
use super::unread;
use crate::scene::error::SceneError;
use crate::scene::{MOST_MATERIALS, too_large};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// Longest name of a material, in bytes.
const LONGEST_NAME: usize = 4096;

/// A material that some statement defines.
pub(super) struct Definition {
    /// What people know it by: its name, or its type and line.
    pub(super) label: String,
    pub(super) statement: Statement,
    pub(super) outcome: Outcome,
    /// Its type.
    pub(super) kind: String,
    own: Parameters,
    /// Those that a mixture is made of.
    pub(super) parts: Vec<Rc<Definition>>,
    /// Levels of mixtures within it.
    depth: usize,
    /// Whether a shape of the scene has it.
    pub(super) used: Cell<bool>,
    /// Variants by the parameters of shapes, under the text of those.
    pub(super) variants: RefCell<HashMap<String, Rc<Definition>>>,
}

impl Definition {
    /// The material before any statement.
    pub(super) fn default(place: Place, files: &Files) -> Result<Self, SceneError> {
        let own = Parameters::default();
        let statement = Statement {
            what: "the default material, matte".to_owned(),
            place,
            implied: true,
        };
        let textures = Textures::default();
        let given = Given {
            shape: None,
            own: &own,
            textures: &textures,
            files,
        };
        let outcome = material("matte", Build::new(given, &statement), &[])?;
        Ok(Self {
            label: "default matte".to_owned(),
            statement,
            outcome,
            kind: "matte".to_owned(),
            own,
            parts: Vec::new(),
            depth: 0,
            used: Cell::new(false),
            variants: RefCell::default(),
        })
    }
}

impl Reader {
    pub(super) fn material(&mut self, lexer: &mut Lexer, place: &Place) -> Result<(), SceneError> {
        let (kind, _) = string(lexer, "the type of a material in quotes follows, such as \"matte\"")?;
        let (own, unknown) = parameters(lexer, &materials::NAMES)?;
        let shown = if kind.is_empty() { "none" } else { &kind };
        let definition = self.define(
            format!("{} at {}", quote(shown), place.label()),
            Statement {
                what: format!("Material \"{}\"", quote(&kind)),
                place: place.clone(),
                implied: false,
            },
            kind,
            own,
            &unknown,
        )?;
        self.current = definition;
        Ok(())
    }

    pub(super) fn make_named(&mut self, lexer: &mut Lexer, place: &Place) -> Result<(), SceneError> {
        let (name, token) = string(lexer, "the name of a material in quotes follows")?;
        if name.trim().is_empty() {
            return Err(lexer
                .place(&token)
                .refuse("the name of a material is not allowed to be empty"));
        }
        if name.len() > LONGEST_NAME {
            return Err(lexer.place(&token).refuse(format!(
                "\"{}\" is not allowed: the name of a material has at most {LONGEST_NAME} bytes",
                quote(&name)
            )));
        }
        let (own, unknown) = parameters(lexer, &materials::NAMES)?;
        let kind = own.get("type", Family::String);
        let Some(kind) = kind else {
            let message = format!(
                "MakeNamedMaterial \"{}\" has no type: it follows as \"string type\" \"matte\" or the like",
                quote(&name)
            );
            return Err(lexer.place(&token).refuse(message));
        };
        let kind = kind.string()?.to_owned();
        let statement = Statement {
            what: format!("MakeNamedMaterial \"{}\" of type {}", quote(&name), quote(&kind)),
            place: place.clone(),
            implied: false,
        };
        let definition = self.define(name.clone(), statement, kind, own, &unknown)?;
        self.named.define(&name, definition);
        Ok(())
    }

    pub(super) fn named(&mut self, lexer: &mut Lexer) -> Result<(), SceneError> {
        let (name, token) = string(lexer, "the name of a material in quotes follows")?;
        self.current = self.find(&name, &lexer.place(&token))?;
        Ok(())
    }

    fn find(&self, name: &str, place: &Place) -> Result<Rc<Definition>, SceneError> {
        self.named.get(name).cloned().ok_or_else(|| {
            place.refuse(format!(
                "\"{}\" is not allowed: no MakeNamedMaterial before it in this scope has that name{}",
                quote(name),
                hint(name, self.named.names())
            ))
        })
    }

    fn define(
        &mut self,
        label: String,
        statement: Statement,
        kind: String,
        own: Parameters,
        unknown: &[Unknown],
    ) -> Result<Rc<Definition>, SceneError> {
        if self.definitions.len() > MOST_MATERIALS {
            return Err(too_large(&self.source, "materials", MOST_MATERIALS));
        }
        unread::tell(&kind, &own, unknown, &self.files.warnings);
        let definition = Rc::new(self.evaluated(label, statement, kind, own, None)?);
        self.definitions.push(definition.clone());
        Ok(definition)
    }

    /// What the statement comes to, with the parameters of a shape before its own.
    fn evaluated(
        &self,
        label: String,
        statement: Statement,
        kind: String,
        own: Parameters,
        shape: Option<(&Definition, &Parameters)>,
    ) -> Result<Definition, SceneError> {
        let given = Given {
            shape: shape.map(|(_, parameters)| parameters),
            own: shape.map_or(&own, |(base, _)| &base.own),
            textures: &self.textures,
            files: &self.files,
        };
        let parts = match kind.as_str() {
            "mix" => self.parts(&given, &statement)?,
            _ => Vec::new(),
        };
        let depth = parts.iter().map(|part| part.depth + 1).max().unwrap_or(0);
        if depth > materials::DEEPEST_MIX {
            return Err(statement.place.refuse(format!(
                "this mixture is not allowed: at most {} lie within one another",
                materials::DEEPEST_MIX
            )));
        }
        let outcome = material(&kind, Build::new(given, &statement), &parts)?;
        Ok(Definition {
            label,
            statement,
            outcome,
            kind,
            own,
            parts,
            depth,
            used: Cell::new(false),
            variants: RefCell::default(),
        })
    }

    /// The two materials of a mixture.
    fn parts(&self, given: &Given<'_>, statement: &Statement) -> Result<Vec<Rc<Definition>>, SceneError> {
        let part = |name| {
            let Some((part, parameter)) = given.string(name)? else {
                let message = format!("{} has no {name}: a mixture names its two materials", statement.what);
                return Err(statement.place.refuse(message));
            };
            self.find(part, &parameter.place)
        };
        Ok(vec![part("namedmaterial1")?, part("namedmaterial2")?])
    }

    /// The material `base` with the parameters of a shape in the place of its own.
    pub(super) fn variant(
        &mut self,
        base: &Rc<Definition>,
        shape: &Parameters,
        place: &Place,
    ) -> Result<Rc<Definition>, SceneError> {
        let text = self.meaning(base, shape);
        if let Some(known) = base.variants.borrow().get(&text) {
            return Ok(known.clone());
        }
        if self.definitions.len() > MOST_MATERIALS {
            return Err(too_large(&self.source, "materials", MOST_MATERIALS));
        }
        let label = format!("{}, shape at {}", base.label, place.label());
        let statement = Statement {
            implied: false,
            ..base.statement.clone()
        };
        let statement = match base.statement.implied {
            true => Statement {
                what: "Shape with the default material, matte".to_owned(),
                place: place.clone(),
                ..statement
            },
            false => statement,
        };
        let definition = self.evaluated(
            label,
            statement,
            base.kind.clone(),
            Parameters::default(),
            Some((base, shape)),
        )?;
        let definition = Rc::new(definition);
        self.definitions.push(definition.clone());
        base.variants.borrow_mut().insert(text, definition.clone());
        Ok(definition)
    }

    /// The parameters of `shape`, and what the names among them and those of `base` stand for here.
    fn meaning(&self, base: &Definition, shape: &Parameters) -> String {
        let mut text = String::new();
        for parameter in shape.iter() {
            text += &format!("{}={:?} ", parameter.declared, parameter.values);
        }
        for parameter in shape.iter().chain(base.own.iter()) {
            if let Some(name) = parameter.as_str() {
                let scalar = self.textures.scalars.get(name).map(|texture| texture.id);
                let tone = self.textures.tones.get(name);
                let material = self.named.get(name).map(Rc::as_ptr);
                text += &format!("{scalar:?}{tone:?}{material:?} ");
            }
        }
        text
    }
}
