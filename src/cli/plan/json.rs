//! A plan for programs.

use super::{Costs, Other};
use crate::cli::lobes;
use serde_json::{Map, Value, json};
use whitefurnace::integrate::{Forecast, Forecasts};
use whitefurnace::plan::{MaterialPlan, Plan, TablePlan};
use whitefurnace::table::axis::Axis;

/// The plan, its costs, and what it saves.
pub(super) fn of_plan(plan: &Plan, costs: &Costs) -> Value {
    let tables: Vec<Value> = plan
        .tables
        .iter()
        .zip(&costs.own.each)
        .map(|(plan, cost)| table(plan, cost))
        .collect();
    let materials = |implied: bool| -> Vec<Value> {
        let wanted = plan.materials.iter().filter(|material| material.implied == implied);
        wanted.map(material).collect()
    };
    let skipped: Vec<Value> = plan
        .skipped
        .iter()
        .map(|skipped| json!({ "effect": skipped.effect.name(), "reason": skipped.reason }))
        .collect();
    let texels: usize = plan.tables.iter().map(TablePlan::texels).sum();
    let Other {
        all_effects,
        tables: other_tables,
        texels: other_texels,
        costs: other,
        ratio,
    } = &costs.other;
    let mut other = cost(*other_tables, *other_texels, other);
    other["times_as_long"] = json!(ratio.is_finite().then_some(ratio));
    let mut own = cost(plan.tables.len(), texels, &costs.own);
    if costs.choosing > 0.0 {
        own["seconds"] = json!(costs.own.seconds() + costs.choosing);
        own["choosing_seconds"] = json!(costs.choosing);
    }
    json!({
        "scene": plan.scene,
        "materials": materials(false),
        "implied_materials": materials(true),
        "unused_materials": plan.unused,
        "tables": tables,
        "skipped": skipped,
        "cost": own,
        (if *all_effects { "cost_of_all_effects" } else { "cost_of_what_is_called_for" }): other,
        "findings": plan.clipped,
        "warnings": plan.warnings,
    })
}

fn cost(tables: usize, texels: usize, costs: &Forecasts) -> Value {
    json!({
        "tables": tables,
        "texels": texels,
        "evaluations": costs.evaluations().round(),
        "seconds": costs.seconds(),
        "tables_judged": costs.studied,
    })
}

fn material(material: &MaterialPlan) -> Value {
    let effects: Vec<&str> = material.calls.iter().map(|call| call.effect.name()).collect();
    let pairs = |pairs: Vec<(&str, &str)>| -> Map<String, Value> {
        let owned = pairs.into_iter().map(|(key, value)| (key.to_owned(), json!(value)));
        owned.collect()
    };
    let because = material.calls.iter();
    let because = pairs(because.map(|call| (call.effect.name(), call.by.as_str())).collect());
    let gaps = &material.gaps;
    let reasons = pairs(gaps.iter().map(|gap| (gap.what.as_str(), gap.why.as_str())).collect());
    json!({
        "name": material.name,
        "effects": effects,
        "called_for_by": because,
        "not_covered": gaps.iter().map(|gap| gap.what.as_str()).collect::<Vec<_>>(),
        "not_covered_because": reasons,
        "lobes": lobes::entries(material),
    })
}

fn table(table: &TablePlan, cost: &Forecast) -> Value {
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
        "lobe": table.lobe.name(),
        "axes": alternatives.first(),
        "alternative_axes": alternatives.get(1..),
        "texels": table.texels(),
        "channels": table.channels.count(),
        "materials": table.materials,
        "estimator": cost.estimator,
        "tolerance": table.effort.tolerance,
        "evaluations": cost.evaluations.round(),
        "seconds": cost.seconds,
    })
}
