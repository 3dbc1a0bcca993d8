//! What a texture holds: `.ktx2`, `.dds`, `.png`, and `.bin` with its `.json`.

use crate::cli::{Failure, format};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use whitefurnace::export::formats::Format;
use whitefurnace::export::formats::read::{Listed, Said, TextureFile, listed_beside, read_texture};
use whitefurnace::export::read::SampleSummary;
use whitefurnace::printable::printable;

/// Reads the file and prints what is known.
pub(super) fn inspect(path: &Path, as_json: bool) -> Result<(), Failure> {
    let file = read_texture(path)?;
    let listed = listed_beside(&file.path);
    if as_json {
        format::say(serde_json::to_string_pretty(&to_json(&file, listed.as_ref()))?);
    } else {
        report(&file, listed.as_ref());
    }
    Ok(())
}

fn report(file: &TextureFile, listed: Option<&Listed>) {
    format::say(format!(
        "{}, {} bytes, sha256 {}{}\n\n",
        printable(&file.path.display().to_string()),
        file.bytes,
        file.sha256,
        standing(listed, &file.sha256)
    ));
    let contents = &file.contents;
    let [width, height, depth] = contents.size;
    line("format", &format!("{}, {}", file.format.name(), contents.texel));
    line("texels", &format!("{width} x {height} x {depth}"));
    if let Some(storage) = contents.storage {
        line("storage", storage.name());
    }
    let names = contents.facts.list("channels");
    for (index, samples) in contents.channels.iter().enumerate() {
        let name = names.get(index).and_then(|channel| channel.get("name"));
        let name = name.map_or_else(|| index.to_string(), |name| (*name).to_owned());
        line("range", &format!("{name}: {}", range(samples)));
    }
    if contents.channels.is_empty() {
        line(
            "range",
            "texels not decoded: their format is none that this program writes",
        );
    }
    report_facts(&contents.facts);
    if contents.facts.is_empty() {
        format::say(match (file.format, listed) {
            (_, Some(listed)) => format!(
                "\nThe file itself has no facts of whitefurnace; {} says what it is.",
                listed.list
            ),
            (Format::Dds, None) => {
                "\nIt has no facts of whitefurnace, for which DDS has no room, and no manifest.json or profile.json \
                                    beside it lists it: axes, channels and errors are unknown."
                    .into()
            }
            _ => "\nIt has no facts of whitefurnace: axes, channels and errors are unknown.".into(),
        });
    }
}

/// How the file and the list beside it go together.
pub(super) fn standing(listed: Option<&Listed>, sha256: &str) -> String {
    match listed {
        Some(listed) if listed.sha256 == sha256 => format!(", as in {}", listed.list),
        Some(listed) => format!(
            "\nfinding: {} beside it has another hash: changed since the bake, or of another bake",
            listed.list
        ),
        None => String::new(),
    }
}

/// A line for a fact, whatever it holds.
fn line(name: &str, fact: &str) {
    format::say(format!("{:<13} {}", printable(name), printable(fact)));
}

/// A line for each axis, channel, error and further fact.
pub(super) fn report_facts(facts: &Said) {
    for axis in facts.list("axes") {
        let [parameter, mapping, rule, min, max, size, shader] =
            ["parameter", "mapping", "texelRule", "min", "max", "size", "shader"].map(|name| part(&axis, name));
        let flipped = match part(&axis, "flipped") {
            "true" => ", flipped",
            _ => "",
        };
        line(
            "axis",
            &format!("{parameter} {min} .. {max}: {size} texels, {mapping}, {rule}{flipped}, coordinate = {shader}"),
        );
    }
    for channel in facts.list("channels") {
        line(
            "channel",
            &format!("{}: {}", part(&channel, "name"), part(&channel, "meaning")),
        );
    }
    for error in facts.list("errors") {
        let [of, max, mean, at, domain, probes] =
            ["of", "max", "mean", "at", "domain", "probes"].map(|name| part(&error, name));
        line(
            "error",
            &format!("{of}: at most {max} at {at}, mean {mean}, over {domain}, {probes} places"),
        );
    }
    for fact in facts.list("facts") {
        line(part(&fact, "name"), part(&fact, "value"));
    }
    for (name, value) in facts.single() {
        line(name, value);
    }
}

fn part<'a>(parts: &BTreeMap<&str, &'a str>, name: &str) -> &'a str {
    parts.get(name).copied().unwrap_or("?")
}

fn range(channel: &SampleSummary) -> String {
    let range = match channel.range {
        Some((min, max)) => format!("{min} .. {max}"),
        None => "no finite value".into(),
    };
    match channel.not_finite {
        0 => range,
        count => format!("{range}, {count} not finite"),
    }
}

/// The list beside the file, and whether it speaks of the same bytes.
pub(super) fn listed_json(listed: Option<&Listed>, sha256: &str) -> Value {
    match listed {
        Some(listed) => json!({ "in": listed.list, "same": listed.sha256 == sha256 }),
        None => Value::Null,
    }
}

fn to_json(file: &TextureFile, listed: Option<&Listed>) -> Value {
    let channel = |channel: &SampleSummary| json!({ "range": channel.range, "not_finite": channel.not_finite });
    let contents = &file.contents;
    json!({
        "file": file.path.display().to_string(),
        "bytes": file.bytes,
        "sha256": file.sha256,
        "listed": listed_json(listed, &file.sha256),
        "format": file.format.name(),
        "size": contents.size,
        "texel": contents.texel,
        "storage": contents.storage.map(|storage| storage.name()),
        "channels": contents.channels.iter().map(channel).collect::<Vec<_>>(),
        "facts": facts_json(&contents.facts),
    })
}

/// The facts, null where there are none.
pub(super) fn facts_json(facts: &Said) -> Value {
    match facts.is_empty() {
        true => Value::Null,
        false => Value::Object(facts.tree()),
    }
}
