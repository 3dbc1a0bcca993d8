//! What engines expect of their tables: one table, a row per engine.
//!
//! Every row says what the *lookup code* of the engine reads, which is not always what the engine's own generator writes; where
//! those are known to differ the note says by how much. mu is n.v, r the perceptual roughness, alpha = r^2; `centres` is a plain
//! lookup at the coordinate, `ends` one whose code moves the coordinate by half a texel or interpolates an array from end to end.

use super::sheet::{Along, Parameter, Sheet, Side, Term};
use super::truth::Lobe;
use crate::distribution::Family;
use crate::export::formats::{Format, Language};
use crate::masking::Masking;
use crate::table::Storage;
use crate::table::axis::{Mapping, TexelRule};

/// An engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// The smallest error per byte, for shaders of one's own.
    Generic,
    /// Filament, single scattering.
    Filament,
    /// Filament, with the terms of multiple scattering and cloth: what its engine carries.
    FilamentMultiscatter,
    /// three.js.
    Three,
    /// Bevy.
    Bevy,
    /// Godot.
    Godot,
    /// The Khronos glTF sample viewer.
    Gltf,
    /// Unity's High Definition Render Pipeline.
    UnityHdrp,
    /// Unreal Engine.
    Unreal,
    /// MaterialX's GLSL library.
    MaterialX,
    /// Blender's Cycles.
    Cycles,
    /// What the OpenPBR specification asks for; it has no files of its own.
    OpenPbr,
}

/// GGX under the height-correlated Smith term, alpha = r^2: what all of these engines shade with.
const GGX: Lobe = Lobe {
    family: Family::Ggx,
    masking: Masking::SmithCorrelated,
};

/// An axis that the shader reads at the parameter itself.
const fn plain(parameter: Parameter, size: usize) -> Along {
    Along {
        parameter,
        mapping: Mapping::Linear,
        rule: TexelRule::Centres,
        flipped: false,
        size,
    }
}

/// An axis that reaches from end to end.
const fn ends(parameter: Parameter, mapping: Mapping, size: usize) -> Along {
    Along {
        parameter,
        mapping,
        rule: TexelRule::Ends,
        flipped: false,
        size,
    }
}

/// sqrt mu from end to end.
const fn root_mu(size: usize) -> Along {
    ends(Parameter::Mu, Mapping::SqrtMu, size)
}

/// r^(3/4) from end to end.
const fn bent_roughness(size: usize) -> Along {
    ends(Parameter::Roughness, Mapping::ThreeQuarters, size)
}

