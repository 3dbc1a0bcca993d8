//! Straight lines through points, by least squares.

/// y = intercept + slope x, with the spread of the points about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// y at x = 0.
    pub intercept: f64,
    /// Change of y with x.
    pub slope: f64,
    /// Standard error of the slope, from the residuals.
    pub slope_error: f64,
    /// Number of points.
    pub points: usize,
}

impl Line {
    /// The line of least squares through at least three `points` with two different x; fewer know no error of their slope.
    ///
    /// slope = sum (x - mx)(y - my)/sum (x - mx)^2, and its variance is sum r^2/((n - 2) sum (x - mx)^2) with the
    /// residuals r.
    pub fn through(points: &[[f64; 2]]) -> Option<Self> {
        let n = points.len() as f64;
        // sums about the mean of equal numbers need not be 0
        let same = points.iter().all(|[x, _]| *x == points[0][0]);
        if points.len() < 3 || same || points.iter().flatten().any(|value| !value.is_finite()) {
            return None;
        }
        let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / n;
        let (mx, my) = (mean(0), mean(1));
        let sxx: f64 = points.iter().map(|[x, _]| (x - mx).powi(2)).sum();
        let sxy: f64 = points.iter().map(|[x, y]| (x - mx) * (y - my)).sum();
        let slope = sxy / sxx;
        let intercept = my - slope * mx;
        let residuals: f64 = points.iter().map(|[x, y]| (y - intercept - slope * x).powi(2)).sum();
        Some(Self {
            intercept,
            slope,
            slope_error: (residuals / (n - 2.0) / sxx).sqrt(),
            points: points.len(),
        })
    }

    /// The same through the logarithms of both coordinates, to base 10, of the points whose coordinates are positive: the
    /// slope is the exponent of a power law.
    pub fn through_logarithms(points: &[[f64; 2]]) -> Option<Self> {
        let positive = points.iter().filter(|point| point.iter().all(|value| *value > 0.0));
        let logarithms: Vec<[f64; 2]> = positive.map(|point| point.map(f64::log10)).collect();
        Self::through(&logarithms)
    }

    /// y at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_with_the_error_of_their_slope() {
        let exact: Vec<[f64; 2]> = (0..5).map(|i| [f64::from(i), 3.0 - 0.5 * f64::from(i)]).collect();
        let line = Line::through(&exact).unwrap();
        assert!((line.slope + 0.5).abs() < 1e-15 && line.slope_error < 1e-15, "{line:?}");
        assert!((line.at(10.0) + 2.0).abs() < 1e-14);
        // residuals 1, -2, 1 about y = 0: variance 6/(3 - 2)/2
        let line = Line::through(&[[-1.0, 1.0], [0.0, -2.0], [1.0, 1.0]]).unwrap();
        assert_eq!((line.slope, line.intercept), (0.0, 0.0));
        assert!((line.slope_error - 3f64.sqrt()).abs() < 1e-15, "{line:?}");
    }

    #[test]
    fn a_power_law_is_a_line_in_logarithms() {
        let law: Vec<[f64; 2]> = (4..10).map(|k| [2f64.powi(k), 7.0 * 2f64.powi(-k)]).collect();
        let line = Line::through_logarithms(&law).unwrap();
        assert!((line.slope + 1.0).abs() < 1e-14 && (line.intercept - 7f64.log10()).abs() < 1e-13);
        assert_eq!(Line::through_logarithms(&[[1.0, 1.0], [2.0, 1.0], [3.0, 0.0]]), None);
    }

    #[test]
    fn too_little_is_no_line() {
        assert_eq!(Line::through(&[[0.0, 0.0], [1.0, 1.0]]), None);
        assert_eq!(Line::through(&[[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), None);
        // three times 0.1 over 3 is not 0.1
        assert_eq!(Line::through(&[[0.1, 0.0], [0.1, 1.0], [0.1, 2.0]]), None);
        assert_eq!(Line::through(&[[0.0, 0.0], [1.0, 1.0], [2.0, f64::INFINITY]]), None);
    }
}
