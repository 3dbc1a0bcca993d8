//! `furnace rho`

use super::{Common, Failure, format, number, select};
use clap::Args;
use glam::DVec3;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::time::Instant;
use whitefurnace::estimate::{Estimate, Estimator, Lobe};
use whitefurnace::integrate::{IntegrateError, Integrator, Target};
use whitefurnace::parameter::Number;
use whitefurnace::scene::Material;
use whitefurnace::spectrum::Channels;

/// Arguments of `furnace rho`.
#[derive(Debug, Args)]
#[command(after_help = "\
Without --mu, --theta-deg or --hh it prints rho_hd at 0, 30, 45, 60, 75, 85 and 90 degrees, and rho_hh. \
The evaluations and the time of the first row of a material include what its directions share. Of several values of \
--tolerance each gets a row of its own, so that the cost of digits is seen. A value that cannot be stated is `refused`, in \
JSON `null` with the reason under `refused`; the others are printed, the reasons follow, and the exit code is 2.

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
    /// The estimator asked for.
    estimator: Estimator,
    estimate: Result<Estimate, IntegrateError>,
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
        let rows = self.common.in_pool(|| {
            let mut rows = Vec::new();
            for (material, roughness) in cases {
                let each = tolerances
                    .iter()
                    .map(|tolerance| self.rows(material, roughness, *tolerance, &targets, &bar));
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
            Ok(rows)
        })?;
        bar.finish_and_clear();
        if self.common.json {
            let results: Vec<Value> = rows.iter().map(Row::as_json).collect();
            format::say(serde_json::to_string_pretty(
                &json!({ "scene": scene.name, "results": results }),
            )?);
        } else if rows.iter().any(|row| row.estimate.is_ok()) {
            report(&rows, tolerances.len() > 1);
        }
        self.tell_refused(&rows)
    }

    /// Says why rows have no value, each reason once for all that share it.
    ///
    /// # Errors
    /// When any of them was asked for.
    fn tell_refused(&self, rows: &[Row]) -> Result<(), Failure> {
        let mut told: Vec<(String, Vec<String>)> = Vec::new();
        let mut refused = 0;
        if rows.is_empty() {
            return Ok(());
        }
        for row in rows {
            let Err(error) = &row.estimate else { continue };
            // nobody asked for the default angles in particular, and with them all is said that there is
            refused += usize::from(!(self.default_angles() && matches!(error, IntegrateError::Diverges(_))));
            let (material, place) = (format!("material `{}`", row.name()), row.place());
            match told
                .iter_mut()
                .find(|(reason, _)| *reason == format!("{material}: {error}"))
            {
                Some((_, places)) => places.push(place),
                None => told.push((format!("{material}: {error}"), vec![place])),
            }
        }
        let reasons = told
            .iter()
            .map(|(reason, places)| format!("{reason} ({})", shortened(places)));
        if refused == rows.len() {
            return Err(reasons.collect::<Vec<_>>().join("\n").into());
        }
        reasons.for_each(format::note);
        match refused {
            0 => Ok(()),
            _ => Err(format!("{refused} of {} values were refused, see the notes above", rows.len()).into()),
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
    ) -> Result<Vec<Row<'a>>, Failure> {
        let start = Instant::now();
        let model = material
            .model
            .at(roughness.map(|(_, value)| value))
            .map_err(|error| format!("material `{}`: {error}", material.name))?;
        let effort = self.common.effort(&model, tolerance);
        let integrator = Integrator::new(&model, self.common.estimator, effort);
        let evaluations = integrator.as_ref().map_or(0, Integrator::shared_evaluations);
        let mut shared = (evaluations, start.elapsed().as_secs_f64());
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
                // where one direction has no value, the others are worth having
                let estimate = integrator
                    .as_ref()
                    .map_err(Clone::clone)
                    .and_then(|integrator| integrator.estimate(target.of(lobe), cell as u64))
                    .map(|estimate| Estimate {
                        evaluations: estimate.evaluations + shared.0,
                        ..estimate
                    });
                let seconds = start.elapsed().as_secs_f64() + shared.1;
                if estimate.is_ok() {
                    shared = (0, 0.0);
                }
                rows.push(Row {
                    material,
                    roughness,
                    tolerance: effort.tolerance,
                    lobe,
                    direction,
                    channels: model.channels(),
                    estimator: self.common.estimator,
                    estimate,
                    seconds,
                });
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

    fn name(&self) -> String {
        match self.roughness {
            Some((parameter, value)) => format!("{}, {parameter} = {value}", self.material.name),
            None => self.material.name.clone(),
        }
    }

    /// The integral, for messages.
    fn place(&self) -> String {
        let of_lobe = match self.lobe {
            Lobe::Reflection => "",
            Lobe::Transmission => " of the transmission",
        };
        match self.direction {
            Some(Direction { mu, phi_deg, .. }) => {
                format!("rho_hd{of_lobe} at mu = {}, phi = {phi_deg} degrees", Number(mu))
            }
            None => format!("rho_hh{of_lobe}"),
        }
    }

    fn as_json(&self) -> Value {
        let known = self.estimate.as_ref().ok();
        let channels = |of: fn(&Estimate) -> DVec3| known.map(|estimate| self.channels.of(of(estimate)));
        let mut value = json!({
            "material": self.material.name,
            "quantity": self.quantity(),
            "lobe": self.lobe.name(),
            "mu": self.direction.map(|direction| direction.mu),
            "phi_deg": self.direction.map(|direction| direction.phi_deg),
            "value": channels(|estimate| estimate.value),
            "error": channels(|estimate| estimate.error),
            "tolerance": self.tolerance,
            "error_kind": known.map(|estimate| estimate.kind.name()),
            "estimator": known.map_or(self.estimator, |estimate| estimate.estimator).name(),
            "evaluations": known.map(|estimate| estimate.evaluations),
            "seconds": self.seconds,
        });
        if let Some(object) = value.as_object_mut() {
            if let Some((name, roughness)) = self.roughness {
                object.insert("roughness".into(), json!({ name: roughness }));
            }
            if let Err(error) = &self.estimate {
                object.insert("refused".into(), json!(error.to_string()));
            }
        }
        value
    }

    fn cells(&self, several: bool) -> Vec<String> {
        let direction = |f: fn(Direction) -> String| self.direction.map_or_else(|| "-".into(), f);
        let mut cells = vec![
            self.name(),
            self.quantity().into(),
            self.lobe.name().into(),
            direction(|direction| format!("{:.4}", direction.theta_deg)),
            direction(|direction| match direction.mu {
                small if small != 0.0 && small < 1e-4 => format!("{small:.2e}"),
                mu => format!("{mu:.6}"),
            }),
            direction(|direction| format!("{}", direction.phi_deg)),
        ];
        cells.extend(match &self.estimate {
            Ok(estimate) => [
                format::channels(&self.channels.of(estimate.value), |value| format!("{value:.10}")),
                format::error(self.channels.of(estimate.error).into_iter().fold(0.0, f64::max)),
                estimate.kind.name().into(),
                estimate.estimator.name().into(),
                format::count(estimate.evaluations),
            ],
            Err(_) => ["refused", "-", "-", self.estimator.name(), "-"].map(Into::into),
        });
        cells.push(format::seconds(self.seconds));
        if several {
            cells.insert(TOLERANCE, format!("{:e}", self.tolerance));
        }
        cells
    }
}

/// The first of several places, and how many more there are.
fn shortened(places: &[String]) -> String {
    const SHOWN: usize = 3;
    let first = places[..places.len().min(SHOWN)].join("; ");
    match places.len().saturating_sub(SHOWN) {
        0 => first,
        more => format!("{first}; and {more} more"),
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
