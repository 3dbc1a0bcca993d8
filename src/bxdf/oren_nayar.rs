//! Rough diffuse reflection after Oren and Nayar [pbrt 2010, section 8.4.1].

use super::{Bxdf, BxdfSample, Flags, cosine_hemisphere, opposite_sides, other_hemisphere};
use crate::geometry::{Polar, azimuth_of};
use crate::parameter::{ParameterError, REFLECTANCE, SIGMA_DEG};
use crate::spectrum::{Channels, Spectrum};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, PI};

/// f = R/pi (A + B max(0, cos(phi_i - phi_o)) sin alpha tan beta), alpha the larger and beta the smaller polar angle,
/// A = 1 - sigma^2/(2 (sigma^2 + 0.33)), B = 0.45 sigma^2/(sigma^2 + 0.09) for sigma in radians.
///
/// This is the approximation as printed, and it is kept although its albedo exceeds 1 at grazing angles for sigma below
/// 18.7 degrees, by 1.52 % at most. f itself has no limit where both directions approach the horizon; there it is as large
/// as it is one smallest normal number above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrenNayar {
    reflectance: Spectrum,
    sigma_deg: f64,
    a: f64,
    b: f64,
}

impl OrenNayar {
    /// Reflectance in [0, 1] in every channel, [`REFLECTANCE`]; `sigma_deg`, the standard deviation of the facet angle, in
    /// [0, 90] degrees, [`SIGMA_DEG`].
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn new(reflectance: Spectrum, sigma_deg: f64) -> Result<Self, ParameterError> {
        let variance = SIGMA_DEG.check(sigma_deg)?.to_radians().powi(2);
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
            sigma_deg,
            a: 1.0 - 0.5 * variance / (variance + 0.33),
            b: 0.45 * variance / (variance + 0.09),
        })
    }

    /// Reflectance R of the facets.
    pub fn reflectance(&self) -> Spectrum {
        self.reflectance
    }

    /// Standard deviation of the facet angle, in degrees.
    pub fn sigma_deg(&self) -> f64 {
        self.sigma_deg
    }

    /// A and B.
    pub fn coefficients(&self) -> [f64; 2] {
        [self.a, self.b]
    }

    /// rho_hd at a direction with cosine `mu` in [0, 1], exact to a few roundings.
    ///
    /// The azimuth gives int max(0, cos phi) dphi = 2. With s, c the sine and cosine of theta_o, what is left of
    /// sin alpha tan beta cos theta_i sin theta_i is s sin^2 below theta_o and (s/c) sin^2 cos above:
    ///
    /// rho_hd = R (A + (2B/pi) (s (theta_o - s c)/2 + s c (1 + s + s^2)/(3 (1 + s)))),
    ///
    /// where (1 - s^3)/c is written without its 0/0 at the horizon.
    pub fn rho_hd(&self, mu: f64) -> DVec3 {
        let theta = Polar::from_cos(mu);
        let Polar { sin: s, cos: c } = theta;
        let below = 0.5 * s * (theta.angle() - s * c);
        let above = s * c * (1.0 + s * (1.0 + s)) / (3.0 * (1.0 + s));
        self.reflectance.value() * (self.a + self.b * FRAC_2_PI * (below + above))
    }

    /// rho_hh = R (A + B (2/3 - 64/(45 pi))), exact to a few roundings.
    pub fn rho_hh(&self) -> DVec3 {
        self.reflectance.value() * (self.a + self.b * (2.0 / 3.0 - 64.0 / (45.0 * PI)))
    }

    /// Integral of A cos theta_i/pi + B/pi sin theta_o max(0, cos phi) over the hemisphere: what `pdf` is divided by.
    fn envelope(&self, sin_o: f64) -> f64 {
        self.a + FRAC_2_PI * self.b * sin_o
    }
}

/// sin theta_o max(0, cos(phi_i - phi_o)).
fn facing(wo: DVec3, wi: DVec3) -> f64 {
    wo.truncate().dot(wi.truncate().normalize_or_zero()).max(0.0)
}

fn sine(w: DVec3) -> f64 {
    libm::hypot(w.x, w.y)
}

