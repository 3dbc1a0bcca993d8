//! A glossy coat over a diffuse base, after Ashikhmin and Shirley [pbrt 2010, section 8.5].

use super::{Bxdf, BxdfSample, Flags, ModelError, Sampling, cosine_hemisphere};
use crate::distribution::{Distribution, Isotropic};
use crate::geometry::{half_vector, reflect};
use crate::masking::{Cosines, LARGEST};
use crate::parameter::{RD, RS};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// f = 28/(23 pi) rd (1 - rs) g(n.i) g(n.o) + D(h) F(o.h)/(4 (o.h) max(n.i, n.o)), with g(mu) = 1 - (1 - mu/2)^5 and
/// Schlick's F = rs + (1 - rs)(1 - o.h)^5.
///
/// The factor 4 is the code's of the source; the 4 pi of its formula would leave the coat a third of its light.
///
/// At the horizon the coat of rs = 1 reflects half the mean of 1/(n.h) over p(h). While that mean is 2 or less, as for every
/// Phong exponent and for GGX up to alpha = 1, no albedo above 1 was found. Wider lobes gain energy, and those of von Mises
/// and Fisher, whose p does not vanish at the horizon, without bound as mu -> 0, like p(horizon) pi ln(1/mu).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FresnelBlend {
    rd: Spectrum,
    rs: Spectrum,
    distribution: Distribution,
}

/// g(mu) = 1 - (1 - mu/2)^5, as (mu/2)(1 + t + t^2 + t^3 + t^4) with t = 1 - mu/2, which keeps its digits for small mu.
fn entering(mu: f64) -> f64 {
    let t = 1.0 - 0.5 * mu;
    0.5 * mu * (1.0 + t * (1.0 + t * (1.0 + t * (1.0 + t))))
}

impl FresnelBlend {
    /// Reflectances in [0, 1] in every channel: `rd` of the base, [`RD`], `rs` of the coat at normal incidence, [`RS`].
    ///
    /// # Errors
    /// [`ModelError::Parameter`] outside that range, with the value and the range; [`ModelError::CoatOfCharlie`] for a distribution of
    /// facets that stand off the surface, under which a coat without masking would gain most of its light.
    pub fn new(rd: Spectrum, rs: Spectrum, distribution: impl Into<Distribution>) -> Result<Self, ModelError> {
        let distribution = distribution.into();
        if matches!(distribution, Distribution::Isotropic(Isotropic::Charlie(_))) {
            return Err(ModelError::CoatOfCharlie);
        }
        Ok(Self {
            rd: rd.check(RD)?,
            rs: rs.check(RS)?,
            distribution,
        })
    }

    /// Reflectance of the diffuse base.
    pub fn rd(&self) -> Spectrum {
        self.rd
    }

    /// Reflectance of the glossy coat at normal incidence.
    pub fn rs(&self) -> Spectrum {
        self.rs
    }

    /// Distribution of the normals of the coat.
    pub fn distribution(&self) -> &Distribution {
        &self.distribution
    }

    /// rho_hd of the diffuse part alone, rd (1 - rs) g(mu): 2 int g(mu) mu dmu = 23/28 cancels the constant.
    pub fn diffuse_rho_hd(&self, mu: f64) -> DVec3 {
        self.base() * entering(mu)
    }

    /// rho_hh of the diffuse part alone, 23/28 rd (1 - rs).
    pub fn diffuse_rho_hh(&self) -> DVec3 {
        self.base() * (23.0 / 28.0)
    }

    /// Schlick's F(o.h) of the coat.
    pub fn coat_reflectance(&self, cos_d: f64) -> DVec3 {
        let rs = self.rs.value();
        rs + (DVec3::ONE - rs) * (1.0 - cos_d).powi(5)
    }

    /// Weight of a half vector drawn from p(h): F(o.h) min(1, (n.i)/(n.o))/(n.h).
    ///
    /// f cos theta_i/pdf of the glossy part with pdf = p/(4 (o.h)) and D = p/(n.h); finite as n.o -> 0. The mean over those
    /// half vectors with o.h > 0 and n.i > 0 is rho_hd of that part.
    pub fn glossy_weight(&self, cos: Cosines) -> DVec3 {
        self.coat_reflectance(cos.d) * ((cos.i / cos.o).min(1.0) / cos.h)
    }

    /// rd (1 - rs).
    fn base(&self) -> DVec3 {
        self.rd.value() * (DVec3::ONE - self.rs.value())
    }

