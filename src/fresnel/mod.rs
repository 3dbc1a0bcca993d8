//! Fresnel reflectance of a smooth interface, for unpolarised light.
//!
//! F takes cos theta, the cosine between a direction and the facet normal, in [0, 1], and returns a fraction in [0, 1].
//! At cos theta = 0 every interface reflects everything; where the indices match (eta = 1, k = 0) the limit along
//! cos theta -> 0 is taken instead, which is 0.

pub(crate) mod lanes;
mod mean;

pub use mean::{dielectric_mean, dielectric_mean_transmittance};

use crate::geometry::{Polar, squared_beyond};
use crate::parameter::{ETA, EXTINCTION, ParameterError, R0};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// The five Fresnel terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fresnel {
    /// 1 everywhere: a perfect mirror.
    None,
    /// Interface of two dielectrics, eta = eta_t/eta_i [pbrt 2010, section 8.2.1].
    Dielectric {
        /// Relative index of refraction.
        eta: Spectrum,
    },
    /// Interface with a conductor of index eta + ik, exact [pbrt 2016, eq. 8.3].
    Conductor {
        /// Relative index of refraction.
        eta: Spectrum,
        /// Relative extinction coefficient.
        k: Spectrum,
    },
    /// The approximation for conductors of large eta, k [pbrt 2010, eq. 8.1 and 8.2].
    ConductorApproximate {
        /// Relative index of refraction.
        eta: Spectrum,
        /// Relative extinction coefficient.
        k: Spectrum,
    },
    /// Schlick's r0 + (1 - r0)(1 - cos theta)^5.
    Schlick {
        /// Reflectance at normal incidence.
        r0: Spectrum,
    },
}

impl Fresnel {
    /// Dielectric with relative index eta in [0.01, 100] in every channel, [`ETA`].
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn dielectric(eta: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self::Dielectric { eta: eta.check(ETA)? })
    }

    /// Conductor with eta in [0.01, 100], [`ETA`], and k in [0, 100], [`EXTINCTION`], in every channel.
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn conductor(eta: Spectrum, k: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self::Conductor {
            eta: eta.check(ETA)?,
            k: k.check(EXTINCTION)?,
        })
    }

    /// Approximate conductor with eta in [0.01, 100], [`ETA`], and k in [0, 100], [`EXTINCTION`], in every channel.
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn conductor_approximate(eta: Spectrum, k: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self::ConductorApproximate {
            eta: eta.check(ETA)?,
            k: k.check(EXTINCTION)?,
        })
    }

    /// Schlick's approximation with r0 in [0, 1] in every channel, [`R0`].
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn schlick(r0: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self::Schlick { r0: r0.check(R0)? })
    }

    /// Number of independent channels.
    pub fn channels(&self) -> Channels {
        match self {
            Self::None => Channels::Grey,
            Self::Dielectric { eta } => eta.channels(),
            Self::Conductor { eta, k } | Self::ConductorApproximate { eta, k } => eta.channels().max(k.channels()),
            Self::Schlick { r0 } => r0.channels(),
        }
    }

    /// Reflectance F at `cos` in [0, 1], per channel.
    pub fn reflectance(&self, cos: f64) -> DVec3 {
        self.reflectance_at(Polar::from_cos(cos))
    }

    /// Reflectance F at the facet angle `theta`, per channel.
    ///
    /// For small |n| all of F happens within a sine of |n|, which the cosine alone does not resolve: at eta = 0.01 its last
    /// bit is 1e-8 of F.
    pub fn reflectance_at(&self, theta: Polar) -> DVec3 {
        let cos = theta.cos;
        match self {
            Self::None => DVec3::ONE,
            Self::Dielectric { eta } => per_channel(*eta, |eta| dielectric_at(theta, eta)),
            Self::Conductor { eta, k } => per_channel_pair(*eta, *k, |eta, k| conductor_at(theta, eta, k)),
            Self::ConductorApproximate { eta, k } => {
                per_channel_pair(*eta, *k, |eta, k| conductor_approximate(cos, eta, k))
            }
            Self::Schlick { r0 } => {
                let r0 = r0.value();
                r0 + (DVec3::ONE - r0) * (1.0 - cos).powi(5)
            }
        }
    }

    /// The same interface seen from its other side.
    ///
    /// The indices of a dielectric change places, eta becomes 1/eta. The other terms stay as they are and take |cos theta|,
    /// as pbrt's do: no light arrives from inside a conductor, and the rest know no sides [pbrt 2010, section 8.2.1].
    pub fn reversed(&self) -> Self {
        match self {
            Self::Dielectric { eta } => Self::Dielectric {
                eta: match eta.channels() {
                    Channels::Grey => Spectrum::grey(eta.value().x.recip()),
                    Channels::Pair | Channels::Rgb => Spectrum::rgb(eta.value().recip().to_array()),
                },
            },
            Self::None | Self::Conductor { .. } | Self::ConductorApproximate { .. } | Self::Schlick { .. } => *self,
        }
    }

    /// Cosines in (0, 1) at which integrators should split, in increasing order.
    ///
    /// With g = sqrt((eta + ik)^2 - 1 + cos^2) the amplitudes are (cos - g)/(cos + g) and (n^2 cos - g)/(n^2 cos + g),
    /// n = eta + ik. They are smooth on the scale on which cos, g and n^2 cos outgrow each other, and over the ranges of
    /// scales above it:
    /// - g branches at cos^2 = 1 - n^2. For a dielectric with eta < 1 that is the edge of total internal reflection, a kink;
    ///   an extinction rounds it over a cosine of Im sqrt(1 - n^2). For nearly matched indices it lies near cos = 0.
    /// - For large |n| the second denominator nearly vanishes at cos = 1/|n|, for small |n| where |g| = |n|^2, beyond the edge.
    /// - For small |n| all of that happens within a sine of |n|.
    pub fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        match self {
            Self::Dielectric { eta } => {
                for (eta, _) in distinct([eta.value(), DVec3::ZERO]) {
                    edges_of_interface(eta, 0.0, &mut edges);
                }
            }
            Self::Conductor { eta, k } => {
                for (eta, k) in distinct([eta.value(), k.value()]) {
                    edges_of_interface(eta, k, &mut edges);
                }
            }
            // the zeros of the two denominators lie at distances 1/|n| and |n| from cos = 0
            Self::ConductorApproximate { eta, k } => {
                for (eta, k) in distinct([eta.value(), k.value()]) {
                    let size = libm::hypot(eta, k);
                    edges.extend(scales(size, LARGEST_SCALE).map(smooth_edge));
                    edges.extend(scales(size.recip(), LARGEST_DOUBLE_POLE).map(smooth_edge));
                }
            }
            Self::None | Self::Schlick { .. } => {}
        }
        edges.retain(|edge| edge.cos > 0.0 && edge.cos < 1.0);
        edges.sort_by(|a, b| a.cos.total_cmp(&b.cos).then(b.kink.cmp(&a.kink)));
        edges.dedup_by(|b, a| a.cos == b.cos);
        edges
    }
}

