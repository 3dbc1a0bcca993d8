//! The error that a shader sees, measured against integrals at places that no table knows of.
//!
//! [`between`](super::fill()) searches each table for its worst place, by integrals of its own. A [`Reference`] is computed
//! once and judges any number of tables over the same domain, of any size, mapping, tolerance and storage, at the price of
//! their lookups.

use super::fill::{FillError, integrals, stable_hash};
use super::{Effort, Estimator};
use crate::numerics::stream::{Stream, StreamId};
use crate::plan::TablePlan;
use crate::table::axis::{Axis, MU};
use crate::table::{Storage, Table};
use glam::DVec3;

/// rho at random places of a table's domain, and at those where tables err most.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Uniform in mu, in the azimuth, and in the coordinate of a roughness axis.
    random: Vec<Known>,
    /// At all scales towards mu = 0, and at the ends of every axis.
    stress: Vec<Known>,
    /// Evaluations of the integrand.
    evaluations: u64,
}

/// The integral at a place.
#[derive(Debug, Clone)]
struct Known {
    place: Vec<f64>,
    value: DVec3,
    error: DVec3,
}

/// How far the lookups of a table are off. Each error counts what the reference itself does not know, so that the truth is
/// no worse, for references that state a bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Largest absolute error of any channel at a random place.
    pub max: f64,
    /// Root of the mean over the random places of the square of their largest error of any channel.
    pub rms: f64,
    /// Where the largest error occurs: one value per axis.
    pub at: Vec<f64>,
    /// Largest error at random places and at those of stress.
    pub anywhere: f64,
    /// Where that occurs.
    pub anywhere_at: Vec<f64>,
    /// Largest error of the reference itself, a part of all of the above.
    pub unknown: f64,
    /// Number of random places.
    pub places: usize,
}

/// Decades towards mu = 0 that are stressed.
const DECADES: f64 = 9.0;

/// Directions that share a roughness: what a model prepares is worth several of them.
const SHARED: usize = 16;

impl Reference {
    /// The integrals of `plan` at `count` random places and about half as many of stress, to an error of `tolerance`.
    ///
    /// The best estimator is used whatever the plan asks for. The places depend on `seed`, `count` and the domain alone.
    ///
    /// # Errors
    /// [`FillError`] with the place that failed, among others where the integral diverges at mu = 0.
    pub fn new(plan: &TablePlan, tolerance: f64, seed: u64, count: usize) -> Result<Self, FillError> {
        let axes = plan.alternatives.first().map_or(&[][..], |axes| &axes[..]);
        let mut stream = Stream::new(StreamId {
            seed,
            cell: stable_hash("what a shader sees"),
            batch: count as u64,
        });
        let effort = Effort {
            tolerance,
            samples: None,
            ..plan.effort
        };
        let mut evaluations = 0;
        let mut known = |places: Vec<Vec<f64>>| -> Result<Vec<Known>, FillError> {
            let (found, shared) = integrals(plan, axes, &places, Estimator::Auto, effort, &|_| {})?;
            evaluations += shared + found.iter().map(|estimate| estimate.evaluations).sum::<u64>();
            let known = places.into_iter().zip(found).map(|(place, estimate)| Known {
                place,
                value: estimate.value,
                error: estimate.error,
            });
            Ok(known.collect())
        };
        let random = known(random(axes, count, &mut stream))?;
        let stress = known(stress(axes, count.div_ceil(2), &mut stream))?;
        Ok(Self {
            random,
            stress,
            evaluations,
        })
    }

    /// Evaluations of the integrand that the reference took.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// How far lookups of `table`, kept in `storage` and filtered linearly, are off.
    pub fn seen(&self, table: &Table, storage: Storage) -> Seen {
        let channels = table.channels.count();
        let largest = |value: DVec3| value.to_array()[..channels].iter().fold(0.0, |a: f64, b| a.max(*b));
        let error = |known: &Known| {
            let found = table.sample_as(storage, &known.place);
            // NaN, of which max knows nothing, must not pass for a small error
            let error = (found - known.value).abs() + known.error;
            if error.is_nan() { f64::INFINITY } else { largest(error) }
        };
        let worst = |known: &[Known]| -> (f64, Vec<f64>) {
            let errors = known.iter().map(|known| (error(known), &known.place));
            let worst = errors.reduce(|a, b| if b.0 > a.0 { b } else { a });
            worst.map_or((0.0, Vec::new()), |(error, place)| (error, place.clone()))
        };
        let squares: f64 = self.random.iter().map(|known| error(known).powi(2)).sum();
        let (max, at) = worst(&self.random);
        let stressed = worst(&self.stress);
        let (anywhere, anywhere_at) = if stressed.0 > max { stressed } else { (max, at.clone()) };
        let all = self.random.iter().chain(&self.stress);
        Seen {
            max,
            rms: (squares / self.random.len().max(1) as f64).sqrt(),
            at,
            anywhere,
            anywhere_at,
            unknown: all.map(|known| largest(known.error)).fold(0.0, f64::max),
            places: self.random.len(),
        }
    }
}

