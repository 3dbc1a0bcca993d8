//! What every format says of a texture: one list, so that formats cannot disagree.

use crate::export::{SOFTWARE, VERSION};
use crate::table::texture::{LookupError, Texture, TextureAxis};
use serde_json::{Map, Value, json};

/// Version of this list.
pub const TEXTURE_FORMAT: u32 = 1;

/// The order of values, the same in all formats that hold them one after the other.
const ORDER: &str = "channels fastest, then axis 0 along the width, axis 1 along the height, axis 2 along the depth; \
                     row 0 is the top one, at texture coordinate 0";

/// The facts of `texture` as a tree: names of the software, sizes, storage, axes, channels, errors, and the texture's own. `layout`
/// is what the format does with texels beyond keeping them, such as padding.
pub fn tree(texture: &Texture, layout: &str) -> Map<String, Value> {
    let (min, max) = range(texture);
    let channels: Vec<Value> = texture
        .channels
        .iter()
        .map(|channel| json!({ "name": text(&channel.name), "meaning": text(&channel.meaning) }))
        .collect();
    let facts: Vec<Value> = texture
        .facts
        .iter()
        .map(|(name, value)| json!({ "name": text(name), "value": text(value) }))
        .collect();
    let errors = match &texture.errors[..] {
        [] => json!("not measured"),
        errors => errors.iter().map(error).collect(),
    };
    let all = [
        ("software", json!(format!("{SOFTWARE} {VERSION}"))),
        ("textureFormat", json!(TEXTURE_FORMAT)),
        ("id", json!(texture.id)),
        ("size", json!(texture.size())),
        ("storage", json!(texture.storage.name())),
        ("transfer", json!("linear")),
        ("order", json!(ORDER)),
        ("layout", json!(layout)),
        ("range", json!([number(min), number(max)])),
        ("axes", texture.axes.iter().map(axis).collect()),
        ("channels", channels.into()),
        ("errors", errors),
        ("facts", facts.into()),
    ];
    all.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()
}

/// The same as names and values, one line or more each: `axes.0.mapping`, `channels.1.name`.
pub fn list(texture: &Texture, layout: &str) -> Vec<(String, String)> {
    flat(&tree(texture, layout))
}

/// Names and values of a tree; arrays of arrays and numbers are values.
pub(super) fn flat(tree: &Map<String, Value>) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for (name, value) in tree {
        flatten(name, value, &mut all);
    }
    all
}

fn flatten(name: &str, value: &Value, into: &mut Vec<(String, String)>) {
    match value {
        Value::String(text) => into.push((name.into(), text.clone())),
        Value::Object(parts) => {
            for (part, value) in parts {
                flatten(&format!("{name}.{part}"), value, into);
            }
        }
        Value::Array(parts) if parts.iter().all(Value::is_object) => {
            for (index, value) in parts.iter().enumerate() {
                flatten(&format!("{name}.{index}"), value, into);
            }
        }
        other => into.push((name.into(), other.to_string())),
    }
}

fn axis(axis: &TextureAxis) -> Value {
    let TextureAxis { axis: along, flipped } = axis;
    json!({
        "parameter": along.parameter,
        "mapping": along.mapping.name(),
        "texelRule": along.rule.name(),
        "flipped": flipped,
        "min": along.min,
        "max": along.max,
        "size": along.size,
        "shader": axis.shader_expression(),
    })
}

fn error(error: &LookupError) -> Value {
    let domain: Vec<Value> = error.domain.iter().map(|ends| json!(ends.map(number))).collect();
    json!({
        "of": text(&error.of),
        "max": number(error.max),
        "mean": number(error.mean),
        "at": error.at.iter().map(|value| number(*value)).collect::<Vec<_>>(),
        "domain": domain,
        "probes": error.probes,
    })
}

/// Smallest and largest value of any channel.
fn range(texture: &Texture) -> (f64, f64) {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    texture
        .values
        .iter()
        .fold(ends, |(min, max), value| (value.min(min), value.max(max)))
}

/// JSON knows no infinity; its name says more than null.
fn number(value: f64) -> Value {
    if value.is_finite() {
        json!(value)
    } else {
        json!(value.to_string())
    }
}

/// Text without the zero that ends it in most formats.
fn text(text: &str) -> String {
    text.replace('\0', "\u{fffd}")
}
