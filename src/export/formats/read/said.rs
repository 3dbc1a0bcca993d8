//! The facts in a file.

use super::MAX_FACT_BYTES;
use crate::export::formats::facts::TEXTURE_FORMAT;
use crate::export::read::SampleSummary;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Names that stand for lists: `axes.0.mapping` is a part of the first of the axes.
const LISTS: [&str; 4] = ["axes", "channels", "errors", "facts"];
/// Facts that are no text.
const VALUES: [&str; 12] = [
    "textureFormat",
    "size",
    "range",
    "min",
    "max",
    "mean",
    "at",
    "domain",
    "probes",
    "flipped",
    "bytes",
    "errors",
];

/// What a file says of its texture, by the names of [`crate::export::formats::facts::list`]; nothing in files of other programs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Said(BTreeMap<String, String>);

/// The image that facts have to agree with.
pub(in crate::export) struct Image<'a> {
    /// Width, height and depth in texels.
    pub(in crate::export) size: [u64; 3],
    /// Whether slices stand side by side.
    pub(in crate::export) tiled: bool,
    /// The name of the storage, where texels are in a format that this program writes.
    pub(in crate::export) storage: Option<&'a str>,
}

impl Said {
    /// The facts in these names and values.
    pub(in crate::export) fn new(pairs: impl IntoIterator<Item = (String, String)>) -> Result<Self, String> {
        let (mut all, mut bytes) = (BTreeMap::new(), 0);
        for (name, value) in pairs {
            bytes += name.len() + value.len();
            if bytes > MAX_FACT_BYTES {
                return Err(format!("its facts take more than {MAX_FACT_BYTES} bytes"));
            }
            if all.contains_key(&name) {
                return Err(format!("its fact {} stands there twice", excerpt(&name)));
            }
            all.insert(name, value);
        }
        match all.get("textureFormat") {
            _ if all.is_empty() => {}
            None => return Err("its facts lack textureFormat".into()),
            Some(found) if *found == TEXTURE_FORMAT.to_string() => {}
            Some(found) => {
                return Err(format!(
                    "its textureFormat is {}, where this program knows {TEXTURE_FORMAT}",
                    excerpt(found)
                ));
            }
        }
        Ok(Self(all))
    }

    /// The same from a tree. Only what stands where lists of facts stand is taken apart: names stay short, however deep it is.
    pub(super) fn of_tree(tree: &Map<String, Value>) -> Result<Self, String> {
        let mut pairs = Vec::new();
        for (name, value) in tree {
            match value {
                Value::Array(parts) if LISTS.contains(&name.as_str()) && parts.iter().all(Value::is_object) => {
                    let objects = parts.iter().filter_map(Value::as_object).enumerate();
                    let leaves = objects.flat_map(|(index, part)| part.iter().map(move |leaf| (index, leaf)));
                    pairs.extend(leaves.map(|(index, (leaf, value))| (format!("{name}.{index}.{leaf}"), plain(value))));
                }
                value => pairs.push((name.clone(), plain(value))),
            }
        }
        Self::new(pairs)
    }

    /// Whether the file has no facts.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The fact called `name`.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// The parts of a list: of `axes` the facts of each axis by names such as `mapping`.
    pub fn list(&self, name: &str) -> Vec<BTreeMap<&str, &str>> {
        let mut all = Vec::new();
        loop {
            let prefix = format!("{name}.{}.", all.len());
            let parts = self.0.range(prefix.clone()..);
            let parts = parts.map_while(|(name, value)| Some((name.strip_prefix(&prefix)?, value.as_str())));
            let parts: BTreeMap<&str, &str> = parts.collect();
            if parts.is_empty() {
                return all;
            }
            all.push(parts);
        }
    }

    /// The facts that are part of no list, by name.
    pub fn single(&self) -> impl Iterator<Item = (&str, &str)> {
        let is_single = |name: &str| name.split_once('.').is_none_or(|(list, _)| !LISTS.contains(&list));
        let all = self.0.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        all.filter(move |(name, _)| is_single(name))
    }

    /// All facts as they were before they became names and values.
    pub fn tree(&self) -> Map<String, Value> {
        let single = self.single().map(|(name, value)| (name.to_owned(), typed(name, value)));
        let mut tree: Map<String, Value> = single.collect();
        for name in LISTS {
            let parts: Vec<Value> = self.list(name).iter().map(object).collect();
            if !parts.is_empty() || (!self.is_empty() && !tree.contains_key(name)) {
                tree.insert(name.into(), parts.into());
            }
        }
        tree
    }

    /// What contradicts the image, or the ranges of its channels, which are empty where they are not known; padding comes last and
    /// goes.
    pub(in crate::export) fn check(&self, image: &Image, channels: &mut Vec<SampleSummary>) -> Result<(), String> {
        if self.is_empty() {
            return Ok(());
        }
        let size: [u64; 3] = self.value("size")?;
        let [width, height, depth] = size;
        let expected = match image.tiled {
            true => [width.saturating_mul(depth), height, 1],
            false => size,
        };
        if expected != image.size {
            return Err(format!("its image is {:?}, its facts say {size:?}", image.size));
        }
        let along: Vec<Option<u64>> = self
            .list("axes")
            .iter()
            .map(|axis| axis.get("size")?.parse().ok())
            .collect();
        let fits = (1..=3).contains(&along.len())
            && size.iter().enumerate().all(|(index, size)| match along.get(index) {
                Some(along) => *along == Some(*size),
                None => *size == 1,
            });
        if !fits {
            return Err(format!("its axes are not those of {size:?} texels"));
        }
        let storage = self.get("storage").unwrap_or_default();
        if image.storage.is_some_and(|found| found != storage) {
            return Err(format!(
                "its facts speak of {} where texels are others",
                excerpt(storage)
            ));
        }
        let count = self.list("channels").len();
        if channels.is_empty() {
            return Ok(());
        }
        if count == 0 || count > channels.len() {
            return Err(format!(
                "its facts speak of {count} channels, it has {}",
                channels.len()
            ));
        }
        channels.truncate(count);
        let ends = channels.iter().filter_map(|channel| channel.range);
        let found = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), (low, high)| {
            (low.min(min), high.max(max))
        });
        let stated: [f64; 2] = self.value("range")?;
        if channels.iter().any(|channel| channel.not_finite > 0) || stated != [found.0, found.1] {
            return Err(format!(
                "its texels lie in {:?}, its facts say {stated:?}: it was changed",
                [found.0, found.1]
            ));
        }
        Ok(())
    }

    /// The fact called `name` as what it has to be.
    fn value<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<T, String> {
        let text = self.get(name).ok_or_else(|| format!("its facts lack {name}"))?;
        serde_json::from_str(text).map_err(|_| format!("its fact {name} is {}", excerpt(text)))
    }
}

/// A value in one line.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn object(parts: &BTreeMap<&str, &str>) -> Value {
    let typed = |(name, value): (&&str, &&str)| ((*name).to_owned(), typed(name, value));
    Value::Object(parts.iter().map(typed).collect())
}

fn typed(name: &str, text: &str) -> Value {
    let value = serde_json::from_str(text).ok().filter(|_| VALUES.contains(&name));
    value.unwrap_or_else(|| text.into())
}

/// The beginning of a text that may be long.
fn excerpt(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.into(),
    }
}
