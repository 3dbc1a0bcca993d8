//! Raw numbers by the JSON beside them.

use super::said::{Image, Said};
use super::{Found, ranges};
use crate::export::json_reason;
use crate::table::Storage;
use serde_json::{Map, Value};

/// What the JSON says of the numbers.
struct About {
    size: [u64; 3],
    storage: Storage,
    channels: usize,
    sha256: String,
    facts: Said,
}

impl About {
    fn of(json: &[u8]) -> Result<Self, String> {
        let about: Map<String, Value> = serde_json::from_slice(json).map_err(|error| json_reason(&error))?;
        let wrong = |name: &str, what: &str| format!("it is no description of raw numbers: {name} should be {what}");
        let text = |name: &str| about.get(name).and_then(Value::as_str);
        let numbers = about.get("size").and_then(Value::as_array);
        let numbers: Option<Vec<u64>> = numbers.and_then(|size| size.iter().map(Value::as_u64).collect());
        let size = numbers.and_then(|size| size.try_into().ok());
        let size = size.ok_or_else(|| wrong("size", "three numbers of texels"))?;
        let storage = text("storage").and_then(Storage::from_name);
        let storage = storage.ok_or_else(|| wrong("storage", "f32, f16, unorm16 or unorm8"))?;
        let channels = about.get("channels").and_then(Value::as_array).map_or(0, Vec::len);
        if !(1..=4).contains(&channels) {
            return Err(wrong("channels", "one to four"));
        }
        if text("byteOrder") != Some("little-endian") {
            return Err(wrong("byteOrder", "little-endian"));
        }
        let sha256 = text("sha256").ok_or_else(|| wrong("sha256", "the hash of the numbers"))?;
        let sha256 = sha256.to_owned();
        // a list of channels is what their number comes from
        let facts = Said::of_tree(&about)?;
        if facts.is_empty() || facts.list("channels").len() != channels {
            return Err(wrong("channels", "one to four with names"));
        }
        Ok(Self {
            size,
            storage,
            channels,
            sha256,
            facts,
        })
    }
}

/// What is wrong with the JSON.
pub(super) fn check(json: &[u8]) -> Result<(), String> {
    About::of(json).map(drop)
}

/// What `bytes`, whose hash is `sha256`, hold by `json`.
pub(super) fn decode(json: &[u8], bytes: &[u8], sha256: &str) -> Result<Found, String> {
    let about = About::of(json).map_err(|reason| format!("the JSON beside it: {reason}"))?;
    let mut channels = ranges(bytes, about.storage, about.channels, about.size)?;
    if about.sha256 != sha256 {
        return Err("its hash is not the one in the JSON beside it".into());
    }
    let image = Image {
        size: about.size,
        tiled: false,
        storage: Some(about.storage.name()),
    };
    about.facts.check(&image, &mut channels)?;
    Ok(Found {
        size: about.size,
        texel: format!("{} x {}, little-endian", about.channels, about.storage.name()),
        storage: Some(about.storage),
        channels,
        facts: about.facts,
    })
}
