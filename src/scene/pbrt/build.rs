//! What the materials share: legal values, distributions of normals, and which parameter calls for what.

use super::lookup::{Given, Scalar, Tint};
use super::parameters::Parameter;
use super::textures::Range;
use super::tokens::{Place, quote};
use crate::distribution::{Anisotropic, Elliptic, Family};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::parameter::{GGX_ALPHA, Legal, Number, ParameterError};
use crate::scene::effect::{Call, Effect, Gap};
use crate::scene::error::SceneError;
use crate::scene::spec::{DistributionSpec, ModelSpec, Roughness};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// Smallest alpha of pbrt's distributions, which takes it for any below.
const SMALLEST_ALPHA: f64 = 1e-3;
/// Smallest roughness that pbrt tells from none when it remaps.
const SMALLEST_ROUGHNESS: f64 = 1e-3;

/// The statement that a material is made by.
#[derive(Debug, Clone)]
pub(super) struct Statement {
    /// `Material "plastic"`
    pub(super) what: String,
    pub(super) place: Place,
    /// Whether no statement but pbrt's own default makes it.
    pub(super) implied: bool,
}

impl Statement {
    /// `line 12: Material "plastic"`
    pub(super) fn label(&self) -> String {
        match self.implied {
            true => self.what.clone(),
            false => format!("{}: {}", self.place.label(), self.what),
        }
    }
}

/// What a material comes to.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub(super) model: ModelSpec,
    pub(super) calls: Vec<Call>,
    pub(super) gaps: Vec<Gap>,
}

/// A colour, and the parameter that it is by.
#[derive(Debug, Clone)]
pub(super) struct Colour {
    pub(super) value: DVec3,
    pub(super) by: String,
    /// Whether it varies over the surface, so that the value is one that was chosen for it.
    pub(super) varies: bool,
}

/// A material on the way.
pub(super) struct Build<'a> {
    pub(super) given: Given<'a>,
    pub(super) statement: &'a Statement,
    /// The first parameter that stands for each effect.
    reasons: Vec<Call>,
    /// Effects that are called for without a model.
    beyond: Vec<Call>,
    gaps: Vec<Gap>,
}

/// The spectrum of three channels.
pub(super) fn spectrum(value: DVec3) -> Spectrum {
    Spectrum::rgb(value.to_array())
}

/// pbrt's alpha of the Trowbridge-Reitz distribution for a roughness that people find even: a quartic in its logarithm.
pub(super) fn remapped(roughness: f64) -> f64 {
    let x = libm::log(roughness.max(SMALLEST_ROUGHNESS));
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}

impl<'a> Build<'a> {
    pub(super) fn new(given: Given<'a>, statement: &'a Statement) -> Self {
        Self {
            given,
            statement,
            reasons: Vec::new(),
            beyond: Vec::new(),
            gaps: Vec::new(),
        }
    }

    /// `line 13: rgb Kd`, or the statement and the default.
    fn by(&self, name: &str, parameter: Option<&Parameter>) -> String {
        match parameter {
            Some(parameter) => format!("{}: {}", parameter.place.label(), parameter.declared),
            None => format!("{}, default {name}", self.statement.label()),
        }
    }

    /// The error that says `verdict` about the value of `name`.
    fn refuse(&self, parameter: Option<&Parameter>, name: &str, verdict: &str) -> SceneError {
        match parameter {
            Some(parameter) => parameter.refuse(verdict),
            None => self.statement.place.refuse(format!("{name} {verdict}")),
        }
    }

    /// That `by` calls for `effect`, if the model does at all and nothing before it did.
    pub(super) fn because(&mut self, effect: Effect, by: String) {
        if self.reasons.iter().all(|call| call.effect != effect) {
            self.reasons.push(Call { effect, by });
        }
    }

    pub(super) fn gap(&mut self, what: impl Into<String>, why: impl Into<String>) {
        self.gaps.push(Gap::new(what, why));
    }