impl Profile {
    /// Every engine.
    pub const ALL: [Self; 12] = [
        Self::Generic,
        Self::Filament,
        Self::FilamentMultiscatter,
        Self::Three,
        Self::Bevy,
        Self::Godot,
        Self::Gltf,
        Self::UnityHdrp,
        Self::Unreal,
        Self::MaterialX,
        Self::Cycles,
        Self::OpenPbr,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generic => "generic",
            Self::Filament => "filament",
            Self::FilamentMultiscatter => "filament-multiscatter",
            Self::Three => "three",
            Self::Bevy => "bevy",
            Self::Godot => "godot",
            Self::Gltf => "gltf",
            Self::UnityHdrp => "unity-hdrp",
            Self::Unreal => "unreal",
            Self::MaterialX => "materialx",
            Self::Cycles => "cycles",
            Self::OpenPbr => "openpbr",
        }
    }

    /// The engine called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name() == name)
    }

    /// The format in which the engine takes its tables most easily.
    pub fn format(self) -> Format {
        match self {
            Self::Generic | Self::Bevy | Self::OpenPbr => Format::Ktx2,
            Self::Filament | Self::FilamentMultiscatter | Self::Three => Format::Raw,
            Self::Godot | Self::Unreal => Format::Dds,
            Self::Gltf => Format::Png,
            Self::UnityHdrp | Self::MaterialX => Format::Exr,
            Self::Cycles => Format::Source(Language::C),
        }
    }

    /// The format of one of its tables: where that knows no floats and the table has them, OpenEXR.
    pub fn format_of(self, sheet: &Sheet) -> Format {
        Some(self.format())
            .filter(|format| format.takes(sheet.storage))
            .unwrap_or(Format::Exr)
    }

    /// How the engine reads its tables and what goes with them, for people.
    pub fn note(self) -> &'static str {
        match self {
            Self::Generic => {
                "read `pair` at (sqrt mu, r^(3/4)), both from end to end: rho = mix(bias, 1 - loss, r0); `pair_mean` at r^(3/4) has \
                 1 - E_avg of the very E that the lookup reads; interfaces also at z = sqrt(|ior - 1|/(ior + 1))"
            }
            Self::Filament => {
                "textureLod(dfg, vec2(NoV, r), 0): f0 x + f90 y, cloth in z. cmgen samples roughness at (row + 1.5)/128, a texel too rough"
            }
            Self::FilamentMultiscatter => {
                "textureLod(dfg, vec2(NoV, r), 0): mix(x, y, f0), 1 + f0 (1/y - 1), cloth in z. cmgen samples roughness at \
                 (row + 1.5)/128, a texel too rough"
            }
            Self::Three => {
                "texture2D(dfgLUT, vec2(roughness, dotNV)): specularColor x + f90 y; roughness is at least 0.045"
            }
            Self::Bevy => "textureSampleLevel(dfg_lut, vec2(NdotV, r), 0): F0 x + y",
            Self::Godot => {
                "textureLod(dfg, vec2(NoV, 1 - r), 0): (f90 - f0) x + f0 y, sheen in z. Its own generator masks by Schlick's \
                 approximation, its lights by the correlated Smith term that is in these tables"
            }
            Self::Gltf => {
                "texture(u_GGXLUT, vec2(NdotV, r)): F0 x + y. Sheen exceeds 1 and so what 8 bits hold: its table is a half-float EXR"
            }
            Self::UnityHdrp => {
                "coordinates (sqrt NdotV, r) moved to texel centres: lerp(x, y, F0), 1/y - 1, and z + 0.5 of Disney diffuse"
            }
            Self::Unreal => {
                "(NoV, r): F0 x + saturate(50 F0) y. Its shader masks by an approximation of the correlated Smith term that is in \
                 this table"
            }
            Self::MaterialX => {
                "texture(u_albedoTable, vec2(NdotV, alpha)): F0 x + F90 y, 1 + F (1/(x + y) - 1); sheen in z at (NdotV, sheen roughness), \
                 whose alpha is not squared"
            }
            Self::Cycles => {
                "arrays from end to end, roughness fastest, then mu, then z = sqrt(|ior - 1|/(ior + 1)): E, E_avg, and both for \
                 glass from outside and from inside"
            }
            Self::OpenPbr => {
                "the specification names no tables. 1 - E and 1 - E_avg of metal are in the layout of Adobe's openpbr-bsdf, cosine \
                 fastest, then r, from end to end; what a dielectric reflects and lets through is at (sqrt mu, r^(3/4), z), \
                 z = sqrt(|ior - 1|/(ior + 1)), from end to end"
            }
        }
    }

    /// Its tables. `size` replaces the numbers of texels along mu, the roughness and the index where the engine leaves them open;
    /// Cycles has them in its code.
    pub fn sheets(self, size: Sizes) -> Vec<Sheet> {
        let (mu, roughness) = (Parameter::Mu, Parameter::Roughness);
        let one = |name, purpose, axes: Vec<Along>, channels: &[Term], storage| {
            vec![Sheet {
                name,
                purpose,
                lobe: GGX,
                axes,
                channels: channels.to_vec(),
                storage,
            }]
        };
        let square = |side: usize| vec![plain(mu, size.mu(side)), plain(roughness, size.roughness(side))];
        match self {
            Self::Generic => generic(size),
            Self::Filament => one(
                "dfg",
                "split sum and cloth",
                square(128),
                &[Term::Scale, Term::Bias, Term::Sheen],
                Storage::F16,
            ),
            Self::FilamentMultiscatter => one(
                "dfg_multiscatter",
                "split sum with multiple scattering, and cloth",
                square(128),
                &[Term::Bias, Term::Total, Term::Sheen],
                Storage::F16,
            ),
            Self::Three => one(
                "dfgLUT",
                "split sum",
                vec![plain(roughness, size.roughness(16)), plain(mu, size.mu(16))],
                &[Term::Scale, Term::Bias],
                Storage::F16,
            ),
            Self::Bevy => one("dfg", "split sum", square(64), &[Term::Scale, Term::Bias], Storage::F16),
            Self::Godot => one(
                "dfg_lut",
                "split sum with multiple scattering, and sheen",
                vec![
                    plain(mu, size.mu(128)),
                    Along {
                        flipped: true,
                        ..plain(roughness, size.roughness(128))
                    },
                ],
                &[Term::Bias, Term::Total, Term::Sheen],
                Storage::F16,
            ),
            Self::Gltf => [
                one(
                    "lut_ggx",
                    "split sum",
                    square(128),
                    &[Term::Scale, Term::Bias],
                    Storage::Unorm8,
                ),
                one(
                    "lut_sheen_E",
                    "albedo of sheen",
                    square(128),
                    &[Term::Sheen],
                    Storage::F16,
                ),
            ]
            .concat(),
            Self::UnityHdrp => one(
                "preintegrated_fgd",
                "split sum with multiple scattering, and Disney diffuse",
                vec![
                    root_mu(size.mu(64)),
                    ends(roughness, Mapping::Linear, size.roughness(64)),
                ],
                &[Term::Bias, Term::Total, Term::DisneyDiffuse],
                Storage::F16,
            ),
            Self::Unreal => one(
                "preintegrated_gf",
                "split sum",
                vec![plain(mu, size.mu(128)), plain(roughness, size.roughness(32))],
                &[Term::Scale, Term::Bias],
                Storage::Unorm16,
            ),
            Self::MaterialX => one(
                "albedo_table",
                "split sum, and sheen",
                vec![plain(mu, size.mu(64)), plain(Parameter::Alpha, size.roughness(64))],
                &[Term::Scale, Term::Bias, Term::Sheen],
                Storage::F16,
            ),
            Self::Cycles => cycles(),
            Self::OpenPbr => openpbr(size),
        }
    }
}

