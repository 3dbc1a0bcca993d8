//! `furnace bake`

use super::{Common, Failure, Shape, format};
use clap::Args;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use whitefurnace::export::manifest::{self, Manifest, TableEntry};
use whitefurnace::export::{exr, write};
use whitefurnace::integrate::choice::{Chooser, Wish};
use whitefurnace::integrate::{FillError, Filled, fill, fill_within, work};
use whitefurnace::plan::{Plan, TablePlan};
use whitefurnace::table::{Storage, Table};

/// Arguments of `furnace bake`.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes <table>.exr for every table and manifest.json with all their facts. Each EXR holds the values as R G B or Y, which \
any viewer opens, and the error of every texel as the layer `error`. Nothing is written before everything is computed.

Two errors are stated: `texel`, the largest error at any texel, and `lookup`, the largest error of a linear-filtered lookup \
anywhere between texels. Without --tolerance the tables have 64, 32 and 16 texels along their axes, and texels are known to \
1e-6. With --tolerance T axes, sizes and texel errors are chosen so that the lookup error is at most T at least bytes; sizes \
that are given stay as given.

Examples:
  furnace bake scene.toml --out tables
  furnace bake --tolerance 1e-3
  furnace bake --resolution 256 --tolerance 1e-4
  furnace bake --estimator mc-visible --samples 100000 --seed 1")]
pub(super) struct Bake {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shape: Shape,
    /// Directory for the tables; outputs/<scene> by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

struct Baked {
    table: Table,
    purpose: &'static str,
    entry: TableEntry,
    bytes: Vec<u8>,
    /// Why its lookup error exceeds the tolerance asked for, where it does.
    unmet: Option<String>,
}

impl Bake {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let start = Instant::now();
        let scene = self.common.load()?;
        let wish = self.common.wish(&self.shape)?;
        let plan = Plan::new(&scene, &self.common.request(&self.shape)?)?;
        let directory = self
            .out
            .clone()
            .unwrap_or_else(|| Path::new("outputs").join(&plan.directory));
        // an unusable directory is found before the work, not after it
        let missing: Vec<&Path> = directory.ancestors().take_while(|part| !part.exists()).collect();
        write::create_dir(&directory)?;
        let baked = self.common.in_pool(|| compute(&plan, wish)).inspect_err(|_| {
            // only what is still empty goes
            missing.iter().for_each(|part| drop(fs::remove_dir(part)));
        })?;
        let manifest = write_all(&directory, &plan, &baked, self.common.seed)?;
        let seconds = start.elapsed().as_secs_f64();
        if self.common.json {
            let directory = directory.display().to_string();
            let unmet: Map<String, Value> = baked
                .iter()
                .filter_map(|baked| Some((baked.table.id.clone(), json!(baked.unmet.as_ref()?))))
                .collect();
            let mut value = json!({ "directory": directory, "seconds": seconds, "manifest": manifest });
            if wish.is_some() {
                value["unmet"] = Value::Object(unmet);
            }
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            report(&directory, &plan, &baked, wish, seconds);
        }
        Ok(())
    }
}

fn compute(plan: &Plan, wish: Option<Wish>) -> Result<Vec<Baked>, Failure> {
    let choosers = match wish {
        None => Vec::new(),
        Some(wish) => choosers(&plan.tables, wish)?,
    };
    let total = match wish {
        None => plan.tables.iter().map(work).sum(),
        Some(wish) => choosers
            .iter()
            .map(|chooser| work(&chooser.choice(wish.tolerance, Storage::F32).plan))
            .sum(),
    };
    let bar = format::progress(total, "baking");
    let mut baked = Vec::with_capacity(plan.tables.len());
    for (index, planned) in plan.tables.iter().enumerate() {
        let Filled { table, unmet } = match choosers.get(index) {
            Some(chooser) => fill_within(chooser, &|integrals| bar.inc(integrals))?,
            None => Filled {
                table: fill(planned, &|integrals| bar.inc(integrals))?,
                unmet: None,
            },
        };
        let bytes = exr::to_bytes(&table)?;
        let entry = TableEntry::new(&table, format!("{}.exr", table.id), &bytes);
        baked.push(Baked {
            table,
            purpose: planned.purpose,
            entry,
            bytes,
            unmet,
        });
    }
    bar.finish_and_clear();
    Ok(baked)
}

