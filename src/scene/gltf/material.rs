//! Reads the properties of a material.
//!
//! A value that the model depends on has to be right. One that has no effect, by the specification or because it calls for
//! nothing that a table could hold, gets a warning.

use super::document::{Document, misplaced};
use super::node::Node;
use super::place::{At, Notes, Problem, quote};
use super::surface::{Base, Dielectric, Factor, Layers, MetallicRoughness, SpecularGlossiness, Surface};
use super::vocabulary::{
    ANISOTROPY, CLEARCOAT, DISPERSION, EMISSIVE_STRENGTH, IOR, IRIDESCENCE, KNOWN, MATERIAL_NAMES,
    METALLIC_ROUGHNESS_NAMES, SHEEN, SPECULAR, SPECULAR_GLOSSINESS, SPECULAR_GLOSSINESS_NAMES, TEXTURE_NAMES,
    TRANSMISSION, UNLIT, VOLUME,
};
use crate::parameter::{Legal, Number};
use crate::scene::suggest::nearest;
use std::collections::HashSet;

const NO_EFFECT: &str = "it has no effect on this material";
const NO_TABLE: &str = "no table depends on it";

/// Reads a material.
pub(super) struct Reader<'n, 'd> {
    document: &'n Document<'d>,
    notes: &'n mut Notes,
    /// Extensions without a declaration that have been told.
    told: &'n mut HashSet<&'d str>,
}

fn unit(name: &'static str) -> Legal {
    Legal::new(name, 0.0, 1.0)
}

fn from(name: &'static str, min: f64) -> Legal {
    Legal::new(name, min, f64::INFINITY)
}

impl<'n, 'd> Reader<'n, 'd> {
    pub(super) fn new(document: &'n Document<'d>, notes: &'n mut Notes, told: &'n mut HashSet<&'d str>) -> Self {
        Self { document, notes, told }
    }

    /// What the material at `at` is made of.
    pub(super) fn surface(&mut self, at: &At<'d>) -> Result<Surface, Problem> {
        at.object()?;
        self.names(at, &MATERIAL_NAMES);
        let unknown = self.extensions(at)?;
        let extension = |name| at.get("extensions").and_then(|extensions| extensions.get(name));
        for name in KNOWN {
            extension(name).map(|at| at.object().map(|_| ())).transpose()?;
        }
        let unlit = extension(UNLIT);
        let glossy = extension(SPECULAR_GLOSSINESS);
        let is_plain = unlit.is_none() && glossy.is_none();
        if let Some(unlit) = &unlit {
            self.names(unlit, &[]);
        }

        let metal = self.metallic_roughness(at);
        let metal = self.judge(metal, is_plain, NO_EFFECT)?;
        let is_dielectric = is_plain && metal.is_partly_dielectric();
        let dielectric = self.dielectric(&extension, is_dielectric)?;
        let layers = self.layers(&extension, is_plain)?;
        let gloss = match &glossy {
            Some(glossy) => {
                let gloss = self.specular_glossiness(glossy);
                Some(self.judge(gloss, unlit.is_none(), NO_EFFECT)?)
            }
            None => None,
        };
        let idle = self.idle(at, &extension);
        self.judge(idle, false, NO_TABLE)?;

        if unlit.is_none() && gloss.is_some() {
            let others = KNOWN
                .iter()
                .filter(|name| ![SPECULAR_GLOSSINESS, EMISSIVE_STRENGTH].contains(name));
            for other in others.filter_map(|name| extension(name)) {
                let message = format!("was passed over: it is not allowed beside {SPECULAR_GLOSSINESS}, which wins");
                self.notes.add(&other.place, &message);
            }
        }
        let base = match (unlit, gloss) {
            (Some(_), _) => Base::Unlit,
            (None, Some(gloss)) => Base::SpecularGlossiness(gloss),
            (None, None) => Base::MetallicRoughness(metal, dielectric, layers),
        };
        Ok(Surface {
            base,
            unknown,
            tangents: at.get("normalTexture").is_none() && along_tangents(&extension),
        })
    }

    /// The value, or the default when it is wrong without being needed.
    fn judge<T: Default>(&mut self, value: Result<T, Problem>, needed: bool, why: &str) -> Result<T, Problem> {
        match value {
            Err(problem) if !needed => {
                self.notes.excuse(&problem, why);
                Ok(T::default())
            }
            other => other,
        }
    }

