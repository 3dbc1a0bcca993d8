//! `furnace rho`

use super::{Common, Failure, format, number, select};
use clap::Args;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::cell::Cell;
use std::fmt::Display;
use std::time::Instant;
use whitefurnace::estimate::{Estimate, Lobe};
use whitefurnace::integrate::{IntegrateError, Integrator, Target};
use whitefurnace::scene::Material;
use whitefurnace::spectrum::Channels;

/// Arguments of `furnace rho`.
#[derive(Debug, Args)]
#[command(after_help = "\
Without --mu, --theta-deg or --hh it prints rho_hd at 0, 30, 45, 60, 75, 85 and 90 degrees, and rho_hh. \
The evaluations and the time of the first row of a material include what its directions share. Of several values of \
--tolerance each gets a row of its own, so that the cost of digits is seen.

Examples:
  furnace rho --material aluminium-k17 --theta-deg 0,45,90 --tolerance 1e-10
  furnace rho --material methanol-k17 --mu 0.1 --tolerance 1e-3,1e-6,1e-9
  furnace rho scene.toml --mu 0,0.1,1 --estimator mc-visible --samples 1000000
  furnace rho --hh --json")]
pub(super) struct Rho {
    #[command(flatten)]
    common: Common,
    /// Only this material; may be given several times.
    #[arg(long, value_name = "NAME")]
    material: Vec<String>,
    /// Cosines of the angle to the normal, 0 to 1; 0 stands for the limit.
    #[arg(long, value_name = "X,Y,...", value_delimiter = ',', value_parser = number::mu, allow_hyphen_values = true)]
    mu: Vec<f64>,
    /// Angles to the normal in degrees, 0 to 90.
    #[arg(long, value_name = "X,Y,...", value_delimiter = ',', value_parser = number::theta, allow_hyphen_values = true)]
    theta_deg: Vec<f64>,
    /// Azimuths in degrees, -360 to 360.
    #[arg(long, value_name = "X,Y,...", value_delimiter = ',', default_value = "0", value_parser = number::phi, allow_hyphen_values = true)]
    phi_deg: Vec<f64>,
    /// Values for materials whose roughness is a range; both of its ends by default.
    #[arg(long, value_name = "X,Y,...", value_delimiter = ',', value_parser = number::roughness, allow_hyphen_values = true)]
    roughness: Vec<f64>,
    /// Print rho_hh too, or alone when no direction is given.
    #[arg(long)]
    hh: bool,
}

/// One result, with where it holds.
struct Row<'a> {
    material: &'a Material,
    /// Name and value, where the scene gives a range.
    roughness: Option<(&'static str, f64)>,
    /// The error that was allowed.
    tolerance: f64,
    lobe: Lobe,
    direction: Option<Direction>,
    channels: Channels,
    estimate: Estimate,
    seconds: f64,
}

#[derive(Clone, Copy)]
struct Direction {
    mu: f64,
    theta_deg: f64,
    phi_deg: f64,
}

/// Angles that are printed when none are given, in degrees.
const DEFAULT_ANGLES: [f64; 7] = [0.0, 30.0, 45.0, 60.0, 75.0, 85.0, 90.0];

