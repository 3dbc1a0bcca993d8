//! A plan for people.

use super::chosen::Chosen;
use super::{Costs, Other};
use crate::cli::format;
use std::collections::HashMap;
use whitefurnace::integrate::Forecast;
use whitefurnace::plan::{MaterialPlan, Plan, Source, TablePlan};
use whitefurnace::table::axis::Axis;

/// Most materials that are told one by one; of more, those with the same effects are told together.
const MOST: usize = 24;

/// What there is to plan for: each material with its effects, what calls for them, and what no table covers.
pub(super) fn materials(plan: &Plan, tolerance: Option<f64>) {
    let wish = tolerance.map_or_else(String::new, |tolerance| format!(", lookups to {tolerance:e}"));
    format::say(format!(
        "{}: {}, {}{wish}\n\n",
        plan.scene,
        counted(plan.tables.len(), "table"),
        counted(plan.materials.len(), "material"),
    ));
    let header = ["material", "effect", "called for by"];
    let rows: Vec<Vec<String>> = alike(&plan.materials)
        .into_iter()
        .flat_map(|(first, more)| rows(first, more))
        .collect();
    if !rows.is_empty() {
        format::say(format::table(&header, &[], rows).to_string());
    }
    if plan.materials.len() > MOST {
        format::say("\nOf materials with the same effects the first is shown; --json tells of each.");
    }
    if !plan.unused.is_empty() {
        let unused = format::some(plan.unused.iter().map(String::as_str));
        format::say(format!("\nNot used by anything, and left out: {unused}"));
    }
}

/// `1 table`, `2 tables`.
fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {what}{plural}", format::count(count as u64))
}

/// Materials to tell of, and how many others are like each.
fn alike(materials: &[MaterialPlan]) -> Vec<(&MaterialPlan, usize)> {
    let mut found: Vec<(&MaterialPlan, usize)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for material in materials {
        let effects: Vec<&str> = material.calls.iter().map(|call| call.effect.name()).collect();
        let gaps: Vec<&str> = material.gaps.iter().map(|gap| gap.what.as_str()).collect();
        let key = match materials.len() > MOST {
            true => format!("{effects:?} {gaps:?}"),
            false => material.name.clone(),
        };
        match known.get(&key) {
            Some(index) => found[*index].1 += 1,
            None => {
                known.insert(key, found.len());
                found.push((material, 0));
            }
        }
    }
    found
}

/// A line for each effect and each gap, and one for a material without any.
fn rows(material: &MaterialPlan, more: usize) -> Vec<Vec<String>> {
    let calls = material
        .calls
        .iter()
        .map(|call| [call.effect.name().to_owned(), call.by.clone()]);
    let gaps = material
        .gaps
        .iter()
        .map(|gap| [format!("{} not covered", gap.what), gap.why.clone()]);
    let mut lines: Vec<[String; 2]> = calls.chain(gaps).collect();
    if lines.is_empty() {
        lines.push(["none".into(), "it scatters no light".into()]);
    }
    let mut name = material.name.clone();
    if more > 0 {
        name = format!("{name} and {} more", format::count(more as u64));
    }
    lines
        .into_iter()
        .map(|[effect, by]| vec![std::mem::take(&mut name), effect, by])
        .collect()
}

/// Those who use a table: the first few.
fn users(table: &TablePlan) -> String {
    const SHOWN: usize = 2;
    let names: Vec<&str> = table.materials.iter().take(SHOWN).map(String::as_str).collect();
    match table.materials.len().saturating_sub(SHOWN) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names.join(", ")),
    }
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

/// The simplest of the alternative axes, and how many there are to choose from.
fn axes(table: &TablePlan) -> String {
    let labels: Vec<String> = table.alternatives.iter().take(1).flatten().map(Axis::label).collect();
    match table.alternatives.len() {
        0 | 1 => labels.join(", "),
        several => format!("{}, or better of {several}", labels.join(", ")),
    }
}

/// The tables of sizes that keep `tolerance`.
pub(super) fn chosen_tables(plan: &Plan, chosen: &[Chosen], (costs, halves): (&Costs, &[Forecast]), tolerance: f64) {
    if plan.tables.is_empty() {
        return no_tables(plan);
    }
    format::say("\n");
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
        "materials",
    ];
    let rows = plan.tables.iter().zip(chosen).zip(costs.own.each.iter().zip(halves));
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
            users(table),
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
        "\n{} bytes in f32, {} in the smallest formats.",
        format::count(bytes as u64),
        format::count(smallest as u64),
    ));
}

