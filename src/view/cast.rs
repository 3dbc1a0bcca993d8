//! Which materials of a scene the page shows, taken apart into lobe, factors and base; and why it does not show the others.

use crate::bxdf::Coupling;
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::parameter::Number;
use crate::scene::{DistributionSpec, Material, ModelSpec, Roughness};
use crate::spectrum::Spectrum;
use glam::DVec3;
use thiserror::Error;

/// Most different sheets of a page: each takes some 200 to 600 kB of it, and a second or so.
pub const MOST_SHEETS: usize = 24;

/// What stands for the Fresnel term of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term {
    /// Two channels, the albedos for r0 = 0 and r0 = 1 of Schlick's term: every r0, and F = 1.
    Pair,
    /// One or three channels with this term.
    Own(Fresnel),
}

/// A rough surface whose roughness runs over a range: everything of a lobe but its Fresnel term.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Family of the normals.
    pub family: Family,
    /// Masking-shadowing.
    pub masking: Masking,
    /// Smallest and largest roughness, in the unit of the family.
    pub range: [f64; 2],
    /// What there are sheets for; [`Term::Pair`] first.
    pub terms: Vec<Term>,
}

/// A material as the page shows it: `ks f_s`, coupled to a base or bare.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the material, as the scene has it.
    pub name: String,
    /// Which of the surfaces.
    pub surface: usize,
    /// Which of its sheets.
    pub sheet: usize,
    /// The Fresnel term.
    pub fresnel: Fresnel,
    /// Smallest and largest roughness, equal where there is but one.
    pub roughness: [f64; 2],
    /// Scale of the lobe, its reflectance included.
    pub ks: Spectrum,
    /// Albedo of the base, 1 where there is none.
    pub kd: Spectrum,
    /// How the base is coupled, `None` where there is none.
    pub coupling: Option<Coupling>,
}

/// A material that the page does not show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// What a page is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Cast {
    /// The surfaces, each once.
    pub surfaces: Vec<Surface>,
    /// The materials, in the order of the scene.
    pub parts: Vec<Part>,
    /// The others.
    pub left_out: Vec<LeftOut>,
}

/// Why there is no page.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CastError {
    /// No material that the page can show.
    #[error(
        "there is nothing to show: a page shows isotropic microfacet lobes that reflect, alone or coupled to a diffuse base{}",
        first(.0)
    )]
    Nothing(Vec<LeftOut>),
    /// More sheets than a page holds.
    #[error(
        "{0} different lobes are not allowed: a page holds at most {MOST_SHEETS}; choose materials with --material NAME"
    )]
    TooMany(usize),
}

fn first(left_out: &[LeftOut]) -> String {
    let more = match left_out.len().saturating_sub(1) {
        0 => String::new(),
        count => format!("; nor are {count} others"),
    };
    left_out.first().map_or_else(
        || ", and the scene has no material".into(),
        |LeftOut { name, reason }| format!("; `{name}` is not shown: {reason}{more}"),
    )
}

impl Surface {
    /// The roughness that a browser can show of the family: its arithmetic has 24 bits, and sharper lobes than these lose digits.
    fn shown(family: Family) -> [f64; 2] {
        match family {
            Family::Ggx | Family::Beckmann | Family::Charlie => [0.001, 10.0],
            Family::Vmf | Family::Phong => [0.0, 1e5],
        }
    }

    /// The range that every surface has at least, for the free choice.
    fn usual(family: Family) -> [f64; 2] {
        match family {
            Family::Ggx | Family::Beckmann | Family::Charlie => [0.03, 1.0],
            Family::Vmf | Family::Phong => [1.0, 4096.0],
        }
    }
}

impl Cast {
    /// What a page of `materials` shows.
    ///
    /// # Errors
    /// [`CastError`] when that is nothing, or too much for a page.
    pub fn new(materials: &[&Material]) -> Result<Self, CastError> {
        let mut cast = Self {
            surfaces: Vec::new(),
            parts: Vec::new(),
            left_out: Vec::new(),
        };
        for material in materials {
            let name = material.name.clone();
            match found(&material.model) {
                Ok(found) => cast.add(name, found),
                Err(reason) => cast.left_out.push(LeftOut { name, reason }),
            }
        }
        let sheets = cast.surfaces.iter().map(|surface| surface.terms.len()).sum();
        if cast.parts.is_empty() {
            return Err(CastError::Nothing(cast.left_out));
        }
        if sheets > MOST_SHEETS {
            return Err(CastError::TooMany(sheets));
        }
        Ok(cast)
    }

