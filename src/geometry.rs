//! Directions around a surface normal: polar angles that stay accurate, reflection, refraction, half vectors, frames.

use glam::{DVec2, DVec3};

/// A polar angle theta in [0, pi/2], held as its sine and cosine so that neither end loses digits.
///
/// 1 - cos theta of a narrow lobe and cos theta at the horizon are both differences of nearly equal numbers when formed
/// from the other; with the pair at hand they are not formed that way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polar {
    /// sin theta, in [0, 1].
    pub sin: f64,
    /// cos theta, in [0, 1].
    pub cos: f64,
}

impl Polar {
    /// theta = 0.
    pub const POLE: Self = Self { sin: 0.0, cos: 1.0 };

    /// From the angle in radians, within [0, pi/2].
    pub fn from_angle(theta: f64) -> Self {
        Self {
            sin: libm::sin(theta),
            cos: libm::cos(theta).max(0.0),
        }
    }

    /// From cos theta, exact to rounding in the cosine.
    pub fn from_cos(cos: f64) -> Self {
        Self {
            sin: ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(),
            cos,
        }
    }

    /// From versin theta = 1 - cos theta and cos theta, each given accurately.
    pub fn from_versine(versine: f64, cos: f64) -> Self {
        Self {
            sin: (versine * (1.0 + cos)).sqrt(),
            cos,
        }
    }

    /// From tan theta, infinity included.
    pub fn from_tan(tan: f64) -> Self {
        if tan > 1e150 {
            return Self {
                sin: 1.0,
                cos: tan.recip(),
            };
        }
        let cos = (1.0 + tan * tan).sqrt().recip();
        Self { sin: tan * cos, cos }
    }

    /// Polar angle of a vector in the upper half space, of any length.
    pub fn of(v: DVec3) -> Self {
        let radius = libm::hypot(v.x, v.y);
        let length = libm::hypot(radius, v.z);
        Self {
            sin: radius / length,
            cos: v.z / length,
        }
    }

    /// 1 - cos theta.
    pub fn versine(self) -> f64 {
        self.sin * self.sin / (1.0 + self.cos)
    }

    /// tan theta, infinite at the horizon.
    pub fn tan(self) -> f64 {
        self.sin / self.cos
    }

    /// ln cos theta, accurate near the pole; minus infinity at the horizon.
    pub fn ln_cos(self) -> f64 {
        if self.sin < 0.5 {
            0.5 * libm::log1p(-self.sin * self.sin)
        } else {
            libm::log(self.cos)
        }
    }

    /// ln sin theta, accurate near the horizon; minus infinity at the pole.
    pub fn ln_sin(self) -> f64 {
        if self.cos < 0.5 {
            0.5 * libm::log1p(-self.cos * self.cos)
        } else {
            libm::log(self.sin)
        }
    }

    /// The angle in radians.
    pub fn angle(self) -> f64 {
        libm::atan2(self.sin, self.cos)
    }

    /// The unit vector at azimuth `phi` (radians).
    pub fn direction(self, phi: f64) -> DVec3 {
        DVec3::new(self.sin * libm::cos(phi), self.sin * libm::sin(phi), self.cos)
    }
}

/// The unit vector at the azimuth `phi` in radians.
pub fn at_azimuth(phi: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(phi);
    DVec2::new(cos, sin)
}

/// The unit vector along the azimuth of `w`; x for the normal, which has none.
///
/// Of the components relative to the larger one: the squares of both underflow within 1e-154 of the normal, and from 1e-150
/// on a quotient by the root of their sum would be a unit vector no more.
pub fn azimuth_of(w: DVec3) -> DVec2 {
    let along = w.truncate();
    (along / along.abs().max_element()).normalize_or(DVec2::X)
}

/// Mirror image of `w` about the axis `wm`: 2 (w.wm) wm - w [Mikkelsen 2009, eq. 6].
pub fn reflect(w: DVec3, wm: DVec3) -> DVec3 {
    2.0 * w.dot(wm) * wm - w
}

/// eta^2 - sin^2 theta in the form that holds its digits: near grazing for eta near 1, near the normal for eta near 0.
pub(crate) fn squared_beyond(theta: Polar, eta: f64) -> f64 {
    if theta.cos < theta.sin {
        (eta - 1.0) * (eta + 1.0) + theta.cos * theta.cos
    } else {
        (eta - theta.sin) * (eta + theta.sin)
    }
}

/// Direction into which `w`, on the side of `n`, is refracted; `None` under total internal reflection.
///
/// `eta` is the index of the far side over the near side. The result points away from the surface, to the far side: its
/// tangential part is that of -w over eta [pbrt 2010, section 8.2].
pub fn refract(w: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let cos = w.dot(n);
    let along = w - n * cos;
    let square = squared_beyond(
        Polar {
            sin: along.length(),
            cos,
        },
        eta,
    );
    (square >= 0.0).then(|| -(n * square.sqrt() + along) / eta)
}

/// The half vector of two directions with the cosine that both make with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfVector {
    /// The direction half way, unit length.
    pub wh: DVec3,
    /// wo.wh = wi.wh = |wo + wi|/2, a form that does not change a bit when the two directions are exchanged.
    pub cos_d: f64,
}

