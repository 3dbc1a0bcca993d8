//! An axis of a table: which parameter it runs over, how texture coordinates map to values, and where texels sit.
//!
//! Everything that a shader has to know to look a table up is here, so that the file, the manifest and the generated
//! shader cannot disagree about it.

use thiserror::Error;

/// Largest number of texels along one axis: what every current GPU takes as a 2D texture.
pub const MAX_SIZE: usize = 16384;

/// Name of the axis of cos theta_o.
pub const MU: &str = "mu";

/// Name of the axis of the azimuth of wo, in radians. It runs from the tangent x to the tangent y; models that have one are
/// symmetric about both, so that phi = atan2(|wo.y|, |wo.x|) looks up any direction.
pub const AZIMUTH: &str = "phi";

/// How the texture coordinate u in [0, 1] and the value v in [min, max] of the parameter correspond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mapping {
    /// u = v, over [0, 1] only: no arithmetic in the shader.
    Mu,
    /// u = sqrt(v), over [0, 1] only: texels crowd towards grazing directions.
    SqrtMu,
    /// u = v^(1/4) as two square roots, over [0, 1] only: the layers of narrow lobes, thinner than a texel of the above.
    FourthRootMu,
    /// u = (v - min) / (max - min).
    Linear,
    /// u = (sqrt(v) - sqrt(min)) / (sqrt(max) - sqrt(min)), for min >= 0: of a slope alpha the perceptual roughness sqrt(alpha).
    Sqrt,
    /// u = v^(3/4) as two square roots, over [0, 1] only: of a perceptual roughness, texels crowd a little towards mirrors.
    ThreeQuarters,
    /// u = ln(v / min) / ln(max / min), for min > 0.
    Log,
    /// u = (ln(1 + v) - ln(1 + min)) / (ln(1 + max) - ln(1 + min)), for min > -1: logarithmic, yet reaching v = 0.
    Log1p,
}

impl Mapping {
    /// Every mapping.
    pub const ALL: [Mapping; 8] = [
        Mapping::Mu,
        Mapping::SqrtMu,
        Mapping::FourthRootMu,
        Mapping::Linear,
        Mapping::Sqrt,
        Mapping::ThreeQuarters,
        Mapping::Log,
        Mapping::Log1p,
    ];

    /// The name in files, manifests and messages.
    pub fn name(self) -> &'static str {
        match self {
            Mapping::Mu => "mu",
            Mapping::SqrtMu => "sqrt-mu",
            Mapping::FourthRootMu => "fourth-root-mu",
            Mapping::Linear => "linear",
            Mapping::Sqrt => "sqrt",
            Mapping::ThreeQuarters => "three-quarters",
            Mapping::Log => "log",
            Mapping::Log1p => "log1p",
        }
    }

    /// The mapping called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mapping| mapping.name() == name)
    }

    /// Whether the mapping can run over `[min, max]`, and if not, what it needs.
    fn needs(self, min: f64, max: f64) -> Result<(), &'static str> {
        match self {
            Mapping::Mu | Mapping::SqrtMu | Mapping::FourthRootMu | Mapping::ThreeQuarters
                if (min, max) != (0.0, 1.0) =>
            {
                Err("the range [0, 1]")
            }
            Mapping::Sqrt if min < 0.0 => Err("min >= 0"),
            Mapping::Sqrt if min.sqrt() >= max.sqrt() => Err("ends whose roots differ"),
            Mapping::Log if min <= 0.0 => Err("min > 0"),
            Mapping::Log if !(max / min).is_finite() => Err("a finite max / min"),
            Mapping::Log1p if min <= -1.0 => Err("min > -1"),
            _ => Ok(()),
        }
    }
}

/// Where the n texels of an axis sit in texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TexelRule {
    /// Texel i at u = (i + 0.5) / n. A linear-filtered clamp-to-edge lookup at u needs no offset, and holds the first
    /// and last half texel constant.
    Centres,
    /// Texel i at u = i / (n - 1), so that both ends of the range are stored. The shader has to scale the coordinate,
    /// u (n - 1)/n + 0.5/n, before a linear-filtered clamp-to-edge lookup.
    Ends,
}

impl TexelRule {
    /// Every rule.
    pub const ALL: [TexelRule; 2] = [TexelRule::Centres, TexelRule::Ends];

    /// The name in files, manifests and messages.
    pub fn name(self) -> &'static str {
        match self {
            TexelRule::Centres => "centres",
            TexelRule::Ends => "ends",
        }
    }

    /// The rule called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rule| rule.name() == name)
    }
}