    /// Notes the names that are not known.
    fn names(&mut self, at: &At<'_>, known: &[&str]) {
        let Node::Object(members) = at.node else { return };
        for (name, _) in members
            .iter()
            .filter(|(name, _)| !known.contains(&name.as_str()) && name != "extensions")
        {
            // comparing a million names that nobody gets to see would take a while
            let candidates = if self.notes.is_full() { &[] } else { known };
            let meant = nearest(name, candidates.iter().copied());
            let meant = meant.map_or(String::new(), |meant| format!("; did you mean {meant}?"));
            let place = format!("{}.{}", at.place, quote(name));
            self.notes
                .add(&place, &format!("is not known and was passed over{meant}"));
        }
    }

    /// The extensions of a material that are not known.
    fn extensions(&mut self, at: &At<'d>) -> Result<Vec<String>, Problem> {
        let Some(extensions) = at.get("extensions") else {
            return Ok(Vec::new());
        };
        let mut unknown = Vec::new();
        for (name, node) in extensions.object()? {
            let place = format!("{}.{}", extensions.place, quote(name));
            if !self.document.declared.contains(name.as_str()) && self.told.insert(name) {
                self.notes.add(&place, "is not declared in extensionsUsed");
            }
            if !KNOWN.contains(&name.as_str()) {
                if let Err(problem) = At::new(node, place).object() {
                    self.notes.excuse(&problem, NO_TABLE);
                }
                unknown.push(name.clone());
            }
        }
        Ok(unknown)
    }

    /// Whether there is a texture `name`.
    fn texture(&mut self, at: &At<'_>, name: &str) -> Result<bool, Problem> {
        let Some(texture) = at.get(name) else { return Ok(false) };
        texture.object()?;
        self.names(&texture, &TEXTURE_NAMES);
        misplaced(&texture, self.notes);
        match texture.get("index") {
            None => self
                .notes
                .add(&texture.place, "has no index; the texture counts as being there"),
            Some(index) => {
                if let Err(problem) = index.index(self.document.textures, "textures") {
                    self.notes.excuse(&problem, "the texture counts as being there");
                }
            }
        }
        Ok(true)
    }

    /// A factor in [0, 1] and the texture that scales it.
    fn factor(
        &mut self,
        at: &At<'_>,
        name: &'static str,
        default: f64,
        texture: Option<&str>,
    ) -> Result<Factor, Problem> {
        let given = at.get(name);
        Ok(Factor {
            value: given.as_ref().map_or(Ok(default), |given| given.number(unit(name)))?,
            given: given.is_some(),
            texture: texture.map_or(Ok(false), |texture| self.texture(at, texture))?,
        })
    }

    fn metallic_roughness(&mut self, material: &At<'_>) -> Result<MetallicRoughness, Problem> {
        let Some(at) = material.get("pbrMetallicRoughness") else {
            return Ok(MetallicRoughness::default());
        };
        at.object()?;
        self.names(&at, &METALLIC_ROUGHNESS_NAMES);
        misplaced(&at, self.notes);
        self.texture(&at, "baseColorTexture")?;
        let texture = self.texture(&at, "metallicRoughnessTexture")?;
        let textured = |factor| Factor { texture, ..factor };
        Ok(MetallicRoughness {
            colour: colour_and_alpha(&at, "baseColorFactor")?,
            metallic: self.factor(&at, "metallicFactor", 1.0, None).map(textured)?,
            roughness: self.factor(&at, "roughnessFactor", 1.0, None).map(textured)?,
        })
    }

    fn specular_glossiness(&mut self, at: &At<'_>) -> Result<SpecularGlossiness, Problem> {
        self.names(at, &SPECULAR_GLOSSINESS_NAMES);
        misplaced(at, self.notes);
        self.texture(at, "diffuseTexture")?;
        Ok(SpecularGlossiness {
            diffuse: colour_and_alpha(at, "diffuseFactor")?,
            specular: colour(at, unit("specularFactor"), 1.0)?,
            glossiness: self.factor(at, "glossinessFactor", 1.0, Some("specularGlossinessTexture"))?,
        })
    }

