//! The whole study.

use super::CostError;
use super::contest::{self, Contest, contests};
use super::ladder::{self, Accuracy};
use super::scaling::{self, Grown, scaling};
use super::settings::{Budget, Settings};
use super::shape::{Shapes, shapes};
use super::subject::Subject;
use crate::scene::Material;
use std::time::Instant;

/// What a study has found.
#[derive(Debug)]
pub struct Report {
    /// Its settings.
    pub settings: Settings,
    /// Estimators, by material.
    pub accuracy: Vec<Accuracy>,
    /// Shapes of tables, by material.
    pub shapes: Vec<Shapes>,
    /// Cost as the work grows.
    pub scaling: Vec<Grown>,
    /// Quadrature against quasi-Monte Carlo.
    pub contests: Vec<Contest>,
    /// Wall seconds of the whole study.
    pub wall: f64,
    /// Wall seconds of each part.
    pub parts: Vec<(&'static str, f64)>,
}

/// Progress of a study: what is going on, how much of it there is, and calls as it is done.
pub trait Watch: Sync {
    /// A part begins, of so much work.
    fn begin(&self, what: &'static str, work: u64);
    /// So much of it is done; called from any thread.
    fn advance(&self, done: u64);
}

/// Nobody looks.
pub struct Unwatched;

impl Watch for Unwatched {
    fn begin(&self, _: &'static str, _: u64) {}
    fn advance(&self, _: u64) {}
}

/// Which share of the time that is left each part of a study may take. The ladder of estimators comes last: it fills what
/// there is.
const SHARES: [f64; 3] = [0.1, 0.4, 0.4];

/// Makes the study of `materials`.
///
/// # Errors
/// [`CostError`] for a material that nothing can compute.
pub fn run(materials: &[&Material], settings: &Settings, watch: &dyn Watch) -> Result<Report, CostError> {
    let begin = Instant::now();
    let until = |share: f64| {
        let now = begin.elapsed().as_secs_f64();
        let end = settings.seconds.map(|seconds| now + share * (seconds - now).max(0.0));
        Budget::until(begin, end)
    };
    let progress = |done| watch.advance(done);
    let subjects: Vec<Subject> = materials
        .iter()
        .map(|material| Subject::new(material, settings.texels))
        .collect::<Result<_, _>>()?;
    let mut parts = Vec::new();
    let mut part = |what, work| {
        parts.push((what, begin.elapsed().as_secs_f64()));
        watch.begin(what, work);
    };
    part("growing the work", scaling::work(settings));
    let scaling = scaling(settings, &until(SHARES[0]), &progress)?;
    part("shaping tables", materials.len() as u64);
    let shapes = shapes(materials, settings, &until(SHARES[1]), &progress)?;
    part("quadrature against samples", contest::work());
    let contests = contests(settings, &until(SHARES[2]), &progress)?;
    part("climbing ladders", ladder::work(&subjects, settings));
    let accuracy = ladder::study(subjects, settings, &until(1.0), &progress)?;
    let wall = begin.elapsed().as_secs_f64();
    // from beginnings to durations
    let ends: Vec<f64> = parts.iter().skip(1).map(|(_, begin)| *begin).chain([wall]).collect();
    parts
        .iter_mut()
        .zip(ends)
        .for_each(|((_, seconds), end)| *seconds = end - *seconds);
    Ok(Report {
        settings: settings.clone(),
        accuracy,
        shapes,
        scaling,
        contests,
        wall,
        parts,
    })
}
