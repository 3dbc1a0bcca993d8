//! docs/engines.md says of every profile what the profile says.

use crate::shared::{baked_with, stated};
use crate::skip::skip;
use std::fs;
use std::path::Path;
use whitefurnace::engine::{Along, Profile, Sheet, Sizes};
use whitefurnace::table::texture::TextureAxis;

fn document() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/engines.md")).unwrap()
}

fn axes(sheet: &Sheet) -> Vec<TextureAxis> {
    sheet.axes.iter().map(|along| along.axis().unwrap()).collect()
}

/// All that is fixed of a table, as the beginning of its row.
fn facts(profile: Profile, sheet: &Sheet) -> String {
    let joined = |of: &dyn Fn(&Along) -> String, between: &str| {
        let all: Vec<String> = sheet.axes.iter().map(of).collect();
        all.join(between)
    };
    let mut rules: Vec<&str> = sheet.axes.iter().map(|along| along.rule.name()).collect();
    rules.dedup();
    let flipped = sheet.axes.iter().filter(|along| along.flipped);
    let flipped: Vec<&str> = flipped.map(|along| along.parameter.name()).collect();
    let channels: Vec<&str> = sheet.channels.iter().map(|term| term.name()).collect();
    let texels: usize = sheet.axes.iter().map(|along| along.size).product();
    let bytes = texels * channels.len() * sheet.storage.bytes();
    let lobe = match channels[..] {
        ["sheen"] => "neubelt".to_owned(),
        _ if channels.contains(&"sheen") => format!("{}; neubelt", sheet.lobe.masking.name()),
        _ => sheet.lobe.masking.name().to_owned(),
    };
    format!(
        "| {} | `{}` | {} | {} | {} | {} | {lobe} | {} {} | {} | {bytes} |",
        profile.name(),
        sheet.name,
        joined(
            &|along| format!("{} {}", along.parameter.name(), along.mapping.name()),
            ", "
        ),
        if flipped.is_empty() {
            "-".into()
        } else {
            flipped.join(", ")
        },
        rules.join(", "),
        channels.join(", "),
        profile.format_of(sheet).name(),
        sheet.storage.name(),
        joined(&|along| along.size.to_string(), " x "),
    )
}

/// The row of a table's coordinates.
fn lookup(profile: Profile, sheet: &Sheet) -> String {
    let expressions: Vec<String> = axes(sheet)
        .iter()
        .map(|axis| format!("`{}`", axis.shader_expression()))
        .collect();
    format!("| {} | `{}` | {} |", profile.name(), sheet.name, expressions.join(", "))
}

fn note(profile: Profile) -> String {
    format!("| {} | {} |", profile.name(), profile.note().replace('|', "\\|"))
}

fn of_all(row: impl Fn(Profile, &Sheet) -> String) -> Vec<String> {
    let rows = |profile: Profile| {
        let sheets = profile.sheets(Sizes::default());
        sheets.iter().map(|sheet| row(profile, sheet)).collect::<Vec<_>>()
    };
    Profile::ALL.into_iter().flat_map(rows).collect()
}

#[test]
fn the_document_has_every_profile_as_it_is() {
    let document = document();
    let of_profiles = |row: &&str| {
        let name = row.split('|').nth(1).unwrap_or_default().trim();
        Profile::from_name(name).is_some()
    };
    let found: Vec<&str> = document.lines().filter(of_profiles).collect();
    let expected = [of_all(facts), of_all(lookup), Profile::ALL.map(note).to_vec()].concat();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.starts_with(expected), "{found}\nis not\n{expected}");
    }
}

/// Prints the rows of the document with the errors of full-size tables: minutes, only where they are asked for.
#[test]
fn rows_of_the_document() {
    let Ok(chosen) = std::env::var("FURNACE_LONG") else {
        skip("FURNACE_LONG=1, or names of profiles, bakes them full size and prints rows of docs/engines.md");
        return;
    };
    let is_chosen = |profile: &Profile| chosen == "1" || chosen.split(',').any(|name| name == profile.name());
    for profile in Profile::ALL.into_iter().filter(is_chosen) {
        let baked = baked_with(profile.sheets(Sizes::default()));
        for (sheet, texture) in &baked {
            let mut names: Vec<&str> = texture.errors.iter().map(|error| error.of.as_str()).collect();
            names.dedup();
            let mut cells = ["", "", ""].map(String::from);
            for (k, name) in names.iter().enumerate() {
                let error = stated(&baked, sheet.name, name);
                let between = if k == 0 { "" } else { "; " };
                cells[0] += &format!("{between}{name}");
                cells[1] += &format!("{between}{:.4} %", 100.0 * error.mean);
                cells[2] += &format!("{between}{:.3} %", 100.0 * error.max);
            }
            if names.is_empty() {
                cells = ["mean of the table before, rounded", "-", "-"].map(String::from);
            }
            println!("{} {} |", facts(profile, sheet), cells.join(" | "));
        }
    }
    for row in of_all(lookup).into_iter().chain(Profile::ALL.map(note)) {
        println!("{row}");
    }
}
