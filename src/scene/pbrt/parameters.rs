//! Parameter lists: `"type name" value` or `"type name" [ values ]`, any number of them.

use super::tokens::{Lexer, Place, Token, What, quote};
use crate::scene::error::{SceneError, unusable};
use crate::scene::suggest::nearest;

/// Most values of a parameter that is read: spectra have some hundred.
const MOST_VALUES: usize = 1 << 16;

/// Types of parameters, as far as they differ here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Float,
    Bool,
    String,
    Texture,
    Rgb,
    Xyz,
    Spectrum,
    Blackbody,
    /// Integers, points, vectors and normals, which no material has.
    Other,
}

/// The types by their names in a declaration.
const KINDS: [(&str, Kind); 17] = [
    ("float", Kind::Float),
    ("integer", Kind::Other),
    ("bool", Kind::Bool),
    ("string", Kind::String),
    ("texture", Kind::Texture),
    ("rgb", Kind::Rgb),
    ("color", Kind::Rgb),
    ("xyz", Kind::Xyz),
    ("spectrum", Kind::Spectrum),
    ("blackbody", Kind::Blackbody),
    ("point", Kind::Other),
    ("point2", Kind::Other),
    ("point3", Kind::Other),
    ("vector", Kind::Other),
    ("vector2", Kind::Other),
    ("vector3", Kind::Other),
    ("normal", Kind::Other),
];

/// What one look-up of a name finds: one of a name and family replaces another, and others stand beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Float,
    Bool,
    String,
    Texture,
    Colour,
    Other,
}

impl Kind {
    pub(super) fn family(self) -> Family {
        match self {
            Self::Float => Family::Float,
            Self::Bool => Family::Bool,
            Self::String => Family::String,
            Self::Texture => Family::Texture,
            Self::Rgb | Self::Xyz | Self::Spectrum | Self::Blackbody => Family::Colour,
            Self::Other => Family::Other,
        }
    }
}

/// The values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    /// Finite numbers.
    Numbers(Vec<f64>),
    Strings(Vec<String>),
}

/// A parameter that is read.
#[derive(Debug, Clone)]
pub(super) struct Parameter {
    pub(super) kind: Kind,
    pub(super) name: &'static str,
    /// Its declaration as it is written, such as `rgb Kd`.
    pub(super) declared: String,
    pub(super) values: Values,
    /// Where the values stand.
    pub(super) place: Place,
}

/// The parameters of a statement that somebody may look up.
#[derive(Debug, Default)]
pub(super) struct Parameters(Vec<Parameter>);

/// A parameter whose name is none of those that are looked up.
#[derive(Debug)]
pub(super) struct Unknown {
    pub(super) name: String,
    pub(super) place: Place,
}

/// Unknown parameters that are told about, of each statement.
const MOST_UNKNOWN: usize = 8;

impl Parameters {
    pub(super) fn get(&self, name: &str, family: Family) -> Option<&Parameter> {
        let found = |parameter: &&Parameter| parameter.name == name && parameter.kind.family() == family;
        self.0.iter().find(found)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Parameter> {
        self.0.iter()
    }

    /// As pbrt has it, the last of several parameters with a name and a family counts.
    fn put(&mut self, parameter: Parameter) {
        let same = |old: &Parameter| old.name == parameter.name && old.kind.family() == parameter.kind.family();
        self.0.retain(|old| !same(old));
        self.0.push(parameter);
    }
}

impl Parameter {
    /// The error `roughness = 7 verdict`.
    pub(super) fn refuse(&self, verdict: impl std::fmt::Display) -> SceneError {
        let value = match &self.values {
            Values::Numbers(numbers) => match numbers.as_slice() {
                [one] => one.to_string(),
                many => format!("{many:?}"),
            },
            Values::Strings(strings) => match strings.as_slice() {
                [one] => format!("\"{one}\""),
                many => format!("{many:?}"),
            },
        };
        self.place
            .refuse(format!("{} = {} {verdict}", self.name, quote(&value)))
    }

    /// The error for data that cannot be used.
    pub(super) fn unusable(&self, error: &dyn std::fmt::Display) -> SceneError {
        self.refuse(unusable(error))
    }

    pub(super) fn numbers(&self) -> Result<&[f64], SceneError> {
        match &self.values {
            Values::Numbers(numbers) => Ok(numbers),
            Values::Strings(_) => Err(self.refuse(format!("is not allowed: a {} is made of numbers", self.declared))),
        }
    }

    /// The one string of the parameter.
    pub(super) fn string(&self) -> Result<&str, SceneError> {
        self.as_str()
            .ok_or_else(|| self.refuse(format!("is not allowed: {} is one string", self.declared)))
    }

    /// The same without an error, which would take the time to find its place in the file.
    pub(super) fn as_str(&self) -> Option<&str> {
        match &self.values {
            Values::Strings(strings) if strings.len() == 1 => Some(&strings[0]),
            _ => None,
        }
    }