/// A cosine at which a Fresnel term changes its behaviour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The cosine.
    pub cos: f64,
    /// Whether F has a square root there, below which it is 1.
    pub kink: bool,
}

/// Scales below this need splits of their own; a rule of 15 nodes resolves wider ones.
const LARGEST_SCALE: f64 = 0.3;
/// The same for a pole near cos = 0, which the rules resolve sooner than a branch.
const LARGEST_POLE: f64 = 0.1;
/// And for two poles that coincide, as those of the approximate conductor do for small k.
const LARGEST_DOUBLE_POLE: f64 = 0.25;
/// Ratio of consecutive splits; a rule of 15 nodes resolves a branch point at that distance to ten digits.
const SCALE_STEP: f64 = 6.0;
/// A kink rounded over less than this share of its cosine is near enough to a square root for a variable that suits one.
const LARGEST_ROUNDING: f64 = 0.03;
/// A kink rounded over less than this share needs no splits: its integral differs from that of a square root by the 3/2 power.
const SHARP: f64 = 1e-10;

fn smooth_edge(cos: f64) -> Edge {
    Edge { cos, kink: false }
}

/// `scale` and its multiples by powers of [`SCALE_STEP`] below 1, if it is less than `largest`. Matched indices, of scale
/// 0, have none: they reflect nothing at any angle.
fn scales(scale: f64, largest: f64) -> impl Iterator<Item = f64> {
    let first = (scale > 0.0 && scale < largest).then_some(scale);
    std::iter::successors(first, |s| Some(s * SCALE_STEP)).take_while(|s| *s < 1.0)
}

