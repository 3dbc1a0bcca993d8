//! The names that a scene may use.

use super::suggest::nearest;
use crate::bxdf::{Coupling, Transport, Veil};
use crate::distribution::{Elliptic, Family};
use crate::masking::Masking;
use crate::parameter::{BECKMANN_M, CHARLIE_ALPHA, GGX_ALPHA, KAPPA, Legal, PHONG_N};
use std::fmt;

/// A closed set of names with their meanings.
pub(super) struct Vocabulary<T: 'static> {
    /// What the names are names of, for messages.
    pub(super) what: &'static str,
    /// The names.
    pub(super) known: &'static [(&'static str, T)],
}

/// Types of bxdfs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BxdfType {
    Lambertian,
    OrenNayar,
    Microfacet,
    FresnelBlend,
    SpecularReflection,
    SpecularTransmission,
    FresnelSpecular,
    RoughDielectric,
    BrdfToBtdf,
    Scaled,
    Sum,
    Merl,
    Irregular,
    DiffuseSpecular,
    Layered,
}

/// Types of Fresnel terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FresnelType {
    None,
    Dielectric,
    Conductor,
    ConductorApproximate,
    Schlick,
}

/// What a distribution may be: isotropic with one roughness parameter under the name that goes with the type name
/// (`phong{n}` is `blinn{exponent}`), or with one along each tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DistributionType {
    pub(super) isotropic: Option<(Family, Legal)>,
    pub(super) elliptic: Option<Elliptic>,
}

const fn distribution(family: Family, legal: Legal, elliptic: Option<Elliptic>) -> DistributionType {
    DistributionType {
        isotropic: Some((family, legal)),
        elliptic,
    }
}

pub(super) const BXDFS: Vocabulary<BxdfType> = Vocabulary {
    what: "bxdf",
    known: &[
        ("lambertian", BxdfType::Lambertian),
        ("oren-nayar", BxdfType::OrenNayar),
        ("microfacet", BxdfType::Microfacet),
        ("fresnel-blend", BxdfType::FresnelBlend),
        ("specular-reflection", BxdfType::SpecularReflection),
        ("specular-transmission", BxdfType::SpecularTransmission),
        ("fresnel-specular", BxdfType::FresnelSpecular),
        ("rough-dielectric", BxdfType::RoughDielectric),
        ("brdf-to-btdf", BxdfType::BrdfToBtdf),
        ("scaled", BxdfType::Scaled),
        ("sum", BxdfType::Sum),
        ("merl", BxdfType::Merl),
        ("irregular", BxdfType::Irregular),
        ("diffuse-specular", BxdfType::DiffuseSpecular),
        ("layered", BxdfType::Layered),
    ],
};

pub(super) const DISTRIBUTIONS: Vocabulary<DistributionType> = Vocabulary {
    what: "distribution",
    known: &[
        ("vmf", distribution(Family::Vmf, KAPPA, None)),
        (
            "beckmann",
            distribution(Family::Beckmann, BECKMANN_M, Some(Elliptic::Beckmann)),
        ),
        ("phong", distribution(Family::Phong, PHONG_N, None)),
        ("blinn", distribution(Family::Phong, EXPONENT, None)),
        (
            "ashikhmin-shirley",
            DistributionType {
                isotropic: None,
                elliptic: Some(Elliptic::AshikhminShirley),
            },
        ),
        ("ggx", distribution(Family::Ggx, GGX_ALPHA, Some(Elliptic::Ggx))),
        ("charlie", distribution(Family::Charlie, CHARLIE_ALPHA, None)),
    ],
};

/// The exponent of [`PHONG_N`] under the name that `blinn` gives it.
const EXPONENT: Legal = Legal {
    name: "exponent",
    ..PHONG_N
};

pub(super) const MASKINGS: Vocabulary<Masking> = Vocabulary {
    what: "masking",
    known: &[
        ("none", Masking::None),
        ("v-groove", Masking::VGroove),
        ("smith", Masking::Smith),
        ("smith-correlated", Masking::SmithCorrelated),
        ("neubelt", Masking::Neubelt),
        ("ashikhmin", Masking::Neubelt),
        ("charlie", Masking::Charlie),
    ],
};

/// The maskings of rough refraction.
pub(super) const SMITHS: Vocabulary<Masking> = Vocabulary {
    what: "masking",
    known: &[
        ("smith", Masking::Smith),
        ("smith-correlated", Masking::SmithCorrelated),
    ],
};

pub(super) const FRESNELS: Vocabulary<FresnelType> = Vocabulary {
    what: "fresnel",
    known: &[
        ("none", FresnelType::None),
        ("dielectric", FresnelType::Dielectric),
        ("conductor", FresnelType::Conductor),
        ("conductor-approximate", FresnelType::ConductorApproximate),
        ("schlick", FresnelType::Schlick),
    ],
};

pub(super) const TRANSPORTS: Vocabulary<Transport> = Vocabulary {
    what: "transport",
    known: &[("radiance", Transport::Radiance), ("importance", Transport::Importance)],
};

pub(super) const COUPLINGS: Vocabulary<Coupling> = Vocabulary {
    what: "coupling",
    known: &[
        ("mikkelsen", Coupling::Mikkelsen),
        ("energy-preserving", Coupling::EnergyPreserving),
    ],
};

pub(super) const VEILS: Vocabulary<Veil> = Vocabulary {
    what: "veil",
    known: &[("albedo", Veil::Albedo), ("fresnel", Veil::Fresnel)],
};

impl<T: Copy> Vocabulary<T> {
    /// What `name` means.
    ///
    /// # Errors
    /// Words that follow `... = "name" is not ...` and say what is understood.
    pub(super) fn find(&self, name: &str) -> Result<T, String> {
        if let Some((_, meaning)) = self.known.iter().find(|(word, _)| *word == name) {
            return Ok(*meaning);
        }
        let hint = match nearest(name, self.known.iter().map(|(word, _)| *word)) {
            Some(word) => format!("; did you mean \"{word}\"?"),
            None => String::new(),
        };
        Err(format!("is not allowed: {self}{hint}"))
    }
}

impl<T> fmt::Display for Vocabulary<T> {
    /// `masking is one of "none", "v-groove"`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.known.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        write!(f, "{} is one of {}", self.what, words.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_understood_or_refused() {
        assert_eq!(MASKINGS.find("v-groove"), Ok(Masking::VGroove));
        assert_eq!(
            MASKINGS.find("vgroove").unwrap_err(),
            "is not allowed: masking is one of \"none\", \"v-groove\", \"smith\", \"smith-correlated\", \
             \"neubelt\", \"ashikhmin\", \"charlie\"; did you mean \"v-groove\"?"
        );
        assert_eq!(
            DISTRIBUTIONS.find("GGX").unwrap_err(),
            "is not allowed: distribution is one of \"vmf\", \"beckmann\", \"phong\", \"blinn\", \"ashikhmin-shirley\", \
             \"ggx\", \"charlie\"; did you mean \"ggx\"?"
        );
        assert!(!BXDFS.find("").unwrap_err().contains("did you mean"));
    }
}
