//! `furnace bake`

mod findings;
mod formats;
mod interruption;
mod profile;
mod progress;
mod report;

pub(super) use profile::{DESCRIPTION, parse_profile};

use super::{Common, Failure, Shape, format, lobes};
use clap::Args;
use indicatif::ProgressBar;
use progress::Progress;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use whitefurnace::engine::{Lobe, Profile};
use whitefurnace::export::formats::Format;
use whitefurnace::export::manifest::{Manifest, TableEntry};
use whitefurnace::export::store::{CACHE, Lookup, Store, file_name, key};
use whitefurnace::export::{exr, sha256_hex};
use whitefurnace::integrate::choice::{Choice, Chooser, Wish};
use whitefurnace::integrate::{FillError, answers, fill, fill_within, request};
use whitefurnace::plan::{Plan, TablePlan};
use whitefurnace::table::{Storage, Table};

/// Arguments of `furnace bake`.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes <table>.exr for every table and manifest.json with all their facts. Each EXR holds the values as R G B or Y, which \
any viewer opens, and the error of every texel as the layer `error`.

Two errors are stated: `texel`, the largest error at any texel, and `lookup`, the largest error of a linear-filtered lookup \
anywhere between texels. Without --tolerance the tables have 64, 32 and 16 texels along their axes, and texels are known to \
1e-6. With --tolerance T axes, sizes and texel errors are chosen so that the lookup error is at most T at least bytes; sizes \
that are given stay as given.

With --format each table is written in further formats too, as <table>.ktx2, .dds, .png, .bin and .json (raw), .h (c), .rs (rust), \
.glsl, .hlsl and .wgsl, rounded to the --storage; manifest.json lists them with the lookup error that each has then. The EXR is \
always there: it alone holds the error of every texel.

Finished tables are kept in DIR/.furnace; when all are finished they take their names at once, and the tables of an earlier \
bake stay whole until then. Interrupted in any way, the same command goes on with what is finished and ends with the same \
bytes. A table of the same model, settings and version is never computed twice, whatever its material is called: DIR/.furnace \
keeps those of earlier bakes too, those used last and 256 MiB at most, beside those in place. It may be deleted at any time.

Examples:
  furnace bake scene.toml --out tables
  furnace bake --tolerance 1e-3
  furnace bake --format ktx2,wgsl --tolerance 1e-3
  furnace bake --format png,raw --storage unorm16
  furnace bake --profile three
  furnace bake scene.gltf --profile filament-multiscatter --format ktx2
  furnace bake --resolution 256 --tolerance 1e-4
  furnace bake --estimator mc-visible --samples 100000 --seed 1")]
pub(super) struct Bake {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shape: Shape,
    #[command(flatten)]
    formats: formats::Formats,
    /// Write the tables of an engine in its layout instead of those of the materials: generic, filament, filament-multiscatter, three,
    /// bevy, godot, gltf, unity-hdrp, unreal, materialx, cycles, openpbr. With a SCENE, those only that it calls for.
    #[arg(long, value_name = "NAME", value_parser = profile::parse_profile)]
    profile: Option<Profile>,
    /// Lobe of the tables of `--profile generic`: ggx-smith-correlated, the default, ggx-smith, beckmann-smith-correlated, beckmann-smith.
    #[arg(long, value_name = "NAME", value_parser = profile::parse_lobe, requires = "profile")]
    lobe: Option<Lobe>,
    /// Directory for the tables; outputs/<scene> or outputs/<profile> by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Compute every table, also those that were computed before, and keep none in DIR/.furnace.
    #[arg(long)]
    no_cache: bool,
}

/// A finished table: what the manifest and the report say of it. The texels are on the disk by then, and not in memory.
struct Baked {
    entry: TableEntry,
    purpose: &'static str,
    row: Vec<String>,
    excess: Option<String>,
    /// Whether it was there before.
    found: bool,
}