impl Bxdf for OrenNayar {
    fn channels(&self) -> Channels {
        self.reflectance.channels()
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::DIFFUSE
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if opposite_sides(wo, wi) {
            return DVec3::ZERO;
        }
        // sin theta_i sin theta_o cos(phi_i - phi_o) over the larger cosine: nothing that depends on the order of the two
        let highest = wo.z.abs().max(wi.z.abs()).max(f64::MIN_POSITIVE);
        let rough = wo.truncate().dot(wi.truncate()).max(0.0) / highest;
        self.reflectance.value() * (FRAC_1_PI * (self.a + self.b * rough))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if opposite_sides(wo, wi) {
            return 0.0;
        }
        FRAC_1_PI * (self.a * wi.z.abs() + self.b * facing(wo, wi)) / self.envelope(sine(wo))
    }

    /// Draws from (A cos theta_i + B sin theta_o max(0, cos phi))/pi, normalised.
    ///
    /// f cos theta_i is R/pi (A cos theta_i + B sin theta_o max(0, cos phi) k), with
    /// k = sin theta_i cos theta_i/max(cos theta_i, cos theta_o) in [0, 1]: no weight exceeds R (A + 2B/pi), at most
    /// 1.04 R. Drawing in proportion to the cosine alone leaves weights with 1/cos theta_i, whose variance is infinite for
    /// wo at the horizon. At sigma = 0 that is what remains.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let sin_o = sine(wo);
        let envelope = self.envelope(sin_o);
        let above = if u[2] * envelope < self.a {
            cosine_hemisphere([u[0], u[1]])
        } else {
            // uniform in cos theta_i, and sin(phi_i - phi_o) uniform in [-1, 1]
            let turn = DVec2::new(2.0 * (u[1] * (1.0 - u[1])).sqrt(), 2.0 * u[1] - 1.0);
            let azimuth = azimuth_of(wo).rotate(turn);
            let theta = Polar::from_cos(u[0]);
            (azimuth * theta.sin).extend(theta.cos)
        };
        let wi = if wo.z < 0.0 { other_hemisphere(above) } else { above };
        let (cos_i, cos_o) = (above.z, wo.z.abs());
        let facing = facing(wo, wi);
        let density = self.a * cos_i + self.b * facing;
        if density <= 0.0 {
            return BxdfSample::lost(wi);
        }
        let highest = cos_i.max(cos_o);
        let k = sine(wi) * if highest > 0.0 { cos_i / highest } else { 1.0 };
        BxdfSample {
            wi,
            pdf: FRAC_1_PI * density / envelope,
            weight: self.reflectance.value() * (envelope * ((self.a * cos_i + self.b * facing * k) / density)),
            flags: self.flags(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bxdf::Lambertian;

    fn directions() -> impl Iterator<Item = (DVec3, DVec3)> {
        (0..400).map(|i| {
            let t = f64::from(i);
            let wo = Polar::from_cos((0.5 + 0.5 * (t * 0.7).sin()).powi(9)).direction(t);
            let wi = Polar::from_cos((0.5 + 0.5 * (t * 1.3).cos()).powi(9)).direction(2.1 * t);
            (wo, wi)
        })
    }

    fn grey(sigma_deg: f64) -> OrenNayar {
        OrenNayar::new(Spectrum::grey(1.0), sigma_deg).unwrap()
    }

    #[test]
    fn f_is_symmetric_to_the_last_bit() {
        for sigma_deg in [0.0, 5.0, 20.0, 90.0] {
            let bxdf = grey(sigma_deg);
            for (wo, wi) in directions() {
                assert_eq!(bxdf.f(wo, wi), bxdf.f(wi, wo));
                assert_eq!(bxdf.f(wo, wi), bxdf.f(-wo, -wi));
                assert_eq!(bxdf.f(wo, -wi), DVec3::ZERO);
            }
        }
    }

    /// The printed formula with its angles, where it is not 0/0.
    #[test]
    fn f_is_the_printed_formula() {
        let (sigma_deg, sigma) = (20.0, 20f64.to_radians());
        let a = 1.0 - sigma * sigma / (2.0 * (sigma * sigma + 0.33));
        let b = 0.45 * sigma * sigma / (sigma * sigma + 0.09);
        for i in 0..200 {
            let t = f64::from(i);
            let (theta_o, theta_i) = (0.75 + 0.75 * (t * 0.7).sin(), 0.75 + 0.75 * (t * 1.3).cos());
            let wo = Polar::from_angle(theta_o).direction(t);
            let wi = Polar::from_angle(theta_i).direction(2.1 * t);
            let angles = theta_o.max(theta_i).sin() * theta_o.min(theta_i).tan();
            let printed = FRAC_1_PI * (a + b * (1.1 * t).cos().max(0.0) * angles);
            let f = grey(sigma_deg).f(wo, wi).x;
            // phi up to 400 carries 1e-13
            assert!((f / printed - 1.0).abs() < 1e-12, "{i}: {f} and {printed}");
        }
    }

    #[test]
    fn without_roughness_it_is_lambertian_to_the_bit() {
        let reflectance = Spectrum::rgb([0.1, 0.5, 1.0]);
        let (rough, flat) = (
            OrenNayar::new(reflectance, 0.0).unwrap(),
            Lambertian::new(reflectance).unwrap(),
        );
        for (i, (wo, wi)) in directions().enumerate() {
            assert_eq!(rough.f(wo, wi), flat.f(wo, wi));
            assert_eq!(rough.pdf(wo, wi), flat.pdf(wo, wi));
            let u = [0.618, 0.324, 0.717].map(|step| (i as f64 * step).fract());
            assert_eq!(rough.sample_f(wo, u), flat.sample_f(wo, u));
            assert_eq!(rough.sample_f(-wo, u), flat.sample_f(-wo, u));
            assert_eq!(rough.rho_hd(wo.z), flat.albedo());
        }
        assert_eq!(rough.rho_hh(), flat.albedo());
    }

    #[test]
    fn weights_are_quotients_and_bounded_at_the_horizon_too() {
        for sigma_deg in [5.0, 20.0, 90.0] {
            let bxdf = grey(sigma_deg);
            let bound = bxdf.envelope(1.0) * (1.0 + 4.0 * f64::EPSILON); // four roundings
            assert!(bound < 1.04);
            for (i, (wo, _)) in directions().enumerate() {
                let u = [0.618, 0.324, 0.717].map(|step| (i as f64 * step).fract());
                for wo in [wo, -wo, DVec3::X, wo.with_z(1e-300).normalize()] {
                    let sample = bxdf.sample_f(wo, u);
                    assert!(sample.weight.x > 0.0 && sample.weight.x <= bound);
                    assert_eq!(sample.pdf, bxdf.pdf(wo, sample.wi));
                    let quotient = bxdf.f(wo, sample.wi).x * sample.wi.z.abs() / sample.pdf;
                    assert!((quotient / sample.weight.x - 1.0).abs() < 1e-14); // some twenty roundings
                }
            }
        }
    }

    /// The albedo exceeds 1 at grazing angles below 18.7 degrees, and by 1.52 % at most.
    #[test]
    fn the_printed_approximation_gains_energy() {
        assert!(grey(18.65).rho_hd(0.0).x > 1.0);
        assert!(grey(18.75).rho_hd(0.0).x < 1.0);
        let mut most = (0.0, 0.0, 0.0);
        for i in 0..=1800 {
            let sigma_deg = f64::from(i) * 0.05;
            for j in 0..=100 {
                let mu = f64::from(j) * 0.01;
                let rho = grey(sigma_deg).rho_hd(mu).x;
                if rho > most.0 {
                    most = (rho, sigma_deg, mu);
                }
            }
            assert!(grey(sigma_deg).rho_hh().x <= 1.0);
        }
        assert!((1.0151..1.0152).contains(&most.0) && most.2 == 0.0, "{most:?}");
    }

    #[test]
    fn parameters_are_refused_with_their_range() {
        let error = OrenNayar::new(Spectrum::grey(0.5), 90.1).unwrap_err().to_string();
        assert_eq!(error, "sigma_deg = 90.1 is not allowed: sigma_deg lies in [0, 90]");
        assert!(OrenNayar::new(Spectrum::grey(0.5), f64::NAN).is_err());
        assert!(OrenNayar::new(Spectrum::grey(1.1), 20.0).is_err());
    }
}
