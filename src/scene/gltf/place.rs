//! Values with the place where they stand, and what is said of those that are wrong.

use super::node::Node;
use crate::parameter::{Legal, Number};
use crate::printable::printable;
use crate::scene::error::SceneError;

/// Most warnings of one scene; how many more there are is said in another.
const MOST_NOTES: usize = 100;

/// Longest text of the file that a message quotes, in characters.
const LONGEST_QUOTE: usize = 40;

/// A value that is in the way, or would be if anything depended on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Problem {
    /// Where: `materials[3].pbrMetallicRoughness.roughnessFactor`, or `byte 12` of a container.
    pub(super) place: String,
    /// What is wrong there, as it goes on behind the place.
    pub(super) message: String,
}

impl Problem {
    pub(super) fn new(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            place: place.into(),
            message: message.into(),
        }
    }

    pub(super) fn of(self, source: &str) -> SceneError {
        SceneError::Misfit {
            path: source.to_owned(),
            place: self.place,
            message: self.message,
        }
    }
}

/// What the reader looked past.
#[derive(Debug, Default)]
pub(super) struct Notes {
    kept: Vec<String>,
    more: usize,
}

impl Notes {
    /// `message` goes on behind `place`.
    pub(super) fn add(&mut self, place: &str, message: &str) {
        if self.is_full() {
            self.more += 1;
        } else {
            self.kept.push(printable(&format!("{place} {message}")));
        }
    }

    /// Whether another warning would only be counted.
    pub(super) fn is_full(&self) -> bool {
        self.kept.len() == MOST_NOTES
    }

    /// What nothing depends on is a warning, and no error.
    pub(super) fn excuse(&mut self, problem: &Problem, why: &str) {
        self.add(&problem.place, &format!("{}; {why}", problem.message));
    }

    pub(super) fn into_warnings(mut self) -> Vec<String> {
        if self.more > 0 {
            self.kept.push(format!("and {} more of such places", self.more));
        }
        self.kept
    }
}

/// Text of the file, cut to a readable length.
pub(super) fn quote(text: &str) -> String {
    let mut quote: String = text.chars().take(LONGEST_QUOTE).collect();
    if quote.len() < text.len() {
        quote.push_str("...");
    }
    printable(&quote)
}

/// A value and where it stands.
#[derive(Debug, Clone)]
pub(super) struct At<'d> {
    pub(super) node: &'d Node,
    pub(super) place: String,
}

impl<'d> At<'d> {
    pub(super) fn new(node: &'d Node, place: impl Into<String>) -> Self {
        Self {
            node,
            place: place.into(),
        }
    }

    /// The member `name`, `None` when it is missing or this is no object.
    pub(super) fn get(&self, name: &str) -> Option<Self> {
        let node = self.node.get(name)?;
        let separator = if self.place.is_empty() { "" } else { "." };
        Some(Self::new(node, format!("{}{separator}{}", self.place, quote(name))))
    }

    /// The problem that this is no `wanted`.
    pub(super) fn is_no(&self, wanted: &str) -> Problem {
        let found = match self.node {
            Node::Number(value) => format!("= {}", Number(*value)),
            Node::Text(text) => format!("= \"{}\"", quote(text)),
            Node::Bool(value) => format!("= {value}"),
            other => format!("is {}, which", other.kind()),
        };
        Problem::new(&*self.place, format!("{found} is not allowed: it is {wanted}"))
    }