/// Half vector of `wo` and `wi` [Mikkelsen 2009, eq. 10]; `None` for opposite directions, which have none.
pub fn half_vector(wo: DVec3, wi: DVec3) -> Option<HalfVector> {
    // a power of two, exact, keeps the squares of directions that are opposite to within 1e-140 from underflowing
    let sum = wo + wi;
    let scale = if sum.abs().max_element() < 1e-140 {
        2f64.powi(500)
    } else {
        1.0
    };
    let scaled = sum * scale;
    let length = scaled.length();
    if length == 0.0 {
        return None;
    }
    Some(HalfVector {
        wh: scaled / length,
        cos_d: (0.5 * length / scale).min(1.0),
    })
}

/// An orthonormal frame around a surface normal: the local frame of the integrals has n = +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// First tangent, local +x.
    pub s: DVec3,
    /// Second tangent, local +y.
    pub t: DVec3,
    /// Normal, local +z.
    pub n: DVec3,
}

impl Frame {
    /// A right-handed frame around the unit vector `n`, continuous except where n.z changes sign.
    pub fn from_normal(n: DVec3) -> Self {
        let (s, t) = n.any_orthonormal_pair();
        Self { s, t, n }
    }

    /// World to local coordinates.
    pub fn to_local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.s), w.dot(self.t), w.dot(self.n))
    }

    /// Local to world coordinates.
    pub fn to_world(&self, w: DVec3) -> DVec3 {
        self.s * w.x + self.t * w.y + self.n * w.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPS: f64 = 4e-16; // a few roundings of numbers near 1

    #[test]
    fn polar_forms_agree_and_keep_both_ends() {
        for theta in [0.0, 1e-12, 1e-6, 0.3, 1.0, 1.5, std::f64::consts::FRAC_PI_2] {
            let polar = Polar::from_angle(theta);
            assert!((polar.angle() - theta).abs() < EPS * 2.0);
            assert!((polar.versine() - 2.0 * (0.5 * theta).sin().powi(2)).abs() <= EPS * polar.versine());
            assert!((Polar::of(polar.direction(1.3) * 7.0).sin - polar.sin).abs() < EPS);
        }
        assert!((Polar::from_tan(1e-9).versine() - 0.5e-18).abs() < 1e-33);
        assert_eq!(Polar::from_tan(f64::INFINITY), Polar { sin: 1.0, cos: 0.0 });
        assert!((Polar::from_angle(1e-9).ln_cos() + 0.5e-18).abs() < 1e-33);
    }

    #[test]
    fn azimuths_are_unit_vectors_however_near_the_normal() {
        for radius in [1.0, 1e-9, 1e-160, 1e-300] {
            let azimuth = azimuth_of(DVec3::new(0.6 * radius, -0.8 * radius, 1.0));
            assert!(
                (azimuth - DVec2::new(0.6, -0.8)).length() < EPS,
                "{radius:e}: {azimuth}"
            );
        }
        assert_eq!(azimuth_of(DVec3::new(0.0, -5e-324, 1.0)), DVec2::NEG_Y);
        assert_eq!(azimuth_of(DVec3::Z), DVec2::X);
    }

    #[test]
    fn reflection_keeps_the_angle_and_is_its_own_inverse() {
        let wo = Polar::from_angle(1.1).direction(0.4);
        let wm = Polar::from_angle(0.5).direction(-0.9);
        let wi = reflect(wo, wm);
        assert!((wi.dot(wm) - wo.dot(wm)).abs() < EPS);
        assert!((reflect(wi, wm) - wo).length() < 2.0 * EPS);
        let half = half_vector(wo, wi).unwrap();
        assert!((half.wh - wm).length() < 4.0 * EPS);
        assert!((half.cos_d - wo.dot(wm)).abs() < EPS);
    }

    #[test]
    fn refraction_obeys_snell_and_reverses() {
        let n = DVec3::Z;
        let wo = Polar::from_angle(0.7).direction(0.2);
        for eta in [0.75, 1.0, 1.00029, 1.5, 100.0] {
            let wt = refract(wo, n, eta).unwrap();
            let (sin_o, sin_t) = (Polar::of(wo).sin, wt.x.hypot(wt.y));
            assert!((sin_o - eta * sin_t).abs() < EPS, "eta {eta}");
            assert!((wt.length() - 1.0).abs() < EPS);
            let back = refract(wt, -n, eta.recip()).unwrap();
            assert!((back - wo).length() < 1e-13 * eta.max(1.0), "eta {eta}"); // rounding of sin_t grows by eta on the way back
        }
        assert_eq!(refract(wo, n, 0.5), None);
    }

    #[test]
    fn half_vector_is_symmetric_to_the_bit_and_absent_for_opposite_directions() {
        let wo = Polar::from_angle(1.2).direction(0.0);
        let wi = Polar::from_angle(0.4).direction(2.0);
        assert_eq!(half_vector(wo, wi), half_vector(wi, wo));
        assert_eq!(half_vector(wo, -wo), None);
    }

    #[test]
    fn frames_are_orthonormal_and_invert() {
        for n in [
            DVec3::Z,
            -DVec3::Z,
            DVec3::new(0.6, 0.0, 0.8),
            DVec3::new(-0.48, 0.6, -0.64),
        ] {
            let frame = Frame::from_normal(n);
            assert!((frame.s.cross(frame.t) - n).length() < EPS);
            let w = DVec3::new(0.1, -0.7, 0.3);
            assert!((frame.to_world(frame.to_local(w)) - w).length() < EPS);
            assert!((frame.to_local(n) - DVec3::Z).length() < EPS);
        }
    }
}