    fn add(&mut self, name: String, found: Found) {
        let same = |surface: &Surface| (surface.family, surface.masking) == (found.family, found.masking);
        let index = self.surfaces.iter().position(same).unwrap_or_else(|| {
            self.surfaces.push(Surface {
                family: found.family,
                masking: found.masking,
                range: Surface::usual(found.family),
                terms: vec![Term::Pair],
            });
            self.surfaces.len() - 1
        });
        let surface = &mut self.surfaces[index];
        let [min, max] = found.roughness;
        surface.range = [surface.range[0].min(min), surface.range[1].max(max)];
        let term = match found.fresnel {
            Fresnel::None | Fresnel::Schlick { .. } => Term::Pair,
            own => Term::Own(own),
        };
        let sheet = surface
            .terms
            .iter()
            .position(|other| *other == term)
            .unwrap_or_else(|| {
                surface.terms.push(term);
                surface.terms.len() - 1
            });
        self.parts.push(Part {
            name,
            surface: index,
            sheet,
            fresnel: found.fresnel,
            roughness: found.roughness,
            ks: found.ks,
            kd: found.kd,
            coupling: found.coupling,
        });
    }
}

/// A material taken apart.
struct Found {
    family: Family,
    masking: Masking,
    fresnel: Fresnel,
    roughness: [f64; 2],
    ks: Spectrum,
    kd: Spectrum,
    coupling: Option<Coupling>,
}

fn found(model: &ModelSpec) -> Result<Found, String> {
    match model {
        ModelSpec::Microfacet {
            reflectance,
            distribution,
            masking,
            fresnel,
        } => lobe(*reflectance, distribution, *masking, *fresnel),
        ModelSpec::Scaled { bxdf, scale } => {
            let below = found(bxdf)?;
            if below.coupling.is_some() {
                return Err("a coupling times a colour".into());
            }
            let ks = times(below.ks, *scale);
            Ok(Found { ks, ..below })
        }
        ModelSpec::DiffuseSpecular {
            specular,
            ks,
            kd,
            coupling,
        } => {
            let below = found(specular)?;
            if below.coupling.is_some() {
                return Err("a coupling within a coupling".into());
            }
            // rho enters eq. 28 as ks rho alone, so that a scale of the lobe is one of ks
            Ok(Found {
                ks: times(below.ks, *ks),
                kd: *kd,
                coupling: Some(*coupling),
                ..below
            })
        }
        ModelSpec::Sum(parts) => match &parts[..] {
            [one] => found(one),
            _ => Err(format!("a sum of {} models", parts.len())),
        },
        ModelSpec::Layered { .. } => Err("a layer over another material".into()),
        _ => Err("no microfacet lobe".into()),
    }
}

fn lobe(
    reflectance: Spectrum,
    distribution: &DistributionSpec,
    masking: Masking,
    fresnel: Fresnel,
) -> Result<Found, String> {
    let DistributionSpec::Isotropic { family, roughness } = *distribution else {
        return Err("an anisotropic lobe, whose albedo depends on the azimuth too".into());
    };
    if family == Family::Charlie {
        return Err("a lobe of fibres, whose facets the page's rule does not follow to the horizon".into());
    }
    if masking == Masking::None {
        return Err("a lobe without masking, whose albedo grows without bound towards the horizon".into());
    }
    let [least, most] = Surface::shown(family);
    let name = family.legal().name;
    let roughness = match roughness {
        // what a texture may hold is more than what one sees of it
        Roughness::Range { min, max } if min < most && max > least => [min.max(least), max.min(most)],
        Roughness::Fixed(value) if (least..=most).contains(&value) => [value; 2],
        other => {
            let (least, most) = (Number(least), Number(most));
            return Err(format!(
                "{name} = {other}, where a browser's 32-bit floats show {least} to {most}"
            ));
        }
    };
    Ok(Found {
        family,
        masking,
        fresnel,
        roughness,
        ks: reflectance,
        kd: Spectrum::grey(1.0),
        coupling: None,
    })
}

