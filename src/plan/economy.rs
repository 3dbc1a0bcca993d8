//! What a plan may save; each saving can be turned off by itself, so that it can be measured.

/// Savings of a plan. None of them costs a digit: what is left out is not called for, is a closed form, or is a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Economy {
    /// Lobes that differ only in a factor (reflectance, scale, ks) share the tables of the lobe without it.
    pub sharing: bool,
    /// Lobes under Schlick's Fresnel term share two channels, for r0 = 0 and r0 = 1, between which rho is linear in r0.
    pub split_sum: bool,
    /// A roughness axis spans what the scene has, and is left out where that is one value.
    pub own_range: bool,
    /// Closed forms and lobes that scatter nothing have no table.
    pub closed_forms: bool,
    /// rho_hh is computed where a diffuse base is coupled to a lobe, or where the scene asks for it.
    pub coupling: bool,
    /// A side of the surface that no light leaves on has no table.
    pub sides: bool,
    /// Isotropic lobes have no azimuth axis.
    pub azimuth: bool,
    /// Grey tables have one channel.
    pub channels: bool,
}

impl Economy {
    /// Only what the scene calls for.
    pub const FULL: Self = Self::all(true);
    /// Every effect for every material.
    pub const NONE: Self = Self::all(false);

    const fn all(on: bool) -> Self {
        Self {
            sharing: on,
            split_sum: on,
            own_range: on,
            closed_forms: on,
            coupling: on,
            sides: on,
            azimuth: on,
            channels: on,
        }
    }
}
