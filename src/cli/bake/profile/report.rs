//! What a bake of a profile says at its end.

use super::Baked;
use crate::cli::format;
use std::path::Path;
use whitefurnace::engine::Profile;
use whitefurnace::table::texture::{LookupError, TextureAxis};

pub(super) fn report(profile: Profile, directory: &Path, baked: &[Baked], skipped: &[(&str, String)], seconds: f64) {
    let mut text = format!(
        "{}: {} in {}\n{}\n\n",
        profile.name(),
        format::counted(baked.len(), "table"),
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
    let axis = |axis: &TextureAxis| {
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
            "mean of the table before, rounded".into(),
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
