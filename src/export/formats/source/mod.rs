//! A table as source text: an array, and a function that looks it up as a texture unit would, without a sampler.
//!
//! All languages get the same arithmetic from the same few lines here: texture coordinates by the expressions of the axes, the two
//! texels around them along each axis, clamped to the edge, and a mix of two values per axis. C and Rust do it in double
//! precision, shaders in that of their floats, which costs n 1e-7 of the step between two of n texels. NaN reads a texel at the
//! edge. Numbers are the shortest that give back the same f32.

mod c;
mod glsl;
mod hlsl;
mod names;
mod rust;
mod wgsl;

use super::texels::PLAIN;
use super::{Language, MAX_SOURCE_VALUES, facts};
use crate::printable::is_hidden;
use crate::table::texture::Texture;
pub use names::identifier;
use names::parameter_names;

/// The letters of the axes.
const LETTERS: [char; 3] = ['x', 'y', 'z'];

/// The text of `texture` in `language`.
pub(super) fn encode(texture: &Texture, language: Language) -> Result<Vec<u8>, String> {
    if texture.values.len() > MAX_SOURCE_VALUES {
        return Err(format!(
            "{} numbers are too many for source text, at most {MAX_SOURCE_VALUES}: choose ktx2, dds or raw",
            texture.values.len()
        ));
    }
    let parts = Parts::new(texture);
    let text = match language {
        Language::C => c::text(&parts),
        Language::Rust => rust::text(&parts),
        Language::Glsl => glsl::text(&parts),
        Language::Hlsl => hlsl::text(&parts),
        Language::Wgsl => wgsl::text(&parts)?,
    };
    Ok(text.into_bytes())
}

/// What all languages are written from.
struct Parts<'a> {
    texture: &'a Texture,
    /// The id as part of an identifier.
    name: String,
    /// The same in capitals.
    upper: String,
    size: [usize; 3],
    axes: Vec<SourceAxis>,
    channels: usize,
}

/// An axis as the text speaks of it.
struct SourceAxis {
    /// The argument.
    parameter: String,
    /// The texture coordinate in terms of the argument.
    expression: String,
    /// `x`, `y` or `z`.
    letter: char,
    size: usize,
}

impl<'a> Parts<'a> {
    fn new(texture: &'a Texture) -> Self {
        let name = identifier(&texture.id);
        let named = texture.axes.iter().zip(parameter_names(&texture.axes)).zip(LETTERS);
        let axes = named.map(|((axis, parameter), letter)| {
            let mut renamed = axis.clone();
            renamed.axis.parameter.clone_from(&parameter);
            SourceAxis {
                expression: renamed.shader_expression(),
                parameter,
                letter,
                size: axis.axis.size,
            }
        });
        Self {
            texture,
            upper: name.to_ascii_uppercase(),
            name,
            size: texture.size(),
            axes: axes.collect(),
            channels: texture.channels.len(),
        }
    }

    /// All facts as comments, one line each, after `mark`.
    fn comments(&self, mark: &str) -> String {
        let facts = facts::list(self.texture, PLAIN);
        let lines = facts.iter().map(|(name, value)| {
            let line = format!("{mark} {name}: {}", one_line(value));
            line.trim_end().to_owned() + "\n"
        });
        lines.collect()
    }

    /// The arguments of the lookup: `double mu, double kappa` for `double {}`.
    fn arguments(&self, pattern: &str) -> String {
        let arguments = self.axes.iter().map(|axis| pattern.replace("{}", &axis.parameter));
        arguments.collect::<Vec<_>>().join(", ")
    }

    /// The mix of texels around the position: `x0`, `x1` and `tx` of each axis, through the function `mix`, of what `texel` says of
    /// three indices.
    fn mixed(&self, mix: &str, texel: &dyn Fn(&[String]) -> String) -> String {
        self.mixed_along(self.axes.len(), Vec::new(), mix, texel)
    }

    fn mixed_along(&self, axes: usize, fixed: Vec<String>, mix: &str, texel: &dyn Fn(&[String]) -> String) -> String {
        let Some(axis) = axes.checked_sub(1) else {
            return texel(&fixed);
        };
        let letter = LETTERS[axis];
        let end = |end: char| {
            let mut fixed = fixed.clone();
            fixed.insert(0, format!("{letter}{end}"));
            self.mixed_along(axis, fixed, mix, texel)
        };
        format!("{mix}({}, {}, t{letter})", end('0'), end('1'))
    }

    /// The index of a texel in an array of texels, of as many indices as there are axes.
    fn index(&self, indices: &[String]) -> String {
        let [width, height, _] = self.size;
        match indices {
            [x, y, z] => format!("({z}*{height} + {y})*{width} + {x}"),
            [x, y] => format!("{y}*{width} + {x}"),
            [x] => x.clone(),
            _ => String::new(),
        }
    }

    /// The texels, each as `texel` writes its channels, a few on each line, separated by commas.
    fn list(&self, indent: &str, texel: &dyn Fn(&[String]) -> String) -> String {
        let texels = self.texture.values.chunks(self.channels);
        let written: Vec<String> = texels.map(|values| texel(&numbers(values))).collect();
        lines(indent, &written)
    }

    /// Name and meaning of each channel, as `red: rho_hd, linear red`.
    fn channel_meanings(&self) -> Vec<String> {
        let channels = self.texture.channels.iter();
        channels
            .map(|channel| one_line(&format!("{}: {}", channel.name, channel.meaning)))
            .collect()
    }
}

/// A value as the shortest text that gives the same f32 again, with a point or an exponent.
fn numbers(values: &[f64]) -> Vec<String> {
    values.iter().map(|value| format!("{:?}", *value as f32)).collect()
}

/// Items separated by commas, on lines of moderate length.
fn lines(indent: &str, items: &[String]) -> String {
    let mut text = String::new();
    let mut line = String::from(indent);
    for (index, item) in items.iter().enumerate() {
        let comma = if index + 1 == items.len() { "" } else { "," };
        if line.len() + item.len() > 116 && line.len() > indent.len() {
            text += line.trim_end();
            text.push('\n');
            line = String::from(indent);
        }
        line += &format!("{item}{comma} ");
    }
    text + line.trim_end() + "\n"
}

/// `text` so that no comment ends within it and none goes on behind it.
fn one_line(text: &str) -> String {
    // a backslash at the end joins lines in C, and "??/" once was one
    if text.chars().any(is_hidden) || text.ends_with(['\\', '/']) {
        format!("{text:?}")
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn comments_cannot_be_left() {
        assert_eq!(one_line("mu in [0, 1]"), "mu in [0, 1]");
        for text in [
            "a\nint main() {}",
            "a\r#error",
            "a\u{2028}b",
            "a\u{85}b",
            "joined \\",
            "joined ??/",
            "\u{202e}a",
        ] {
            let line = one_line(text);
            assert!(line.starts_with('"') && line.ends_with('"'), "{line}");
            assert!(!line.chars().any(crate::printable::is_hidden), "{line}");
        }
    }
}
