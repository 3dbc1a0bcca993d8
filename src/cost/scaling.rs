//! How cost grows with the work: with texels, with the sharpness of a lobe, with digits.

use super::clock::{Seconds, timed};
use super::ladder::compute;
use super::settings::{Budget, Settings};
use super::subject::Subject;
use super::{CostError, workers};
use crate::estimate::{Effort, Estimator};
use crate::scene::{Material, Scene};

/// What grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Growth {
    /// Texels of the table.
    Texels,
    /// 1/alpha, or 1/m.
    Sharpness,
    /// Digits of the tolerance.
    Digits,
}

/// One table by quadrature.
#[derive(Debug, Clone, PartialEq)]
pub struct Grown {
    /// The lobe.
    pub lobe: &'static str,
    /// What grows.
    pub growth: Growth,
    /// How far it has grown.
    pub value: f64,
    /// Texels of the table.
    pub texels: usize,
    /// Evaluations of all texels.
    pub evaluations: u64,
    /// What they took; nothing when the rules did not converge, or time was up.
    pub seconds: Option<Seconds>,
}

/// The lobes: their names, families, parameters and masking.
const LOBES: [(&str, &str, &str, &str); 2] = [
    ("Beckmann, V-groove", "beckmann", "m", "v-groove"),
    ("GGX, Smith", "ggx", "alpha", "smith-correlated"),
];

const USUAL_ROUGHNESS: f64 = 0.2;
const USUAL_TOLERANCE: f64 = 1e-6;
const USUAL_TEXELS: usize = 32;

impl Growth {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Texels, Self::Sharpness, Self::Digits];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Texels => "texels",
            Self::Sharpness => "sharpness",
            Self::Digits => "digits",
        }
    }

    /// How far it grows in a study.
    fn values(self, settings: &Settings) -> Vec<f64> {
        let most = settings.sizes.iter().copied().max().unwrap_or(64).max(64);
        match self {
            Self::Texels => {
                let sizes = (4..=13).map(|k| 1usize << k).take_while(|size| *size <= 4 * most);
                sizes.map(|size| size as f64).collect()
            }
            Self::Sharpness => (0..=6).map(|k| 10f64.powi(k)).collect(),
            Self::Digits => (2..=11).map(f64::from).collect(),
        }
    }
}

/// One job: lobe, growth, value.
type Job = (usize, Growth, f64);

/// Times quadrature while one of texels, sharpness and digits grows and the others rest: 32 texels, a roughness of 0.2,
/// a tolerance of 1e-6, glass.
///
/// # Errors
/// [`CostError`] when the system has no threads.
pub(super) fn scaling(
    settings: &Settings,
    budget: &Budget,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Grown>, CostError> {
    let jobs = jobs(settings);
    let results = workers::run(settings.threads, &jobs, |&(lobe, growth, value)| {
        let grown = one((lobe, growth, value), budget);
        progress(1);
        grown
    })?;
    results.into_iter().collect()
}

fn jobs(settings: &Settings) -> Vec<Job> {
    let each = Growth::ALL.into_iter().flat_map(|growth| {
        let values = growth.values(settings).into_iter();
        values.flat_map(move |value| (0..LOBES.len()).map(move |lobe| (lobe, growth, value)))
    });
    each.collect()
}

/// Number of tables.
pub(super) fn work(settings: &Settings) -> u64 {
    jobs(settings).len() as u64
}

fn one((lobe, growth, value): Job, budget: &Budget) -> Result<Grown, CostError> {
    let (mut texels, mut roughness, mut tolerance) = (USUAL_TEXELS, USUAL_ROUGHNESS, USUAL_TOLERANCE);
    match growth {
        Growth::Texels => texels = value as usize,
        Growth::Sharpness => roughness = 1.0 / value,
        Growth::Digits => tolerance = 10f64.powf(-value),
    }
    let (name, family, parameter, masking) = LOBES[lobe];
    let mut grown = Grown {
        lobe: name,
        growth,
        value,
        texels,
        evaluations: 0,
        seconds: None,
    };
    if !budget.allows(0.0) {
        return Ok(grown);
    }
    let distribution = format!("{{ type = \"{family}\", {parameter} = {roughness:?} }}");
    let glass = "{ type = \"dielectric\", eta = 1.5 }";
    let subject = Subject::new(&microfacet(name, &distribution, masking, glass), texels)?;
    let effort = Effort {
        tolerance,
        samples: None,
        seed: 0,
    };
    let (result, seconds) = timed(|| compute(&subject, Estimator::Quadrature, effort));
    if let Ok((_, evaluations)) = result {
        grown.evaluations = evaluations;
        grown.seconds = Some(seconds);
    }
    Ok(grown)
}

/// A material of one lobe, from the words of a scene.
pub(super) fn microfacet(name: &str, distribution: &str, masking: &str, fresnel: &str) -> Material {
    let text = format!(
        "[[material]]\nname = \"{name}\"\n[material.bxdf]\ntype = \"microfacet\"\ndistribution = {distribution}\n\
         masking = \"{masking}\"\nfresnel = {fresnel}\n"
    );
    let scene = Scene::parse(&text, "cost study").unwrap_or_else(|error| unreachable!("{error}"));
    scene.materials[0].clone()
}