/// One axis of a table. [`Axis::new`] checks what it is given; [`Axis::check`] does so again for edited fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the parameter, as a shader variable: `mu`, `kappa`, `m`, `n`, ...
    pub parameter: String,
    /// Correspondence of coordinate and value.
    pub mapping: Mapping,
    /// Where the texels sit.
    pub rule: TexelRule,
    /// Value at u = 0, in the unit of the parameter.
    pub min: f64,
    /// Value at u = 1, in the unit of the parameter.
    pub max: f64,
    /// Number of texels.
    pub size: usize,
}

/// An axis that cannot be sampled.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AxisError {
    /// The name would not do as a shader variable.
    #[error("axis parameter {0:?} is not a name: it starts with an ASCII letter and goes on with letters, digits, _")]
    Parameter(String),
    /// Too few or too many texels.
    #[error("axis {parameter}: {size} texels are not allowed: {rule} takes {least} to {MAX_SIZE}")]
    Size {
        /// The axis.
        parameter: String,
        /// The refused number of texels.
        size: usize,
        /// Name of the texel rule.
        rule: &'static str,
        /// Fewest texels that the rule works with.
        least: usize,
    },
    /// Not an interval of finite values.
    #[error("axis {parameter}: [{min}, {max}] is not a range: both ends are finite and min < max")]
    Range {
        /// The axis.
        parameter: String,
        /// The refused lower end.
        min: f64,
        /// The refused upper end.
        max: f64,
    },
    /// The mapping is not defined over the range.
    #[error("axis {parameter}: mapping {mapping} over [{min}, {max}] is not allowed: it needs {needs}")]
    Mapping {
        /// The axis.
        parameter: String,
        /// Name of the mapping.
        mapping: &'static str,
        /// Lower end of the range.
        min: f64,
        /// Upper end of the range.
        max: f64,
        /// What the mapping needs.
        needs: &'static str,
    },
}

impl Axis {
    /// An axis over `[min, max]` with `size` texels.
    ///
    /// # Errors
    /// [`AxisError`] when the name is no identifier, the range is empty or not finite, the mapping is not defined over
    /// it, or the number of texels is outside 1 (for `ends` 2) to [`MAX_SIZE`].
    pub fn new(
        parameter: impl Into<String>,
        mapping: Mapping,
        rule: TexelRule,
        [min, max]: [f64; 2],
        size: usize,
    ) -> Result<Self, AxisError> {
        let axis = Self {
            parameter: parameter.into(),
            mapping,
            rule,
            min,
            max,
            size,
        };
        axis.check()?;
        Ok(axis)
    }

    /// The axis to start with: `size` texel centres uniform in mu.
    ///
    /// # Errors
    /// [`AxisError`] when `size` is outside 1 to [`MAX_SIZE`].
    pub fn mu(size: usize) -> Result<Self, AxisError> {
        Self::new("mu", Mapping::Mu, TexelRule::Centres, [0.0, 1.0], size)
    }

    /// Whether the fields still describe an axis that can be sampled.
    ///
    /// # Errors
    /// Those of [`Axis::new`].
    pub fn check(&self) -> Result<(), AxisError> {
        let (parameter, min, max) = (self.parameter.clone(), self.min, self.max);
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !parameter.starts_with(|c: char| c.is_ascii_alphabetic()) || !parameter.chars().all(is_word) {
            return Err(AxisError::Parameter(parameter));
        }
        let least = match self.rule {
            TexelRule::Centres => 1,
            TexelRule::Ends => 2,
        };
        if self.size < least || self.size > MAX_SIZE {
            return Err(AxisError::Size {
                parameter,
                size: self.size,
                rule: self.rule.name(),
                least,
            });
        }
        // A range as wide as f64 itself would overflow max - min.
        if !(min.is_finite() && max.is_finite() && min < max && (max - min).is_finite()) {
            return Err(AxisError::Range { parameter, min, max });
        }
        self.mapping.needs(min, max).map_err(|needs| AxisError::Mapping {
            parameter,
            mapping: self.mapping.name(),
            min,
            max,
            needs,
        })
    }