fn edges_of_interface(eta: f64, k: f64, edges: &mut Vec<Edge>) {
    // 1 - n^2 = re - i im
    let (re, im) = ((1.0 - eta) * (1.0 + eta) + k * k, 2.0 * eta * k);
    let modulus = libm::hypot(re, im);
    let size = libm::hypot(eta, k);
    let cos = (0.5 * (modulus + re)).sqrt();
    let rounding = 0.5 * im / cos;
    let kink = re > 0.0 && eta < 1.0 && rounding < LARGEST_ROUNDING * cos;
    // the first of the scales below are where the kink is
    let skipped = usize::from(kink);
    edges.extend(scales(modulus.sqrt(), LARGEST_SCALE).skip(skipped).map(smooth_edge));
    edges.extend(scales(size.recip(), LARGEST_POLE).map(smooth_edge));
    if kink {
        edges.push(Edge { cos, kink });
        if rounding > SHARP * cos {
            let distances = scales(rounding, 1.0).take_while(|s| *s < cos);
            edges.extend(distances.flat_map(|s| [cos - s, cos + s].map(smooth_edge)));
        }
        // |g| = |n|^2 and beyond
        let poles = scales(size * size, LARGEST_POLE).take_while(|g| *g < size);
        edges.extend(poles.map(|g| smooth_edge((re + g * g).sqrt())));
    }
    let sines = scales(size, LARGEST_SCALE).skip(skipped);
    edges.extend(sines.map(|sin| smooth_edge(((1.0 - sin) * (1.0 + sin)).sqrt())));
}

/// The pairs of channels that differ.
fn distinct([a, b]: [DVec3; 2]) -> Vec<(f64, f64)> {
    let mut pairs: Vec<(f64, f64)> = a.to_array().into_iter().zip(b.to_array()).collect();
    pairs.dedup();
    pairs
}

fn per_channel(a: Spectrum, f: impl Fn(f64) -> f64) -> DVec3 {
    let v = a.value();
    match a.channels() {
        Channels::Grey => DVec3::splat(f(v.x)),
        Channels::Pair | Channels::Rgb => DVec3::new(f(v.x), f(v.y), f(v.z)),
    }
}

fn per_channel_pair(a: Spectrum, b: Spectrum, f: impl Fn(f64, f64) -> f64) -> DVec3 {
    let (v, w) = (a.value(), b.value());
    match a.channels().max(b.channels()) {
        Channels::Grey => DVec3::splat(f(v.x, w.x)),
        Channels::Pair | Channels::Rgb => DVec3::new(f(v.x, w.x), f(v.y, w.y), f(v.z, w.z)),
    }
}

/// eta^2 cos^2 - sin^2, 0 at Brewster's angle, for g = sqrt(eta^2 - sin^2) >= 0.
///
/// For small eta that angle and the edge of total reflection, tan = eta and sin = eta, are apart by eta^3/2 only: near the edge
/// eta cos - sin would lose 2/eta^2 roundings, and g^2 - eta^2 sin^2, the same number, loses none. For large eta that one
/// cancels, at grazing.
#[inline(always)]
pub(crate) fn beyond_brewster(theta: Polar, eta: f64, g: f64) -> f64 {
    let Polar { sin, cos } = theta;
    let (a, b) = if eta < 1.0 { (g, eta * sin) } else { (eta * cos, sin) };
    (a - b) * (a + b)
}

/// Dielectric reflectance at `cos`, exact for unpolarised light.
pub fn dielectric(cos: f64, eta: f64) -> f64 {
    dielectric_at(Polar::from_cos(cos), eta)
}

/// Dielectric reflectance, exact for unpolarised light.
///
/// With g = eta cos theta_t = sqrt(eta^2 - sin^2) the amplitudes are r_perp = (cos - g)/(cos + g) and
/// r_par = (eta^2 cos - g)/(eta^2 cos + g). Multiplied by their conjugates the numerators become
/// (1 - eta)(1 + eta) and (eta - 1)(eta + 1)(eta^2 cos^2 - sin^2), which hold all digits for eta near 1; the last factor is
/// in [`beyond_brewster`]. Nothing here asks eta to be a legal parameter: the quotient of two legal indices, 1e-4 to 1e4,
/// will do.
pub(crate) fn dielectric_at(theta: Polar, eta: f64) -> f64 {
    let cos = theta.cos;
    let step = (eta - 1.0) * (eta + 1.0);
    if cos == 0.0 {
        return if step == 0.0 { 0.0 } else { 1.0 };
    }
    let g_squared = squared_beyond(theta, eta);
    if g_squared <= 0.0 {
        return if step == 0.0 { 0.0 } else { 1.0 };
    }
    let g = g_squared.sqrt();
    let eta_squared = eta * eta;
    let r_perp = -step / ((cos + g) * (cos + g));
    let par = eta_squared * cos + g;
    let r_par = step * beyond_brewster(theta, eta, g) / (par * par);
    (0.5 * (r_perp * r_perp + r_par * r_par)).min(1.0)
}

