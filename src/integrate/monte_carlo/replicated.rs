//! Points that keep clear of each other: the error is the spread of the means of independent sets.
//!
//! The weights of one set depend on each other, so their own spread says nothing of the error of their mean, which falls
//! faster than n^-1/2. The means of independently randomised sets are independent and unbiased, and near enough to normal
//! for Student's t, which of the known intervals keeps its promise best [L'Ecuyer et al. 2023].

use super::draw::{batch, point_set};
use super::unseen::{of_nothing, peak, unseen};
use super::{CONFIDENCE, Finding, Samples, Trial, known, nothing, too_few, too_many};
use crate::bxdf::Bxdf;
use crate::integrate::IntegrateError;
use crate::numerics::moments::Moments;
use crate::numerics::points::{BATCH, LONGEST_SEQUENCE, PointSet, Points};
use glam::DVec3;
use rayon::prelude::*;

/// Independent sets. Student's t at 99 % for 15 degrees of freedom is 2.95, within 15 % of what infinitely many would need;
/// twice as many of half the size would gain those 7 % and lose up to half of what larger sets gain.
const REPLICATES: u64 = 16;

/// Points of each set after which the spread is first looked at.
const PILOT: u64 = 1 << 7;

/// How samples are dealt out: `sets` of `points` each.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Layout {
    sets: u64,
    points: u64,
}

impl Layout {
    /// At least `count` samples. Longer sequences than there are direction numbers for become more sequences.
    fn of(points: Points, count: u64) -> Self {
        let sets = match points {
            Points::Quasi => REPLICATES.max(count.div_ceil(LONGEST_SEQUENCE)),
            Points::Random | Points::Stratified => REPLICATES,
        };
        Self {
            sets,
            points: count.div_ceil(sets).max(1),
        }
    }

    fn count(self) -> u64 {
        self.sets * self.points
    }
}

/// What has been drawn: the moments of the weights of each set.
struct Drawn {
    sets: Vec<Moments>,
}

impl Drawn {
    /// Those of all weights.
    fn all(&self) -> Moments {
        self.sets.iter().copied().fold(Moments::default(), Moments::merge)
    }

    /// Those of the means of the sets.
    fn means(&self) -> Moments {
        let mut means = Moments::default();
        self.sets.iter().for_each(|set| means.push(set.mean()));
        means
    }
}

/// With a tolerance, a first look tells how far off it is; the sets grow as if the error fell like 1/n, by powers of two, and
/// are looked at again. Scrambled sequences are continued; strata do not nest and are drawn anew.
pub(super) fn find<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial) -> Result<Finding, IntegrateError> {
    let peak = peak(bxdf, &trial);
    let mut spent = 0;
    match trial.samples {
        Samples::Fixed(count) => {
            let drawn = draw(bxdf, &trial, Layout::of(trial.points, count), None, 0, &mut spent);
            let all = expecting(&drawn, peak);
            if !known(&all) {
                return Err(too_few(&trial, &all));
            }
            let half_width = half_width(bxdf, &trial, &drawn, &all, &mut spent);
            Ok(Finding {
                value: drawn.means().mean(),
                half_width,
                evaluations: spent,
            })
        }
        Samples::UpTo { tolerance, limit } => {
            let mut points = PILOT;
            let mut drawn = None;
            for level in 0.. {
                let layout = Layout::of(trial.points, points * REPLICATES);
                let now = draw(bxdf, &trial, layout, drawn.take(), level, &mut spent);
                let all = expecting(&now, peak);
                let half_width = half_width(bxdf, &trial, &now, &all, &mut spent);
                let reached = half_width.max_element();
                if reached <= tolerance && (known(&all) || nothing(&all)) {
                    if !known(&all) {
                        return Err(too_few(&trial, &all));
                    }
                    return Ok(Finding {
                        value: now.means().mean(),
                        half_width,
                        evaluations: spent,
                    });
                }
                let ratio = libm::log2((reached / tolerance).clamp(2.0, 1e18)).ceil().max(1.0) as u32;
                let needed = layout.count() as f64 * 2f64.powi(ratio as i32);
                if needed > limit as f64 {
                    return Err(too_many(&trial, &all, needed, tolerance, limit));
                }
                points <<= ratio;
                drawn = Some(now);
            }
            unreachable!("the levels end at the limit")
        }
    }
}

fn expecting(drawn: &Drawn, peak: DVec3) -> Moments {
    let mut all = drawn.all();
    all.expect(peak);
    all
}

fn half_width<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, drawn: &Drawn, all: &Moments, spent: &mut u64) -> DVec3 {
    if nothing(all) {
        return of_nothing(bxdf, trial, all);
    }
    drawn.means().student(CONFIDENCE) + unseen(bxdf, trial, all, spent)
}

/// Draws what `layout` asks for beyond what there is.
fn draw<B: Bxdf + ?Sized>(
    bxdf: &B,
    trial: &Trial,
    layout: Layout,
    before: Option<Drawn>,
    level: u64,
    spent: &mut u64,
) -> Drawn {
    let before = before.filter(|_| trial.points == Points::Quasi);
    // sequences that are continued keep their name
    let level = if trial.points == Points::Quasi { 0 } else { level };
    let mut sets = before.map_or(Vec::new(), |drawn| drawn.sets);
    sets.resize(layout.sets as usize, Moments::default());
    let jobs: Vec<(usize, PointSet, u64)> = sets
        .iter()
        .enumerate()
        .map(|(index, done)| {
            let name = level << 24 | index as u64;
            (index, point_set(bxdf, trial, name, layout.points), done.count)
        })
        .collect();
    let batches: Vec<(usize, Moments)> = jobs
        .par_iter()
        .flat_map(|(index, set, done)| {
            (done / BATCH..layout.points.div_ceil(BATCH)).into_par_iter().map(|b| {
                let start = (b * BATCH).max(*done);
                (
                    *index,
                    batch(bxdf, trial, set, start..layout.points.min((b + 1) * BATCH)),
                )
            })
        })
        .collect();
    for (index, moments) in batches {
        *spent += moments.count;
        sets[index] = sets[index].merge(moments);
    }
    Drawn { sets }
}
