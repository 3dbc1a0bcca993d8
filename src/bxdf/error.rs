//! Why a model cannot be made of the parts it was given.

use crate::parameter::ParameterError;
use thiserror::Error;

/// Parts that make no model.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ModelError {
    /// A parameter outside its legal range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Smith masking of a distribution that has no exact Lambda.
    #[error(
        "masking \"{masking}\" is not allowed with distribution \"{distribution}\": it goes with beckmann and ggx only"
    )]
    SmithNeedsSlopes {
        /// Name of the masking.
        masking: &'static str,
        /// Name of the distribution.
        distribution: &'static str,
    },
    /// Facets that stand off the surface with a masking of others, or the reverse.
    #[error(
        "masking \"{masking}\" is not allowed with distribution \"{distribution}\": charlie goes with neubelt and charlie \
         only, and those with nothing else"
    )]
    SheenNeedsCharlie {
        /// Name of the masking.
        masking: &'static str,
        /// Name of the distribution.
        distribution: &'static str,
    },
    /// A layer that transmits light, or reflects none.
    #[error("the top of layers reflects and lets nothing through: what lies below gets what the veil leaves")]
    LayerLetsThrough,
    /// The veil of a Fresnel term, of a layer that has none.
    #[error("veil \"fresnel\" is not allowed: it goes with a microfacet or a specular-reflection on top")]
    LayerWithoutFresnel,
    /// A coat of facets that stand off the surface.
    #[error("distribution \"charlie\" is not allowed in a fresnel-blend: a coat has facets that lie in the surface")]
    CoatOfCharlie,
    /// A masking of rough refraction other than the two of Smith.
    #[error("masking \"{masking}\" is not allowed with a rough-dielectric: it takes smith or smith-correlated")]
    NeedsSmith {
        /// Name of the masking.
        masking: &'static str,
    },
    /// Media whose indices are as good as equal.
    #[error(
        "indices {eta_a} and {eta_b} of a rough interface are as good as equal: no facet bends light where their quotient is within \
         1e-6 of 1; a fresnel-specular is the model of that"
    )]
    NoBend {
        /// Index above the surface.
        eta_a: f64,
        /// Index below the surface.
        eta_b: f64,
    },
}