    fn dielectric(
        &mut self,
        extension: &impl Fn(&'static str) -> Option<At<'d>>,
        needed: bool,
    ) -> Result<Dielectric, Problem> {
        let mut read = Dielectric::default();
        if let Some(at) = extension(IOR) {
            self.names(&at, &["ior"]);
            read.ior = match at.get("ior").map(|ior| index_of_refraction(&ior)) {
                None => read.ior,
                Some(ior) => self.judge(ior.map(Some), needed, NO_EFFECT)?.unwrap_or(read.ior),
            };
        }
        if let Some(at) = extension(SPECULAR) {
            self.names(
                &at,
                &[
                    "specularFactor",
                    "specularTexture",
                    "specularColorFactor",
                    "specularColorTexture",
                ],
            );
            let specular = self.factor(&at, "specularFactor", 1.0, Some("specularTexture"));
            let colour = colour(&at, from("specularColorFactor", 0.0), 1.0);
            let texture = self.texture(&at, "specularColorTexture");
            if let Some(specular) = self.judge(specular.map(Some), needed, NO_EFFECT)? {
                read.specular = specular;
                let needed = needed && specular.value > 0.0;
                read.specular_colour = self.judge(colour, needed, NO_EFFECT)?;
                self.judge(texture, needed, NO_EFFECT)?;
            }
        }
        if let Some(at) = extension(TRANSMISSION) {
            self.names(&at, &["transmissionFactor", "transmissionTexture"]);
            let factor = self.factor(&at, "transmissionFactor", 0.0, Some("transmissionTexture"));
            read.transmission = self
                .judge(factor.map(Some), needed, NO_EFFECT)?
                .unwrap_or(read.transmission);
        }
        if let Some(at) = extension(DISPERSION) {
            self.names(&at, &["dispersion"]);
            let dispersion = at
                .get("dispersion")
                .map_or(Ok(0.0), |at| at.number(from("dispersion", 0.0)));
            read.dispersion = self.judge(dispersion, needed && read.transmission.value > 0.0, NO_EFFECT)?;
            if extension(VOLUME).is_none() {
                self.notes
                    .add(&at.place, &format!("needs {VOLUME}, which this material does not have"));
            }
        }
        if let Some(at) = extension(VOLUME) {
            read.volume = true;
            let thickness = at.get("thicknessFactor");
            // a wrong one that nothing depends on is told of where the volume is read
            read.thick = match thickness.filter(|_| needed && read.transmission.value > 0.0) {
                Some(thickness) => thickness.number(from("thicknessFactor", 0.0))? > 0.0,
                None => false,
            };
        }
        Ok(read)
    }

    fn layers(&mut self, extension: &impl Fn(&'static str) -> Option<At<'d>>, needed: bool) -> Result<Layers, Problem> {
        let mut read = Layers::default();
        if let Some(at) = extension(CLEARCOAT) {
            let names = [
                "clearcoatFactor",
                "clearcoatTexture",
                "clearcoatRoughnessFactor",
                "clearcoatRoughnessTexture",
            ];
            self.names(&at, &[&names[..], &["clearcoatNormalTexture"]].concat());
            let factor = self.factor(&at, names[0], 0.0, Some(names[1]));
            read.clearcoat = self
                .judge(factor.map(Some), needed, NO_EFFECT)?
                .unwrap_or(read.clearcoat);
            let roughness = self.factor(&at, names[2], 0.0, Some(names[3]));
            read.clearcoat_roughness = self
                .judge(roughness.map(Some), needed && read.clearcoat.value > 0.0, NO_EFFECT)?
                .unwrap_or(read.clearcoat_roughness);
            let normal = self.texture(&at, "clearcoatNormalTexture");
            self.judge(normal, false, NO_TABLE)?;
        }
        if let Some(at) = extension(SHEEN) {
            let names = ["sheenRoughnessFactor", "sheenRoughnessTexture"];
            self.names(&at, &[&names[..], &["sheenColorFactor", "sheenColorTexture"]].concat());
            read.sheen = self.judge(colour(&at, unit("sheenColorFactor"), 0.0), needed, NO_EFFECT)?;
            let is_on = read.sheen != [0.0; 3];
            let texture = self.texture(&at, "sheenColorTexture");
            self.judge(texture, needed && is_on, NO_EFFECT)?;
            let roughness = self.factor(&at, names[0], 0.0, Some(names[1]));
            read.sheen_roughness = self
                .judge(roughness.map(Some), needed && is_on, NO_EFFECT)?
                .unwrap_or(read.sheen_roughness);
        }
        if let Some(at) = extension(IRIDESCENCE) {
            read.iridescence = self.iridescence(&at, needed)?;
        }
        if let Some(at) = extension(ANISOTROPY) {
            self.names(&at, &["anisotropyStrength", "anisotropyRotation", "anisotropyTexture"]);
            let strength = self.factor(&at, "anisotropyStrength", 0.0, Some("anisotropyTexture"));
            read.anisotropy = self
                .judge(strength.map(Some), needed, NO_EFFECT)?
                .unwrap_or(read.anisotropy);
            let rotation = at
                .get("anisotropyRotation")
                .map_or(Ok(0.0), |at| at.number(from("anisotropyRotation", f64::MIN)));
            self.judge(rotation, false, NO_TABLE)?;
        }
        Ok(read)
    }

    fn iridescence(&mut self, at: &At<'_>, needed: bool) -> Result<Factor, Problem> {
        let names = [
            "iridescenceFactor",
            "iridescenceTexture",
            "iridescenceIor",
            "iridescenceThicknessTexture",
        ];
        let ends = ["iridescenceThicknessMinimum", "iridescenceThicknessMaximum"];
        self.names(at, &[&names[..], &ends[..]].concat());
        let factor = self.factor(at, names[0], 0.0, Some(names[1]));
        let factor = self.judge(factor.map(Some), needed, NO_EFFECT)?;
        let factor = factor.unwrap_or(Factor::default(0.0));
        let needed = needed && factor.value > 0.0;
        let texture = self.texture(at, names[3]);
        self.judge(texture, needed, NO_EFFECT)?;
        for (name, min) in [(names[2], 1.0), (ends[0], 0.0), (ends[1], 0.0)] {
            let value = at.get(name).map_or(Ok(0.0), |at| at.number(from(name, min)));
            self.judge(value, needed, NO_EFFECT)?;
        }
        Ok(factor)
    }

    /// What calls for no table: how the surface is bent, glows, is cut out or absorbs what has passed it.
    fn idle(&mut self, at: &At<'_>, extension: &impl Fn(&'static str) -> Option<At<'d>>) -> Result<(), Problem> {
        for name in ["normalTexture", "occlusionTexture", "emissiveTexture"] {
            self.texture(at, name)?;
        }
        colour(at, unit("emissiveFactor"), 0.0)?;
        let check = |at: &At<'_>, legal: Legal| at.get(legal.name).map_or(Ok(0.0), |at| at.number(legal));
        check(at, from("alphaCutoff", 0.0))?;
        if let Some(at) = extension(EMISSIVE_STRENGTH) {
            self.names(&at, &["emissiveStrength"]);
            check(&at, from("emissiveStrength", 0.0))?;
        }
        if let Some(at) = extension(VOLUME) {
            self.names(
                &at,
                &[
                    "thicknessFactor",
                    "thicknessTexture",
                    "attenuationDistance",
                    "attenuationColor",
                ],
            );
            check(&at, from("thicknessFactor", 0.0))?;
            check(&at, from("attenuationDistance", f64::MIN_POSITIVE))?;
            colour(&at, unit("attenuationColor"), 1.0)?;
            self.texture(&at, "thicknessTexture")?;
        }
        Ok(())
    }
}

/// Whether a part of the material is defined along tangents.
fn along_tangents<'d>(extension: &impl Fn(&'static str) -> Option<At<'d>>) -> bool {
    let coat = extension(CLEARCOAT).and_then(|coat| coat.get("clearcoatNormalTexture"));
    coat.is_some() || extension(ANISOTROPY).is_some()
}

/// The colour in a factor of red, green and blue, each `default` unless given.
fn colour(at: &At<'_>, legal: Legal, default: f64) -> Result<[f64; 3], Problem> {
    at.get(legal.name).map_or(Ok([default; 3]), |at| at.numbers::<3>(legal))
}

/// The colour in a factor of red, green, blue and alpha, white unless given.
fn colour_and_alpha(at: &At<'_>, name: &'static str) -> Result<[f64; 3], Problem> {
    let [r, g, b, _] = at.get(name).map_or(Ok([1.0; 4]), |at| at.numbers::<4>(unit(name)))?;
    Ok([r, g, b])
}

/// 0 stands for reflecting everything.
fn index_of_refraction(at: &At<'_>) -> Result<f64, Problem> {
    match at.node {
        Node::Number(ior) if *ior == 0.0 || *ior >= 1.0 => Ok(*ior),
        Node::Number(ior) => {
            let message = format!("= {} is not allowed: ior is 0 or at least 1", Number(*ior));
            Err(Problem::new(&*at.place, message))
        }
        _ => Err(at.is_no("a number, 0 or at least 1")),
    }
}
