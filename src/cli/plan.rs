//! `furnace plan`

use super::bake::{BATCH, choosers};
use super::{Common, Failure, Shape, format};
use clap::Args;
use rayon::prelude::*;
use serde_json::{Value, json};
use whitefurnace::integrate::choice::{Choice, Obstacle, Wish};
use whitefurnace::integrate::{FillError, Forecast, forecast};
use whitefurnace::plan::{Plan, TablePlan};
use whitefurnace::table::Storage;
use whitefurnace::table::axis::Axis;

/// Arguments of `furnace plan`.
#[derive(Debug, Args)]
#[command(after_help = "\
With --tolerance T axes and sizes are those that keep the error of a lookup within T at least bytes, and the plan says what \
half the error would cost. Sizes of tables with one axis are measured; those with two (~) are estimated along lines through \
their domain, and a bake measures and corrects them. Evaluations and times are measured at a few texels and scaled up.

Examples:
  furnace plan scene.toml
  furnace plan --tolerance 1e-3")]
pub(super) struct PlanCommand {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shape: Shape,
}

impl PlanCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = self.common.load()?;
        let wish = self.common.wish(&self.shape)?;
        let mut plan = Plan::new(&scene, &self.common.request(&self.shape)?)?;
        let chosen = match wish {
            None => Vec::new(),
            Some(wish) => self.common.in_pool(|| chosen(&plan.tables, wish))?,
        };
        if !chosen.is_empty() {
            plan.tables = chosen.iter().map(|chosen| chosen.choice.plan.clone()).collect();
        }
        let costs = plan
            .tables
            .iter()
            .map(forecast)
            .collect::<Result<Vec<Forecast>, FillError>>()?;
        let halves = chosen
            .iter()
            .map(|chosen| forecast(&chosen.half.plan))
            .collect::<Result<Vec<Forecast>, FillError>>()?;
        let threads = self.common.in_pool(|| Ok(rayon::current_num_threads()))?;
        if self.common.json {
            let mut value = as_json(&plan, &costs);
            if let Some(tables) = value["tables"].as_array_mut() {
                for (index, (table, chosen)) in tables.iter_mut().zip(&chosen).enumerate() {
                    chosen.tell(table, &halves[index]);
                }
            }
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            match wish {
                None => report(&plan, &costs, threads),
                Some(wish) => report_chosen(&plan, &chosen, (&costs, &halves), wish.tolerance, threads),
            }
        }
        Ok(())
    }
}

/// What is chosen for a table, in 32-bit floats, in the fewest bytes, and for half the error.
struct Chosen {
    choice: Choice,
    smallest: Option<Choice>,
    half: Choice,
}

fn chosen(tables: &[TablePlan], wish: Wish) -> Result<Vec<Chosen>, Failure> {
    let bar = format::progress_of(tables.len() as u64, "choosing sizes", "tables");
    let mut chosen = Vec::with_capacity(tables.len());
    for batch in tables.chunks(BATCH) {
        let choosers = choosers(batch, wish, &bar)?;
        chosen.par_extend(choosers.par_iter().map(|chooser| Chosen {
            choice: chooser.choice(wish.tolerance, Storage::F32),
            smallest: chooser.smallest(wish.tolerance),
            half: chooser.choice(0.5 * wish.tolerance, Storage::F32),
        }));
    }
    bar.finish_and_clear();
    Ok(chosen)
}

impl Chosen {
    /// The lookup error that is expected, and whether that is measured.
    fn error(&self) -> String {
        if self.choice.error.is_infinite() {
            return "unknown".into();
        }
        let about = if self.choice.whole { "" } else { "~" };
        format!("{about}{}", format::error(self.choice.error))
    }

    /// Adds to the JSON of a table what was chosen; `half` is the cost of half the error.
    fn tell(&self, table: &mut Value, half: &Forecast) {
        let finite = |error: f64| error.is_finite().then_some(error);
        let sizes = |choice: &Choice| -> Vec<usize> {
            let axes = choice.plan.alternatives.iter().take(1).flatten();
            axes.map(|axis| axis.size).collect()
        };
        table["bytes"] = json!(self.choice.bytes);
        table["lookup_error"] = json!(finite(self.choice.error));
        table["lookup_error_is"] = json!(if self.choice.whole { "measured" } else { "estimated" });
        table["obstacle"] = json!(self.choice.obstacle.map(Obstacle::reason));
        table["smallest"] = self.smallest.as_ref().map_or(Value::Null, |smallest| {
            json!({
                "storage": smallest.storage.name(),
                "bytes": smallest.bytes,
                "size": sizes(smallest),
                "lookup_error": finite(smallest.error),
            })
        });
        table["half_the_error"] = json!({
            "size": sizes(&self.half),
            "texels": self.half.plan.texels(),
            "bytes": self.half.bytes,
            "lookup_error": finite(self.half.error),
            "evaluations": half.evaluations.round(),
            "seconds": half.seconds,
        });
    }
}

