//! The directives of pbrt 3, and what follows each.

use super::parameters::{parameters, pass_over};
use super::tokens::{Lexer, Token, What, quote};
use crate::scene::error::SceneError;
use crate::scene::suggest::nearest;

/// What a directive asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Directive {
    AttributeBegin,
    AttributeEnd,
    Include,
    MakeNamedMaterial,
    Material,
    NamedMaterial,
    ObjectBegin,
    ObjectEnd,
    ObjectInstance,
    Shape,
    Texture,
    WorldBegin,
    WorldEnd,
    /// Nothing that a material depends on.
    Skipped(Arguments),
}

/// What follows a directive that is passed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arguments {
    /// So many numbers.
    Numbers(usize),
    /// Sixteen numbers in brackets.
    Matrix,
    /// A word.
    Word,
    /// A string.
    String,
    /// One string, or two.
    Strings,
    /// A string and parameters.
    Parameters,
}

/// Every directive, in the order of the alphabet.
const DIRECTIVES: [(&str, Directive); 37] = {
    use Arguments::{Matrix, Numbers, Parameters, String, Strings, Word};
    use Directive::*;
    [
        ("Accelerator", Skipped(Parameters)),
        ("ActiveTransform", Skipped(Word)),
        ("AreaLightSource", Skipped(Parameters)),
        ("AttributeBegin", AttributeBegin),
        ("AttributeEnd", AttributeEnd),
        ("Camera", Skipped(Parameters)),
        ("ConcatTransform", Skipped(Matrix)),
        ("CoordSysTransform", Skipped(String)),
        ("CoordinateSystem", Skipped(String)),
        ("Film", Skipped(Parameters)),
        ("Identity", Skipped(Numbers(0))),
        ("Include", Include),
        ("Integrator", Skipped(Parameters)),
        ("LightSource", Skipped(Parameters)),
        ("LookAt", Skipped(Numbers(9))),
        ("MakeNamedMaterial", MakeNamedMaterial),
        ("MakeNamedMedium", Skipped(Parameters)),
        ("Material", Material),
        ("MediumInterface", Skipped(Strings)),
        ("NamedMaterial", NamedMaterial),
        ("ObjectBegin", ObjectBegin),
        ("ObjectEnd", ObjectEnd),
        ("ObjectInstance", ObjectInstance),
        ("PixelFilter", Skipped(Parameters)),
        ("ReverseOrientation", Skipped(Numbers(0))),
        ("Rotate", Skipped(Numbers(4))),
        ("Sampler", Skipped(Parameters)),
        ("Scale", Skipped(Numbers(3))),
        ("Shape", Shape),
        ("Texture", Texture),
        ("Transform", Skipped(Matrix)),
        ("TransformBegin", Skipped(Numbers(0))),
        ("TransformEnd", Skipped(Numbers(0))),
        ("TransformTimes", Skipped(Numbers(2))),
        ("Translate", Skipped(Numbers(3))),
        ("WorldBegin", WorldBegin),
        ("WorldEnd", WorldEnd),
    ]
};

/// The directive that `token` is.
pub(super) fn directive(lexer: &Lexer, token: &Token) -> Result<Directive, SceneError> {
    let word = lexer.written(token);
    if let Some((_, directive)) = DIRECTIVES.iter().find(|(name, _)| *name == word) {
        return Ok(*directive);
    }
    let names = DIRECTIVES.map(|(name, _)| name);
    let found = quote(word);
    let message = match token.what {
        What::Word => {
            let hint = nearest(word, names).map_or(String::new(), |near| format!("; did you mean {near}?"));
            format!("unknown directive {found}: pbrt 3 has {}{hint}", names.join(", "))
        }
        _ => format!("{found} is not allowed here: a directive such as Material or Shape begins a statement"),
    };
    Err(lexer.place(token).refuse(message))
}

/// The string that has to follow, and where; `rule` says what it is.
pub(super) fn string(lexer: &mut Lexer, rule: &str) -> Result<(String, Token), SceneError> {
    let token = lexer.required(rule)?;
    match lexer.string(&token)? {
        Some(string) => Ok((string.into_owned(), token)),
        None => {
            let found = quote(lexer.written(&token));
            Err(lexer
                .place(&token)
                .refuse(format!("{found} is not allowed here: {rule}")))
        }
    }
}

/// Passes over what follows a directive.
pub(super) fn skip(lexer: &mut Lexer, arguments: Arguments) -> Result<(), SceneError> {
    match arguments {
        Arguments::Numbers(count) => numbers(lexer, count),
        Arguments::Matrix => {
            let first = lexer.peek()?.cloned();
            if first.as_ref().is_some_and(|token| token.what == What::Open) {
                return pass_over(lexer);
            }
            let token = lexer.required(MATRIX)?;
            let found = quote(lexer.written(&token));
            Err(lexer
                .place(&token)
                .refuse(format!("{found} is not allowed here: {MATRIX}")))
        }
        Arguments::Word => {
            let token = lexer.required("ActiveTransform is All, StartTime or EndTime")?;
            match lexer.written(&token) {
                "All" | "StartTime" | "EndTime" => Ok(()),
                other => {
                    let message = format!(
                        "{} is not allowed here: ActiveTransform is All, StartTime or EndTime",
                        quote(other)
                    );
                    Err(lexer.place(&token).refuse(message))
                }
            }
        }
        Arguments::String => string(lexer, "a name in quotes follows").map(drop),
        Arguments::Strings => {
            string(lexer, "the name of a medium in quotes follows")?;
            if lexer.peek()?.is_some_and(|token| token.what == What::Quoted) {
                lexer.next()?;
            }
            Ok(())
        }
        Arguments::Parameters => {
            string(lexer, "a type in quotes follows, and parameters")?;
            parameters(lexer, &[]).map(drop)
        }
    }
}

const MATRIX: &str = "sixteen numbers in [ ] follow";

fn numbers(lexer: &mut Lexer, count: usize) -> Result<(), SceneError> {
    let rule = format!("{count} numbers follow this directive");
    for _ in 0..count {
        let token = lexer.required(&rule)?;
        if token.what != What::Word || lexer.written(&token).parse::<f64>().is_err() {
            let found = quote(lexer.written(&token));
            return Err(lexer
                .place(&token)
                .refuse(format!("{found} is not allowed here: {rule}")));
        }
    }
    Ok(())
}
