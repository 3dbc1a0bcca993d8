//! `furnace bake --profile`: the tables of an engine, in its layout.

mod report;

use super::{Bake, interruption};
use crate::cli::{Failure, format, output_directory};
use serde_json::{Map, Value, json};
use std::collections::HashSet;
use std::fs;
use std::io::{IsTerminal, stderr};
use std::path::Path;
use std::time::Instant;
use whitefurnace::engine::{self, LOBES, Lobe, Profile, Sheet, Sizes, Term};
use whitefurnace::estimate::Estimator;
use whitefurnace::export::formats::{Format, facts, files};
use whitefurnace::export::write::write_described;
use whitefurnace::export::{SOFTWARE, VERSION, sha256_hex};
use whitefurnace::plan::{Plan, Request};
use whitefurnace::printable::printable;
use whitefurnace::scene::{Effect, ModelSpec, Scene};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::{LookupError, Texture};

/// What says which files there are, written last.
pub(in crate::cli) const DESCRIPTION: &str = "profile.json";

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

/// A bake that has run so many seconds without a terminal tells of each finished table.
const LONG: f64 = 10.0;

/// Most integrals of a bake, hours of them.
const MOST: u64 = 200_000_000;

/// Sheets to bake, and names of the others with the reason.
type Called = (Vec<Sheet>, Vec<(&'static str, String)>);

/// More integrals than this take seconds: such a bake is announced where no terminal looks on.
const MANY: u64 = 100_000;

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
        let (sheets, skipped) = called_for(sheets, scene.as_ref())?;
        self.formats.check_sheets(profile, &sheets)?;
        let work: u64 = sheets.iter().map(engine::work).sum();
        if work > MOST {
            let (name, work, most) = (profile.name(), format::count(work), format::count(MOST));
            return Err(format!(
                "the sizes asked for are not allowed: {name} would take {work} integrals, more than {most}; lower --resolution or \
                 --roughness-resolution"
            )
            .into());
        }
        if let Some(storage) = self.formats.storage().filter(|_| profile != Profile::Generic) {
            let other = sheets.iter().filter(|sheet| sheet.storage != storage);
            let other: Vec<String> = other
                .map(|sheet| format!("{} as {}", sheet.name, sheet.storage.name()))
                .collect();
            if !other.is_empty() {
                let (storage, profile, other) = (storage.name(), profile.name(), other.join(", "));
                format::note(format!(
                    "the code of {profile} reads {other}: with --storage {storage} its loader has to change"
                ));
            }
        }
        let directory = match &self.out {
            Some(out) => out.clone(),
            None => Path::new("outputs").join(profile.name()),
        };
        output_directory(&directory)?;
        let publication = interruption::tell_nothing_is_written(&directory);
        announce(profile, &sheets, &directory);
        let baked = self
            .common
            .in_pool(|| compute(sheets, profile, (&formats, self.formats.storage())))?;
        let description = description(profile, &baked, &skipped);
        let text = serde_json::to_string_pretty(&description)? + "\n";
        let written = baked.iter().flat_map(|baked| &baked.files);
        let written: Vec<(&str, &[u8])> = written
            .map(|file| (file.name.as_str(), file.bytes.as_slice()))
            .collect();
        let earlier = earlier_files(&directory);
        publication.publish(|| write_described(&directory, &written, (DESCRIPTION, text.as_bytes())))?;
        let names: HashSet<&str> = written.iter().map(|(name, _)| *name).collect();
        let is_left = |name: &String| !names.contains(name.as_str()) && directory.join(name).is_file();
        let left: Vec<String> = earlier
            .into_iter()
            .filter(is_left)
            .map(|name| printable(&name))
            .collect();
        if !left.is_empty() {
            format::note(format!(
                "{} also holds files of an earlier bake, which profile.json no longer lists: {}",
                directory.display(),
                left.join(", ")
            ));
        }
        let seconds = start.elapsed().as_secs_f64();
        if self.common.json {
            let directory = directory.display().to_string();
            let value = json!({ "directory": directory, "seconds": seconds, "profile": description });
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            report::report(profile, &directory, &baked, &skipped, seconds);
        }
        Ok(())
    }

    /// Options that say how tables of a scene are computed, where an engine fixes what they say.
    fn refuse_what_profiles_fix(&self) -> Result<(), Failure> {
        let usual = [
            ("--tolerance", self.common.tolerance.is_empty()),
            ("--samples", self.common.samples.is_none()),
            ("--estimator", self.common.estimator == Estimator::Auto),
            ("--seed", self.common.seed == 0),
            ("--no-cache", !self.no_cache),
            ("--azimuth-resolution", self.shape.azimuth_resolution.is_none()),
            ("--axis", self.shape.axis.0.is_none()),
            ("--all-effects", !self.shape.all_effects),
        ];
        match usual.into_iter().find(|(_, is_usual)| !is_usual) {
            Some((option, _)) => Err(format!(
                "{option} is not allowed with --profile, which fixes the layout and how texels are computed: leave it out; --resolution \
                 and --roughness-resolution change sizes, --format and --storage files"
            )
            .into()),
            None => Ok(()),
        }
    }
}