impl Rho {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = self.common.load()?;
        let materials = select(&scene.materials, &self.material)?;
        let directions = self.directions();
        let hh = self.hh || self.default_angles();
        let mut cases = Vec::new();
        for material in materials {
            cases.extend(
                self.roughness_values(material)?
                    .into_iter()
                    .map(|roughness| (material, roughness)),
            );
        }
        self.common.tell_unused();
        let targets: Vec<Option<Direction>> = directions.into_iter().map(Some).chain(hh.then_some(None)).collect();
        let tolerances: Vec<Option<f64>> = match &self.common.tolerance[..] {
            [] => vec![None],
            several => several.iter().copied().map(Some).collect(),
        };
        let integrals = cases.len() * targets.len() * tolerances.len();
        let bar = format::progress_of(integrals as u64, "integrating", "integrals");
        let (rows, refused) = self.common.in_pool(|| {
            let refused = Cell::new(0);
            let mut rows = Vec::new();
            for (material, roughness) in cases {
                let each = tolerances
                    .iter()
                    .map(|tolerance| self.rows(material, roughness, *tolerance, &targets, &bar, &refused));
                let mut each: Vec<Vec<Row>> = each.collect::<Result<_, Failure>>()?;
                // the tolerances of one direction below each other
                let longest = each.iter().map(Vec::len).max().unwrap_or(0);
                for each in &mut each {
                    each.reverse();
                }
                for _ in 0..longest {
                    rows.extend(each.iter_mut().filter_map(Vec::pop));
                }
            }
            Ok((rows, refused.get()))
        })?;
        bar.finish_and_clear();
        if self.common.json {
            let results: Vec<Value> = rows.iter().map(Row::as_json).collect();
            format::say(serde_json::to_string_pretty(
                &json!({ "scene": scene.name, "results": results }),
            )?);
        } else {
            report(&rows, tolerances.len() > 1);
        }
        // nobody asked for the default angles in particular
        match refused {
            0 => Ok(()),
            _ if self.default_angles() => Ok(()),
            _ => Err(format!("{refused} of the values asked for do not exist, see the notes above").into()),
        }
    }

    /// Whether the command line asks for nothing in particular.
    fn default_angles(&self) -> bool {
        self.mu.is_empty() && self.theta_deg.is_empty() && !self.hh
    }

    /// Every combination of the angles with the azimuths.
    fn directions(&self) -> Vec<Direction> {
        let theta = if self.default_angles() {
            &DEFAULT_ANGLES[..]
        } else {
            &self.theta_deg
        };
        let from_mu = self.mu.iter().map(|mu| (*mu, mu.acos().to_degrees()));
        // through the elevation, so that 90 degrees is exactly the horizon
        let from_theta = theta.iter().map(|theta| ((90.0 - theta).to_radians().sin(), *theta));
        let angles: Vec<(f64, f64)> = from_mu.chain(from_theta).collect();
        let with_azimuths = |(mu, theta_deg): &(f64, f64)| {
            let (mu, theta_deg) = (*mu, *theta_deg);
            self.phi_deg.iter().map(move |phi_deg| Direction {
                mu,
                theta_deg,
                phi_deg: *phi_deg,
            })
        };
        angles.iter().flat_map(with_azimuths).collect()
    }

    fn rows<'a>(
        &self,
        material: &'a Material,
        roughness: Option<(&'static str, f64)>,
        tolerance: Option<f64>,
        targets: &[Option<Direction>],
        bar: &ProgressBar,
        refused: &Cell<usize>,
    ) -> Result<Vec<Row<'a>>, Failure> {
        let failed = |error: &dyn Display| format!("material `{}`: {error}", material.name);
        let start = Instant::now();
        let model = material
            .model
            .at(roughness.map(|(_, value)| value))
            .map_err(|error| failed(&error))?;
        let effort = self.common.effort(&model, tolerance);
        let integrator = Integrator::new(&model, self.common.estimator, effort).map_err(|error| failed(&error))?;
        let mut shared = (integrator.shared_evaluations(), start.elapsed().as_secs_f64());
        let mut rows = Vec::new();
        let lobes: Vec<Lobe> = Lobe::ALL
            .into_iter()
            .filter(|lobe| model.flags().contains(lobe.flag()))
            .collect();
        for (cell, direction) in targets.iter().copied().enumerate() {
            for lobe in lobes.iter().copied() {
                let start = Instant::now();
                let target = direction.map_or(Target::rho_hh(), |direction| {
                    Target::rho_hd(direction.mu, direction.phi_deg.to_radians())
                });
                let result = integrator.estimate(target.of(lobe), cell as u64);
                let mut estimate = match result {
                    // the other rows are worth having
                    Err(error @ IntegrateError::Diverges(_)) => {
                        bar.suspend(|| format::note(failed(&error)));
                        refused.set(refused.get() + 1);
                        continue;
                    }
                    estimate => estimate.map_err(|error| failed(&error))?,
                };
                estimate.evaluations += shared.0;
                let seconds = start.elapsed().as_secs_f64() + shared.1;
                rows.push(Row {
                    material,
                    roughness,
                    tolerance: effort.tolerance,
                    lobe,
                    direction,
                    channels: model.channels(),
                    estimate,
                    seconds,
                });
                shared = (0, 0.0);
            }
            bar.inc(1);
        }
        Ok(rows)
    }

    /// The roughness to use, `None` where the scene fixes it.
    fn roughness_values(&self, material: &Material) -> Result<Vec<Option<(&'static str, f64)>>, Failure> {
        let Some((family, min, max)) = material.model.roughness_range() else {
            return Ok(vec![None]);
        };
        let name = family.legal().name;
        if let Some(outside) = self.roughness.iter().find(|value| !(min..=max).contains(*value)) {
            let material = &material.name;
            return Err(
                format!("--roughness {outside}: {name} of material `{material}` lies in [{min}, {max}]").into(),
            );
        }
        let values = if self.roughness.is_empty() {
            vec![min, max]
        } else {
            self.roughness.clone()
        };
        Ok(values.into_iter().map(|value| Some((name, value))).collect())
    }
}