    pub(super) fn object(&self) -> Result<&'d [(String, Node)], Problem> {
        match self.node {
            Node::Object(members) => Ok(members),
            _ => Err(self.is_no("an object")),
        }
    }

    /// The elements of an array, each with its place.
    pub(super) fn elements(&self) -> Result<impl ExactSizeIterator<Item = Self> + use<'d>, Problem> {
        let Node::Array(elements) = self.node else {
            return Err(self.is_no("an array"));
        };
        let place = self.place.clone();
        let element = move |(index, node)| Self::new(node, format!("{place}[{index}]"));
        Ok(elements.iter().enumerate().map(element))
    }

    pub(super) fn text(&self) -> Result<&'d str, Problem> {
        match self.node {
            Node::Text(text) => Ok(text),
            _ => Err(self.is_no("a string")),
        }
    }

    /// A number within `legal`; a maximum of infinity is none.
    pub(super) fn number(&self, legal: Legal) -> Result<f64, Problem> {
        let Legal { name, min, max } = legal;
        let range = if max == f64::INFINITY {
            format!("{name} is at least {}", Number(min))
        } else {
            format!("{name} lies in [{}, {}]", Number(min), Number(max))
        };
        match self.node {
            Node::Number(value) if legal.check(*value).is_ok() => Ok(*value),
            Node::Number(value) => {
                let message = format!("= {} is not allowed: {range}", Number(*value));
                Err(Problem::new(&*self.place, message))
            }
            _ => Err(self.is_no(&format!("a number, and {range}"))),
        }
    }

    /// `N` numbers within `legal`.
    pub(super) fn numbers<const N: usize>(&self, legal: Legal) -> Result<[f64; N], Problem> {
        let elements = self
            .elements()
            .map_err(|_| self.is_no(&format!("an array of {N} numbers")))?;
        let count = elements.len();
        let mut numbers = [0.0; N];
        if count != N {
            return Err(Problem::new(
                &*self.place,
                format!("has {count} elements, which is not allowed: it is an array of {N} numbers"),
            ));
        }
        for (number, element) in numbers.iter_mut().zip(elements) {
            *number = element.number(legal)?;
        }
        Ok(numbers)
    }

    /// The place of an element in an array of `count`, which are called `what`.
    pub(super) fn index(&self, count: usize, what: &str) -> Result<usize, Problem> {
        let Node::Number(value) = self.node else {
            return Err(self.is_no(&format!("an index of {what}")));
        };
        if *value >= 0.0 && *value < count as f64 && value.fract() == 0.0 {
            return Ok(*value as usize);
        }
        let allowed = match count {
            0 => format!("the file has no {what}"),
            1 => format!("of {what} the file has one, with the index 0"),
            _ => format!("it is an index of {what}, 0 to {}", count - 1),
        };
        let message = format!("= {} is not allowed: {allowed}", Number(*value));
        Err(Problem::new(&*self.place, message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(value: f64, count: usize) -> Result<usize, String> {
        let at = At::new(&Node::Number(value), "m").index(count, "materials");
        at.map_err(|problem| format!("{} {}", problem.place, problem.message))
    }

    #[test]
    fn indices_are_whole_numbers_of_what_there_is() {
        assert_eq!(index(2.0, 3), Ok(2));
        assert_eq!(index(-0.0, 3), Ok(0));
        for value in [3.0, -1.0, 0.5, 1e300, 18446744073709551616.0] {
            let error = index(value, 3).unwrap_err();
            assert!(
                error.ends_with("is not allowed: it is an index of materials, 0 to 2"),
                "{error}"
            );
        }
        assert_eq!(
            index(0.0, 0).unwrap_err(),
            "m = 0 is not allowed: the file has no materials"
        );
    }

    #[test]
    fn ranges_are_stated_with_the_value() {
        let number = |value, max| {
            let at = At::new(&value, "a.b").number(Legal::new("b", 0.0, max));
            at.map_err(|problem| format!("{} {}", problem.place, problem.message))
        };
        assert_eq!(number(Node::Number(0.25), 1.0), Ok(0.25));
        assert_eq!(
            number(Node::Number(7.0), 1.0).unwrap_err(),
            "a.b = 7 is not allowed: b lies in [0, 1]"
        );
        assert_eq!(
            number(Node::Number(-1.0), f64::INFINITY).unwrap_err(),
            "a.b = -1 is not allowed: b is at least 0"
        );
        assert_eq!(
            number(Node::Null, 1.0).unwrap_err(),
            "a.b is null, which is not allowed: it is a number, and b lies in [0, 1]"
        );
    }

    #[test]
    fn notes_have_an_end() {
        let mut notes = Notes::default();
        (0..1000).for_each(|index| notes.add(&format!("a[{index}]"), "is odd"));
        let warnings = notes.into_warnings();
        assert_eq!(warnings.len(), MOST_NOTES + 1);
        assert_eq!(warnings[0], "a[0] is odd");
        assert_eq!(warnings[MOST_NOTES], "and 900 more of such places");
    }
}