    /// The value of the parameter at the coordinate `u` in [0, 1]; never outside [min, max], not even by rounding, so
    /// that a legal range asks for legal values only.
    pub fn value(&self, u: f64) -> f64 {
        if u <= 0.0 {
            return self.min;
        }
        if u >= 1.0 {
            return self.max;
        }
        let value = match self.mapping {
            Mapping::Mu => u,
            Mapping::SqrtMu => u * u,
            Mapping::FourthRootMu => (u * u) * (u * u),
            Mapping::ThreeQuarters => u * libm::cbrt(u),
            Mapping::Linear => self.min + u * (self.max - self.min),
            Mapping::Sqrt => {
                let root = self.min.sqrt() + u * (self.max.sqrt() - self.min.sqrt());
                root * root
            }
            Mapping::Log => self.min * libm::exp(u * (libm::log(self.max) - libm::log(self.min))),
            Mapping::Log1p => {
                let (from, to) = (libm::log1p(self.min), libm::log1p(self.max));
                libm::expm1(from + u * (to - from))
            }
        };
        value.clamp(self.min, self.max)
    }

    /// The texture coordinate of `value` in [min, max], before the scaling that [`TexelRule::Ends`] needs. Outside the
    /// range the result leaves [0, 1] or is NaN.
    pub fn u(&self, value: f64) -> f64 {
        match self.mapping {
            Mapping::Mu => value,
            Mapping::SqrtMu => value.sqrt(),
            Mapping::FourthRootMu => value.sqrt().sqrt(),
            Mapping::ThreeQuarters => (value * value.sqrt()).sqrt(),
            Mapping::Linear => (value - self.min) / (self.max - self.min),
            Mapping::Sqrt => (value.sqrt() - self.min.sqrt()) / (self.max.sqrt() - self.min.sqrt()),
            Mapping::Log => (libm::log(value) - libm::log(self.min)) / (libm::log(self.max) - libm::log(self.min)),
            Mapping::Log1p => {
                let (from, to) = (libm::log1p(self.min), libm::log1p(self.max));
                (libm::log1p(value) - from) / (to - from)
            }
        }
    }

    /// The coordinate u of texel `i`.
    pub fn texel_u(&self, i: usize) -> f64 {
        match self.rule {
            TexelRule::Centres => (i as f64 + 0.5) / self.size as f64,
            TexelRule::Ends => i as f64 / (self.size - 1) as f64,
        }
    }

    /// The value of the parameter at texel `i` of `0..size`.
    pub fn texel(&self, i: usize) -> f64 {
        self.value(self.texel_u(i))
    }

    /// The continuous texel index in [0, size - 1] at which a linear-filtered clamp-to-edge lookup at `u` reads; its
    /// fraction weighs the two neighbours. For [`TexelRule::Ends`] the shader scales u by (n - 1)/n + 0.5/n first, and
    /// this is the position after that scaling.
    pub fn texel_position(&self, u: f64) -> f64 {
        let n = self.size as f64;
        let position = match self.rule {
            TexelRule::Centres => u * n - 0.5,
            TexelRule::Ends => u * (n - 1.0),
        };
        position.clamp(0.0, n - 1.0)
    }

    /// Parameter, mapping and texel rule in a few words: `sqrt-mu centres`, `log1p(kappa) ends`.
    pub fn label(&self) -> String {
        match self.mapping {
            Mapping::Mu | Mapping::SqrtMu | Mapping::FourthRootMu => {
                format!("{} {}", self.mapping.name(), self.rule.name())
            }
            Mapping::Linear | Mapping::Sqrt | Mapping::ThreeQuarters | Mapping::Log | Mapping::Log1p => {
                format!("{}({}) {}", self.mapping.name(), self.parameter, self.rule.name())
            }
        }
    }

    /// The texture coordinate as one assignment that GLSL, HLSL, MSL and WGSL all read, scaling for
    /// [`TexelRule::Ends`] included: `u = sqrt(mu)`, `u = log(kappa/1.0)/log(4096.0)`.
    pub fn shader_formula(&self) -> String {
        format!("u = {}", self.shader_expression())
    }

    /// The right-hand side of [`Axis::shader_formula`].
    pub fn shader_expression(&self) -> String {
        let coordinate = self.coordinate_formula();
        match self.rule {
            TexelRule::Centres => coordinate,
            TexelRule::Ends => {
                let n = self.size as f64;
                format!("{coordinate}*({:?}/{n:?}) + 0.5/{n:?}", n - 1.0)
            }
        }
    }