impl Row<'_> {
    fn quantity(&self) -> &'static str {
        if self.direction.is_some() { "rho_hd" } else { "rho_hh" }
    }

    fn as_json(&self) -> Value {
        let mut value = json!({
            "material": self.material.name,
            "quantity": self.quantity(),
            "lobe": self.lobe.name(),
            "mu": self.direction.map(|direction| direction.mu),
            "phi_deg": self.direction.map(|direction| direction.phi_deg),
            "value": self.channels.of(self.estimate.value),
            "error": self.channels.of(self.estimate.error),
            "tolerance": self.tolerance,
            "error_kind": self.estimate.kind.name(),
            "estimator": self.estimate.estimator.name(),
            "evaluations": self.estimate.evaluations,
            "seconds": self.seconds,
        });
        if let (Some((name, roughness)), Some(object)) = (self.roughness, value.as_object_mut()) {
            object.insert("roughness".into(), json!({ name: roughness }));
        }
        value
    }

    fn cells(&self, several: bool) -> Vec<String> {
        let name = match self.roughness {
            Some((parameter, value)) => format!("{}, {parameter} = {value}", self.material.name),
            None => self.material.name.clone(),
        };
        let direction = |f: fn(Direction) -> String| self.direction.map_or_else(|| "-".into(), f);
        let mut cells = vec![
            name,
            self.quantity().into(),
            self.lobe.name().into(),
            direction(|direction| format!("{:.4}", direction.theta_deg)),
            direction(|direction| format!("{:.6}", direction.mu)),
            direction(|direction| format!("{}", direction.phi_deg)),
            format::channels(&self.channels.of(self.estimate.value), |value| format!("{value:.10}")),
            format::error(self.channels.of(self.estimate.error).into_iter().fold(0.0, f64::max)),
            self.estimate.kind.name().into(),
            self.estimate.estimator.name().into(),
            format::count(self.estimate.evaluations),
            format::seconds(self.seconds),
        ];
        if several {
            cells.insert(TOLERANCE, format!("{:e}", self.tolerance));
        }
        cells
    }
}

/// The column of the tolerance, where there are several.
const TOLERANCE: usize = 6;

fn report(rows: &[Row], several: bool) {
    let mut header = vec![
        "material",
        "quantity",
        "lobe",
        "theta/deg",
        "mu",
        "phi/deg",
        "value",
        "error",
        "kind",
        "estimator",
        "evaluations",
        "time",
    ];
    if several {
        header.insert(TOLERANCE, "tolerance");
    }
    let right = [
        "theta/deg",
        "mu",
        "phi/deg",
        "tolerance",
        "error",
        "evaluations",
        "time",
    ];
    let rows = rows.iter().map(|row| row.cells(several)).collect();
    format::say(format::table(&header, &right, rows).to_string());
}
