//! The file: a template with style, scripts, shaders and data in it.
//!
//! Names of materials are free text, and the page is made to be passed on: data stand in a block of JSON that no name can end, get
//! into the page as text alone, and a policy in the page allows the scripts and the style of this file, by their hashes, and
//! nothing else. It asks no server for anything.

use super::base64;
use super::cast::Cast;
use super::data;
use super::sheets::Sheets;
use crate::export::VERSION;
use crate::printable::printable;
use crate::shader::{self, Language, ShaderError};
use crate::table::axis::AxisError;
use serde_json::json;
use sha2::{Digest, Sha256};
use thiserror::Error;

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// In the order in which they need each other.
const SCRIPTS: [&str; 6] = [
    include_str!("page/tables.js"),
    include_str!("page/predict.js"),
    include_str!("page/renderer.js"),
    include_str!("page/colours.js"),
    include_str!("page/plots.js"),
    include_str!("page/page.js"),
];

/// Why there is no page.
#[derive(Debug, Error)]
pub enum PageError {
    /// A surface without an axis; those that sheets were made for have one.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// The library of shader functions was refused.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

/// The page of `cast`, whose sheets are `sheets`, as HTML.
///
/// # Errors
/// [`PageError`]
pub fn html(scene: &str, cast: &Cast, sheets: &[Vec<Sheets>]) -> Result<String, PageError> {
    let mut value = data::json(scene, cast, sheets)?;
    // lobes, couplings and compensation, the same text that renderers get
    let library = shader::library(Language::GlslEs)?;
    let material = format!("{library}\n{}", include_str!("page/material.glsl"));
    value["shaders"] = json!({
        "corners": include_str!("page/corners.vert.glsl"),
        "material": material,
        "furnace": include_str!("page/furnace.frag.glsl"),
        "lit": include_str!("page/lit.frag.glsl"),
        "enclosed": include_str!("page/enclosed.frag.glsl"),
    });
    let script = SCRIPTS.concat();
    let policy = format!(
        "default-src 'none'; img-src data:; style-src '{}'; script-src '{}'; base-uri 'none'; form-action 'none'",
        hash(STYLE),
        hash(&script)
    );
    let title = escaped(&printable(scene));
    Ok(filled(
        TEMPLATE,
        &[
            ("policy", &policy),
            ("scene", &title),
            ("version", VERSION),
            ("style", STYLE),
            ("data", &harmless(&value.to_string())),
            ("script", &script),
        ],
    ))
}

/// What a policy knows an inline block by.
fn hash(text: &str) -> String {
    format!("sha256-{}", base64::encode(&Sha256::digest(text.as_bytes())))
}

/// `template` with every `{{name}}` replaced, in one pass: what is put in is not looked at again.
fn filled(template: &str, parts: &[(&str, &str)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text.push_str(before);
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let part = parts.iter().find(|(known, _)| *known == name);
        text.push_str(part.map_or("", |(_, value)| value));
        rest = after;
    }
    text.push_str(rest);
    text
}

/// Text between tags or in quotes.
fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c => safe.push(c),
        }
    }
    safe
}

/// JSON that ends no block of HTML and opens no comment: these characters stand in strings alone, where JSON may write them so.
fn harmless(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => safe.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn names_cannot_leave_their_place() {
        let hostile = "</script><!-- \" ' & {{script}} \u{2028}";
        let json = harmless(&json!({ "name": hostile }).to_string());
        assert!(!json.contains(['<', '>', '&', '\u{2028}']), "{json}");
        let back: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(back["name"], hostile);
        let title = escaped(hostile);
        assert!(!title.contains(['<', '>', '"', '\'']), "{title}");
        let page = filled(
            "<title>{{scene}}</title>{{script}}",
            &[("scene", &title), ("script", "x{{scene}}")],
        );
        assert_eq!(page, format!("<title>{title}</title>x{{{{scene}}}}"));
    }

    #[test]
    fn the_template_asks_for_what_there_is() {
        let known = ["policy", "scene", "version", "style", "data", "script"];
        let asked: Vec<&str> = TEMPLATE
            .split("{{")
            .skip(1)
            .map(|part| part.split_once("}}").unwrap().0)
            .collect();
        assert!(asked.iter().all(|name| known.contains(name)), "{asked:?}");
        assert!(known.iter().all(|name| asked.contains(name)), "{asked:?}");
        // blocks of text that would end early
        assert!(!SCRIPTS.concat().contains("</script") && !STYLE.contains("</style"));
        // nothing from elsewhere
        let all = [TEMPLATE, STYLE, &SCRIPTS.concat()].concat();
        assert!(!all.contains("http:") && !all.contains("https:") && !all.contains("@import"));
    }
}