fn times(a: Spectrum, b: Spectrum) -> Spectrum {
    Spectrum::rgb((a.value() * b.value()).to_array())
}

/// The reflectance at normal incidence, which compensation takes for the colour of a lobe.
pub(super) fn r0(fresnel: Fresnel) -> DVec3 {
    fresnel.reflectance(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn cast(text: &str) -> Result<Cast, CastError> {
        let scene = Scene::parse(text, "test.toml").unwrap();
        Cast::new(&scene.materials.iter().collect::<Vec<_>>())
    }

    fn lobe(name: &str, distribution: &str, masking: &str, fresnel: &str) -> String {
        format!(
            "[[material]]\nname = \"{name}\"\n[material.bxdf]\ntype = \"microfacet\"\ndistribution = {{ {distribution} }}\n\
             masking = \"{masking}\"\nfresnel = {{ {fresnel} }}\n"
        )
    }

    #[test]
    fn lobes_of_the_built_in_scene_share_surfaces_and_sheets() {
        let scene = Scene::default_scene();
        let cast = Cast::new(&scene.materials.iter().collect::<Vec<_>>()).unwrap();
        let found: Vec<_> = cast.surfaces.iter().map(|s| (s.family.name(), s.terms.len())).collect();
        assert_eq!(found, [("vmf", 3), ("beckmann", 1), ("phong", 1), ("ggx", 2)]);
        assert_eq!(cast.surfaces[0].range, [1.0, 4096.0]);
        assert!(cast.parts[0].sheet == 1 && cast.parts[0].coupling == Some(Coupling::Mikkelsen));
        let left_out: Vec<_> = cast.left_out.iter().map(|left| left.name.as_str()).collect();
        assert_eq!(left_out, ["ashikhmin-shirley-10-100"]);
        assert_eq!(cast.parts.len() + cast.left_out.len(), scene.materials.len());
    }

    #[test]
    fn what_is_not_shown_says_why() {
        let none = "type = \"none\"";
        for (distribution, masking, reason) in [
            ("type = \"ggx\", alpha = 0.3", "none", "without masking"),
            ("type = \"charlie\", alpha = 0.3", "neubelt", "a lobe of fibres"),
            ("type = \"ggx\", alpha_x = 0.3, alpha_y = 0.1", "smith", "anisotropic"),
            (
                "type = \"vmf\", kappa = 1e12",
                "v-groove",
                "kappa = 1000000000000, where",
            ),
        ] {
            let error = cast(&lobe("a", distribution, masking, none)).unwrap_err().to_string();
            assert!(error.contains(reason) && error.contains("`a` is not shown"), "{error}");
        }
        assert!(
            Cast::new(&[])
                .unwrap_err()
                .to_string()
                .contains("the scene has no material")
        );
    }

    #[test]
    fn ranges_are_clipped_to_what_a_browser_shows_and_widen_the_free_one() {
        let text = lobe(
            "a",
            "type = \"ggx\", alpha = { min = 1e-6, max = 2.0 }",
            "smith",
            "type = \"none\"",
        );
        let cast = cast(&text).unwrap();
        assert_eq!(cast.parts[0].roughness, [0.001, 2.0]);
        assert_eq!(cast.surfaces[0].range, [0.001, 2.0]);
    }

    #[test]
    fn pages_have_a_limit() {
        let many = (0..MOST_SHEETS).map(|i| {
            let eta = 1.1 + 0.1 * i as f64;
            let fresnel = format!("type = \"dielectric\", eta = {eta}");
            lobe(&format!("m{i}"), "type = \"ggx\", alpha = 0.3", "smith", &fresnel)
        });
        let error = cast(&many.collect::<String>()).unwrap_err();
        assert_eq!(error, CastError::TooMany(MOST_SHEETS + 1));
    }
}