/// One value of `axis` as a shader is given it, spread evenly: mu and phi themselves, a roughness in its coordinate.
fn even(axis: &Axis, u: f64) -> f64 {
    if axis.parameter == MU { u } else { axis.value(u) }
}

/// Random places, those of one roughness together.
fn random(axes: &[Axis], count: usize, stream: &mut Stream) -> Vec<Vec<f64>> {
    match axes {
        [] => vec![Vec::new()],
        [only] => (0..count).map(|_| vec![even(only, stream.uniform())]).collect(),
        [first, second, ..] => (0..count.div_ceil(SHARED))
            .flat_map(|_| {
                let row = even(second, stream.uniform());
                let columns: Vec<f64> = (0..SHARED).map(|_| even(first, stream.uniform())).collect();
                columns.into_iter().map(move |column| vec![column, row])
            })
            .take(count)
            .collect(),
    }
}

/// Places at all scales towards mu = 0 and at both ends of the axes, those of one roughness together.
fn stress(axes: &[Axis], count: usize, stream: &mut Stream) -> Vec<Vec<f64>> {
    let mut along = |axis: &Axis, count: usize| -> Vec<f64> {
        let inner = (0..count.saturating_sub(2)).map(|i| {
            let part = (i as f64 + stream.uniform()) / count as f64;
            if axis.parameter == MU {
                libm::exp10(-DECADES * part)
            } else {
                even(axis, part)
            }
        });
        [axis.min, axis.max].into_iter().chain(inner).collect()
    };
    match axes {
        [] => Vec::new(),
        [only] => along(only, count.max(2)).into_iter().map(|value| vec![value]).collect(),
        [first, second, ..] => {
            // the ends of the second axis are a few of many rows, as the ends of the first are a few of many columns
            let rows = along(second, count.div_ceil(SHARED).max(2));
            rows.into_iter()
                .flat_map(|row| along(first, SHARED).into_iter().map(move |column| vec![column, row]))
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{fill, texels};
    use crate::plan::{Plan, Request};
    use crate::scene::Scene;
    use crate::table::axis::{Mapping, TexelRule};

    fn plan(id: &str) -> TablePlan {
        let request = Request {
            resolution: 16,
            roughness_resolution: 8,
            azimuth_resolution: 4,
            ..Request::default()
        };
        let plan = Plan::new(&Scene::default_scene(), &request).unwrap();
        plan.tables.into_iter().find(|table| table.id == id).unwrap()
    }

    /// The searched maximum is no smaller than what many places see, and is seen nearly.
    #[test]
    fn what_is_seen_is_what_fill_states() {
        for (id, count) in [("beckmann-m0.2.rho_hd", 4000), ("vmf-any-roughness.rho_hd", 8000)] {
            let plan = plan(id);
            let reference = Reference::new(&plan, 1e-8, 0, count).unwrap();
            let table = fill(&plan, &|_| {}).unwrap();
            let stated = table.between.as_ref().unwrap().error;
            let seen = reference.seen(&table, Storage::F32);
            assert!(seen.max <= seen.anywhere && seen.rms < seen.max);
            assert!(seen.unknown <= 1e-8);
            assert!(seen.anywhere <= stated + seen.unknown, "{id}: {seen:?} beyond {stated}");
            assert!(seen.anywhere > 0.8 * stated, "{id}: {seen:?} of {stated}");
            assert_eq!(
                seen,
                Reference::new(&plan, 1e-8, 0, count)
                    .unwrap()
                    .seen(&table, Storage::F32)
            );
        }
    }

    /// Storage costs what its rounding costs; sizes and mappings of any kind are judged by one reference.
    #[test]
    fn one_reference_judges_every_table() {
        let plan = plan("beckmann-m0.2.rho_hd");
        let reference = Reference::new(&plan, 1e-8, 1, 2000).unwrap();
        let table = |mapping, size| {
            let axis = Axis::new(MU, mapping, TexelRule::Centres, [0.0, 1.0], size).unwrap();
            texels(&plan, &[axis], &|_| {}).unwrap()
        };
        let seen = |mapping, size| reference.seen(&table(mapping, size), Storage::F32);
        let [coarse, fine] = [32, 128].map(|size| seen(Mapping::SqrtMu, size));
        // linear interpolation: a quarter of the step, a sixteenth of the error, less what the layer at mu = 0 hides
        assert!(fine.rms < coarse.rms / 12.0, "{} {}", fine.rms, coarse.rms);
        // the layer lies within the first texels of mu, where random places seldom look and stress does
        let uniform = seen(Mapping::Mu, 32);
        assert!(uniform.anywhere > 2.0 * coarse.anywhere, "{uniform:?} {coarse:?}");
        let table = table(Mapping::SqrtMu, 128);
        for storage in Storage::ALL {
            let stored = reference.seen(&table, storage);
            let off = (stored.max - fine.max).abs();
            assert!(off <= storage.rounding(1.0) + 6e-8, "{storage:?}: {off}");
        }
        let steps = reference.seen(&table, Storage::Unorm8);
        // half a step of 1/255 at worst, and 1/sqrt(12) of a step on average
        assert!(steps.max > 0.4 / 255.0 && steps.rms < 0.35 / 255.0, "{steps:?}");
    }
}
