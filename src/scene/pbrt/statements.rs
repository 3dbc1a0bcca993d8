//! The graphics state: which material is current at each shape.

use super::build::{Build, Outcome, Statement};
use super::directives::{Directive, directive, skip, string};
use super::lookup::{Files, Given, hint};
use super::materials::{self, material};
use super::parameters::{Parameters, Unknown, parameters};
use super::scopes::Scopes;
use super::textures::{self, Textures};
use super::tokens::{Lexer, Place, Source, Token, quote};
use super::{LARGEST, include, unread};
use crate::scene::error::SceneError;
use crate::scene::{MOST_MATERIALS, too_large};
use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

/// Most attributes and objects that are open at once.
const DEEPEST: usize = 1 << 16;
/// Most files that are open at once.
const MOST_FILES: usize = 16;
/// Longest name of a material, in bytes.
const LONGEST_NAME: usize = 4096;

/// A material that some statement defines.
pub(super) struct Definition {
    /// What people know it by: its name, or its type and line.
    pub(super) label: String,
    pub(super) statement: Statement,
    pub(super) outcome: Outcome,
    /// Its type.
    kind: String,
    own: Parameters,
    /// Those that a mixture is made of.
    pub(super) parts: Vec<Rc<Definition>>,
    /// Levels of mixtures within it.
    depth: usize,
    /// Whether a shape of the scene has it.
    pub(super) used: Cell<bool>,
    /// Variants by the parameters of shapes, under the text of those.
    variants: RefCell<HashMap<String, Rc<Definition>>>,
}

/// Reads a scene statement by statement.
pub(super) struct Reader {
    pub(super) files: Files,
    /// In the order of the scene.
    pub(super) definitions: Vec<Rc<Definition>>,
    default: Rc<Definition>,
    current: Rc<Definition>,
    named: Scopes<Rc<Definition>>,
    textures: Textures,
    /// The materials that are current again when attributes end.
    outer: Vec<(Rc<Definition>, Place)>,
    world: World,
    /// Materials of the shapes of each object until the object is used.
    objects: HashMap<String, Object>,
    /// The object that is being defined, and how many attributes were open before.
    object: Option<String>,
    /// Files that are open, by their true names.
    open: Vec<PathBuf>,
    bytes: usize,
    source: String,
}

/// The materials of an object.
#[derive(Default)]
struct Object {
    materials: Vec<Rc<Definition>>,
    known: HashSet<*const Definition>,
    used: bool,
}

/// Where in the scene the reader is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum World {
    /// A file without WorldBegin, or before it.
    Before,
    Inside,
    After,
}

impl Reader {
    pub(super) fn new(source: &Rc<Source>, files: Files) -> Result<Self, SceneError> {
        let own = Parameters::default();
        let statement = Statement {
            what: "the default material, matte".to_owned(),
            place: Lexer::new(source.clone()).place(&Token {
                what: super::tokens::What::Word,
                span: 0..0,
                line: 1,
            }),
            implied: true,
        };
        let textures = Textures::default();
        let given = Given {
            shape: None,
            own: &own,
            textures: &textures,
            files: &files,
        };
        let outcome = material("matte", Build::new(given, &statement), &[])?;
        let default = Rc::new(Definition {
            label: "default matte".to_owned(),
            statement,
            outcome,
            kind: "matte".to_owned(),
            own,
            parts: Vec::new(),
            depth: 0,
            used: Cell::new(false),
            variants: RefCell::default(),
        });
        Ok(Self {
            files,
            definitions: vec![default.clone()],
            current: default.clone(),
            default,
            named: Scopes::default(),
            textures,
            outer: Vec::new(),
            world: World::Before,
            objects: HashMap::new(),
            object: None,
            open: Vec::new(),
            bytes: 0,
            source: source.name.clone(),
        })
    }

