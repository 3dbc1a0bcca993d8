//! Textures: which values they take.

use super::lookup::{Files, Given};
use super::parameters::Parameters;
use super::scopes::Scopes;
use super::spectra::Tone;
use super::tokens::Place;
use crate::scene::error::SceneError;

/// The numbers from `min` to `max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
}

/// A float texture.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScalarTexture {
    pub(super) range: Range,
    /// Tells it from any other.
    pub(super) id: usize,
}

/// The textures that have a name.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) scalars: Scopes<ScalarTexture>,
    /// `None` for colours that vary over the surface.
    pub(super) tones: Scopes<Option<Tone>>,
    count: usize,
}

/// Names of the parameters of textures that are read.
pub(super) const NAMES: [&str; 11] = [
    "value", "tex1", "tex2", "amount", "scale", "inside", "outside", "v00", "v01", "v10", "v11",
];

impl Range {
    /// What an image or a noise is taken to hold.
    pub(super) const UNIT: Self = Self { min: 0.0, max: 1.0 };

    pub(super) fn single(value: f64) -> Self {
        Self { min: value, max: value }
    }

    pub(super) fn is_single(self) -> bool {
        self.min == self.max
    }

    /// The smallest range that holds `values`.
    fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let empty = Self {
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        };
        values.into_iter().fold(empty, |range, value| Self {
            min: range.min.min(value),
            max: range.max.max(value),
        })
    }

    fn ends(self) -> [f64; 2] {
        [self.min, self.max]
    }

    fn times(self, other: Self) -> Self {
        Self::around(self.ends().into_iter().flat_map(|a| other.ends().map(|b| a * b)))
    }

    /// (1 - amount) self + amount other, whose extremes lie at the ends of all three.
    fn mixed(self, other: Self, amount: Self) -> Self {
        let at = |t: f64| {
            let pairs = self
                .ends()
                .into_iter()
                .flat_map(move |a| other.ends().map(move |b| (a, b)));
            pairs.map(move |(a, b)| (1.0 - t) * a + t * b)
        };
        Self::around(amount.ends().into_iter().flat_map(at))
    }

    pub(super) fn together(self, other: Self) -> Self {
        Self::around([self.min, self.max, other.min, other.max])
    }
}

impl Textures {
    pub(super) fn open(&mut self) {
        self.scalars.open();
        self.tones.open();
    }

    pub(super) fn close(&mut self) {
        self.scalars.close();
        self.tones.close();
    }

    /// What a declaration finds: its own parameters, and the textures before it.
    fn given<'a>(&'a self, own: &'a Parameters, files: &'a Files) -> Given<'a> {
        Given {
            shape: None,
            own,
            textures: self,
            files,
        }
    }

    /// Declares the float texture `name` of the type `class`.
    pub(super) fn declare_scalar(
        &mut self,
        name: &str,
        (class, place): (&str, &Place),
        own: &Parameters,
        files: &Files,
    ) -> Result<(), SceneError> {
        let range = scalar_range(class, &self.given(own, files))?;
        if !(range.min.is_finite() && range.max.is_finite()) {
            return Err(place.refuse("the values of this texture are not allowed: they are no finite numbers"));
        }
        self.count += 1;
        let id = self.count;
        self.scalars.define(name, ScalarTexture { range, id });
        Ok(())
    }

    /// Declares the spectrum texture `name` of the type `class`.
    pub(super) fn declare_tone(
        &mut self,
        name: &str,
        class: &str,
        own: &Parameters,
        files: &Files,
    ) -> Result<(), SceneError> {
        let tone = tone_of(class, &self.given(own, files))?;
        self.tones.define(name, tone);
        Ok(())
    }
}

fn scalar_range(class: &str, given: &Given<'_>) -> Result<Range, SceneError> {
    let of = |name: &str, default: f64| {
        let found = given.scalar(name)?;
        Ok::<_, SceneError>(found.map_or(Range::single(default), |found| found.range))
    };
    let all = |parts: &[(&str, f64)]| {
        let mut range = of(parts[0].0, parts[0].1)?;
        for (name, default) in &parts[1..] {
            range = range.together(of(name, *default)?);
        }
        Ok(range)
    };
    match class {
        "constant" => of("value", 1.0),
        "scale" => Ok(of("tex1", 1.0)?.times(of("tex2", 1.0)?)),
        "mix" => Ok(of("tex1", 0.0)?.mixed(of("tex2", 1.0)?, of("amount", 0.5)?)),
        "checkerboard" => all(&[("tex1", 1.0), ("tex2", 0.0)]),
        "dots" => all(&[("inside", 1.0), ("outside", 0.0)]),
        "bilerp" => all(&[("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)]),
        "imagemap" => Ok(Range::UNIT.times(of("scale", 1.0)?)),
        _ => Ok(Range::UNIT),
    }
}

fn tone_of(class: &str, given: &Given<'_>) -> Result<Option<Tone>, SceneError> {
    let of = |name: &str, default: f64| {
        let found = given.tint(name)?;
        Ok::<_, SceneError>(found.map_or(Some(Tone::grey(default)), |found| found.tone))
    };
    Ok(match class {
        "constant" => of("value", 1.0)?,
        "scale" => match (of("tex1", 1.0)?, of("tex2", 1.0)?) {
            (Some(a), Some(b)) => Some(a.with(b, |a, b| a * b)),
            _ => None,
        },
        "mix" => {
            let amount = given.scalar("amount")?.map_or(Range::single(0.5), |found| found.range);
            match (of("tex1", 0.0)?, of("tex2", 1.0)?) {
                (Some(a), Some(b)) if amount.is_single() => {
                    Some(a.with(b, |a, b| (1.0 - amount.min) * a + amount.min * b))
                }
                _ => None,
            }
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_products_and_mixtures() {
        let range = |min, max| Range { min, max };
        assert_eq!(range(-1.0, 2.0).times(range(3.0, 4.0)), range(-4.0, 8.0));
        assert_eq!(range(0.0, 1.0).times(Range::single(0.25)), range(0.0, 0.25));
        let mixed = range(0.0, 0.5).mixed(Range::single(1.0), range(0.25, 0.5));
        assert_eq!(mixed, range(0.25, 0.75));
        let mixed = Range::single(0.2).mixed(Range::single(0.4), Range::single(0.5));
        assert!(mixed.is_single());
        assert_eq!(range(0.0, 1.0).together(range(-1.0, 0.5)), range(-1.0, 1.0));
    }
}