impl Bake {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if let Some(profile) = self.profile {
            return self.profile(profile);
        }
        let start = Instant::now();
        let formats = self.formats.wanted()?;
        let scene = self.common.load()?;
        let wish = self.common.wish(&self.shape)?;
        let plan = Plan::new(&scene, &self.common.request(&self.shape)?)?;
        formats::check_identifiers(plan.tables.iter().map(|table| table.id.as_str()), &formats)?;
        let directory = self
            .out
            .clone()
            .unwrap_or_else(|| Path::new("outputs").join(&plan.directory));
        // an unusable directory is found before the work, not after it
        let store = Store::open(&directory)?;
        let store = Arc::new(if self.no_cache { store.without_cache() } else { store });
        interruption::tell_what_is_kept(&store, plan.tables.len());
        let (baked, manifest) = self
            .common
            .in_pool(|| self.bake(&plan, wish, &formats, &store))
            .map_err(|failure| kept_for_later(&store, failure))?;
        let findings = findings::findings(&plan, store.directory(), &manifest)?;
        let seconds = start.elapsed().as_secs_f64();
        if self.common.json {
            let directory = directory.display().to_string();
            let mut value = json!({ "directory": directory, "seconds": seconds, "found_finished": manifest.reused, "findings": findings, "manifest": manifest });
            if wish.is_some() {
                let unmet = |baked: &Baked| Some((baked.entry.id.clone(), json!(baked.entry.unmet.as_ref()?)));
                let unmet: Map<String, Value> = baked.iter().filter_map(unmet).collect();
                value["unmet"] = Value::Object(unmet);
            }
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            report::report(&directory, &plan, &baked, (wish, &findings), seconds);
        }
        Ok(())
    }

    fn bake(
        &self,
        plan: &Plan,
        wish: Option<Wish>,
        formats: &[(Format, Storage)],
        store: &Store,
    ) -> Result<(Vec<Baked>, Manifest), Failure> {
        let keys: Vec<String> = plan
            .tables
            .iter()
            .map(|table| key(&request(table, wish.as_ref())))
            .collect();
        let find = |(table, key): (&TablePlan, &String)| {
            let lookup = store.find(key, &table.id, &|found| answers(table, found));
            tell_damaged(&lookup, &table.id);
            let kept = lookup.kept?;
            Some(Baked::new(&kept.table, table, kept.bytes, kept.sha256, true))
        };
        let mut baked: Vec<Option<Baked>> = plan.tables.iter().zip(&keys).map(find).collect();
        let missing: Vec<usize> = (0..baked.len()).filter(|index| baked[*index].is_none()).collect();
        let mut progress = Progress::new(missing.len());
        // in batches, so that what choices need is in memory for a few tables only
        for batch in missing.chunks(BATCH) {
            let jobs = progress.choosing(|bar| jobs(plan, batch, wish, bar))?;
            progress.expect(&jobs);
            for (job, index) in jobs.iter().zip(batch) {
                let table = progress.during(job.plan(), |done| job.fill(done))?;
                let bytes = exr::to_bytes(&table)?;
                store.keep(&keys[*index], &bytes)?;
                let (sha256, plan) = (sha256_hex(&bytes), &plan.tables[*index]);
                baked[*index] = Some(Baked::new(&table, plan, bytes.len() as u64, sha256, false));
            }
        }
        progress.end();
        let mut baked: Vec<Baked> = baked.into_iter().flatten().collect();
        formats::put_aside(store, &keys, &mut baked, formats)?;
        let entries: Vec<TableEntry> = baked.iter().map(|baked| baked.entry.clone()).collect();
        let ids = plan.tables.iter().map(|table| table.id.clone());
        let requests: BTreeMap<String, String> = ids.zip(keys).collect();
        let reused = baked
            .iter()
            .filter(|baked| baked.found)
            .map(|baked| baked.entry.id.clone());
        let materials: Vec<String> = plan.names().map(str::to_owned).collect();
        let mut manifest = Manifest {
            reused: reused.collect(),
            all_effects: self.shape.all_effects,
            ..Manifest::new(&plan.scene, self.common.seed, &materials, entries, requests)
        };
        for (entry, material) in manifest.materials.iter_mut().zip(&plan.materials) {
            entry.lobes = lobes::entries(material);
        }
        store.publish(&manifest)?;
        Ok((baked, manifest))
    }
}