    /// That `by` calls for `effect`, though no part of the model does.
    pub(super) fn call(&mut self, effect: Effect, by: String) {
        self.beyond.push(Call { effect, by });
    }

    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        self.given.flag(name, default)
    }

    /// A factor in [0, 1] under `name`; one that varies over the surface counts as 1, since a shader multiplies tables by it.
    /// `effects` are those that it stands for while it is not 0.
    pub(super) fn factor(&mut self, name: &'static str, default: f64, effects: &[Effect]) -> Result<DVec3, SceneError> {
        let colour = self.colour(Legal::new(name, 0.0, 1.0), DVec3::splat(default), DVec3::ONE)?;
        if colour.value != DVec3::ZERO {
            for effect in effects {
                self.because(*effect, colour.by.clone());
            }
        }
        Ok(colour.value)
    }

    /// The colour under the name of `legal`; `default` unless it is given, and `varying` where it varies over the surface.
    pub(super) fn colour(&mut self, legal: Legal, default: DVec3, varying: DVec3) -> Result<Colour, SceneError> {
        let Legal { name, .. } = legal;
        let colour = |value, by, varies| Ok(Colour { value, by, varies });
        let Some(Tint { tone, parameter }) = self.given.tint(name)? else {
            return colour(default, self.by(name, None), false);
        };
        let by = self.by(name, parameter);
        let Some(tone) = tone else {
            return colour(varying, by, true);
        };
        let wrong = tone.rgb.into_iter().find_map(|channel| legal.check(channel).err());
        match (wrong, tone.mean) {
            (None, _) => colour(DVec3::from_array(tone.rgb), by, false),
            (Some(_), Some(mean)) if legal.check(mean).is_ok() => {
                if let Some(parameter) = parameter {
                    let what = format!(
                        "{} is more saturated than red, green and blue can be: its mean {} counts in all three",
                        parameter.declared,
                        Number(mean)
                    );
                    self.given.files.warnings.add(&parameter.place, what);
                }
                colour(DVec3::splat(mean), by, false)
            }
            (Some(ParameterError { min, max, .. }), _) => {
                let verdict = format!("is not allowed: {name} lies in [{}, {}]", Number(min), Number(max));
                Err(self.refuse(parameter, name, &verdict))
            }
        }
    }

    /// The number under `name`, or `default`.
    pub(super) fn scalar(&self, name: &str, default: f64) -> Result<Scalar<'a>, SceneError> {
        Ok(self.given.scalar(name)?.unwrap_or(Scalar {
            range: Range::single(default),
            texture: None,
            parameter: None,
        }))
    }

    /// The number `scalar` within `legal`; of one that varies over the surface the largest value, and a gap.
    pub(super) fn fixed(&mut self, scalar: &Scalar<'_>, legal: Legal) -> Result<f64, SceneError> {
        let Range { min, max } = scalar.range;
        let Legal { name, .. } = legal;
        if legal.check(min).is_err() || legal.check(max).is_err() {
            let verdict = format!(
                "is not allowed: {name} lies in [{}, {}]",
                Number(legal.min),
                Number(legal.max)
            );
            return Err(self.refuse(scalar.parameter, name, &verdict));
        }
        if scalar.texture.is_some() {
            let why = format!(
                "it varies over the surface and no table has an axis for it: the tables are of {name} = {}",
                Number(max)
            );
            self.gap(name, why);
        }
        Ok(max)
    }

    /// The index of refraction of a dielectric, `eta` before `index`.
    pub(super) fn index(&mut self) -> Result<f64, SceneError> {
        let scalar = match self.given.scalar("eta")? {
            Some(scalar) => scalar,
            None => self.scalar("index", 1.5)?,
        };
        let name = scalar.parameter.map_or("index", |parameter| parameter.name);
        self.fixed(
            &scalar,
            Legal {
                name,
                ..crate::parameter::ETA
            },
        )
    }

    /// alpha for the roughness `scalar`.
    fn alpha(&self, scalar: &Scalar<'_>, name: &str, remap: bool) -> Result<Range, SceneError> {
        let Range { min, max } = scalar.range;
        let refuse = |verdict: String| Err(self.refuse(scalar.parameter, name, &verdict));
        if max < 0.0 {
            return refuse("is not allowed: a roughness is at least 0".to_owned());
        }
        // the quartic does not decrease
        let of = |roughness: f64| if remap { remapped(roughness) } else { roughness }.max(SMALLEST_ALPHA);
        let alpha = Range {
            min: of(min),
            max: of(max),
        };
        if let Err(ParameterError { min, max, value, .. }) = GGX_ALPHA.check(alpha.max) {
            return refuse(format!(
                "is not allowed: it gives alpha = {}, and alpha lies in [{}, {}]",
                Number(value),
                Number(min),
                Number(max)
            ));
        }
        Ok(alpha)
    }

    /// The distribution of normals for a roughness along each tangent.
    pub(super) fn distribution(
        &mut self,
        [u, v]: [(&str, Scalar<'_>); 2],
        remap: bool,
    ) -> Result<DistributionSpec, SceneError> {
        let (along_u, along_v) = (self.alpha(&u.1, u.0, remap)?, self.alpha(&v.1, v.0, remap)?);
        let by = |build: &Self, (name, scalar): &(&str, Scalar<'_>)| {
            let texture = scalar.parameter.and_then(Parameter::as_str);
            match texture {
                Some(texture) => format!("{} \"{}\"", build.by(name, scalar.parameter), quote(texture)),
                None => build.by(name, scalar.parameter),
            }
        };
        let isotropic = |roughness| DistributionSpec::Isotropic {
            family: Family::Ggx,
            roughness,
        };
        if along_u.is_single() && along_v.is_single() {
            if along_u == along_v {
                return Ok(isotropic(Roughness::Fixed(along_u.min)));
            }
            let pair = Anisotropic::new(Elliptic::Ggx, along_u.min, along_v.min);
            let pair = pair.map_err(|error| self.statement.place.refuse(error.to_string()))?;
            let by = format!(
                "{} and {}: alpha_x = {} and alpha_y = {}",
                by(self, &u),
                by(self, &v),
                along_u.min,
                along_v.min
            );
            self.because(Effect::Anisotropy, by);
            return Ok(DistributionSpec::Anisotropic(pair));
        }
        let (reason, both) = match along_u.is_single() {
            true => (by(self, &v), along_u.together(along_v)),
            false => (by(self, &u), along_u.together(along_v)),
        };
        self.because(Effect::RoughnessRange, reason.clone());
        if u.1.texture != v.1.texture {
            self.gap(
                Effect::Anisotropy.name(),
                "the roughness varies along each tangent by itself, and a table has no third axis for that: the tables are of \
                 lobes as rough along both tangents",
            );
            self.call(Effect::Anisotropy, reason);
        }
        Ok(isotropic(Roughness::Range {
            min: both.min,
            max: both.max,
        }))
    }

    /// The microfacet lobe of pbrt: Trowbridge-Reitz with height-correlated Smith masking.
    pub(super) fn microfacet(reflectance: DVec3, distribution: DistributionSpec, fresnel: Fresnel) -> ModelSpec {
        ModelSpec::Microfacet {
            reflectance: spectrum(reflectance),
            distribution,
            masking: Masking::SmithCorrelated,
            fresnel,
        }
    }

    /// That light passes a surface with two roughnesses, which no model here does.
    pub(super) fn rough_transmission(&mut self) {
        let by = format!("{}, rough", self.statement.label());
        self.call(Effect::Transmission, by);
        self.gap(
            Effect::Transmission.name(),
            "light that is refracted by a surface with two roughnesses is left out: what it reflects is covered",
        );
    }

    /// The error for a value that a model refuses beyond what was checked here.
    pub(super) fn refused(&self) -> impl Fn(ParameterError) -> SceneError + 'a {
        let place = &self.statement.place;
        |error| place.refuse(error.to_string())
    }

    /// The Fresnel term of a dielectric, whose index was checked.
    pub(super) fn dielectric(&self, eta: f64) -> Result<Fresnel, SceneError> {
        Fresnel::dielectric(Spectrum::grey(eta)).map_err(self.refused())
    }

    /// The sum of `parts`, with what they call for.
    pub(super) fn done(self, mut parts: Vec<ModelSpec>) -> Outcome {
        let model = match parts.len() {
            1 => parts.remove(0),
            _ => ModelSpec::Sum(parts),
        };
        let mut calls = model.calls();
        for call in &mut calls {
            let reason = self.reasons.iter().find(|reason| reason.effect == call.effect);
            call.by = reason.map_or_else(|| self.statement.label(), |reason| reason.by.clone());
        }
        Outcome {
            model,
            calls: merged(calls, self.beyond),
            gaps: self.gaps,
        }
    }
}

/// Both lists, each effect once and in order; the first reason counts.
pub(super) fn merged(mut calls: Vec<Call>, more: Vec<Call>) -> Vec<Call> {
    for call in more {
        if calls.iter().all(|known| known.effect != call.effect) {
            calls.push(call);
        }
    }
    calls.sort_by_key(|call| call.effect);
    calls
}

/// Whether a colour differs between channels.
pub(super) fn is_coloured(value: DVec3) -> bool {
    spectrum(value).channels() == Channels::Rgb
}