    fn diffuse(&self, cos_o: f64, cos_i: f64) -> DVec3 {
        // in this order the product does not change a bit when the directions are exchanged
        self.base() * (28.0 / 23.0 * FRAC_1_PI * (entering(cos_i) * entering(cos_o)))
    }

    /// Share of the draws that goes to the coat; each part that can contribute keeps at least a tenth.
    fn glossy_share(&self, cos_o: f64) -> f64 {
        let diffuse = self.diffuse_rho_hd(cos_o).element_sum();
        if self.base() == DVec3::ZERO {
            return 1.0;
        }
        let glossy = self.coat_reflectance(cos_o).element_sum();
        (glossy / (glossy + diffuse)).clamp(0.1, 0.9)
    }

    /// Density of wi as a mirror image of wo in normals drawn from p(h), and their cosines, for wo above the surface.
    fn mirror_density(&self, wo: DVec3, wi: DVec3) -> Option<(f64, Cosines)> {
        let half = half_vector(wo, wi).filter(|half| half.wh.z > 0.0)?;
        let cosines = Cosines {
            o: wo.z.abs(), // -0 is above
            i: wi.z,
            h: half.wh.z,
            d: half.cos_d,
        };
        Some((
            (self.distribution.p(half.wh) / (4.0 * half.cos_d)).min(LARGEST),
            cosines,
        ))
    }

    /// The two parts of the mixture density, for wo above the surface. Mirror images below it are drawn too, in vain.
    fn density(&self, wo: DVec3, wi: DVec3) -> (f64, Option<(f64, Cosines)>) {
        let share = self.glossy_share(wo.z);
        let mirror = self.mirror_density(wo, wi);
        let glossy = mirror.map_or(0.0, |(density, _)| density);
        let pdf = share * glossy + (1.0 - share) * wi.z.max(0.0) * FRAC_1_PI;
        (pdf, mirror)
    }
}