/// 1 - F of a dielectric for light at the cosine `cos` that goes on at the cosine `g`/eta, g = sqrt(eta^2 - sin^2) > 0.
///
/// 1 - r_perp^2 = 4 cos g/(cos + g)^2 and 1 - r_par^2 = 4 eta^2 cos g/(eta^2 cos + g)^2 cancel nothing, and stay the same when
/// the light runs the other way.
#[inline(always)]
pub(crate) fn dielectric_passes(cos: f64, g: f64, eta: f64) -> f64 {
    let perp = (cos + g).recip();
    let par = eta / (eta * eta * cos + g);
    (2.0 * cos * g * (perp * perp + par * par)).min(1.0)
}

/// Conductor reflectance at `cos` for index eta + ik, exact for unpolarised light.
pub fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    conductor_at(Polar::from_cos(cos), eta, k)
}

/// Conductor reflectance for index eta + ik, exact for unpolarised light [pbrt 2016, eq. 8.3].
///
/// a + ib is the square root of (eta + ik)^2 - sin^2. a^2 and b^2 are (|z| +- Re z)/2; the one that cancels is taken from
/// their product (eta k)^2. The numerators of both reflectances are written as sums of squares.
fn conductor_at(theta: Polar, eta: f64, k: f64) -> f64 {
    let cos = theta.cos;
    let matched = eta == 1.0 && k == 0.0;
    if matched || cos == 0.0 {
        return if matched { 0.0 } else { 1.0 };
    }
    let cos2 = cos * cos;
    let sin2 = theta.sin * theta.sin;
    let re = squared_beyond(theta, eta) - k * k;
    let im = 2.0 * eta * k;
    let modulus = libm::hypot(re, im);
    let (a2, b2) = if re >= 0.0 {
        let a2 = 0.5 * (modulus + re);
        (a2, if a2 > 0.0 { 0.25 * im * im / a2 } else { 0.0 })
    } else {
        let b2 = 0.5 * (modulus - re);
        (0.25 * im * im / b2, b2)
    };
    let a = a2.sqrt();
    // a - cos = (a^2 - cos^2)/(a + cos) with a^2 - cos^2 = b^2 + (eta - 1)(eta + 1) - k^2
    let sum = a + cos;
    let difference = (b2 + (eta - 1.0) * (eta + 1.0) - k * k) / sum;
    let r_perp = (difference * difference + b2) / (sum * sum + b2);
    let (p, q) = (a * cos - sin2, a * cos + sin2);
    let cos_b = cos2 * b2;
    let denominator = q * q + cos_b;
    let ratio = if denominator > 0.0 {
        (p * p + cos_b) / denominator
    } else {
        1.0
    };
    (0.5 * r_perp * (1.0 + ratio)).min(1.0)
}

