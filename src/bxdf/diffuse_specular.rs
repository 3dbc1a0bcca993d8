//! A specular lobe over a diffuse base that shares one energy budget [Mikkelsen 2009, eq. 28].

use super::{Bxdf, BxdfSample, Flags, Model, Sampling, cosine_hemisphere, opposite_sides, other_hemisphere};
use crate::numerics::surface::Surface;
use crate::parameter::{KD, KS, ParameterError};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// How the diffuse base is weighted by what the specular lobe leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// (1 - ks rho(i)) kd/pi (1 - ks rho(o)), as printed. Loses the fraction (1 - ks rho(o)) ks rho_bar even at kd = 1.
    Mikkelsen,
    /// The same divided by 1 - ks rho_bar: reciprocal, and nothing is lost at ks = kd = 1.
    EnergyPreserving,
}

impl Coupling {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mikkelsen => "mikkelsen",
            Self::EnergyPreserving => "energy-preserving",
        }
    }
}

/// Parameters of f = ks f_s + (1 - ks rho(i)) kd/pi (1 - ks rho(o)) and of its energy-preserving variant.
///
/// rho is rho_hd of the specular lobe f_s alone, rho_bar its rho_hh.
#[derive(Debug, Clone, PartialEq)]
pub struct DiffuseSpecular {
    specular: Model,
    ks: Spectrum,
    kd: Spectrum,
    coupling: Coupling,
}

impl DiffuseSpecular {
    /// ks and kd in [0, 1] in every channel, [`KS`] and [`KD`].
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn new(specular: Model, ks: Spectrum, kd: Spectrum, coupling: Coupling) -> Result<Self, ParameterError> {
        Ok(Self {
            specular,
            ks: ks.check(KS)?,
            kd: kd.check(KD)?,
            coupling,
        })
    }

    /// The specular lobe, unscaled.
    pub fn specular(&self) -> &Model {
        &self.specular
    }

    /// Scale of the specular lobe.
    pub fn ks(&self) -> Spectrum {
        self.ks
    }

    /// Albedo of the diffuse base.
    pub fn kd(&self) -> Spectrum {
        self.kd
    }

    /// The variant.
    pub fn coupling(&self) -> Coupling {
        self.coupling
    }

    /// Number of independent channels.
    pub fn channels(&self) -> Channels {
        self.specular.channels().max(self.ks.channels()).max(self.kd.channels())
    }

    /// rho_hd of the whole from that of the specular lobe.
    ///
    /// ks rho + (1 - ks rho) kd (1 - ks rho_bar) as printed, ks rho + (1 - ks rho) kd energy preserving; `unspent` is
    /// 1 - ks rho_bar.
    pub fn total_albedo(&self, rho: DVec3, unspent: DVec3) -> DVec3 {
        let spent = self.ks.value() * rho;
        spent + (DVec3::ONE - spent) * self.kd.value() * self.diffuse_scale(unspent)
    }

    /// rho_hh of the whole: the cosine-weighted mean of [`DiffuseSpecular::total_albedo`], which is linear in rho.
    pub fn total_mean_albedo(&self, unspent: DVec3) -> DVec3 {
        (DVec3::ONE - unspent) + unspent * self.kd.value() * self.diffuse_scale(unspent)
    }

    /// Largest change of [`DiffuseSpecular::total_albedo`] for changes of rho by `rho_error` and of 1 - ks rho_bar by
    /// `unspent_error`; both derivatives are at most ks and 1.
    pub fn total_albedo_error(&self, rho: DVec3, rho_error: DVec3, unspent: DVec3, unspent_error: DVec3) -> DVec3 {
        let ks = self.ks.value();
        let slope = ks * (DVec3::ONE - self.kd.value() * self.diffuse_scale(unspent)).abs();
        let scale_error = match self.coupling {
            Coupling::Mikkelsen => (DVec3::ONE - ks * rho).abs() * self.kd.value() * unspent_error,
            Coupling::EnergyPreserving => DVec3::ZERO,
        };
        // the product of both changes, second order
        slope * rho_error + scale_error + ks * rho_error * unspent_error
    }

    fn diffuse_scale(&self, unspent: DVec3) -> DVec3 {
        match self.coupling {
            Coupling::Mikkelsen => unspent,
            Coupling::EnergyPreserving => DVec3::ONE,
        }
    }
}

/// What eq. 28 needs to know of its specular lobe.
#[derive(Debug, Clone)]
pub struct SpecularAlbedo {
    /// rho_hd over all directions.
    pub rho_hd: Surface,
    /// 1 - ks rho_hh, with all its digits where rho_hh is close to 1.
    pub unspent: DVec3,
}

/// [`DiffuseSpecular`] with its specular albedo at hand, ready to be evaluated and sampled.
pub struct CoupledBxdf<S> {
    parameters: DiffuseSpecular,
    specular: S,
    albedo: SpecularAlbedo,
    /// kd/pi, divided by 1 - ks rho_bar in the energy-preserving variant.
    base: DVec3,
}

