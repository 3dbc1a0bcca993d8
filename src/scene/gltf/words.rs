//! What calls for an effect, and what is left out, in the names of the file.

use super::place::quote;
use super::surface::{Dielectric, Factor, Layers};
use super::vocabulary::{ANISOTROPY, CLEARCOAT, DISPERSION, IRIDESCENCE, SHEEN, TRANSMISSION};
use crate::parameter::Number;
use crate::scene::effect::{Call, Effect, Gap};
use crate::scene::spec::ModelSpec;

/// A model, with what calls for it and what it leaves out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Made {
    pub(super) model: ModelSpec,
    pub(super) calls: Vec<Call>,
    pub(super) gaps: Vec<Gap>,
}

impl Default for Made {
    /// What scatters nothing.
    fn default() -> Self {
        Self {
            model: ModelSpec::Sum(Vec::new()),
            calls: Vec::new(),
            gaps: Vec::new(),
        }
    }
}

/// A property of an extension of a material.
pub(super) fn property(extension: &str, name: &str) -> String {
    format!("extensions.{extension}.{name}")
}

impl Factor {
    /// `property = 1 (default), times a texture`
    pub(super) fn told(self, property: &str) -> String {
        let default = if self.given { "" } else { " (default)" };
        let texture = if self.texture { ", times a texture" } else { "" };
        format!("{property} = {}{default}{texture}", Number(self.value))
    }
}

impl Made {
    /// `effect`, unless something has called for it already.
    pub(super) fn call(&mut self, effect: Effect, by: String) {
        if self.calls.iter().all(|call| call.effect != effect) {
            self.calls.push(Call { effect, by });
        }
    }

    pub(super) fn gap(&mut self, what: &str, why: impl Into<String>) {
        self.gaps.push(Gap::new(what, why));
    }

    /// The calls in the order of [`Effect::ALL`].
    pub(super) fn in_order(mut self) -> Self {
        self.calls.sort_by_key(|call| call.effect);
        self
    }

    /// Light that passes, and what becomes of it on the other side.
    pub(super) fn transmission(&mut self, dielectric: &Dielectric) {
        let by = dielectric
            .transmission
            .told(&property(TRANSMISSION, "transmissionFactor"));
        let volume = match dielectric.volume {
            true => "; the volume behind it absorbs by Beer's law, which needs no table",
            false => "",
        };
        self.call(Effect::Transmission, format!("{by}{volume}"));
        // 1 is the index of the other side as well, at every wavelength
        if dielectric.dispersion > 0.0 && dielectric.ior != 1.0 {
            let by = format!(
                "{} = {}",
                property(DISPERSION, "dispersion"),
                Number(dielectric.dispersion)
            );
            self.call(Effect::Dispersion, by);
            self.gap(
                Effect::Dispersion.name(),
                "an index that depends on the wavelength has no table: those of the material have the one index in the middle",
            );
        }
    }

    pub(super) fn anisotropy(&mut self, strength: Factor) {
        self.call(
            Effect::Anisotropy,
            strength.told(&property(ANISOTROPY, "anisotropyStrength")),
        );
        if strength.texture {
            self.gap(
                Effect::Anisotropy.name(),
                "the strength comes from a texture, and a table has no axis for it: it is taken as the factor",
            );
        }
    }

    pub(super) fn layers(&mut self, layers: &Layers) {
        if layers.sheen != [0.0; 3] {
            self.call(
                Effect::Sheen,
                format!("{} = {:?}", property(SHEEN, "sheenColorFactor"), layers.sheen),
            );
        }
        if layers.clearcoat.value > 0.0 {
            let by = layers.clearcoat.told(&property(CLEARCOAT, "clearcoatFactor"));
            self.call(Effect::Clearcoat, by);
        }
        if layers.iridescence.value > 0.0 {
            let by = layers.iridescence.told(&property(IRIDESCENCE, "iridescenceFactor"));
            self.call(Effect::Iridescence, by);
            self.gap(
                Effect::Iridescence.name(),
                "interference in a thin film has no table: those of the material are without the film",
            );
        }
    }

    /// A layer whose roughness comes from a texture, though the material has an axis of roughness already.
    pub(super) fn one_axis(&mut self, effect: Effect) {
        self.gap(
            effect.name(),
            "its roughness comes from a texture, as another one of the material does, which has one axis for that: it is taken \
             as the factor",
        );
    }

    pub(super) fn unknown(&mut self, names: &[String]) {
        for name in names {
            let shown = quote(name);
            let what = match shown.trim() {
                "" => format!("\"{shown}\""),
                _ => shown,
            };
            self.gap(
                &what,
                "the extension is not known: the tables of the material are of what the rest of it says",
            );
        }
    }
}
