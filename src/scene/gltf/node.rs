//! JSON as far as materials need it.
//!
//! A file may be large for what it embeds: meshes, animations and textures in base64. Those are passed over while the text is
//! read, so that memory goes with what is kept, and of that there is at most [`MOST_NODES`]. Derived structs would refuse a
//! file at its first oddity anywhere, where this reader wants to say which of them are in its way, and by which name.

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::cell::Cell;
use std::fmt;

/// Most values that are kept of a file: some 90 bytes each when they have a name, a third of that when they have none.
/// A material of the richest kind has fewer than a hundred.
pub(super) const MOST_NODES: usize = 1 << 22;

/// A JSON value; numbers are f64, as in JavaScript, so that 1 and 1.0 are the same.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    Null,
    Bool(bool),
    Number(f64),
    Text(String),
    Array(Vec<Node>),
    /// In the order of the file, with different names.
    Object(Vec<(String, Node)>),
}

/// What is kept of a value.
#[derive(Debug, Clone, Copy)]
pub(super) enum Keep {
    /// Everything but what is called `extras`, which belongs to applications.
    All,
    /// Which kind of value it is: scalars as they are, arrays and objects without what is in them.
    Kind,
    /// Of an object the names, and of which kind their values are.
    Names,
    /// Of an array all elements, each as far as this says.
    Each(&'static Keep),
    /// Of an object the values with these names.
    Only(&'static [(&'static str, Keep)]),
}

impl Node {
    /// The value called `name` of an object.
    pub(super) fn get(&self, name: &str) -> Option<&Self> {
        let Self::Object(members) = self else { return None };
        members.iter().find(|(own, _)| own == name).map(|(_, node)| node)
    }

    /// What it is, for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Bool(_) => "a boolean",
            Self::Number(_) => "a number",
            Self::Text(_) => "a string",
            Self::Array(_) => "an array",
            Self::Object(_) => "an object",
        }
    }
}

/// Reads a value as far as `keep` says; `left` counts down the values that may still be kept.
pub(super) struct Reading<'b> {
    pub(super) keep: Keep,
    pub(super) left: &'b Cell<usize>,
}

impl Reading<'_> {
    /// What is kept of an element of an array, `None` when nothing is.
    fn of_element(&self) -> Option<Keep> {
        match self.keep {
            Keep::All => Some(Keep::All),
            Keep::Each(keep) => Some(*keep),
            Keep::Kind | Keep::Names | Keep::Only(_) => None,
        }
    }

    /// What is kept of the member `name` of an object, `None` when nothing is.
    fn of_member(&self, name: &str) -> Option<Keep> {
        match self.keep {
            Keep::All => (name != "extras").then_some(Keep::All),
            Keep::Names => Some(Keep::Kind),
            Keep::Only(members) => members.iter().find(|(own, _)| *own == name).map(|(_, keep)| *keep),
            Keep::Kind | Keep::Each(_) => None,
        }
    }

    fn inner(&self, keep: Keep) -> Self {
        Self { keep, left: self.left }
    }

    fn count<E: Error>(&self) -> Result<(), E> {
        let left = self.left.get().checked_sub(1);
        self.left.set(left.unwrap_or(0));
        left.map(|_| ()).ok_or_else(|| E::custom("too many values"))
    }
}

impl<'de> DeserializeSeed<'de> for Reading<'_> {
    type Value = Node;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Node, D::Error> {
        self.count()?;
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Reading<'_> {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Bool(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Node, E> {
        Ok(Node::Text(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Node, A::Error> {
        let mut kept = Vec::new();
        match self.of_element() {
            Some(keep) => {
                while let Some(node) = elements.next_element_seed(self.inner(keep))? {
                    kept.push(node);
                }
            }
            None => while elements.next_element::<IgnoredAny>()?.is_some() {},
        }
        Ok(Node::Array(kept))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Node, A::Error> {
        let mut kept = Vec::new();
        while let Some(name) = members.next_key::<String>()? {
            match self.of_member(&name) {
                Some(keep) => kept.push((name, members.next_value_seed(self.inner(keep))?)),
                None => {
                    members.next_value::<IgnoredAny>()?;
                }
            }
        }
        // of two values neither can be taken for the one that is meant
        let mut names: Vec<&str> = kept.iter().map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => {
                let name: String = pair[0].chars().take(40).collect();
                Err(A::Error::custom(format!("an object has two values named \"{name}\"")))
            }
            None => Ok(Node::Object(kept)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(keep: Keep, text: &str, most: usize) -> Result<Node, String> {
        let left = Cell::new(most);
        let reading = Reading { keep, left: &left };
        let node = reading.deserialize(&mut serde_json::Deserializer::from_str(text));
        node.map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_not_kept_is_passed_over() {
        const KEEP: Keep = Keep::Only(&[("a", Keep::All), ("b", Keep::Kind), ("c", Keep::Names)]);
        let text = r#"{"a":[1,{"extras":{},"x":null}],"b":{"y":1e999},"c":{"z":[1]},"d":{"a":1e999,"a":2}}"#;
        let object = |members: &[(&str, Node)]| {
            Node::Object(
                members
                    .iter()
                    .map(|(name, node)| ((*name).to_owned(), node.clone()))
                    .collect(),
            )
        };
        let expected = object(&[
            ("a", Node::Array(vec![Node::Number(1.0), object(&[("x", Node::Null)])])),
            ("b", object(&[])),
            ("c", object(&[("z", Node::Array(vec![]))])),
        ]);
        assert_eq!(read(KEEP, text, 100), Ok(expected));
    }

    #[test]
    fn names_that_stand_twice_numbers_beyond_f64_and_too_much_are_refused() {
        for (text, reason) in [
            (r#"{"a":1,"b":2,"a":3}"#, "two values named \"a\""),
            ("[1e999]", "number out of range"),
            ("[0,0,0,0,0,0,0]", "too many values"),
            ("[", "EOF"),
        ] {
            let error = read(Keep::All, text, 7).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
        let deep = format!("{}{}", "[".repeat(200), "]".repeat(200));
        assert!(read(Keep::All, &deep, 1000).unwrap_err().contains("recursion limit"));
    }
}