impl<S: Bxdf> CoupledBxdf<S> {
    /// `specular` is the lobe that `albedo` was computed from.
    pub fn new(parameters: DiffuseSpecular, specular: S, albedo: SpecularAlbedo) -> Self {
        let base = parameters.kd.value() * FRAC_1_PI;
        let base = match parameters.coupling {
            Coupling::Mikkelsen => base,
            // where nothing is left over, every 1 - ks rho is 0 too and the base is unreachable
            Coupling::EnergyPreserving => {
                DVec3::select(albedo.unspent.cmpgt(DVec3::ZERO), base / albedo.unspent, DVec3::ZERO)
            }
        };
        Self {
            parameters,
            specular,
            albedo,
            base,
        }
    }

    /// 1 - ks rho in the direction `w`.
    ///
    /// Where rho is 1, the interpolant's error may take it to the other side of 0; what is 0 within that error is not negative.
    fn left(&self, w: DVec3) -> DVec3 {
        let left = DVec3::ONE - self.parameters.ks.value() * self.albedo.rho_hd.at(w);
        let known = left.abs().cmpgt(DVec3::splat(self.albedo.rho_hd.error()));
        DVec3::select(known, left, left.max(DVec3::ZERO))
    }

    fn diffuse(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        // in this order the product does not change a bit when the directions are exchanged
        self.base * (self.left(wi) * self.left(wo))
    }

    /// A draw of the specular lobe, which happens with probability `share`.
    fn shared_specular(&self, lobe: BxdfSample, share: f64) -> BxdfSample {
        BxdfSample {
            pdf: lobe.pdf * share,
            weight: self.parameters.ks.value() * lobe.weight / share,
            ..lobe
        }
    }

    /// A direction on the side of wo, proportional to its cosine.
    fn base_direction(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        let wi = cosine_hemisphere([u[0], u[1]]);
        if wo.z < 0.0 { other_hemisphere(wi) } else { wi }
    }

    /// Share of the draws that goes to the specular lobe; each lobe that can contribute keeps at least a tenth.
    fn specular_share(&self, wo: DVec3) -> f64 {
        if self.parameters.kd.value() == DVec3::ZERO {
            return 1.0;
        }
        if self.parameters.ks.value() == DVec3::ZERO {
            return 0.0;
        }
        let left = self.left(wo);
        let specular = (DVec3::ONE - left).element_sum();
        let diffuse = (left * self.parameters.kd.value()).element_sum();
        (specular / (specular + diffuse)).clamp(0.1, 0.9)
    }
}

impl<S: Bxdf> Bxdf for CoupledBxdf<S> {
    fn channels(&self) -> Channels {
        self.parameters.channels()
    }

    fn flags(&self) -> Flags {
        self.specular.flags() | Flags::REFLECTION | Flags::DIFFUSE
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if opposite_sides(wo, wi) {
            return DVec3::ZERO;
        }
        self.parameters.ks.value() * self.specular.f(wo, wi) + self.diffuse(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if opposite_sides(wo, wi) {
            return 0.0;
        }
        let share = self.specular_share(wo);
        share * self.specular.pdf(wo, wi) + (1.0 - share) * wi.z.abs() * FRAC_1_PI
    }

    /// One lobe is drawn by its share, and the weight is that of the mixture density; a specular direction, which the
    /// other lobe never draws, keeps its own.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let share = self.specular_share(wo);
        let wi = if u[2] < share {
            let lobe = self.specular.sample_f(wo, [u[0], u[1], u[2] / share]);
            if lobe.flags.contains(Flags::SPECULAR) {
                return self.shared_specular(lobe, share);
            }
            lobe.wi
        } else {
            self.base_direction(wo, u)
        };
        let pdf = self.pdf(wo, wi);
        if opposite_sides(wo, wi) || pdf <= 0.0 {
            return BxdfSample::lost(wi);
        }
        BxdfSample {
            wi,
            pdf,
            weight: self.f(wo, wi) * (wi.z.abs() / pdf),
            flags: self.flags() - Flags::SPECULAR,
        }
    }

    /// The diffuse part integrates to pi base (1 - ks rho(mu)) (1 - ks rho_bar), and the interpolated albedo is off by at
    /// most its error in both factors.
    fn albedo_error(&self, _mu: f64) -> DVec3 {
        let error = self.parameters.ks.value() * self.albedo.rho_hd.error();
        // what is left at wo is at most 1
        PI * self.base * error * (DVec3::ONE + self.albedo.unspent + error)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        self.specular.supports(sampling)
    }

    /// For half-vector samplings each lobe is drawn in its own way and weighted alone: the mean is the sum of both
    /// albedos, without any quotient of narrow densities.
    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match sampling {
            Sampling::Uniform => super::sample_uniform(self, wo, u),
            Sampling::Cosine => super::sample_cosine(self, wo, u),
            Sampling::Bxdf => self.sample_f(wo, u),
            Sampling::Normals | Sampling::Visible => {
                let share = self.specular_share(wo);
                if u[2] < share {
                    let lobe = self.specular.sample(sampling, wo, [u[0], u[1], u[2] / share]);
                    self.shared_specular(lobe, share)
                } else {
                    let wi = self.base_direction(wo, u);
                    let pdf = wi.z.abs() * FRAC_1_PI * (1.0 - share);
                    BxdfSample {
                        wi,
                        pdf,
                        weight: self.diffuse(wo, wi) * (wi.z.abs() / pdf),
                        flags: Flags::REFLECTION | Flags::DIFFUSE,
                    }
                }
            }
        }
    }
}
