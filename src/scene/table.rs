//! Tables and values of a scene together with the places where they stand.

use super::error::{SceneError, unusable};
use super::library::Library;
use super::suggest::nearest;
use super::text::Text;
use super::vocabulary::Vocabulary;
use crate::measured::MeasuredError;
use crate::parameter::{Legal, Number};
use crate::spectrum::Spectrum;
use serde_spanned::Spanned;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::{DeInteger, DeTable, DeValue};

/// A table of the scene.
pub(super) struct Table<'t> {
    text: &'t Text<'t>,
    entries: &'t DeTable<'t>,
    span: Range<usize>,
}

/// A value of the scene and the key that it belongs to.
#[derive(Clone, Copy)]
pub(super) struct Entry<'t> {
    text: &'t Text<'t>,
    key: &'t str,
    value: &'t Spanned<DeValue<'t>>,
}

impl<'t> Table<'t> {
    pub(super) fn new(text: &'t Text<'t>, entries: &'t DeTable<'t>, span: Range<usize>) -> Self {
        Self { text, entries, span }
    }

    /// Line on which the table begins, counted from 1.
    pub(super) fn line(&self) -> usize {
        self.text.line(self.span.start)
    }

    /// Refuses keys beyond `allowed`, the first in the file first; `what` names the table in the message.
    pub(super) fn only(&self, what: &str, allowed: &[&str]) -> Result<(), SceneError> {
        let unknown = self.entries.keys().filter(|key| !allowed.contains(&&**key.get_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else {
            return Ok(());
        };
        let hint = match nearest(key.get_ref(), allowed.iter().copied()) {
            Some(name) => format!("; did you mean {name}?"),
            None => String::new(),
        };
        let written = self.text.quote(key.span());
        let message = format!(
            "unknown key {written}: the keys of {what} are {}{hint}",
            allowed.join(", ")
        );
        Err(self.text.refuse(key.span(), message))
    }

    pub(super) fn optional(&self, key: &'t str) -> Option<Entry<'t>> {
        self.entries.get(key).map(|value| Entry {
            text: self.text,
            key,
            value,
        })
    }

    /// The value of `key`; `rule` says what it may be, in case that it is missing.
    pub(super) fn required(&self, key: &'t str, rule: &dyn fmt::Display) -> Result<Entry<'t>, SceneError> {
        if let Some(entry) = self.optional(key) {
            return Ok(entry);
        }
        let present = self.entries.keys().map(|key| &**key.get_ref());
        let near = nearest(key, present).and_then(|near| self.entries.keys().find(|key| *key.get_ref() == near));
        Err(match near {
            Some(near) => {
                let written = self.text.quote(near.span());
                let message = format!("missing key {key}: {rule}; is {written} a misspelling of {key}?");
                self.text.refuse(near.span(), message)
            }
            None => self.refuse(format!("missing key {key}: {rule}")),
        })
    }

    /// The grey value or linear RGB under the name of `legal`.
    pub(super) fn spectrum(&self, legal: Legal) -> Result<Spectrum, SceneError> {
        let rule = Rule("a number or an array of three numbers", legal);
        self.required(legal.name, &rule)?.spectrum(legal)
    }

    /// The error that says `message` about the table as a whole.
    pub(super) fn refuse(&self, message: impl Into<String>) -> SceneError {
        self.text.refuse(self.span.clone(), message)
    }
}

impl<'t> Entry<'t> {
    /// The value as a table.
    pub(super) fn as_table(&self) -> Option<Table<'t>> {
        let entries = self.value.get_ref().as_table()?;
        Some(Table::new(self.text, entries, self.value.span()))
    }

    /// The value as a string.
    pub(super) fn as_str(&self) -> Option<&'t str> {
        self.value.get_ref().as_str()
    }

    /// The value as a table; `rule` says what it may be.
    pub(super) fn table(&self, rule: &dyn fmt::Display) -> Result<Table<'t>, SceneError> {
        self.as_table().ok_or_else(|| self.wrong_type(rule))
    }

    /// The elements of the value, as if each were written after the key; `rule` says what it may be.
    pub(super) fn elements(&self, rule: &dyn fmt::Display) -> Result<impl Iterator<Item = Self> + use<'t>, SceneError> {
        let Self { text, key, value } = *self;
        let array = value.get_ref().as_array().ok_or_else(|| self.wrong_type(rule))?;
        Ok(array.iter().map(move |value| Entry { text, key, value }))
    }

