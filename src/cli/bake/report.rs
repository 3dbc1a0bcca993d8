//! What a bake has to say when it is done.

use super::{Baked, formats, place};
use crate::cli::format;
use crate::cli::plan::text;
use std::collections::HashSet;
use std::fs;
use std::path::Path;
use whitefurnace::export::manifest;
use whitefurnace::integrate::choice::Wish;
use whitefurnace::plan::Plan;
use whitefurnace::table::Table;

/// The columns of [`row`].
const HEADER: [&str; 8] = [
    "table",
    "texels",
    "axes",
    "values",
    "estimator",
    "evaluations",
    "texel error",
    "lookup error",
];

/// Those that hold numbers.
const RIGHT: [&str; 4] = ["texels", "evaluations", "texel error", "lookup error"];

/// Prints what was baked, what is wrong with it, and what to do next.
pub(super) fn report(
    directory: &Path,
    plan: &Plan,
    baked: &[Baked],
    (wish, findings): (Option<Wish>, &[String]),
    seconds: f64,
) {
    let found = baked.iter().filter(|baked| baked.found).count();
    format::say(format!(
        "{}: {} in {}{}\n\n",
        plan.scene,
        format::counted(baked.len(), "table"),
        directory.display(),
        match found {
            0 => String::new(),
            found => format!(", {found} of them found finished (--no-cache computes them again)"),
        }
    ));
    let rows = baked.iter().map(|baked| baked.row.clone()).collect();
    if baked.is_empty() {
        format::say(text::nothing(plan));
    } else {
        format::say(format::table(&HEADER, &RIGHT, rows).to_string());
    }
    tell_gaps(plan);
    for finding in findings {
        format::say(format!("\nfinding: {finding}"));
    }
    for excess in baked.iter().filter_map(|baked| baked.excess.as_ref()) {
        format::say(format!("\nfinding: {excess}: this model does not conserve energy"));
    }
    for clipped in &plan.clipped {
        format::say(format!("\nfinding: {clipped}"));
    }
    match wish {
        Some(wish) => tell_unmet(baked, wish),
        None => tell_lookups(baked),
    }
    let evaluations = baked.iter().map(|baked| baked.entry.evaluations).sum();
    let bytes: u64 = baked.iter().map(|baked| baked.entry.bytes).sum();
    format::say(format!(
        "\n{} evaluations at the texels, {} KiB, {}.",
        format::count(evaluations),
        bytes.div_ceil(1024),
        format::seconds(seconds)
    ));
    for line in formats::lines(baked, wish.map(|wish| wish.tolerance)) {
        format::say(line);
    }
    let others = others(directory, baked);
    if !others.is_empty() {
        format::say(format!(
            "\nnote: {} also holds tables that this bake did not write: {}",
            directory.display(),
            others.join(", ")
        ));
    }
    if let Some(first) = baked.first() {
        format::say(format!(
            "\nNext:\n  furnace inspect {}",
            directory.join(&first.entry.file).display()
        ));
        format::say(format!("    what a table holds; this one: {}", first.purpose));
        format::say(format!(
            "  {}\n    every fact, for programs",
            directory.join(manifest::FILE_NAME).display()
        ));
        format::say("  README.md, \"Reading a table in a shader\"");
    }
}

/// Most gaps that are told of; `furnace plan` has them all.
const MOST_GAPS: usize = 40;

/// What materials ask for and no table covers.
fn tell_gaps(plan: &Plan) {
    let gaps = plan.materials.iter();
    let gaps = gaps.flat_map(|material| material.gaps.iter().map(move |gap| (material, gap)));
    let lines: Vec<String> = gaps
        .map(|(material, gap)| format!("not covered: {}: {}: {}", material.name, gap.what, gap.why))
        .collect();
    if !lines.is_empty() {
        format::say("\n");
    }
    for line in lines.iter().take(MOST_GAPS) {
        format::say(line);
    }
    if lines.len() > MOST_GAPS {
        let more = format::count((lines.len() - MOST_GAPS) as u64);
        format::say(format!("and {more} more of other materials, which furnace plan tells"));
    }
}