    /// Reads the file `source`, whose true name is `name`.
    pub(super) fn read(&mut self, source: Rc<Source>, name: PathBuf) -> Result<(), SceneError> {
        self.bytes = self.bytes.saturating_add(source.text.len());
        if self.bytes > LARGEST {
            return Err(too_large(&self.source, "bytes with all that it includes", LARGEST));
        }
        self.open.push(name);
        let mut lexer = Lexer::new(source);
        while let Some(token) = lexer.next()? {
            self.statement(&mut lexer, &token)?;
        }
        self.open.pop();
        Ok(())
    }

    /// Tells about what the end of the scene leaves open.
    pub(super) fn end(&mut self) {
        if let Some((_, place)) = self.outer.last() {
            let count = self.outer.len();
            let what = format!("no end of this, of {count} that are open: is the file complete?");
            self.files.warnings.add(place, what);
        } else if self.world == World::Inside {
            self.files.warnings.note("there is no WorldEnd: is the file complete?");
        }
    }

    fn statement(&mut self, lexer: &mut Lexer, token: &Token) -> Result<(), SceneError> {
        let place = lexer.place(token);
        match directive(lexer, token)? {
            Directive::Skipped(arguments) => skip(lexer, arguments),
            Directive::AttributeBegin => self.begin(place),
            Directive::AttributeEnd => {
                self.close(&place);
                Ok(())
            }
            Directive::Include => self.include(lexer),
            Directive::Material => self.material(lexer, &place),
            Directive::MakeNamedMaterial => self.make_named(lexer, &place),
            Directive::NamedMaterial => self.named(lexer),
            Directive::ObjectBegin => {
                let (name, _) = string(lexer, "the name of an object in quotes follows")?;
                self.begin(place)?;
                self.objects.insert(name.clone(), Object::default());
                self.object = Some(name);
                Ok(())
            }
            Directive::ObjectEnd => {
                if self.object.take().is_none() {
                    self.files
                        .warnings
                        .add(&place, "no object begins before this ObjectEnd");
                }
                self.close(&place);
                Ok(())
            }
            Directive::ObjectInstance => self.instance(lexer),
            Directive::Shape => self.shape(lexer, &place),
            Directive::Texture => self.texture(lexer),
            Directive::WorldBegin => {
                self.world_begins(&place);
                Ok(())
            }
            Directive::WorldEnd => {
                self.end_of_world(&place);
                Ok(())
            }
        }
    }

    fn begin(&mut self, place: Place) -> Result<(), SceneError> {
        if self.outer.len() == DEEPEST {
            return Err(place.refuse(format!(
                "this is not allowed: at most {DEEPEST} attributes and objects are open at once"
            )));
        }
        self.outer.push((self.current.clone(), place));
        self.named.open();
        self.textures.open();
        Ok(())
    }

    fn close(&mut self, place: &Place) {
        let Some((current, _)) = self.outer.pop() else {
            self.files.warnings.add(place, "nothing is open that this could end");
            return;
        };
        self.current = current;
        self.named.close();
        self.textures.close();
    }

    /// Forgets what was set, as the beginning and the end of a world do.
    fn reset(&mut self) {
        self.current = self.default.clone();
        self.named = Scopes::default();
        self.textures = Textures::default();
        self.outer.clear();
        self.objects.clear();
        self.object = None;
    }

    fn world_begins(&mut self, place: &Place) {
        match self.world {
            World::Inside => {
                self.files
                    .warnings
                    .add(place, "the world has begun before: this WorldBegin is ignored");
                return;
            }
            World::Before if self.definitions.len() > 1 || self.default.used.get() => {
                let what = "materials and shapes before WorldBegin are ignored, as pbrt does";
                self.files.warnings.add(place, what);
                self.default.used.set(false);
                self.default.variants.borrow_mut().clear();
                self.definitions.truncate(1);
            }
            World::Before | World::After => {}
        }
        self.reset();
        self.world = World::Inside;
    }