impl Baked {
    fn new(table: &Table, plan: &TablePlan, bytes: u64, sha256: String, found: bool) -> Self {
        Self {
            entry: TableEntry::new(table, file_name(&table.id), bytes, sha256, &plan.materials),
            purpose: plan.purpose,
            row: report::row(table),
            excess: report::excess(table),
            found,
        }
    }
}

/// A table to compute, as planned or as chosen.
enum Job<'a> {
    Planned(&'a TablePlan),
    Chosen {
        chooser: Box<Chooser<'a>>,
        choice: Box<Choice>,
    },
}

impl Job<'_> {
    fn plan(&self) -> &TablePlan {
        match self {
            Self::Planned(plan) => plan,
            Self::Chosen { choice, .. } => &choice.plan,
        }
    }

    /// How often it is computed, as a rule.
    fn repeats(&self) -> f64 {
        match self {
            Self::Chosen { choice, .. } => choice.repeats(),
            Self::Planned(_) => 1.0,
        }
    }

    fn fill(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<Table, FillError> {
        match self {
            Self::Planned(plan) => fill(plan, progress),
            Self::Chosen { chooser, choice } => fill_within(chooser, choice, progress),
        }
    }
}

/// What the tables with these indices take.
fn jobs<'a>(plan: &'a Plan, indices: &[usize], wish: Option<Wish>, bar: &ProgressBar) -> Result<Vec<Job<'a>>, Failure> {
    let tables = indices.iter().map(|index| &plan.tables[*index]);
    let Some(wish) = wish else {
        return Ok(tables.map(Job::Planned).collect());
    };
    let chosen = choosers(tables, wish, bar)?.into_iter().map(|chooser| Job::Chosen {
        choice: Box::new(chooser.wished()),
        chooser: Box::new(chooser),
    });
    Ok(chosen.collect())
}

/// Most tables whose choices are made together.
pub(super) const BATCH: usize = 256;

/// What choices for each of the `tables` need, found out side by side.
pub(super) fn choosers<'a>(
    tables: impl IntoIterator<Item = &'a TablePlan>,
    wish: Wish,
    bar: &ProgressBar,
) -> Result<Vec<Chooser<'a>>, Failure> {
    let tables: Vec<&TablePlan> = tables.into_iter().collect();
    let chooser = |table| {
        let chooser = Chooser::new(table, wish);
        bar.inc(1);
        chooser
    };
    let choosers = tables.into_par_iter().map(chooser);
    Ok(choosers.collect::<Result<_, FillError>>()?)
}

/// A failure, and what of the work is not lost.
fn kept_for_later(store: &Store, failure: Failure) -> Failure {
    let finished = store.abandon().tables;
    // a directory that was taken away is not where anything is kept
    if finished == 0 || !store.directory().join(CACHE).exists() {
        return failure;
    }
    let directory = store.directory().display();
    let next = match store.uses_cache() {
        true => "the next bake",
        false => "a bake without --no-cache",
    };
    format!("{failure}\n{finished} tables are finished and kept in {directory}: {next} goes on from there").into()
}

/// Files that should have held the table `id`, and what becomes of it.
fn tell_damaged(lookup: &Lookup, id: &str) {
    let next = match &lookup.kept {
        None => "is computed again",
        Some(_) => "is taken from another file",
    };
    for damaged in &lookup.damaged {
        format::note(format!("{damaged}; {id} {next}"));
    }
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
