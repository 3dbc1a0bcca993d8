//! What a material calls for, by which of its properties, and what of that no table covers.

/// An effect that a table may have to hold, or that a scene may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// A specular lobe of a conductor, or of anything that reflects like one.
    Metal,
    /// A specular lobe of an opaque dielectric, as a rule over a diffuse base.
    Dielectric,
    /// A diffuse lobe, alone or coupled to a specular one.
    Diffuse,
    /// Light that passes to the other side; the interface reflects the rest.
    Transmission,
    /// A roughness that differs along the two tangents.
    Anisotropy,
    /// A lobe of fibres that stand off the surface.
    Sheen,
    /// A second specular lobe, above all others.
    Clearcoat,
    /// Interference in a thin film.
    Iridescence,
    /// An index of refraction that depends on the wavelength.
    Dispersion,
    /// A BRDF known from measurements.
    Measured,
    /// A roughness that varies over the surface.
    RoughnessRange,
    /// A Fresnel term or measurement that differs between the channels, so that a table has three.
    Colour,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Self; 12] = [
        Self::Metal,
        Self::Dielectric,
        Self::Diffuse,
        Self::Transmission,
        Self::Anisotropy,
        Self::Sheen,
        Self::Clearcoat,
        Self::Iridescence,
        Self::Dispersion,
        Self::Measured,
        Self::RoughnessRange,
        Self::Colour,
    ];

    /// The name in plans and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metal => "metal",
            Self::Dielectric => "dielectric",
            Self::Diffuse => "diffuse",
            Self::Transmission => "transmission",
            Self::Anisotropy => "anisotropy",
            Self::Sheen => "sheen",
            Self::Clearcoat => "clearcoat",
            Self::Iridescence => "iridescence",
            Self::Dispersion => "dispersion",
            Self::Measured => "measured",
            Self::RoughnessRange => "roughness-range",
            Self::Colour => "colour",
        }
    }
}

/// An effect that a material calls for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call {
    /// The effect.
    pub effect: Effect,
    /// The property, statement or line that calls for it: `bxdf.fresnel = conductor`, `metallicFactor = 1 (default)`.
    pub by: String,
}

impl Call {
    /// `effect`, called for by `by`.
    pub fn new(effect: Effect, by: impl Into<String>) -> Self {
        Self { effect, by: by.into() }
    }
}

/// Something that a material asks for and no table covers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gap {
    /// Name of the effect, or of an extension or material type that is not known.
    pub what: String,
    /// Why there is no table, and what the tables of the material leave out without it.
    pub why: String,
}

impl Gap {
    /// `what` is not covered, `why`.
    pub fn new(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            why: why.into(),
        }
    }
}
