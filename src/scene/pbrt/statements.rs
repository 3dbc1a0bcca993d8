//! The graphics state: which material is current at each shape.

use super::definitions::Definition;
use super::directives::{Directive, directive, skip, string};
use super::lookup::Files;
use super::materials;
use super::parameters::parameters;
use super::scopes::Scopes;
use super::textures::{self, Textures};
use super::tokens::{Lexer, Place, Source, Token, What, quote};
use super::{LARGEST, include};
use crate::scene::error::SceneError;
use crate::scene::too_large;
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

/// Most attributes and objects that are open at once.
const DEEPEST: usize = 1 << 16;
/// Most files that are open at once.
const MOST_FILES: usize = 16;

/// Reads a scene statement by statement.
pub(super) struct Reader {
    pub(super) files: Files,
    /// In the order of the scene.
    pub(super) definitions: Vec<Rc<Definition>>,
    pub(super) default: Rc<Definition>,
    pub(super) current: Rc<Definition>,
    pub(super) named: Scopes<Rc<Definition>>,
    pub(super) textures: Textures,
    /// The materials that are current again when attributes end.
    outer: Vec<(Rc<Definition>, Place)>,
    world: World,
    /// Materials of the shapes of each object until the object is used.
    objects: HashMap<String, Object>,
    /// The object that is being defined.
    object: Option<String>,
    /// Files that are open, by their true names.
    open: Vec<PathBuf>,
    bytes: usize,
    pub(super) source: String,
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
        let start = Token {
            what: What::Word,
            span: 0..0,
            line: 1,
        };
        let default = Rc::new(Definition::default(Lexer::new(source.clone()).place(&start), &files)?);
        Ok(Self {
            files,
            definitions: vec![default.clone()],
            current: default.clone(),
            default,
            named: Scopes::default(),
            textures: Textures::default(),
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