    /// The right-hand side before the scaling for `ends`. Numbers print as {:?}, which always keeps a point or an
    /// exponent: GLSL ES refuses integers among floats.
    fn coordinate_formula(&self) -> String {
        let (v, min, max) = (&self.parameter, self.min, self.max);
        match self.mapping {
            Mapping::Mu => v.clone(),
            Mapping::SqrtMu => format!("sqrt({v})"),
            Mapping::FourthRootMu => format!("sqrt(sqrt({v}))"),
            Mapping::ThreeQuarters => format!("sqrt({v}*sqrt({v}))"),
            Mapping::Linear if (min, max) == (0.0, 1.0) => v.clone(),
            Mapping::Linear if min == 0.0 => format!("{v}/{max:?}"),
            Mapping::Linear if min < 0.0 => format!("({v} + {:?})/{:?}", -min, max - min),
            Mapping::Linear => format!("({v} - {min:?})/{:?}", max - min),
            Mapping::Sqrt if min == 0.0 => format!("sqrt({v})/{:?}", max.sqrt()),
            Mapping::Sqrt => format!("(sqrt({v}) - {:?})/{:?}", min.sqrt(), max.sqrt() - min.sqrt()),
            Mapping::Log => format!("log({v}/{min:?})/log({:?})", max / min),
            Mapping::Log1p if min == 0.0 => format!("log(1.0 + {v})/log({:?})", 1.0 + max),
            Mapping::Log1p => format!("log((1.0 + {v})/{:?})/log({:?})", 1.0 + min, (1.0 + max) / (1.0 + min)),
        }
    }
}