/// The sheets that an effect of the scene calls for, all without a scene, and what is skipped and why.
fn called_for(sheets: Vec<Sheet>, scene: Option<&Scene>) -> Result<Called, Failure> {
    let Some(scene) = scene else {
        return Ok((sheets, Vec::new()));
    };
    // smooth glass needs no table
    let plan = Plan::new(scene, &Request::default())?;
    let mut planned = plan.tables.iter();
    let is_rough_glass = planned.any(|table| matches!(table.model, ModelSpec::RoughDielectric { .. }));
    let has = |effect: &Effect| {
        let mut calls = scene.materials.iter().flat_map(|material| &material.calls);
        calls.any(|call| call.effect == *effect)
    };
    let mut skipped = Vec::new();
    let mut kept = Vec::new();
    for sheet in sheets {
        let effects = effects(&sheet);
        if effects == [Effect::Transmission] && !is_rough_glass {
            skipped.push((
                sheet.name,
                "no material lets light through a rough interface".to_owned(),
            ));
        } else if effects.iter().any(has) {
            kept.push(sheet);
        } else {
            let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
            skipped.push((sheet.name, format!("no material calls for {}", names.join(" or "))));
        }
    }
    Ok((kept, skipped))
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
                // what glass reflects too, under an environment
                vec![
                    Effect::Metal,
                    Effect::Dielectric,
                    Effect::Clearcoat,
                    Effect::Transmission,
                ]
            }
            // of glass where an index is along
            Term::Mean | Term::MeanLoss if sheet.axes.len() > 1 => vec![Effect::Transmission],
            Term::Mean | Term::MeanLoss => {
                vec![
                    Effect::Metal,
                    Effect::Dielectric,
                    Effect::Clearcoat,
                    Effect::Transmission,
                ]
            }
        });
    }
    effects.sort();
    effects.dedup();
    effects
}

/// What is going to be computed, for whoever cannot see a bar.
fn announce(profile: Profile, sheets: &[Sheet], directory: &Path) {
    let work: u64 = sheets.iter().map(engine::work).sum();
    if work > MANY && !stderr().is_terminal() {
        format::note(format!(
            "{}: {} to fit, {} integrals; nothing is written to {} before all are finished",
            profile.name(),
            format::counted(sheets.len(), "table"),
            format::count(work),
            directory.display()
        ));
    }
}

/// The files that an earlier bake has listed; none where there is no list that can be read.
fn earlier_files(directory: &Path) -> Vec<String> {
    let text = fs::read(directory.join(DESCRIPTION)).unwrap_or_default();
    let value: Value = serde_json::from_slice(&text).unwrap_or_default();
    let tables = value["tables"].as_array().into_iter().flatten();
    let files = tables.flat_map(|table| table["files"].as_array().into_iter().flatten());
    let names = files.filter_map(|file| Some(file["file"].as_str()?.to_owned()));
    // a name, and not a way out of the directory
    names.filter(|name| !name.contains(['/', '\\'])).collect()
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
    let (start, count) = (Instant::now(), sheets.len());
    let mut baked: Vec<Baked> = Vec::new();
    for mut sheet in sheets {
        sheet.storage = storage.unwrap_or(sheet.storage);
        let earlier: Vec<(&Sheet, &Texture)> = baked.iter().map(|baked| (&baked.sheet, &baked.texture)).collect();
        let engine::Baked { texture, sampled } = engine::bake(&sheet, &earlier, &done)?;
        let formats = match formats {
            [] => vec![profile.format_of(&sheet)],
            chosen => chosen.to_vec(),
        };
        let mut written = Vec::new();
        for format in formats {
            let of_format = files(&texture, format)?.into_iter();
            written.extend(of_format.map(|(name, bytes)| File { name, format, bytes }));
        }
        if start.elapsed().as_secs_f64() > LONG && !stderr().is_terminal() {
            format::note(format!("{}/{count} {} is fitted", baked.len() + 1, sheet.name));
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