/// Numbers of texels that replace those of a profile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Along mu.
    pub mu: Option<usize>,
    /// Along the roughness.
    pub roughness: Option<usize>,
}

/// Lobes that `generic` offers, by name: GGX and Beckmann with either Smith term; alpha = m = r^2.
pub const LOBES: [(&str, Lobe); 4] = {
    const fn lobe(family: Family, masking: Masking) -> Lobe {
        Lobe { family, masking }
    }
    [
        ("ggx-smith-correlated", lobe(Family::Ggx, Masking::SmithCorrelated)),
        ("ggx-smith", lobe(Family::Ggx, Masking::Smith)),
        (
            "beckmann-smith-correlated",
            lobe(Family::Beckmann, Masking::SmithCorrelated),
        ),
        ("beckmann-smith", lobe(Family::Beckmann, Masking::Smith)),
    ]
};

impl Sizes {
    fn mu(self, usual: usize) -> usize {
        self.mu.unwrap_or(usual)
    }

    fn roughness(self, usual: usize) -> usize {
        self.roughness.unwrap_or(usual)
    }
}

/// sqrt mu, r^(3/4) and ends are the best of all that were tried for 16 x 16 and 32 x 32 texels; 1 - E keeps in f16 the digits that
/// compensation needs where E is nearly 1.
fn generic(size: Sizes) -> Vec<Sheet> {
    let (u, v) = (root_mu(size.mu(32)), bent_roughness(size.roughness(32)));
    let mut sheets = vec![
        Sheet {
            name: "pair",
            purpose: "split sum and what one reflection loses",
            lobe: GGX,
            axes: vec![u, v],
            channels: vec![Term::Bias, Term::Loss],
            storage: Storage::F16,
        },
        Sheet {
            name: "pair_mean",
            purpose: "mean of what one reflection loses, for reciprocal compensation",
            lobe: GGX,
            axes: vec![v],
            channels: vec![Term::MeanLoss],
            storage: Storage::F32,
        },
        Sheet {
            name: "sheen",
            purpose: "albedo of Charlie sheen",
            lobe: GGX,
            axes: vec![u, v],
            channels: vec![Term::Sheen],
            storage: Storage::F16,
        },
        Sheet {
            name: "coat",
            purpose: "a varnish of index 1.5: what it reflects, and what passes to the layers below",
            lobe: GGX,
            axes: vec![u, v],
            channels: vec![Term::Reflected, Term::Transmitted],
            storage: Storage::F16,
        },
    ];
    sheets.extend(glass(size));
    sheets
}

