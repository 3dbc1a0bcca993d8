//! What the properties of a material say, with the defaults of the specification.

/// A factor, and whether a texture scales it to something between 0 and the factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Factor {
    pub(super) value: f64,
    /// Whether the file gives it; the specification does otherwise.
    pub(super) given: bool,
    pub(super) texture: bool,
}

/// The properties that decide what a surface is made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surface {
    pub(super) base: Base,
    /// Extensions that this reader does not know.
    pub(super) unknown: Vec<String>,
    /// Whether it is defined along tangents.
    pub(super) tangents: bool,
}

/// What lies below the layers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Base {
    /// Shown in its colour whatever the light does.
    Unlit,
    /// Specular and diffuse colours of their own.
    SpecularGlossiness(SpecularGlossiness),
    /// A metal, a dielectric or a mixture, with the layers that only these have.
    MetallicRoughness(MetallicRoughness, Dielectric, Layers),
}

/// `pbrMetallicRoughness`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MetallicRoughness {
    pub(super) colour: [f64; 3],
    pub(super) metallic: Factor,
    pub(super) roughness: Factor,
}

/// `KHR_materials_pbrSpecularGlossiness`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpecularGlossiness {
    pub(super) diffuse: [f64; 3],
    pub(super) specular: [f64; 3],
    pub(super) glossiness: Factor,
}

/// The extensions of the dielectric part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dielectric {
    pub(super) ior: f64,
    pub(super) specular: Factor,
    pub(super) specular_colour: [f64; 3],
    pub(super) transmission: Factor,
    pub(super) volume: bool,
    /// Whether that volume has a thickness: without one the surface is a thin wall, which does not refract.
    pub(super) thick: bool,
    pub(super) dispersion: f64,
}

/// The extensions of both parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layers {
    pub(super) clearcoat: Factor,
    pub(super) clearcoat_roughness: Factor,
    pub(super) sheen: [f64; 3],
    pub(super) sheen_roughness: Factor,
    pub(super) iridescence: Factor,
    pub(super) anisotropy: Factor,
}

impl Factor {
    /// The value that the specification gives it.
    pub(super) const fn default(value: f64) -> Self {
        Self {
            value,
            given: false,
            texture: false,
        }
    }
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            colour: [1.0; 3],
            metallic: Factor::default(1.0),
            roughness: Factor::default(1.0),
        }
    }
}

impl MetallicRoughness {
    /// Whether any of it is a dielectric.
    pub(super) fn is_partly_dielectric(&self) -> bool {
        self.metallic.value < 1.0 || self.metallic.texture
    }
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse: [1.0; 3],
            specular: [1.0; 3],
            glossiness: Factor::default(1.0),
        }
    }
}

impl Default for Dielectric {
    fn default() -> Self {
        Self {
            ior: 1.5,
            specular: Factor::default(1.0),
            specular_colour: [1.0; 3],
            transmission: Factor::default(0.0),
            volume: false,
            thick: false,
            dispersion: 0.0,
        }
    }
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            clearcoat: Factor::default(0.0),
            clearcoat_roughness: Factor::default(0.0),
            sheen: [0.0; 3],
            sheen_roughness: Factor::default(0.0),
            iridescence: Factor::default(0.0),
            anisotropy: Factor::default(0.0),
        }
    }
}

/// The material of primitives that name none.
impl Default for Surface {
    fn default() -> Self {
        let base = Base::MetallicRoughness(Default::default(), Default::default(), Default::default());
        Self {
            base,
            unknown: Vec::new(),
            tangents: false,
        }
    }
}