fn report_chosen(
    plan: &Plan,
    chosen: &[Chosen],
    (costs, halves): (&[Forecast], &[Forecast]),
    tolerance: f64,
    threads: usize,
) {
    format::say(format!(
        "{}: {} tables, {} materials, lookups to {tolerance:e}\n\n",
        plan.scene,
        plan.tables.len(),
        plan.materials.len()
    ));
    let header = [
        "table",
        "texels",
        "axes",
        "estimator",
        "lookup error",
        "f32 bytes",
        "smallest",
        "evaluations/texel",
        "time",
        "half the error",
    ];
    let rows = plan.tables.iter().zip(chosen).zip(costs.iter().zip(halves));
    let rows = rows.map(|((table, chosen), (cost, half))| {
        let each = cost.evaluations / table.texels() as f64;
        let more = half.evaluations / chosen.half.plan.texels() as f64 - each;
        vec![
            table.id.clone(),
            size(table),
            axes(table),
            cost.estimator.into(),
            chosen.error(),
            format::count(chosen.choice.bytes as u64),
            chosen.smallest.as_ref().map_or_else(
                || "none".into(),
                |smallest| format!("{} {}", format::count(smallest.bytes as u64), smallest.storage.name()),
            ),
            format::count(each.round() as u64),
            format::seconds(cost.seconds),
            format!(
                "{} texels, {}{} evaluations/texel, x{:.1} time{}",
                size(&chosen.half.plan),
                if more < 0.0 { "-" } else { "+" },
                format::count(more.abs().round() as u64),
                half.seconds / cost.seconds,
                if chosen.half.error <= 0.5 * tolerance {
                    ""
                } else {
                    ", not reached"
                },
            ),
        ]
    });
    let right = [
        "texels",
        "lookup error",
        "f32 bytes",
        "smallest",
        "evaluations/texel",
        "time",
    ];
    format::say(format::table(&header, &right, rows.collect()).to_string());
    for (table, chosen) in plan.tables.iter().zip(chosen) {
        if let Some(obstacle) = chosen.choice.obstacle {
            format::say(format!("\n{}: sizes were not chosen: {}", table.id, obstacle.reason()));
        } else if chosen.choice.error > tolerance {
            format::say(format!(
                "\n{}: {tolerance:e} is not reached, {} is",
                table.id,
                format::error(chosen.choice.error)
            ));
        }
    }
    let total: f64 = costs.iter().map(|cost| cost.seconds).sum();
    let bytes: usize = chosen.iter().map(|chosen| chosen.choice.bytes).sum();
    let smallest: usize = chosen
        .iter()
        .map(|chosen| {
            chosen
                .smallest
                .as_ref()
                .map_or(chosen.choice.bytes, |smallest| smallest.bytes)
        })
        .sum();
    format::say(format!(
        "\nAbout {} of one core, {} on {threads} threads, with the lookup error between texels measured; {} bytes in f32, {} \
         in the smallest formats.",
        format::seconds(total),
        format::seconds(total / threads as f64),
        format::count(bytes as u64),
        format::count(smallest as u64),
    ));
    leave_out(plan);
}

/// Sizes of the axes.
fn size(table: &TablePlan) -> String {
    let axes = table.alternatives.iter().take(1).flatten();
    let sizes: Vec<String> = axes.map(|axis| axis.size.to_string()).collect();
    if sizes.is_empty() {
        "1".into()
    } else {
        sizes.join(" x ")
    }
}

fn report(plan: &Plan, costs: &[Forecast], threads: usize) {
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
    leave_out(plan);
}

/// What is not computed, and what to do next.
fn leave_out(plan: &Plan) {
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

fn as_json(plan: &Plan, costs: &[Forecast]) -> Value {
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

fn table_json(table: &TablePlan, cost: &Forecast) -> Value {
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