/// The tables of usual sizes.
pub(super) fn tables(plan: &Plan, costs: &Costs) {
    if plan.tables.is_empty() {
        return no_tables(plan);
    }
    format::say("\n");
    let header = [
        "table",
        "texels",
        "axes",
        "channels",
        "estimator",
        "error",
        "evaluations",
        "time",
        "materials",
    ];
    let rows = plan.tables.iter().zip(&costs.own.each).map(|(table, cost)| {
        vec![
            table.id.clone(),
            size(table),
            axes(table),
            table.channels.count().to_string(),
            cost.estimator.into(),
            format!("{:e}", table.effort.tolerance),
            format!("{:.1e}", cost.evaluations),
            format::seconds(cost.seconds),
            users(table),
        ]
    });
    let right = ["texels", "channels", "error", "evaluations", "time"];
    format::say(format::table(&header, &right, rows.collect()).to_string());
}

/// Why there is nothing to compute.
fn no_tables(plan: &Plan) {
    format::say(format!("\n{}", nothing(plan)));
}

/// Why `plan` has no tables, and the formulae that its materials have instead.
pub(in crate::cli) fn nothing(plan: &Plan) -> String {
    let terms = || plan.materials.iter().flat_map(|material| &material.terms);
    let why = if plan.materials.is_empty() {
        "no material is in use"
    } else if terms().next().is_none() {
        "no material scatters light that a table would tell of"
    } else {
        "every albedo is a closed form"
    };
    let mut text = format!("Nothing to compute: {why}.");
    let mut formulae: Vec<&str> = terms()
        .filter_map(|term| match &term.albedo {
            Source::ClosedForm(formula) => Some(*formula),
            Source::Table { .. } => None,
        })
        .collect();
    formulae.sort_unstable();
    formulae.dedup();
    for formula in formulae {
        text = format!("{text}\n  {formula}");
    }
    text
}

/// What the plan costs, and what the other one would.
pub(super) fn savings(costs: &Costs, chosen: bool) {
    let Costs {
        own,
        choosing,
        other,
        threads,
    } = costs;
    let judged = |studied: usize, all: usize| {
        if studied < all {
            format!(", judged by {} of the tables", format::count(studied as u64))
        } else {
            String::new()
        }
    };
    let total = own.seconds() + choosing;
    if !own.each.is_empty() {
        format::say(format!(
            "\nAbout {} of one core, {} on {threads} threads, with the lookup error between texels measured{}.",
            format::seconds(total),
            format::seconds(total / *threads as f64),
            judged(own.studied, own.each.len()),
        ));
    }
    let Other {
        all_effects,
        tables,
        texels,
        costs,
        ratio,
    } = other;
    let times = match ratio {
        ratio if !ratio.is_finite() => String::new(),
        ratio if chosen => format!(", {ratio:.2} times what this plan takes at those"),
        ratio if *ratio >= 1.0 => format!(", {ratio:.1} times as much"),
        ratio => format!(", {:.1} times less", 1.0 / ratio),
    };
    let usual = match chosen {
        true => " at the usual sizes",
        false => "",
    };
    format::say(format!(
        "{}{usual}: {}, {} texels, about {} of one core{times}{}.",
        if *all_effects {
            "With --all-effects"
        } else {
            "Without --all-effects"
        },
        counted(*tables, "table"),
        format::count(*texels as u64),
        format::seconds(costs.seconds()),
        judged(costs.studied, *tables),
    ));
}

/// What is not computed, and what to do next.
pub(super) fn skipped(plan: &Plan) {
    for clipped in &plan.clipped {
        format::say(format!("\nfinding: {clipped}"));
    }
    if !plan.skipped.is_empty() {
        format::say("\nSkipped:");
    }
    let rows = plan.skipped.iter();
    let rows: Vec<Vec<String>> = rows
        .map(|skipped| vec![skipped.effect.name().to_owned(), skipped.reason.clone()])
        .collect();
    if !rows.is_empty() {
        format::say(format::rows(rows));
    }
    format::say("\nNext: furnace bake with the same arguments.");
}
