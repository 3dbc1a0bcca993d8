//! `furnace plan`

use super::{Common, Failure, Shape, format};
use clap::Args;
use serde_json::{Value, json};
use std::time::Instant;
use whitefurnace::integrate::{Integrator, Target, work};
use whitefurnace::plan::{Plan, TablePlan};
use whitefurnace::table::Quantity;
use whitefurnace::table::axis::{AZIMUTH, Axis, MU};

/// Arguments of `furnace plan`.
#[derive(Debug, Args)]
pub(super) struct PlanCommand {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shape: Shape,
}

/// What a table will cost, judged by a few of its integrals.
struct Cost {
    estimator: &'static str,
    evaluations: f64,
    seconds: f64,
}

/// Directions whose integrals make up rho_hh of an anisotropic model, as a rule.
const MEAN_OVER_DIRECTIONS: f64 = 1000.0;

/// Azimuth at which it is: neither tangent.
const PROBE_AZIMUTH: f64 = 0.7;

/// Cosines at which the cost of a direction is sampled.
const PROBES: [f64; 4] = [0.02, 0.15, 0.45, 0.85];

impl PlanCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = self.common.load()?;
        let plan = Plan::new(&scene, &self.common.request(&self.shape))?;
        let costs = plan.tables.iter().map(cost).collect::<Result<Vec<Cost>, Failure>>()?;
        let threads = self.common.in_pool(|| Ok(rayon::current_num_threads()))?;
        if self.common.json {
            format::say(serde_json::to_string_pretty(&as_json(&plan, &costs))?);
        } else {
            report(&plan, &costs, threads);
        }
        Ok(())
    }
}

/// Integrates at a few directions in the middle of the roughness range and scales up.
fn cost(table: &TablePlan) -> Result<Cost, Failure> {
    let mut axes = table.alternatives.iter().flatten();
    let roughness = axes.find(|axis| axis.parameter != MU && axis.parameter != AZIMUTH);
    let middle = roughness.map(|axis| axis.value(0.5));
    // what directions share is computed anew for each roughness
    let shared = roughness.map_or(1, |axis| axis.size) as f64;
    let model = table.model.at(middle)?;
    let failed = |error| format!("table {}: {error}", table.id);
    let integrator = Integrator::new(&model, table.estimator, table.effort).map_err(failed)?;
    // the mean over directions of an anisotropic model is some thousand of its integrals: told from a few, and not paid for
    let (quantity, each_is) = match table.quantity {
        Quantity::RhoHh if model.is_anisotropic() => (Quantity::RhoHd, MEAN_OVER_DIRECTIONS),
        quantity => (quantity, 1.0),
    };
    let targets: Vec<Target> = match quantity {
        Quantity::RhoHd => PROBES
            .iter()
            .map(|mu| Target::rho_hd(*mu, PROBE_AZIMUTH).of(table.lobe))
            .collect(),
        Quantity::RhoHh => vec![Target::rho_hh().of(table.lobe)],
    };
    let mut evaluations = 0;
    let mut times = Vec::new();
    for (cell, target) in targets.iter().enumerate() {
        let start = Instant::now();
        evaluations += integrator.estimate(*target, cell as u64).map_err(failed)?.evaluations;
        times.push(start.elapsed().as_secs_f64());
    }
    // the median: one interruption by the system outweighs all directions together
    times.sort_by(f64::total_cmp);
    let each = each_is / targets.len() as f64;
    Ok(Cost {
        estimator: integrator.estimator(targets[0]).name(),
        evaluations: evaluations as f64 * each * table.texels() as f64
            + shared * integrator.shared_evaluations() as f64,
        seconds: times[times.len() / 2] * each_is * work(table) as f64,
    })
}

fn report(plan: &Plan, costs: &[Cost], threads: usize) {
    format::say(format!(
        "{}: {} tables, {} materials\n\n",
        plan.scene,
        plan.tables.len(),
        plan.materials.len()
    ));
    let header = [
        "table",
        "what for",
        "texels",
        "axes",
        "channels",
        "estimator",
        "evaluations",
        "time",
    ];
    let rows = plan.tables.iter().zip(costs).map(|(table, cost)| {
        vec![
            table.id.clone(),
            table.purpose.into(),
            table.texels().to_string(),
            axes(table),
            table.channels.count().to_string(),
            cost.estimator.into(),
            format!("{:.1e}", cost.evaluations),
            format::seconds(cost.seconds),
        ]
    });
    let right = ["texels", "channels", "evaluations", "time"];
    format::say(format::table(&header, &right, rows.collect()).to_string());
    let total: f64 = costs.iter().map(|cost| cost.seconds).sum();
    format::say(format!(
        "\nAbout {} of one core, {} on {threads} threads, with the lookup error between texels measured.",
        format::seconds(total),
        format::seconds(total / threads as f64),
    ));
    format::say("\nLeft out:");
    for left_out in &plan.left_out {
        format::say(format!("  {}: {}", left_out.effect, left_out.reason));
    }
    format::say("\nNext: furnace bake with the same arguments.");
}

/// The simplest of the alternative axes, and how many there are to choose from.
fn axes(table: &TablePlan) -> String {
    let labels: Vec<String> = table.alternatives.iter().take(1).flatten().map(Axis::label).collect();
    match table.alternatives.len() {
        0 | 1 => labels.join(", "),
        several => format!("{}, or better of {several}", labels.join(", ")),
    }
}

fn as_json(plan: &Plan, costs: &[Cost]) -> Value {
    let tables: Vec<Value> = plan
        .tables
        .iter()
        .zip(costs)
        .map(|(table, cost)| table_json(table, cost))
        .collect();
    let materials: Vec<Value> = plan.materials.iter().map(|name| json!({ "name": name })).collect();
    let skipped: Vec<Value> = plan
        .left_out
        .iter()
        .map(|left_out| json!({ "effect": left_out.effect, "reason": left_out.reason }))
        .collect();
    json!({ "scene": plan.scene, "materials": materials, "tables": tables, "skipped": skipped })
}

fn table_json(table: &TablePlan, cost: &Cost) -> Value {
    let axis = |axis: &Axis| {
        json!({
            "parameter": axis.parameter,
            "mapping": axis.mapping.name(),
            "texel_rule": axis.rule.name(),
            "min": axis.min,
            "max": axis.max,
            "size": axis.size,
        })
    };
    let alternatives: Vec<Vec<Value>> = table
        .alternatives
        .iter()
        .map(|axes| axes.iter().map(axis).collect())
        .collect();
    json!({
        "id": table.id,
        "quantity": table.quantity.name(),
        "purpose": table.purpose,
        "axes": alternatives.first(),
        "alternative_axes": alternatives.get(1..),
        "channels": table.channels.count(),
        "materials": table.materials,
        "estimator": cost.estimator,
        "tolerance": table.effort.tolerance,
        "evaluations": cost.evaluations.round(),
        "seconds": cost.seconds,
    })
}