    pub(super) fn flag(&self) -> Result<bool, SceneError> {
        match self.as_str() {
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            _ => Err(self.refuse(format!("is not allowed: {} is \"true\" or \"false\"", self.declared))),
        }
    }
}

/// Reads the parameters that follow in `lexer`: those with a name among `wanted`, and the first few others by name alone.
///
/// The values of others are passed over, whatever they are and however many.
pub(super) fn parameters(lexer: &mut Lexer, wanted: &[&'static str]) -> Result<(Parameters, Vec<Unknown>), SceneError> {
    let (mut known, mut unknown) = (Parameters::default(), Vec::new());
    while let Some(token) = lexer.peek()?.filter(|token| token.what == What::Quoted).cloned() {
        lexer.next()?;
        let declaration = lexer.string(&token)?.unwrap_or_default().into_owned();
        let mut words = declaration.split([' ', '\t']).filter(|word| !word.is_empty());
        let (Some(kind), Some(name)) = (words.next(), words.next()) else {
            let message = format!(
                "\"{}\" is not allowed: a parameter is declared by its type and its name, such as \"float roughness\"",
                quote(&declaration)
            );
            return Err(lexer.place(&token).refuse(message));
        };
        let Some(name) = wanted.iter().find(|wanted| **wanted == name) else {
            if unknown.len() < MOST_UNKNOWN {
                unknown.push(Unknown {
                    name: name.to_owned(),
                    place: lexer.place(&token),
                });
            }
            pass_over(lexer)?;
            continue;
        };
        let Some((_, found)) = KINDS.iter().find(|(word, _)| *word == kind) else {
            let names = KINDS.map(|(word, _)| word);
            let hint = nearest(kind, names).map_or(String::new(), |near| format!("; did you mean {near}?"));
            let message = format!(
                "type {} is not allowed: a parameter is of type {}{hint}",
                quote(kind),
                names.join(", ")
            );
            return Err(lexer.place(&token).refuse(message));
        };
        if *found == Kind::Other {
            pass_over(lexer)?;
            let place = lexer.place(&token);
            known.put(Parameter {
                kind: *found,
                name,
                declared: format!("{kind} {name}"),
                values: Values::Numbers(Vec::new()),
                place,
            });
            continue;
        }
        let (values, place) = values(lexer, *found)?;
        known.put(Parameter {
            kind: *found,
            name,
            declared: format!("{kind} {name}"),
            values,
            place,
        });
    }
    Ok((known, unknown))
}

const VALUE: &str = "a parameter has a value, or several in [ ]";

/// Passes over the value of a parameter.
pub(super) fn pass_over(lexer: &mut Lexer) -> Result<(), SceneError> {
    let first = lexer.required(VALUE)?;
    match first.what {
        What::Quoted => Ok(()),
        // a directive here would mean that the value was forgotten
        What::Word if is_value(lexer.written(&first)) => Ok(()),
        What::Open => loop {
            let token = lexer.required("an array ends with ]")?;
            match token.what {
                What::Close => return Ok(()),
                What::Open => return Err(nested(lexer, &token)),
                What::Word | What::Quoted => {}
            }
        },
        What::Word | What::Close => Err(no_value(lexer, &first)),
    }
}

fn is_value(word: &str) -> bool {
    matches!(word, "true" | "false") || word.parse::<f64>().is_ok()
}

fn no_value(lexer: &Lexer, token: &Token) -> SceneError {
    let found = quote(lexer.written(token));
    lexer.place(token).refuse(format!("{found} is no value: {VALUE}"))
}

fn nested(lexer: &Lexer, token: &Token) -> SceneError {
    lexer
        .place(token)
        .refuse("[ is not allowed within [ ]: arrays hold values")
}

fn values(lexer: &mut Lexer, kind: Kind) -> Result<(Values, Place), SceneError> {
    let first = lexer.required(VALUE)?;
    let place = lexer.place(&first);
    let mut values = match kind.family() {
        Family::Bool | Family::String | Family::Texture => Values::Strings(Vec::new()),
        _ => Values::Numbers(Vec::new()),
    };
    if first.what != What::Open {
        add(lexer, &first, kind, &mut values)?;
        return Ok((values, place));
    }
    loop {
        let token = lexer.required("an array ends with ]")?;
        if token.what == What::Close {
            return Ok((values, place.up_to(&token)));
        }
        add(lexer, &token, kind, &mut values)?;
    }
}

/// Adds the value at `token` to those of its parameter.
fn add(lexer: &Lexer, token: &Token, kind: Kind, values: &mut Values) -> Result<(), SceneError> {
    let refuse = |what: &str| {
        let found = quote(lexer.written(token));
        Err(lexer.place(token).refuse(format!("{found} is not allowed: {what}")))
    };
    let length = match values {
        Values::Numbers(numbers) => numbers.len(),
        Values::Strings(strings) => strings.len(),
    };
    if length == MOST_VALUES {
        return refuse(&format!("a parameter of a material has at most {MOST_VALUES} values"));
    }
    match (token.what, values) {
        (What::Open, _) => Err(nested(lexer, token)),
        (What::Close, _) => Err(no_value(lexer, token)),
        (What::Quoted, Values::Strings(strings)) => {
            strings.push(lexer.string(token)?.unwrap_or_default().into_owned());
            Ok(())
        }
        // file names of spectra
        (What::Quoted, values) if kind == Kind::Spectrum && length == 0 => {
            *values = Values::Strings(vec![lexer.string(token)?.unwrap_or_default().into_owned()]);
            Ok(())
        }
        (What::Quoted, Values::Numbers(_)) => refuse("this parameter is made of numbers"),
        // as the fourth version writes them
        (What::Word, Values::Strings(strings)) if kind == Kind::Bool => {
            strings.push(lexer.written(token).to_owned());
            Ok(())
        }
        (What::Word, Values::Strings(_)) => refuse("this parameter is made of strings, in quotes"),
        (What::Word, Values::Numbers(numbers)) => match lexer.written(token).parse::<f64>() {
            Ok(number) if number.is_finite() => {
                // -0 is 0
                numbers.push(number + 0.0);
                Ok(())
            }
            _ => refuse("a finite number belongs here"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::tokens::Source;
    use super::*;

    fn read(text: &str) -> Result<(Parameters, Vec<Unknown>), String> {
        let mut lexer = Lexer::new(Source::new("s", text, false));
        parameters(&mut lexer, &["Kd", "sigma", "type", "on"]).map_err(|error| error.to_string())
    }

    #[test]
    fn lists_hold_what_is_wanted() {
        let text = "\"rgb Kd\" [.1 2. -3e-1] \"float  sigma\" 7 \"point P\" [ nonsense # ]\n \"x\" ] \"bool on\" true\n\
                    \"string type\" [\"a\"] \"texture Kd\" \"t\" Shape";
        let (known, unknown) = read(text).unwrap();
        let rgb = known.get("Kd", Family::Colour).unwrap();
        assert_eq!(rgb.values, Values::Numbers(vec![0.1, 2.0, -0.3]));
        assert_eq!(
            (rgb.kind, rgb.declared.as_str(), rgb.place.line),
            (Kind::Rgb, "rgb Kd", 1)
        );
        assert_eq!(known.get("sigma", Family::Float).unwrap().numbers().unwrap(), [7.0]);
        assert!(known.get("on", Family::Bool).unwrap().flag().unwrap());
        assert_eq!(known.get("Kd", Family::Texture).unwrap().string().unwrap(), "t");
        assert_eq!(unknown.iter().map(|it| it.name.as_str()).collect::<Vec<_>>(), ["P"]);
    }

    #[test]
    fn the_last_of_a_name_and_family_counts() {
        let (known, _) = read("\"rgb Kd\" [1 1 1] \"float Kd\" 3 \"color Kd\" [0 0 0]").unwrap();
        assert_eq!(known.get("Kd", Family::Colour).unwrap().declared, "color Kd");
        assert_eq!(known.iter().count(), 2);
    }

    #[test]
    fn what_is_no_list_is_refused_at_its_place() {
        for (text, place, reason) in [
            ("\"Kd\" 1", "s:1:1", "declared by its type and its name"),
            ("\"\" 1", "s:1:1", "declared by its type and its name"),
            ("\"flaot sigma\" 1", "s:1:1", "did you mean float?"),
            (
                "\"float sigma\"",
                "s:1:14",
                "the file ends too early: a parameter has a value",
            ),
            ("\"float sigma\" [", "s:1:16", "an array ends with ]"),
            ("\"float sigma\" [1", "s:1:17", "an array ends with ]"),
            ("\"float sigma\" ]", "s:1:15", "] is no value"),
            ("\"float sigma\" [1 [2]]", "s:1:18", "[ is not allowed within [ ]"),
            (
                "\"float sigma\" nan",
                "s:1:15",
                "nan is not allowed: a finite number belongs here",
            ),
            (
                "\"float sigma\" [inf]",
                "s:1:16",
                "inf is not allowed: a finite number belongs here",
            ),
            (
                "\"float sigma\" 1e999",
                "s:1:15",
                "1e999 is not allowed: a finite number",
            ),
            ("\"float sigma\" \"a\"", "s:1:15", "made of numbers"),
            ("\"spectrum Kd\" [1 \"a\"]", "s:1:18", "made of numbers"),
            ("\"texture Kd\" 1", "s:1:14", "made of strings"),
            ("\"point P\" Shape \"a\"", "s:1:11", "Shape is no value"),
            ("\"point P\" [[", "s:1:12", "[ is not allowed within [ ]"),
            ("\"point P\" [1 2", "s:1:15", "an array ends with ]"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(place) && error.contains(reason), "{text}: {error}");
        }
        let long = format!("\"spectrum Kd\" [{}]", "1 ".repeat(MOST_VALUES + 1));
        assert!(read(&long).unwrap_err().contains("at most 65536 values"));
    }
}