/// Tables whose lookups err by more than was asked for.
fn tell_unmet(baked: &[Baked], wish: Wish) {
    for Baked { entry, .. } in baked {
        if let Some(reason) = &entry.unmet {
            format::say(format!(
                "\nexceeded: lookups of {} are off by up to {}, more than {:e}: {reason}",
                entry.id,
                format::error(lookup_error(entry)),
                wish.tolerance,
            ));
        }
    }
}

/// That lookups err by more than texels, where sizes were not chosen for them.
fn tell_lookups(baked: &[Baked]) {
    let exceeds = |entry: &&manifest::TableEntry| lookup_error(entry) > entry.tolerance;
    let exceeding: Vec<_> = baked.iter().map(|baked| &baked.entry).filter(exceeds).collect();
    let worst = exceeding
        .iter()
        .max_by(|a, b| lookup_error(a).total_cmp(&lookup_error(b)));
    if let Some(worst) = worst {
        format::say(format!(
            "\nBetween texels {} of the tables err by more than at them, {} by up to {}: --tolerance T chooses axes and sizes \
             such that no lookup errs by more than T.",
            exceeding.len(),
            worst.id,
            format::error(lookup_error(worst)),
        ));
    }
}

fn lookup_error(entry: &manifest::TableEntry) -> f64 {
    match &entry.between {
        None => entry.max_texel_error,
        // not bounded, where the function itself is not
        Some(between) => between.error.unwrap_or(f64::INFINITY),
    }
}

/// What only tables are called here.
const TEXTURES: [&str; 3] = [".exr", ".ktx2", ".dds"];

/// Tables in the directory that are of another bake.
fn others(directory: &Path, baked: &[Baked]) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let entries = || baked.iter().map(|baked| &baked.entry);
    let files = entries().flat_map(|entry| entry.files.iter().map(|file| file.file.as_str()));
    let ours: HashSet<&str> = entries().map(|entry| entry.file.as_str()).chain(files).collect();
    let stem_of = |name: &'_ String| Some(name.rsplit_once('.')?.0.to_owned());
    let textures = names
        .iter()
        .filter(|name| TEXTURES.iter().any(|end| name.ends_with(end)));
    let ids = entries().map(|entry| entry.id.clone());
    let stems: HashSet<String> = ids.chain(textures.filter_map(stem_of)).collect();
    // numbers and source text are tables where something else of their name is one
    let is_table = |name: &str| {
        let parts = name.rsplit_once('.');
        parts.is_some_and(|(stem, end)| stems.contains(stem) && formats::is_extension(end))
    };
    let is_other = |name: &&String| is_table(name) && !ours.contains(name.as_str());
    let mut others: Vec<String> = names.iter().filter(is_other).cloned().collect();
    others.sort();
    others
}

/// A table in one line.
pub(super) fn row(table: &Table) -> Vec<String> {
    let [width, height] = table.size();
    let (min, max) = table.range();
    let labels: Vec<String> = table.axes.iter().map(|axis| axis.label()).collect();
    vec![
        table.id.clone(),
        if height == 1 {
            width.to_string()
        } else {
            format!("{width} x {height}")
        },
        labels.join(", "),
        if min == max {
            format!("{min:.5}")
        } else {
            format!("{min:.5} .. {max:.5}")
        },
        table.estimator.clone(),
        format::count(table.evaluations),
        format::error(table.max_texel_error()),
        match &table.between {
            None => "-".into(),
            Some(between) => format::error(between.error),
        },
    ]
}

/// By how much and where a table exceeds 1 beyond its error.
pub(super) fn excess(table: &Table) -> Option<String> {
    let excess = table.energy_excess()?;
    let at = match &excess.at[..] {
        [] => String::new(),
        at => format!(" at {}", place(table, at)),
    };
    Some(format!("{} exceeds 1 by {:.3}{at}", table.id, excess.excess))
}
