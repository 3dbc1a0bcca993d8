//! The albedo of Burley's diffuse lobe.
//!
//! With r the perceptual roughness and f - 1 = r - 1/2 + r (l.v), the lobe is (1 + (f - 1)(1 - n.l)^5)(1 + (f - 1)(1 - n.v)^5)/pi times
//! the base colour [Burley 2012]; Unity divides it by 1.03571, so that it keeps within 1 up to 45 degrees.
//!
//! l.v = mu x + s sin theta cos phi, with x = n.l and s^2 = 1 - mu^2: over the azimuth f - 1 has the mean g = c_0 + c_1 x, c_0 = r - 1/2,
//! c_1 = r mu, and (f - 1)^2 the mean g^2 + q (1 - x^2), q = r^2 s^2/2. What is left are the moments
//! B_k = int_0^1 x^k (1 - x)^5 dx = k! 5!/(k + 6)!.

/// 1.03571, the largest value of the lobe at normal incidence.
const UNITY: f64 = 1.03571;

/// B_1, B_2 and B_3.
const MOMENTS: [f64; 3] = [1.0 / 42.0, 1.0 / 168.0, 1.0 / 504.0];

/// int f |cos theta| dw at cos theta_o = `mu` and perceptual roughness `r`, both in [0, 1], for a white base.
pub(super) fn disney_diffuse(mu: f64, r: f64) -> f64 {
    let [b1, b2, b3] = MOMENTS;
    let (c0, c1) = (r - 0.5, r * mu);
    let q = 0.5 * r * r * (1.0 - mu * mu);
    let square = (1.0 - mu) * (1.0 - mu);
    let view = square * square * (1.0 - mu);
    let light = 2.0 * (c0 * b1 + c1 * b2);
    let both = 2.0 * (c0 * c0 * b1 + 2.0 * c0 * c1 * b2 + c1 * c1 * b3 + q * (b1 - b3));
    (1.0 + light + view * (c0 + c1 * (2.0 / 3.0)) + view * both) / UNITY
}

#[cfg(test)]
mod tests {
    use super::disney_diffuse;
    use std::f64::consts::TAU;

    /// The closed form against the lobe itself, summed over midpoints of n.l and of the azimuth: polynomials of degree 9, so that the
    /// rule of 400 points is within 1e-5.
    #[test]
    fn closed_form_is_the_integral() {
        for (mu, r) in [(0.0, 0.3), (0.1, 1.0), (0.5, 0.0), (0.9, 0.7), (1.0, 1.0)] {
            let (mu, r): (f64, f64) = (mu, r);
            let (cells, turns) = (400, 16);
            let mut sum = 0.0;
            for i in 0..cells {
                let x = (f64::from(i) + 0.5) / f64::from(cells);
                for j in 0..turns {
                    let phi = TAU * f64::from(j) / f64::from(turns);
                    let lv = mu * x + ((1.0 - mu * mu) * (1.0 - x * x)).sqrt() * phi.cos();
                    let f90 = 0.5 + r + r * lv;
                    let lobe = (1.0 + (f90 - 1.0) * (1.0 - x).powi(5)) * (1.0 + (f90 - 1.0) * (1.0 - mu).powi(5));
                    sum += 2.0 * x * lobe / f64::from(cells * turns);
                }
            }
            let found = disney_diffuse(mu, r);
            assert!((found - sum / 1.03571).abs() < 1e-5, "{mu} {r}: {found} {sum}");
        }
    }
}
