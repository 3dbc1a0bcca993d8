//! `furnace bake --profile`: the tables of an engine, in its layout.

use super::Bake;
use crate::cli::{Failure, format, output_directory};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Instant;
use whitefurnace::engine::{self, LOBES, Lobe, Profile, Sheet, Sizes, Term, Texels};
use whitefurnace::export::formats::{Format, facts, files};
use whitefurnace::export::write::write_described;
use whitefurnace::export::{SOFTWARE, VERSION, sha256_hex};
use whitefurnace::printable::printable;
use whitefurnace::scene::{Effect, Scene};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::{LookupError, Texture};

/// What says which files there are, written last.
const DESCRIPTION: &str = "profile.json";

/// A file to write.
struct File {
    name: String,
    format: Format,
    bytes: Vec<u8>,
}

/// A table, and what became of it.
struct Baked {
    sheet: Sheet,
    texture: Texture,
    /// The errors that texels would leave that hold the truth at their places.
    sampled: Vec<LookupError>,
    files: Vec<File>,
}

pub(in crate::cli) fn parse_profile(name: &str) -> Result<Profile, String> {
    let names: Vec<&str> = Profile::ALL.into_iter().map(Profile::name).collect();
    Profile::from_name(name).ok_or_else(|| format!("{} is none of {}", printable(name), names.join(", ")))
}

pub(super) fn parse_lobe(name: &str) -> Result<Lobe, String> {
    let names: Vec<&str> = LOBES.iter().map(|(name, _)| *name).collect();
    let found = LOBES.iter().find(|(known, _)| *known == name);
    found
        .map(|(_, lobe)| *lobe)
        .ok_or_else(|| format!("{} is none of {}", printable(name), names.join(", ")))
}

impl Bake {
    pub(super) fn profile(&self, profile: Profile) -> Result<(), Failure> {
        let start = Instant::now();
        self.refuse_what_profiles_fix()?;
        let formats = self.formats.of_profile()?;
        let scene = self.common.scene.as_ref().map(|_| self.common.load()).transpose()?;
        let sizes = Sizes {
            mu: self.shape.resolution,
            roughness: self.shape.roughness_resolution,
        };
        let mut sheets = profile.sheets(sizes);
        if let Some(lobe) = self.lobe {
            if profile != Profile::Generic {
                return Err("--lobe is not allowed with --profile other than generic: an engine has one lobe".into());
            }
            sheets.iter_mut().for_each(|sheet| sheet.lobe = lobe);
        }
        let (sheets, skipped) = called_for(sheets, scene.as_ref());
        let directory = match &self.out {
            Some(out) => out.clone(),
            None => Path::new("outputs").join(profile.name()),
        };
        output_directory(&directory)?;
        let baked = self
            .common
            .in_pool(|| compute(sheets, profile, (&formats, self.formats.storage())))?;
        let description = description(profile, &baked, &skipped);
        let text = serde_json::to_string_pretty(&description)? + "\n";
        let written = baked.iter().flat_map(|baked| &baked.files);
        let written: Vec<(&str, &[u8])> = written
            .map(|file| (file.name.as_str(), file.bytes.as_slice()))
            .collect();
        write_described(&directory, &written, (DESCRIPTION, text.as_bytes()))?;
        let seconds = start.elapsed().as_secs_f64();
        if self.common.json {
            let directory = directory.display().to_string();
            let value = json!({ "directory": directory, "seconds": seconds, "profile": description });
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            report(profile, &directory, &baked, &skipped, seconds);
        }
        Ok(())
    }

    /// Options that say how tables of a scene are computed, where an engine fixes what they say.
    fn refuse_what_profiles_fix(&self) -> Result<(), Failure> {
        let usual = [
            ("--tolerance", self.common.tolerance.is_empty()),
            ("--samples", self.common.samples.is_none()),
            ("--azimuth-resolution", self.shape.azimuth_resolution.is_none()),
            ("--axis", self.shape.axis.0.is_none()),
            ("--all-effects", !self.shape.all_effects),
        ];
        match usual.into_iter().find(|(_, is_usual)| !is_usual) {
            Some((option, _)) => Err(format!(
                "{option} is not allowed with --profile, which fixes the layout: leave it out; --resolution and \
                 --roughness-resolution change sizes, --format and --storage files"
            )
            .into()),
            None => Ok(()),
        }
    }
}

