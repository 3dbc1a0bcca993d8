//! The facts of a table as attributes of an OpenEXR header, both ways.
//!
//! What it is called and who uses it are none of them: a table under another name is the same file.
//!
//! Single numbers are doubles, so that a loader need not parse them. OpenEXR has no 64-bit integers: counts and seeds
//! are decimal strings, which no reader rounds. What was not measured is the string [`NOT_MEASURED`], never a zero.
//! Names stay below 32 bytes, above which a file needs the long-names flag and old readers refuse it. `version` is
//! reserved by OpenEXR for deep data, hence `whitefurnaceVersion`.

use super::FORMAT;
use crate::spectrum::Channels;
use crate::table::axis::{Axis, Mapping, TexelRule};
use crate::table::{Between, ErrorKind, Goal, Lobe, Quantity, Table};
use ::exr::meta::attribute::{AttributeValue, Text};
use std::collections::HashMap;
use std::fmt::Display;

/// The attribute that marks a file as ours.
pub(super) const MARK: &str = "whitefurnaceFormat";
/// The program version that wrote a file.
pub(super) const VERSION: &str = "whitefurnaceVersion";
/// Hash of the samples.
pub(super) const SAMPLES: &str = "sampleSha256";
const NOT_MEASURED: &str = "not measured";
/// The lookup error that a table was sized for; absent where sizes were given.
const GOAL: &str = "lookupTolerance";
/// Why it is exceeded; absent where it is kept.
const UNMET: &str = "unmet";
/// Value of `betweenError` where the function itself grows without bound.
const UNBOUNDED: &str = "unbounded";

/// Attributes of one header, in no order.
pub(super) type Attributes = HashMap<Text, AttributeValue>;

/// UTF-8 as it is; the constructors of the crate would refuse everything beyond Latin-1.
pub(super) fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn lines(lines: impl Iterator<Item = String>) -> AttributeValue {
    AttributeValue::TextVector(lines.map(|line| text(&line)).collect())
}

/// All facts of `table`, which has passed its checks, but its id, and the hash of its samples.
pub(super) fn from_table(table: &Table, sample_hash: &str) -> Attributes {
    let mut all = Attributes::new();
    let mut put = |name: &str, value| all.insert(text(name), value);
    let string = |value: &dyn Display| AttributeValue::Text(text(&value.to_string()));
    let number = AttributeValue::F64;
    let (min, max) = table.range();
    put(MARK, AttributeValue::I32(FORMAT));
    put(VERSION, string(&super::VERSION));
    put(SAMPLES, string(&sample_hash));
    put("quantity", string(&table.quantity.name()));
    put("lobe", string(&table.lobe.name()));
    put("estimator", string(&table.estimator));
    put("errorKind", string(&table.error_kind.name()));
    put("tolerance", number(table.tolerance));
    put("maxTexelError", number(table.max_texel_error()));
    put("min", number(min));
    put("max", number(max));
    put("evaluations", string(&table.evaluations));
    put("seed", string(&table.seed));
    // OpenEXR knows no empty string vectors: an absent one is empty.
    if !table.parameters.is_empty() {
        let pairs = table.parameters.iter().map(|(name, value)| format!("{name} = {value}"));
        put("parameters", lines(pairs));
    }
    if let Some(goal) = &table.goal {
        put(GOAL, number(goal.tolerance));
        if let Some(reason) = &goal.unmet {
            put(UNMET, string(reason));
        }
    }
    match &table.between {
        None => drop(put("betweenError", string(&NOT_MEASURED))),
        Some(between) => {
            let bounded = between.error.is_finite();
            put(
                "betweenError",
                if bounded {
                    number(between.error)
                } else {
                    string(&UNBOUNDED)
                },
            );
            put("betweenProbes", string(&between.probes));
            for (k, value) in between.at.iter().enumerate() {
                put(&format!("betweenAt{k}"), number(*value));
            }
        }
    }
    put("axes", AttributeValue::I32(table.axes.len() as i32));
    for (k, axis) in table.axes.iter().enumerate() {
        let mut put = |name: &str, value| put(&format!("axis{k}.{name}"), value);
        put("parameter", string(&axis.parameter));
        put("mapping", string(&axis.mapping.name()));
        put("texelRule", string(&axis.rule.name()));
        put("min", number(axis.min));
        put("max", number(axis.max));
        put("size", AttributeValue::I32(axis.size as i32));
        put("shader", string(&axis.shader_formula()));
    }
    all
}

/// Whether the header was written by this program.
pub(super) fn is_ours(attributes: &Attributes) -> bool {
    attributes.contains_key(&text(MARK))
}

/// Reads facts and says which one is missing or wrong.
pub(super) struct Facts<'a>(pub(super) &'a Attributes);