/// Axis values of every texel, in the order of a table over `axes`: the first axis runs fastest.
pub fn texel_places(axes: &[Axis]) -> Vec<Vec<f64>> {
    let mut places = vec![Vec::new()];
    for axis in axes.iter().rev() {
        places = places
            .into_iter()
            .flat_map(|rest: Vec<f64>| (0..axis.size).map(move |i| [vec![axis.texel(i)], rest.clone()].concat()))
            .collect();
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(mapping: Mapping, rule: TexelRule, range: [f64; 2], size: usize) -> Axis {
        Axis::new("kappa", mapping, rule, range, size).unwrap()
    }

    fn all_kinds() -> Vec<Axis> {
        let mut axes = Vec::new();
        for rule in TexelRule::ALL {
            for size in [2, 3, 33, 16384] {
                axes.push(axis(Mapping::Mu, rule, [0.0, 1.0], size));
                axes.push(axis(Mapping::SqrtMu, rule, [0.0, 1.0], size));
                axes.push(axis(Mapping::FourthRootMu, rule, [0.0, 1.0], size));
                axes.push(axis(Mapping::ThreeQuarters, rule, [0.0, 1.0], size));
                axes.push(axis(Mapping::Linear, rule, [-2.0, 90.0], size));
                axes.push(axis(Mapping::Sqrt, rule, [1e-6, 1.0], size));
                axes.push(axis(Mapping::Sqrt, rule, [0.0, 10.0], size));
                axes.push(axis(Mapping::Log, rule, [1e-6, 10.0], size));
                axes.push(axis(Mapping::Log, rule, [1.0, 1e12], size));
                axes.push(axis(Mapping::Log1p, rule, [0.0, 1e8], size));
                axes.push(axis(Mapping::Log1p, rule, [0.5, 1e12], size));
            }
        }
        axes
    }

    #[test]
    fn values_and_coordinates_are_inverse_and_stay_in_range() {
        for axis in all_kinds() {
            assert_eq!((axis.value(0.0), axis.value(1.0)), (axis.min, axis.max), "{axis:?}");
            let mut last = f64::NEG_INFINITY;
            for step in 0..=1000 {
                let u = step as f64 / 1000.0;
                let value = axis.value(u);
                assert!(value > last && value >= axis.min && value <= axis.max, "{axis:?} {u}");
                assert!((axis.u(value) - u).abs() < 1e-13, "{axis:?} {u}");
                last = value;
            }
        }
    }

    #[test]
    fn texels_sit_where_a_lookup_reads_them() {
        for axis in all_kinds() {
            for i in [0, 1, axis.size / 2, axis.size - 1] {
                let position = axis.texel_position(axis.u(axis.texel(i)));
                assert!((position - i as f64).abs() < 1e-9, "{axis:?} {i} {position}");
            }
            assert_eq!(axis.texel_position(-1.0), 0.0);
            assert_eq!(axis.texel_position(2.0), (axis.size - 1) as f64);
        }
        assert_eq!(Axis::mu(4).unwrap().texel(0), 0.125);
        assert_eq!(Axis::mu(1).unwrap().texel_position(0.9), 0.0);
        assert_eq!(axis(Mapping::Mu, TexelRule::Ends, [0.0, 1.0], 5).texel(4), 1.0);
    }

    #[test]
    fn formulae_are_what_a_shader_evaluates() {
        let centres = |mapping, range| axis(mapping, TexelRule::Centres, range, 8).shader_formula();
        assert_eq!(centres(Mapping::Mu, [0.0, 1.0]), "u = kappa");
        assert_eq!(centres(Mapping::SqrtMu, [0.0, 1.0]), "u = sqrt(kappa)");
        assert_eq!(centres(Mapping::FourthRootMu, [0.0, 1.0]), "u = sqrt(sqrt(kappa))");
        assert_eq!(
            centres(Mapping::ThreeQuarters, [0.0, 1.0]),
            "u = sqrt(kappa*sqrt(kappa))"
        );
        assert_eq!(centres(Mapping::Linear, [0.0, 1.0]), "u = kappa");
        assert_eq!(centres(Mapping::Linear, [0.0, 90.0]), "u = kappa/90.0");
        assert_eq!(centres(Mapping::Linear, [1.0, 3.5]), "u = (kappa - 1.0)/2.5");
        assert_eq!(centres(Mapping::Linear, [-1.0, 1.0]), "u = (kappa + 1.0)/2.0");
        assert_eq!(centres(Mapping::Sqrt, [0.0, 4.0]), "u = sqrt(kappa)/2.0");
        assert_eq!(centres(Mapping::Sqrt, [0.25, 1.0]), "u = (sqrt(kappa) - 0.5)/0.5");
        assert_eq!(centres(Mapping::Log, [1.0, 4096.0]), "u = log(kappa/1.0)/log(4096.0)");
        assert_eq!(
            centres(Mapping::Log1p, [0.0, 4095.0]),
            "u = log(1.0 + kappa)/log(4096.0)"
        );
        assert_eq!(
            centres(Mapping::Log1p, [1.0, 7.0]),
            "u = log((1.0 + kappa)/2.0)/log(4.0)"
        );
        let ends = axis(Mapping::SqrtMu, TexelRule::Ends, [0.0, 1.0], 64).shader_formula();
        assert_eq!(ends, "u = sqrt(kappa)*(63.0/64.0) + 0.5/64.0");
    }

    #[test]
    fn impossible_axes_are_refused_with_a_reason() {
        let new = |mapping, rule, range, size| {
            Axis::new("m", mapping, rule, range, size)
                .map(|_| ())
                .map_err(|error| error.to_string())
        };
        for (mapping, rule, range, size, reason) in [
            (Mapping::Mu, TexelRule::Centres, [0.0, 1.0], 0, "takes 1 to 16384"),
            (Mapping::Mu, TexelRule::Centres, [0.0, 1.0], 16385, "takes 1 to 16384"),
            (Mapping::Mu, TexelRule::Ends, [0.0, 1.0], 1, "takes 2 to 16384"),
            (Mapping::Mu, TexelRule::Centres, [0.0, 2.0], 8, "needs the range [0, 1]"),
            (Mapping::Log, TexelRule::Centres, [0.0, 2.0], 8, "needs min > 0"),
            (Mapping::Sqrt, TexelRule::Centres, [-0.5, 2.0], 8, "needs min >= 0"),
            (Mapping::Log1p, TexelRule::Centres, [-1.0, 2.0], 8, "needs min > -1"),
            (Mapping::Linear, TexelRule::Centres, [2.0, 2.0], 8, "min < max"),
            (Mapping::Linear, TexelRule::Centres, [f64::NAN, 2.0], 8, "finite"),
            (Mapping::Linear, TexelRule::Centres, [0.0, f64::INFINITY], 8, "finite"),
            (
                Mapping::Linear,
                TexelRule::Centres,
                [-f64::MAX, f64::MAX],
                8,
                "is not a range",
            ),
        ] {
            let error = new(mapping, rule, range, size).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
        for name in ["", "2m", "m x", "µ", "m;discard"] {
            assert!(matches!(
                Axis::new(name, Mapping::Mu, TexelRule::Centres, [0.0, 1.0], 8),
                Err(AxisError::Parameter(_))
            ));
        }
        assert!(
            Mapping::ALL
                .iter()
                .all(|&mapping| Mapping::from_name(mapping.name()) == Some(mapping))
        );
        assert!(
            TexelRule::ALL
                .iter()
                .all(|&rule| TexelRule::from_name(rule.name()) == Some(rule))
        );
    }
}
