//! `furnace inspect`

mod texture;

use super::{Failure, bake::place, format};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use whitefurnace::export::formats::read::{format_of, listed_beside};
use whitefurnace::export::manifest::{self, Manifest, TableEntry};
use whitefurnace::export::read::{Contents, ForeignChannel, ForeignLayer, TableFile, read_exr};
use whitefurnace::printable::printable;
use whitefurnace::table::Table;

/// Arguments of `furnace inspect`.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// A table (.exr), or a texture of it (.exr, .ktx2, .dds, .png, or .bin with its .json).
    file: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if format_of(&self.file).is_some() {
            return texture::inspect(&self.file, self.json);
        }
        let file = read_exr(&self.file)?;
        let manifest = Manifest::read(&file.path.with_file_name(manifest::FILE_NAME)).ok();
        let listed = manifest.as_ref().and_then(|manifest| listed(manifest, &file));
        if self.json {
            format::say(serde_json::to_string_pretty(&as_json(&file, listed))?);
            return Ok(());
        }
        let standing = match listed_beside(&file.path) {
            // a texture, of a profile perhaps
            Some(found) => texture::standing(Some(&found), &file.sha256),
            None => manifest.as_ref().map_or("", |_| standing(&file, listed)).into(),
        };
        format::say(format!(
            "{}, {} bytes, sha256 {}{standing}\n\n",
            printable(&file.path.display().to_string()),
            file.bytes,
            file.sha256
        ));
        match &file.contents {
            Contents::Table { table, version } => report(table, version, listed),
            Contents::Foreign(layers) => layers.iter().for_each(report_foreign),
        }
        Ok(())
    }
}

/// The entry of the file in the manifest beside it.
fn listed<'a>(manifest: &'a Manifest, file: &TableFile) -> Option<&'a TableEntry> {
    let name = file.path.file_name()?.to_str()?;
    manifest.tables.iter().find(|entry| entry.file == name)
}

/// How the file and its entry go together: header text is not covered by the hash of the samples.
fn standing(file: &TableFile, listed: Option<&TableEntry>) -> &'static str {
    match listed {
        Some(entry) if entry.sha256 == file.sha256 => ", as in the manifest",
        Some(_) => "\nfinding: the manifest beside it has another hash: changed since the bake, or of another bake",
        None => "\nnote: the manifest beside it does not list this file",
    }
}

fn report(table: &Table, version: &str, listed: Option<&TableEntry>) {
    let (min, max) = table.range();
    let mut facts = vec![
        ("quantity", format!("{}, {}", table.quantity.name(), table.lobe.name())),
        (
            "materials",
            listed.map_or("unknown: no manifest beside it lists the file".into(), |entry| {
                entry.materials.join(", ")
            }),
        ),
        ("channels", table.channels.count().to_string()),
    ];
    for axis in &table.axes {
        facts.push((
            "axis",
            format!("{} texels, {}, {}", axis.size, axis.rule.name(), axis.shader_formula()),
        ));
    }
    facts.push(("range", format!("{min} .. {max}")));
    facts.push((
        "texel error",
        format!(
            "{} ({})",
            format::error(table.max_texel_error()),
            table.error_kind.name()
        ),
    ));
    let lookup = table.between.as_ref().map(|between| {
        let (error, at) = (format::error(between.error), place(table, &between.at));
        format!("{error} at {at}, the largest of {} places", between.probes)
    });
    facts.push(("lookup error", lookup.unwrap_or_else(|| "not measured".into())));
    if let Some(goal) = &table.goal {
        let verdict = match &goal.unmet {
            None => "kept".into(),
            Some(reason) => format!("exceeded: {reason}"),
        };
        facts.push(("sized for", format!("lookups within {:e}, {verdict}", goal.tolerance)));
    }
    let made = format!(
        "{}, tolerance {:e}, seed {}",
        table.estimator, table.tolerance, table.seed
    );
    facts.push((
        "made by",
        format!(
            "whitefurnace {version}, {made}, {} evaluations",
            format::count(table.evaluations)
        ),
    ));
    for (name, value) in &table.parameters {
        facts.push(("parameter", format!("{name} = {value}")));
    }
    if let Some(excess) = table.energy_excess() {
        facts.push((
            "finding",
            format!("exceeds 1 by {:.3} at {}", excess.excess, place(table, &excess.at)),
        ));
    }
    for (name, fact) in facts {
        // a line for each, whatever it holds
        format::say(format!("{name:<13} {}", printable(&fact)));
    }
    format::say(format!("\n{}", samples(table)));
}