    fn end_of_world(&mut self, place: &Place) {
        if self.world != World::Inside {
            self.files.warnings.add(place, "no WorldBegin before this WorldEnd");
        }
        if let Some((_, begun)) = self.outer.last() {
            self.files.warnings.add(begun, "no end of this before WorldEnd");
        }
        if self.world == World::Inside {
            self.reset();
            self.world = World::After;
        }
    }

    fn include(&mut self, lexer: &mut Lexer) -> Result<(), SceneError> {
        let (name, token) = string(lexer, "the name of a file in quotes follows")?;
        let place = lexer.place(&token);
        let (source, path) = include(&name, &place, &self.files.root)?;
        if self.open.contains(&path) {
            return Err(place.refuse(format!(
                "\"{}\" is not allowed: a file cannot include itself, not even by way of another",
                quote(&name)
            )));
        }
        if self.open.len() == MOST_FILES {
            return Err(place.refuse(format!(
                "\"{}\" is not allowed: at most {MOST_FILES} files are open at once, each included by the one before",
                quote(&name)
            )));
        }
        self.read(source, path)
    }

    fn material(&mut self, lexer: &mut Lexer, place: &Place) -> Result<(), SceneError> {
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

    fn make_named(&mut self, lexer: &mut Lexer, place: &Place) -> Result<(), SceneError> {
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
        let kind = own.get("type", super::parameters::Family::String);
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

    fn named(&mut self, lexer: &mut Lexer) -> Result<(), SceneError> {
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

    fn texture(&mut self, lexer: &mut Lexer) -> Result<(), SceneError> {
        let (name, _) = string(lexer, "the name of a texture in quotes follows")?;
        let (values, token) = string(lexer, "\"float\" or \"spectrum\" follows the name of a texture")?;
        let (class, at) = string(lexer, "the type of a texture in quotes follows, such as \"constant\"")?;
        let (own, _) = parameters(lexer, &textures::NAMES)?;
        match values.as_str() {
            "float" => {
                let place = lexer.place(&at);
                self.textures.declare_scalar(&name, (&class, &place), &own, &self.files)
            }
            "spectrum" | "color" => self.textures.declare_tone(&name, &class, &own, &self.files),
            _ => {
                let message = format!(
                    "\"{}\" is not allowed: a texture is of \"float\" or of \"spectrum\" (also \"color\")",
                    quote(&values)
                );
                Err(lexer.place(&token).refuse(message))
            }
        }
    }

    fn shape(&mut self, lexer: &mut Lexer, place: &Place) -> Result<(), SceneError> {
        string(lexer, "the type of a shape in quotes follows, such as \"sphere\"")?;
        let base = self.current.clone();
        let (shape, _) = parameters(lexer, materials::names(&base.kind).unwrap_or_default())?;
        let material = match shape.iter().next() {
            None => base,
            Some(_) => self.variant(&base, &shape, place)?,
        };
        match self.object.as_ref().and_then(|name| self.objects.get_mut(name)) {
            None => material.used.set(true),
            Some(object) => {
                if object.known.insert(Rc::as_ptr(&material)) {
                    object.materials.push(material);
                }
            }
        }
        Ok(())
    }

    /// The material `base` with the parameters of a shape in the place of its own.
    fn variant(
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

    fn instance(&mut self, lexer: &mut Lexer) -> Result<(), SceneError> {
        let (name, token) = string(lexer, "the name of an object in quotes follows")?;
        let warnings = &self.files.warnings;
        if self.object.is_some() {
            warnings.add(
                &lexer.place(&token),
                "an instance within an object is ignored, as pbrt does",
            );
            return Ok(());
        }
        let Some(object) = self.objects.get_mut(&name) else {
            warnings.add(&lexer.place(&token), format!("there is no object \"{}\"", quote(&name)));
            return Ok(());
        };
        if !std::mem::replace(&mut object.used, true) {
            object.materials.iter().for_each(|material| material.used.set(true));
        }
        Ok(())
    }
}