/// Approximate conductor reflectance [pbrt 2010, eq. 8.1 and 8.2]; the printed r^2 are powers already.
pub fn conductor_approximate(cos: f64, eta: f64, k: f64) -> f64 {
    let cos2 = cos * cos;
    let norm = eta * eta + k * k;
    let cross = 2.0 * eta * cos;
    // norm cos^2 - 2 eta cos + 1 = (eta cos - 1)^2 + k^2 cos^2, and likewise below: sums of squares do not cancel
    let r_par = ((eta * cos - 1.0).powi(2) + k * k * cos2) / (norm * cos2 + cross + 1.0);
    let r_perp = ((eta - cos).powi(2) + k * k) / (norm + cross + cos2);
    0.5 * (r_par + r_perp)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ETAS: [f64; 7] = [0.01, 0.5, 0.999, 1.00029, 1.329, 2.42, 100.0];

    /// Textbook amplitudes, without regard for cancellation.
    fn dielectric_textbook(cos: f64, eta: f64) -> f64 {
        let cos_t_squared = 1.0 - (1.0 - cos * cos) / (eta * eta);
        if cos_t_squared < 0.0 {
            return 1.0;
        }
        let cos_t = cos_t_squared.sqrt();
        let r_par = (eta * cos - cos_t) / (eta * cos + cos_t);
        let r_perp = (cos - eta * cos_t) / (cos + eta * cos_t);
        0.5 * (r_par * r_par + r_perp * r_perp)
    }

    #[test]
    fn dielectric_matches_the_textbook_form_where_that_one_holds() {
        for eta in ETAS {
            for i in 0..=64 {
                let cos = f64::from(i) / 64.0;
                let (f, g) = (dielectric(cos, eta), dielectric_textbook(cos, eta));
                // the textbook form loses digits to 1 - sin^2/eta^2, at worst half of them near the edge
                assert!((f - g).abs() < 1e-11, "eta {eta}, cos {cos}: {f} and {g}");
            }
        }
    }

    #[test]
    fn normal_incidence_grazing_and_matched_indices() {
        for eta in ETAS {
            let r: f64 = (eta - 1.0) / (eta + 1.0);
            // eta - 1 of the reference keeps 3e-13 relative at eta = 1.00029
            assert!((dielectric(1.0, eta) / (r * r) - 1.0).abs() < 1e-12, "eta {eta}");
            assert_eq!(dielectric(0.0, eta), 1.0);
            assert_eq!(conductor(0.0, eta, 0.3), 1.0);
        }
        for cos in [0.0, 1e-200, 0.3, 1.0] {
            assert_eq!(dielectric(cos, 1.0), 0.0);
            assert_eq!(conductor(cos, 1.0, 0.0), 0.0);
        }
    }

    #[test]
    fn weak_interface_keeps_relative_accuracy() {
        // the textbook amplitudes in 40-digit arithmetic at the f64 nearest to 1.00029
        let reference = 4.706_738_024_002_212e-6;
        let f = dielectric(0.25, 1.00029);
        assert!((f / reference - 1.0).abs() < 1e-12, "{f:e}"); // eta - 1 carries 2e-16/3e-4
    }

    #[test]
    fn conductor_without_extinction_is_a_dielectric() {
        for eta in ETAS {
            for i in 0..=100 {
                let cos = f64::from(i) / 100.0;
                let (f, g) = (conductor(cos, eta, 0.0), dielectric(cos, eta));
                assert!((f - g).abs() < 1e-13, "eta {eta}, cos {cos}: {f} and {g}");
                // k -> 0 is continuous, at worst like sqrt(k) at the edge of total reflection
                assert!((conductor(cos, eta, 1e-16) - g).abs() < 1e-6);
            }
        }
    }

    /// [Mikkelsen 2009, section 3]: aluminium at 500 nm reflects 92 % at normal incidence.
    #[test]
    fn aluminium_exact_and_approximate() {
        let (eta, k) = (0.769_f64, 6.08);
        let r = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        assert!((conductor(1.0, eta, k) - r).abs() < 1e-15);
        assert!((conductor_approximate(1.0, eta, k) - r).abs() < 1e-15);
        let worst = (0..=1000)
            .map(|i| f64::from(i) / 1000.0)
            .map(|cos| (conductor(cos, eta, k) - conductor_approximate(cos, eta, k)).abs())
            .fold(0.0, f64::max);
        assert!((2.0e-3..2.4e-3).contains(&worst), "{worst}");
    }

    #[test]
    fn every_term_stays_within_0_and_1() {
        for eta in ETAS {
            for k in [0.0, 1e-12, 1e-3, 1.0, 100.0] {
                for i in 0..=200 {
                    let cos = (f64::from(i) / 200.0).powi(3);
                    for f in [
                        dielectric(cos, eta),
                        conductor(cos, eta, k),
                        conductor_approximate(cos, eta, k),
                    ] {
                        assert!((0.0..=1.0).contains(&f), "eta {eta}, k {k}, cos {cos}: {f}");
                    }
                }
            }
        }
    }

    #[test]
    fn edges_are_where_total_reflection_begins() {
        let f = Fresnel::dielectric(Spectrum::grey(0.75)).unwrap();
        let [Edge { cos: edge, kink: true }] = f.edges()[..] else {
            panic!("one edge")
        };
        assert_eq!(f.reflectance(edge * 0.999_999).x, 1.0);
        assert!(f.reflectance(edge * 1.001).x < 0.95);
        assert!(Fresnel::dielectric(Spectrum::grey(1.0)).unwrap().edges().is_empty());
        assert!(Fresnel::dielectric(Spectrum::grey(0.0)).is_err());
        assert!(Fresnel::schlick(Spectrum::rgb([0.0, 1.1, 0.0])).is_err());
    }
}