/// Texels spread over the table, its ends among them, with their errors.
fn samples(table: &Table) -> comfy_table::Table {
    let [width, height] = table.size();
    let spread = |size: usize, most: usize| -> Vec<usize> {
        if size <= most {
            (0..size).collect()
        } else {
            (0..most).map(|i| i * (size - 1) / (most - 1)).collect()
        }
    };
    let mut header: Vec<&str> = table.axes.iter().map(|axis| axis.parameter.as_str()).collect();
    header.extend(["value", "error"]);
    let mut rows = Vec::new();
    for y in spread(height, 3) {
        for x in spread(width, 9) {
            let index = y * width + x;
            let at = table
                .axes
                .iter()
                .zip([x, y])
                .map(|(axis, i)| format!("{:.6}", axis.texel(i)));
            let value = format::channels(&table.channels.of(table.stored(index)), |value| format!("{value:.7}"));
            let error = table
                .channels
                .of(table.texel_error(index))
                .into_iter()
                .fold(0.0, f64::max);
            rows.push(at.chain([value, format::error(error)]).collect());
        }
    }
    format::table(&header, &header, rows)
}

fn report_foreign(layer: &ForeignLayer) {
    let name = printable(layer.name.as_deref().unwrap_or("image"));
    let [width, height] = layer.size;
    format::say(format!(
        "{name}: {width} x {height}, written by {}",
        printable(layer.software.as_deref().unwrap_or("unknown"))
    ));
    for channel in &layer.channels {
        let fact = match &channel.samples {
            None => format!("not decoded, compression {}", layer.compression),
            Some(samples) => {
                let range = samples
                    .range
                    .map_or_else(|| "no finite sample".into(), |(min, max)| format!("{min} .. {max}"));
                if samples.not_finite > 0 {
                    format!("{range}, {} not finite", samples.not_finite)
                } else {
                    range
                }
            }
        };
        format::say(format!("  {} ({}): {fact}", printable(&channel.name), channel.kind));
    }
    if layer.facts.is_empty() {
        format::say("It has no attributes of whitefurnace: axes, texel rule and errors are unknown.");
    }
    texture::report_facts(&layer.facts);
}

fn as_json(file: &TableFile, listed: Option<&TableEntry>) -> Value {
    let path = file.path.display().to_string();
    match &file.contents {
        Contents::Table { table, version } => {
            let materials = listed.map_or(&[][..], |entry| &entry.materials);
            let mut entry = json!(TableEntry::new(
                table,
                &path,
                file.bytes,
                file.sha256.clone(),
                materials
            ));
            entry["version"] = json!(version);
            entry
        }
        Contents::Foreign(layers) => {
            let layers: Vec<Value> = layers.iter().map(foreign_json).collect();
            json!({ "file": path, "bytes": file.bytes, "sha256": file.sha256, "foreign": layers })
        }
    }
}

fn foreign_json(layer: &ForeignLayer) -> Value {
    let channel = |channel: &ForeignChannel| {
        json!({
            "name": channel.name,
            "type": channel.kind,
            "range": channel.samples.as_ref().and_then(|samples| samples.range),
            "not_finite": channel.samples.as_ref().map(|samples| samples.not_finite),
        })
    };
    let channels: Vec<Value> = layer.channels.iter().map(channel).collect();
    json!({ "name": layer.name, "size": layer.size, "software": layer.software, "channels": channels,
        "facts": texture::facts_json(&layer.facts) })
}