impl Bxdf for FresnelBlend {
    fn channels(&self) -> Channels {
        self.rd.channels().max(self.rs.channels())
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::GLOSSY
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        // the sum, so that a direction at the horizon goes with either side
        let (wo, wi) = if wo.z + wi.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        let (lowest, highest) = (wo.z.min(wi.z), wo.z.max(wi.z));
        if lowest < 0.0 || highest <= 0.0 {
            return DVec3::ZERO;
        }
        let diffuse = self.diffuse(wo.z, wi.z);
        match half_vector(wo, wi).filter(|half| half.wh.z > 0.0) {
            // D/(4 (o.h) max) with D = p/(n.h) and n.h = (n.i + n.o)/(2 (o.h)): o.h cancels
            Some(half) => {
                let shape = 0.5 * self.distribution.p(half.wh) / (lowest + highest) / highest;
                diffuse + self.coat_reflectance(half.cos_d) * shape.min(LARGEST)
            }
            None => diffuse,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (wo, wi) = if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        self.density(wo, wi).0
    }

    /// A direction proportional to its cosine, or the mirror image in a normal drawn from p(h), weighted by the density of
    /// both together.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        if wo.z < 0.0 {
            let above = self.sample_f(-wo, u);
            return BxdfSample { wi: -above.wi, ..above };
        }
        let wi = if u[2] < self.glossy_share(wo.z) {
            reflect(wo, self.distribution.sample([u[0], u[1]]))
        } else {
            cosine_hemisphere([u[0], u[1]])
        };
        let (pdf, mirror) = self.density(wo, wi);
        if wi.z <= 0.0 || pdf <= 0.0 {
            return BxdfSample::lost(wi);
        }
        // each part by the quotient that stays finite, (f cos/density) (density/pdf) for the coat
        let diffuse = self.diffuse(wo.z, wi.z) * (wi.z / pdf);
        let glossy = match mirror {
            Some((density, cosines)) if density > 0.0 => self.glossy_weight(cosines) * (density / pdf),
            _ => DVec3::ZERO,
        };
        BxdfSample {
            wi,
            pdf,
            weight: diffuse + glossy,
            flags: self.flags(),
        }
    }

    fn supports(&self, sampling: Sampling) -> bool {
        match sampling {
            Sampling::Uniform | Sampling::Cosine | Sampling::Normals | Sampling::Bxdf => true,
            Sampling::Visible => false, // without masking every normal is seen
        }
    }

    /// For [`Sampling::Normals`] each part is drawn in its own way and weighted alone: the mean is the sum of both albedos,
    /// without any quotient of narrow densities.
    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match sampling {
            Sampling::Uniform => super::sample_uniform(self, wo, u),
            Sampling::Cosine => super::sample_cosine(self, wo, u),
            Sampling::Visible | Sampling::Bxdf => self.sample_f(wo, u),
            Sampling::Normals if wo.z < 0.0 => {
                let above = self.sample(sampling, -wo, u);
                BxdfSample { wi: -above.wi, ..above }
            }
            Sampling::Normals => {
                let share = self.glossy_share(wo.z);
                if u[2] >= share {
                    let wi = cosine_hemisphere([u[0], u[1]]);
                    return BxdfSample {
                        wi,
                        pdf: wi.z * FRAC_1_PI * (1.0 - share),
                        weight: self.diffuse(wo.z, wi.z) * (PI / (1.0 - share)),
                        flags: self.flags(),
                    };
                }
                let wm = self.distribution.sample([u[0], u[1]]);
                let wi = reflect(wo, wm);
                let cosines = Cosines {
                    o: wo.z.abs(),
                    i: wi.z,
                    h: wm.z,
                    d: wo.dot(wm).min(1.0),
                };
                if cosines.d <= 0.0 || cosines.i <= 0.0 || cosines.h <= 0.0 {
                    return BxdfSample::lost(wi);
                }
                BxdfSample {
                    wi,
                    pdf: (self.distribution.p(wm) / (4.0 * cosines.d) * share).min(LARGEST),
                    weight: self.glossy_weight(cosines) / share,
                    flags: self.flags(),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::{Anisotropic, Elliptic, Family};
    use crate::geometry::Polar;
    use crate::numerics::quadrature::{Piece, integrate_scalar};

    fn blends() -> Vec<FresnelBlend> {
        let (rd, rs) = (Spectrum::rgb([0.1, 0.5, 1.0]), Spectrum::grey(0.04));
        let mut all: Vec<FresnelBlend> = [
            (Family::Vmf, 17.0),
            (Family::Beckmann, 0.2),
            (Family::Phong, 1e4),
            (Family::Ggx, 0.5),
        ]
        .into_iter()
        .map(|(family, roughness)| FresnelBlend::new(rd, rs, family.with(roughness).unwrap()).unwrap())
        .collect();
        let wood = Anisotropic::new(Elliptic::AshikhminShirley, 100.0, 5.0).unwrap();
        all.push(FresnelBlend::new(rd, rs, wood).unwrap());
        all
    }

    #[test]
    fn f_is_symmetric_to_the_last_bit() {
        for bxdf in blends() {
            for i in 0..400 {
                let t = f64::from(i);
                let wo = Polar::from_cos((0.5 + 0.5 * (t * 0.7).sin()).powi(9)).direction(t);
                let wi = Polar::from_cos((0.5 + 0.5 * (t * 1.3).cos()).powi(9)).direction(2.1 * t);
                assert_eq!(bxdf.f(wo, wi), bxdf.f(wi, wo));
                assert_eq!(bxdf.f(wo, wi), bxdf.f(-wo, -wi));
                assert_eq!(bxdf.f(wo, -wi), DVec3::ZERO);
            }
        }
    }

    /// The source's code in its own order, where it does not divide by 0.
    #[test]
    fn f_is_the_printed_code() {
        for bxdf in blends() {
            for i in 0..200 {
                let t = f64::from(i);
                let wo = Polar::from_cos(0.1 + 0.9 * (t * 0.618).fract()).direction(t);
                let wi = Polar::from_cos(0.1 + 0.9 * (t * 0.324).fract()).direction(2.1 * t);
                let wh = (wo + wi).normalize();
                let (rd, rs) = (bxdf.rd().value(), bxdf.rs().value());
                let five = |w: DVec3| 1.0 - (1.0 - 0.5 * w.z).powi(5);
                let diffuse = 28.0 / (23.0 * PI) * rd * (1.0 - rs) * five(wi) * five(wo);
                let schlick = rs + (1.0 - wi.dot(wh)).powi(5) * (1.0 - rs);
                let specular = bxdf.distribution().d(wh) / (4.0 * wi.dot(wh) * wi.z.max(wo.z)) * schlick;
                let (f, printed) = (bxdf.f(wo, wi), diffuse + specular);
                // D of exponent 1e4 multiplies the rounding of the cosine by that number
                assert!((f / printed - 1.0).abs().max_element() < 1e-11, "{f} and {printed}");
            }
        }
    }

    #[test]
    fn weights_are_the_quotients_they_stand_for() {
        for bxdf in blends() {
            for sampling in [Sampling::Uniform, Sampling::Cosine, Sampling::Bxdf] {
                for i in 0..200 {
                    let t = f64::from(i) * 0.618;
                    let u = [t.fract(), (t * 1.7).fract(), (t * 2.9).fract()];
                    let wo = Polar::from_cos((t * 3.1).fract()).direction(0.3 * t);
                    let wo = if i % 2 == 0 { wo } else { -wo };
                    let sample = bxdf.sample(sampling, wo, u);
                    if sample.weight == DVec3::ZERO {
                        continue;
                    }
                    let quotient = bxdf.f(wo, sample.wi) * sample.wi.z.abs() / sample.pdf;
                    let relative = (quotient / sample.weight - DVec3::ONE).abs().max_element();
                    assert!(relative < 1e-13, "{sampling:?} {i}: {relative:e}"); // some tens of roundings
                    if sampling == Sampling::Bxdf {
                        assert_eq!(bxdf.pdf(wo, sample.wi), sample.pdf);
                    }
                }
            }
            assert!(bxdf.supports(Sampling::Normals) && !bxdf.supports(Sampling::Visible));
        }
    }

    #[test]
    fn the_diffuse_part_in_closed_form() {
        let smooth = [Piece::smooth(0.0, 1.0)];
        for bxdf in blends() {
            for mu in [0.0, 1e-300, 1e-9, 0.1, 0.7, 1.0] {
                let rho = bxdf.diffuse_rho_hd(mu);
                let integrand = |cos_i: f64| 2.0 * PI * cos_i * bxdf.diffuse(mu, cos_i).y;
                let quadrature = integrate_scalar(&smooth, 1e-15, integrand).unwrap();
                // six roundings of the closed form, as many of the integrand
                let rounding = 12.0 * f64::EPSILON * rho.y;
                assert!((rho.y - quadrature.value).abs() <= quadrature.error + rounding, "{mu}");
            }
            let mean = integrate_scalar(&smooth, 1e-15, |mu| 2.0 * mu * bxdf.diffuse_rho_hd(mu).y).unwrap();
            assert!((bxdf.diffuse_rho_hh().y - mean.value).abs() <= mean.error + 4.0 * f64::EPSILON);
        }
        // 1 - (1 - mu/2)^5 tends to 5/2 mu
        assert_eq!(entering(1e-200), 2.5e-200);
        assert_eq!(entering(1.0), 1.0 - 0.5f64.powi(5));
    }

    #[test]
    fn either_part_alone() {
        let lobe = Family::Phong.with(20.0).unwrap();
        let wo = Polar::from_angle(0.5).direction(0.2);
        let wi = Polar::from_angle(0.9).direction(1.2);
        let coat = FresnelBlend::new(Spectrum::grey(0.0), Spectrum::grey(0.3), lobe).unwrap();
        let opaque = FresnelBlend::new(Spectrum::grey(0.8), Spectrum::grey(1.0), lobe).unwrap();
        assert_eq!(coat.diffuse_rho_hd(0.5), DVec3::ZERO);
        assert_eq!(opaque.diffuse_rho_hh(), DVec3::ZERO);
        assert_eq!((coat.glossy_share(0.5), opaque.glossy_share(0.0)), (1.0, 1.0));
        // rs = 0 still reflects at grazing half angles, and f is linear in rd and in rs
        let bare = FresnelBlend::new(Spectrum::grey(0.0), Spectrum::grey(0.0), lobe).unwrap();
        assert!(bare.f(wo, wi).x > 0.0);
        let mirror = FresnelBlend::new(Spectrum::grey(0.0), Spectrum::grey(1.0), lobe).unwrap();
        let mixed = 0.7 * bare.f(wo, wi) + 0.3 * mirror.f(wo, wi);
        assert!((coat.f(wo, wi) / mixed - 1.0).abs().max_element() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn parameters_are_refused_with_their_range() {
        let lobe = Family::Phong.with(20.0).unwrap();
        let error = FresnelBlend::new(Spectrum::grey(-0.5), Spectrum::grey(0.0), lobe).unwrap_err();
        assert_eq!(error.to_string(), "rd = -0.5 is not allowed: rd lies in [0, 1]");
        let error = FresnelBlend::new(Spectrum::grey(0.5), Spectrum::rgb([0.0, 2.0, 0.0]), lobe).unwrap_err();
        assert_eq!(error.to_string(), "rs = 2 is not allowed: rs lies in [0, 1]");
    }
}