/// What an interface reflects and lets through, 16 x 16 x 16.
fn glass(size: Sizes) -> [Sheet; 2] {
    [
        (
            "dielectric",
            "a dielectric interface, light from outside",
            Side::Outside,
        ),
        (
            "dielectric_inside",
            "a dielectric interface, light from inside",
            Side::Inside,
        ),
    ]
    .map(|(name, purpose, side)| Sheet {
        name,
        purpose,
        lobe: GGX,
        axes: vec![
            root_mu(size.mu(16)),
            bent_roughness(size.roughness(16)),
            ends(Parameter::Z(side), Mapping::Linear, 16),
        ],
        channels: vec![Term::Reflected, Term::Transmitted],
        storage: Storage::F16,
    })
}

/// Those of metal are in the layout of Adobe's openpbr-bsdf; its tables of dielectrics have an axis of two halves, which stands here as z.
fn openpbr(size: Sizes) -> Vec<Sheet> {
    let along = |parameter, size| ends(parameter, Mapping::Linear, size);
    let (mu, roughness) = (Parameter::Mu, Parameter::Roughness);
    let sheet = |name, purpose, axes: &[Along], channels: &[Term], storage| Sheet {
        name,
        purpose,
        lobe: GGX,
        axes: axes.to_vec(),
        channels: channels.to_vec(),
        storage,
    };
    let (u, v) = (along(mu, size.mu(32)), along(roughness, size.roughness(32)));
    let mut sheets = vec![
        sheet(
            "ideal_metal_energy_complement",
            "what one reflection of metal loses",
            &[u, v],
            &[Term::Loss],
            Storage::Unorm16,
        ),
        sheet(
            "ideal_metal_average_energy_complement",
            "its mean",
            &[v],
            &[Term::MeanLoss],
            Storage::Unorm16,
        ),
    ];
    sheets.extend(glass(size));
    sheets
}

/// Sizes and order are those of the arrays in its sources.
fn cycles() -> Vec<Sheet> {
    let along = |parameter, size| ends(parameter, Mapping::Linear, size);
    let (mu, roughness) = (Parameter::Mu, Parameter::Roughness);
    let sheet = |name, purpose, axes: &[Along], term| Sheet {
        name,
        purpose,
        lobe: GGX,
        axes: axes.to_vec(),
        channels: vec![term],
        storage: Storage::F32,
    };
    let mut sheets = vec![
        sheet(
            "table_ggx_E",
            "albedo of metal",
            &[along(roughness, 32), along(mu, 32)],
            Term::Total,
        ),
        sheet("table_ggx_Eavg", "its mean", &[along(roughness, 32)], Term::Mean),
    ];
    for (name, mean, side) in [
        ("table_ggx_glass_E", "table_ggx_glass_Eavg", Side::Outside),
        ("table_ggx_glass_inv_E", "table_ggx_glass_inv_Eavg", Side::Inside),
    ] {
        let z = along(Parameter::Z(side), 16);
        let r = along(roughness, 16);
        sheets.push(sheet(
            name,
            "albedo of glass, both sides together",
            &[r, along(mu, 16), z],
            Term::Interface,
        ));
        sheets.push(sheet(mean, "its mean", &[r, z], Term::Mean));
    }
    sheets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_engines_and_files_differ() {
        for profile in Profile::ALL {
            assert_eq!(Profile::from_name(profile.name()), Some(profile));
            let sheets = profile.sheets(Sizes::default());
            for (k, sheet) in sheets.iter().enumerate() {
                assert!(sheets[..k].iter().all(|other| other.name != sheet.name), "{profile:?}");
                assert!(
                    profile.format_of(sheet).takes(sheet.storage),
                    "{profile:?} {}",
                    sheet.name
                );
                assert!(
                    sheet.axes.iter().all(|along| along.axis().is_ok()),
                    "{profile:?} {}",
                    sheet.name
                );
            }
        }
        assert_eq!(Profile::from_name("frostbite"), None);
    }
}