    /// A string that says something.
    pub(super) fn name(&self) -> Result<&'t str, SceneError> {
        let rule = format!("{} is a string, and not empty", self.key);
        match self.as_str() {
            Some(name) if !name.trim().is_empty() => Ok(name),
            Some(_) => Err(self.refuse(format!("is not allowed: {rule}"))),
            None => Err(self.wrong_type(&rule)),
        }
    }

    /// The file that the value names, relative to the directory of the scene file.
    pub(super) fn path(&self) -> Result<PathBuf, SceneError> {
        Ok(self.text.directory().join(self.name()?))
    }

    /// What `read` finds in that file.
    pub(super) fn data<T>(
        &self,
        read: impl FnOnce(&Library, &Path) -> Result<Arc<T>, MeasuredError>,
    ) -> Result<Arc<T>, SceneError> {
        read(self.text.library(), &self.path()?).map_err(|error| self.unusable(&error))
    }

    /// The error for a file that cannot be used.
    pub(super) fn unusable(&self, error: &dyn fmt::Display) -> SceneError {
        self.refuse(unusable(error))
    }

    /// What the value means among the names of `vocabulary`.
    pub(super) fn choice<T: Copy>(&self, vocabulary: &Vocabulary<T>) -> Result<T, SceneError> {
        let name = self.as_str().ok_or_else(|| self.wrong_type(vocabulary))?;
        vocabulary.find(name).map_err(|verdict| self.refuse(verdict))
    }

    /// A legal number; the words of a wrong type say that it may be nothing else.
    pub(super) fn number(&self, legal: Legal) -> Result<f64, SceneError> {
        self.number_or(legal, "a number")
    }

    /// A legal number where `kinds` of values, numbers among them, are allowed. Integers are taken as well as floats, and -0 is 0.
    pub(super) fn number_or(&self, legal: Legal, kinds: &'static str) -> Result<f64, SceneError> {
        let number = match self.value.get_ref() {
            DeValue::Integer(integer) => integer_as_f64(integer),
            DeValue::Float(float) => float.as_str().parse().ok(),
            _ if self.is_range() => return Err(self.refuse(NO_RANGE)),
            _ => return Err(self.wrong_type(&Rule(kinds, legal))),
        };
        match number.map(|number| legal.check(number)) {
            Some(Ok(number)) => Ok(number + 0.0),
            Some(Err(_)) | None => {
                let Legal { name, min, max } = legal;
                let (min, max) = (Number(min), Number(max));
                Err(self.refuse(format!("is not allowed: {name} lies in [{min}, {max}]")))
            }
        }
    }

    /// A legal grey value or linear RGB.
    pub(super) fn spectrum(&self, legal: Legal) -> Result<Spectrum, SceneError> {
        let rule = Rule("a number or an array of three numbers", legal);
        match self.value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => Ok(Spectrum::grey(self.number(legal)?)),
            DeValue::Array(channels) if channels.len() == 3 => {
                let mut rgb = [0.0; 3];
                for (channel, entry) in rgb.iter_mut().zip(self.elements(&rule)?) {
                    *channel = entry.number(legal)?;
                }
                Ok(Spectrum::rgb(rgb))
            }
            DeValue::Array(channels) => {
                Err(self.refuse(format!("is not allowed: {rule}, not an array of {}", channels.len())))
            }
            _ if self.is_range() => Err(self.refuse(NO_RANGE)),
            _ => Err(self.wrong_type(&rule)),
        }
    }

    /// Whether the value looks like `{ min = .., max = .. }`.
    fn is_range(&self) -> bool {
        let table = self.value.get_ref().as_table();
        table.is_some_and(|table| table.contains_key("min") || table.contains_key("max"))
    }

    /// The error `key = value verdict`.
    pub(super) fn refuse(&self, verdict: impl fmt::Display) -> SceneError {
        let Self { text, key, value } = self;
        let written = text.quote(value.span());
        let message = match value.get_ref() {
            // a table under a header or of dotted keys has no text of its own
            DeValue::Table(_) if !written.starts_with('{') => format!("{key} as a table {verdict}"),
            _ => format!("{key} = {written} {verdict}"),
        };
        text.refuse(value.span(), message)
    }

    /// The error for a value of a type that `rule` does not allow.
    pub(super) fn wrong_type(&self, rule: &dyn fmt::Display) -> SceneError {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a float",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date or time",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        };
        self.refuse(format!("is not allowed: {rule}, not {found}"))
    }
}

const NO_RANGE: &str = "is not allowed: only roughness parameters (kappa, m, n, exponent) may be ranges";

/// `kappa is a number in [0, 1e12]`
pub(super) struct Rule(pub(super) &'static str, pub(super) Legal);

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(kind, Legal { name, min, max }) = self;
        write!(f, "{name} is {kind} in [{}, {}]", Number(*min), Number(*max))
    }
}

/// The nearest f64; `None` for hexadecimal and the like beyond 128 bits, which no legal range reaches.
fn integer_as_f64(integer: &DeInteger<'_>) -> Option<f64> {
    match integer.radix() {
        10 => integer.as_str().parse().ok(),
        radix => u128::from_str_radix(integer.as_str(), radix)
            .ok()
            .map(|bits| bits as f64),
    }
}