impl Facts<'_> {
    fn get(&self, name: &str) -> Result<&AttributeValue, String> {
        let found = self.0.get(&text(name));
        found.ok_or_else(|| format!("attribute {name} is missing"))
    }

    pub(super) fn string(&self, name: &str) -> Result<String, String> {
        match self.get(name)? {
            AttributeValue::Text(value) => utf8(name, value),
            _ => Err(format!("attribute {name} is not a string")),
        }
    }

    fn strings(&self, name: &str) -> Result<Vec<String>, String> {
        match self.0.get(&text(name)) {
            None => Ok(Vec::new()),
            Some(AttributeValue::TextVector(values)) => values.iter().map(|value| utf8(name, value)).collect(),
            Some(_) => Err(format!("attribute {name} is not a vector of strings")),
        }
    }

    pub(super) fn number(&self, name: &str) -> Result<f64, String> {
        match self.get(name)? {
            AttributeValue::F64(value) if value.is_finite() => Ok(*value),
            AttributeValue::F64(value) => Err(format!("attribute {name} is {value}")),
            _ => Err(format!("attribute {name} is not a double")),
        }
    }

    fn small(&self, name: &str) -> Result<i32, String> {
        match self.get(name)? {
            AttributeValue::I32(value) => Ok(*value),
            _ => Err(format!("attribute {name} is not an int")),
        }
    }

    fn count(&self, name: &str) -> Result<u64, String> {
        let value = self.string(name)?;
        value
            .parse()
            .map_err(|_| format!("attribute {name} is {value:?}, not a number"))
    }

    fn choice<T>(&self, name: &str, from_name: fn(&str) -> Option<T>) -> Result<T, String> {
        let value = self.string(name)?;
        from_name(&value).ok_or_else(|| format!("attribute {name} is {value:?}, which this version does not know"))
    }

    /// Refuses layouts that this version cannot know.
    pub(super) fn check_format(&self) -> Result<(), String> {
        match self.small(MARK)? {
            FORMAT => Ok(()),
            other => Err(format!(
                "attribute {MARK} is {other}, where this version reads {FORMAT}"
            )),
        }
    }

    fn axis(&self, k: usize) -> Result<Axis, String> {
        let name = |part: &str| format!("axis{k}.{part}");
        let size = self.small(&name("size"))?;
        Axis::new(
            self.string(&name("parameter"))?,
            self.choice(&name("mapping"), Mapping::from_name)?,
            self.choice(&name("texelRule"), TexelRule::from_name)?,
            [self.number(&name("min"))?, self.number(&name("max"))?],
            usize::try_from(size).map_err(|_| format!("axis{k}.size is {size}"))?,
        )
        .map_err(|error| error.to_string())
    }

    fn parameters(&self) -> Result<Vec<(String, String)>, String> {
        let pair = |line: &String| match line.split_once(" = ") {
            Some((name, value)) => Ok((name.to_string(), value.to_string())),
            None => Err(format!("attribute parameters holds {line:?}, not name = value")),
        };
        self.strings("parameters")?.iter().map(pair).collect()
    }

    fn between(&self, axes: usize) -> Result<Option<Between>, String> {
        if self.string("betweenError").is_ok_and(|value| value == NOT_MEASURED) {
            return Ok(None);
        }
        let at: Result<Vec<f64>, String> = (0..axes).map(|k| self.number(&format!("betweenAt{k}"))).collect();
        Ok(Some(Between {
            error: match self.string("betweenError") {
                Ok(text) if text == UNBOUNDED => f64::INFINITY,
                _ => self.number("betweenError")?,
            },
            at: at?,
            probes: self.count("betweenProbes")?,
        }))
    }

    fn goal(&self) -> Result<Option<Goal>, String> {
        if self.get(GOAL).is_err() {
            return Ok(None);
        }
        let unmet = self.get(UNMET).is_ok().then(|| self.string(UNMET));
        Ok(Some(Goal {
            tolerance: self.number(GOAL)?,
            unmet: unmet.transpose()?,
        }))
    }

    /// The table that the attributes describe, called `id`, still without values and errors.
    pub(super) fn table(&self, id: &str, channels: Channels) -> Result<Table, String> {
        let axes = match self.small("axes")? {
            count @ 0..=2 => count as usize,
            count => return Err(format!("attribute axes is {count}, where 0 to 2 are possible")),
        };
        let all_axes: Result<Vec<Axis>, String> = (0..axes).map(|k| self.axis(k)).collect();
        Ok(Table {
            id: id.into(),
            quantity: self.choice("quantity", Quantity::from_name)?,
            lobe: self.choice("lobe", Lobe::from_name)?,
            axes: all_axes?,
            channels,
            values: Vec::new(),
            errors: Vec::new(),
            error_kind: self.choice("errorKind", ErrorKind::from_name)?,
            parameters: self.parameters()?,
            estimator: self.string("estimator")?,
            tolerance: self.number("tolerance")?,
            evaluations: self.count("evaluations")?,
            seed: self.count("seed")?,
            goal: self.goal()?,
            between: self.between(axes)?,
        })
    }
}

fn utf8(name: &str, value: &Text) -> Result<String, String> {
    String::from_utf8(value.as_slice().to_vec()).map_err(|_| format!("attribute {name} is not UTF-8"))
}