/// The sheets that an effect of the scene calls for, all without a scene, and what is skipped and why.
fn called_for(sheets: Vec<Sheet>, scene: Option<&Scene>) -> (Vec<Sheet>, Vec<(&'static str, String)>) {
    let Some(scene) = scene else {
        return (sheets, Vec::new());
    };
    let has = |effect: &Effect| {
        let mut calls = scene.materials.iter().flat_map(|material| &material.calls);
        calls.any(|call| call.effect == *effect)
    };
    let mut skipped = Vec::new();
    let mut kept = Vec::new();
    for sheet in sheets {
        let effects = effects(&sheet);
        if effects.iter().any(has) {
            kept.push(sheet);
        } else {
            let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
            skipped.push((sheet.name, format!("no material calls for {}", names.join(" or "))));
        }
    }
    (kept, skipped)
}

/// The effects that a sheet serves.
fn effects(sheet: &Sheet) -> Vec<Effect> {
    let mut effects = Vec::new();
    for term in &sheet.channels {
        effects.extend(match term {
            Term::Sheen => vec![Effect::Sheen],
            Term::Interface | Term::Reflected | Term::Transmitted if sheet.axes.len() > 2 => vec![Effect::Transmission],
            Term::Interface | Term::Reflected | Term::Transmitted => vec![Effect::Clearcoat],
            Term::DisneyDiffuse => vec![Effect::Diffuse],
            Term::Scale | Term::Bias | Term::Total | Term::Loss => {
                vec![Effect::Metal, Effect::Dielectric, Effect::Clearcoat]
            }
            // of glass where an index is along
            Term::Mean | Term::MeanLoss if sheet.axes.len() > 1 => vec![Effect::Transmission],
            Term::Mean | Term::MeanLoss => vec![Effect::Metal, Effect::Dielectric, Effect::Clearcoat],
        });
    }
    effects.sort();
    effects.dedup();
    effects
}

/// Computes and encodes all sheets.
fn compute(
    sheets: Vec<Sheet>,
    profile: Profile,
    (formats, storage): (&[Format], Option<Storage>),
) -> Result<Vec<Baked>, Failure> {
    let work: u64 = sheets.iter().map(engine::work).sum();
    let bar = format::progress_of(work, "fitting", "integrals");
    let done = |count: u64| bar.inc(count);
    let mut baked: Vec<Baked> = Vec::new();
    for mut sheet in sheets {
        sheet.storage = storage.unwrap_or(sheet.storage);
        let earlier: Vec<(&Sheet, &Texture)> = baked.iter().map(|baked| (&baked.sheet, &baked.texture)).collect();
        let texture = engine::bake(&sheet, Texels::Fitted, &earlier, &done)?;
        let sampled = match sheet.axes.len() {
            2 => engine::bake(&sheet, Texels::Sampled, &earlier, &|_| ())?.errors,
            _ => Vec::new(),
        };
        let formats = match formats {
            [] => vec![profile.format_of(&sheet)],
            chosen => chosen.to_vec(),
        };
        let mut written = Vec::new();
        for format in formats {
            let of_format = files(&texture, format)?.into_iter();
            written.extend(of_format.map(|(name, bytes)| File { name, format, bytes }));
        }
        baked.push(Baked {
            sheet,
            texture,
            sampled,
            files: written,
        });
    }
    bar.finish_and_clear();
    Ok(baked)
}

fn description(profile: Profile, baked: &[Baked], skipped: &[(&str, String)]) -> Value {
    let table = |baked: &Baked| {
        let mut entry = facts::tree(&baked.texture, "");
        entry.shift_remove("layout");
        let files = baked.files.iter().map(|file| {
            json!({ "file": file.name, "format": file.format.name(), "bytes": file.bytes.len(), "sha256": sha256_hex(&file.bytes) })
        });
        entry.insert("files".into(), files.collect());
        entry.insert("texelBytes".into(), json!(baked.texture.bytes()));
        Value::Object(entry)
    };
    let skipped: Map<String, Value> = skipped
        .iter()
        .map(|(name, why)| ((*name).to_owned(), json!(why)))
        .collect();
    json!({
        "software": SOFTWARE,
        "version": VERSION,
        "profile": profile.name(),
        "lookup": profile.note(),
        "tables": baked.iter().map(table).collect::<Vec<_>>(),
        "skipped": skipped,
    })
}

fn report(profile: Profile, directory: &Path, baked: &[Baked], skipped: &[(&str, String)], seconds: f64) {
    let mut text = format!(
        "{}: {} tables in {}\n{}\n\n",
        profile.name(),
        baked.len(),
        directory.display(),
        profile.note()
    );
    if baked.is_empty() {
        text += "The scene calls for none of its tables.\n";
    } else {
        text += &table(baked);
    }
    for (name, why) in skipped {
        text += &format!("Skipped {name}: {why}.\n");
    }
    text += &format!("{}.", format::seconds(seconds));
    format::say(text);
}

fn table(baked: &[Baked]) -> String {
    let mut text = format::table(
        &[
            "table",
            "texels",
            "axes",
            "channels",
            "stored",
            "bytes",
            "error of",
            "mean",
            "largest",
            "at",
            "not fitted",
        ],
        &["texels", "bytes", "mean", "largest", "not fitted"],
        baked.iter().flat_map(rows).collect(),
    )
    .to_string();
    text += "\n\nErrors are of linear lookups for mu from 0.01 and roughness from 0.05 on: of `furnace` and `r0` shares of the albedo, of others \
             of 1. `not fitted` has what the same texels would leave if each held the truth at its place: mean and largest.\n";
    text
}

/// A line for each error over the domain, the first with what the table is.
fn rows(baked: &Baked) -> Vec<Vec<String>> {
    let texture = &baked.texture;
    let sizes: Vec<String> = texture.axes.iter().map(|axis| axis.axis.size.to_string()).collect();
    let axis = |axis: &whitefurnace::table::texture::TextureAxis| {
        let flip = if axis.flipped { "1 - " } else { "" };
        format!("{flip}{}", axis.axis.label())
    };
    let axes: Vec<String> = texture.axes.iter().map(axis).collect();
    let channels: Vec<&str> = texture.channels.iter().map(|channel| channel.name.as_str()).collect();
    let first = [
        texture.id.clone(),
        sizes.join(" x "),
        axes.join(", "),
        channels.join(", "),
        texture.storage.name().to_owned(),
        texture.bytes().to_string(),
    ];
    let domain = baked.sheet.domain();
    let of_domain = || texture.errors.iter().filter(|error| error.domain == domain);
    let line = |error: &LookupError| {
        let at: Vec<String> = texture
            .axes
            .iter()
            .zip(&error.at)
            .map(|(axis, at)| format!("{} {at:.3}", axis.axis.parameter))
            .collect();
        let plain = baked
            .sampled
            .iter()
            .find(|other| other.of == error.of && other.domain == error.domain);
        let plain = plain.map(|plain| format!("{}, {}", percent(plain.mean), percent(plain.max)));
        vec![
            error.of.clone(),
            percent(error.mean),
            percent(error.max),
            at.join(", "),
            plain.unwrap_or_default(),
        ]
    };
    let mut lines: Vec<Vec<String>> = of_domain().map(line).collect();
    if lines.is_empty() {
        lines.push(vec![
            "exact mean of the table before".into(),
            "-".into(),
            "-".into(),
            String::new(),
            String::new(),
        ]);
    }
    let blank = || vec![String::new(); first.len()];
    let start = |k: usize| if k == 0 { first.to_vec() } else { blank() };
    lines
        .into_iter()
        .enumerate()
        .map(|(k, line)| [start(k), line].concat())
        .collect()
}

fn percent(share: f64) -> String {
    format!("{:.4} %", 100.0 * share)
}