/// What choices for each of the `tables` need, found out side by side.
pub(super) fn choosers(tables: &[TablePlan], wish: Wish) -> Result<Vec<Chooser<'_>>, Failure> {
    let bar = format::progress_of(tables.len() as u64, "choosing sizes", "tables");
    let chooser = |table| {
        let chooser = Chooser::new(table, wish);
        bar.inc(1);
        chooser
    };
    let choosers = tables.par_iter().map(chooser).collect::<Result<_, FillError>>()?;
    bar.finish_and_clear();
    Ok(choosers)
}

/// The tables first, the manifest last: a manifest never names a table that is not there.
fn write_all(directory: &Path, plan: &Plan, baked: &[Baked], seed: u64) -> Result<Manifest, Failure> {
    for table in baked {
        write::write_whole(&directory.join(&table.entry.file), &table.bytes)?;
    }
    let entries = baked.iter().map(|table| table.entry.clone()).collect();
    let manifest = Manifest::new(&plan.scene, seed, &plan.materials, entries);
    write::write_whole(&directory.join(manifest::FILE_NAME), manifest.to_json()?.as_bytes())?;
    Ok(manifest)
}

fn report(directory: &Path, plan: &Plan, baked: &[Baked], wish: Option<Wish>, seconds: f64) {
    let header = [
        "table",
        "texels",
        "axes",
        "values",
        "estimator",
        "evaluations",
        "texel error",
        "lookup error",
    ];
    let right = ["texels", "evaluations", "texel error", "lookup error"];
    let rows = baked.iter().map(|baked| row(&baked.table)).collect();
    format::say(format!(
        "{}: {} tables in {}\n\n",
        plan.scene,
        baked.len(),
        directory.display()
    ));
    format::say(format::table(&header, &right, rows).to_string());
    for baked in baked {
        if let Some(excess) = baked.table.energy_excess() {
            format::say(format!(
                "\nfinding: {} exceeds 1 by {:.3}{}: this model does not conserve energy",
                baked.table.id,
                excess.excess,
                match &excess.at[..] {
                    [] => String::new(),
                    at => format!(" at {}", place(&baked.table, at)),
                },
            ));
        }
    }
    if let Some(wish) = wish {
        let exceeding = baked.iter().filter_map(|baked| Some((baked, baked.unmet.as_ref()?)));
        for (baked, reason) in exceeding {
            let error = baked
                .table
                .between
                .as_ref()
                .map_or_else(|| baked.table.max_texel_error(), |between| between.error);
            format::say(format!(
                "\nexceeded: lookups of {} are off by up to {}, more than {:e}: {reason}",
                baked.table.id,
                format::error(error),
                wish.tolerance,
            ));
        }
    }
    let evaluations = baked.iter().map(|baked| baked.table.evaluations).sum();
    let bytes: usize = baked.iter().map(|baked| baked.bytes.len()).sum();
    format::say(format!(
        "\n{} evaluations at the texels, {} KiB, {}.",
        format::count(evaluations),
        bytes.div_ceil(1024),
        format::seconds(seconds)
    ));
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

/// Tables in the directory that are of another bake.
fn others(directory: &Path, baked: &[Baked]) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut others: Vec<String> = names
        .filter(|name| name.ends_with(".exr") && !baked.iter().any(|table| table.entry.file == *name))
        .collect();
    others.sort();
    others
}

fn row(table: &Table) -> Vec<String> {
    let [width, height] = table.size();
    let (min, max) = table.range();
    vec![
        table.id.clone(),
        if height == 1 {
            width.to_string()
        } else {
            format!("{width} x {height}")
        },
        table
            .axes
            .iter()
            .map(|axis| axis.label())
            .collect::<Vec<_>>()
            .join(", "),
        if min == max {
            format!("{min:.5}")
        } else {
            format!("{min:.5} .. {max:.5}")
        },
        table.estimator.clone(),
        format::count(table.evaluations),
        format::error(table.max_texel_error()),
        table
            .between
            .as_ref()
            .map_or_else(|| "-".into(), |between| format::error(between.error)),
    ]
}

/// Axis values as `mu = 0.5, kappa = 17`.
pub(super) fn place(table: &Table, at: &[f64]) -> String {
    let value = |value: f64| match value {
        small if small != 0.0 && small < 1e-3 => format!("{small:.2e}"),
        value => format!("{value:.6}"),
    };
    let places = table
        .axes
        .iter()
        .zip(at)
        .map(|(axis, at)| format!("{} = {}", axis.parameter, value(*at)));
    places.collect::<Vec<_>>().join(", ")
}
