//! The function that looks a texture up.

use crate::printable::printable;
use crate::table::axis::Axis;
use crate::table::texture::{Channel, Texture, TextureAxis};
use std::collections::BTreeSet;

/// What a shader has to know of a texture.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureLayout {
    /// Its id, of which the names in the shader are made.
    pub id: String,
    /// The file that holds it, for the comment above its function.
    pub file: String,
    /// None to three axes, along width, height and depth; a texture without axes has a single texel.
    pub axes: Vec<TextureAxis>,
    /// One to four channels.
    pub channels: Vec<Channel>,
}

/// A texture in a shader.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampler {
    /// Name of the texture, `table_` and the name of the table; its sampler is called the same with `_sampler`.
    pub texture: String,
    /// Name of the function, `sample_` and the name of the table.
    pub function: String,
    /// Arguments of the function in their order, one per axis, named as the parameters.
    pub arguments: Vec<String>,
    /// Which of the textures it is, from 0.
    pub index: usize,
    /// The declarations and the function, in WGSL.
    pub wgsl: String,
}

impl TextureLayout {
    /// The layout of `texture`, which the file `file` holds.
    pub fn of(texture: &Texture, file: impl Into<String>) -> Self {
        Self {
            id: texture.id.clone(),
            file: file.into(),
            axes: texture.axes.clone(),
            channels: texture.channels.clone(),
        }
    }
}

/// A name that every language takes, from free text: lower-case ASCII letters, digits and single underscores. It is meant to follow
/// a prefix: it may begin with a digit.
pub fn identifier(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        let c = if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        };
        if c != '_' || !(name.is_empty() || name.ends_with('_')) {
            name.push(c);
        }
    }
    let name = name.trim_end_matches('_');
    // names much longer are none for people, and compilers may have limits
    let name = name[..name.len().min(100)].trim_end_matches('_');
    if name.is_empty() { "unnamed".into() } else { name.into() }
}

/// [`identifier`] of each, all different: those that came before keep their names, the others are numbered.
pub fn identifiers<'a>(texts: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let unique = |text: &str| {
        let first = identifier(text);
        let numbered = (2..).map(|number| format!("{first}_{number}"));
        let mut names = std::iter::once(first.clone()).chain(numbered);
        names.find(|name| taken.insert(name.clone())).unwrap_or_default()
    };
    texts.into_iter().map(unique).collect()
}

/// The texture `layout` as number `index` of a shader, under the `name` that [`identifiers`] gave it.
///
/// The function takes one argument per axis in the unit of the axis, clamps it to its range, and returns what linear filtering between
/// texel centres, clamped to the edge, reads from level 0: `f32`, `vec2f`, `vec3f` or `vec4f`, by the number of channels. The
/// texture is at binding 2 index, its sampler at the next one, of group 0.
pub fn sampler_of(layout: &TextureLayout, name: &str, index: usize) -> Sampler {
    let (texture, function) = (format!("table_{name}"), format!("sample_{name}"));
    let arguments: Vec<String> = layout.axes.iter().map(|axis| axis.axis.parameter.clone()).collect();
    let signature: Vec<String> = arguments.iter().map(|name| format!("{name}: f32")).collect();
    let mut body = String::new();
    let mut at = Vec::new();
    for (axis, coordinate) in layout.axes.iter().zip(["u", "v", "w"]) {
        body += &format!("    let {coordinate}_at = {};\n", clamped(axis).shader_expression());
        at.push(format!("{coordinate}_at"));
    }
    at.resize(at.len().max(2), "0.5".into());
    let dimensions = at.len();
    let (kind, swizzle) = match layout.channels.len() {
        1 => ("f32", "r"),
        2 => ("vec2f", "rg"),
        3 => ("vec3f", "rgb"),
        _ => ("vec4f", "rgba"),
    };
    let (texture_binding, sampler_binding) = (2 * index, 2 * index + 1);
    let mut comment = format!("// {}, {}:\n", printable(&layout.id), printable(&layout.file));
    for (channel, letter) in layout.channels.iter().zip(["r", "g", "b", "a"]) {
        let (name, meaning) = (printable(&channel.name), printable(&channel.meaning));
        comment += &format!("// {letter} = {name}: {meaning}\n");
    }
    for TextureAxis { axis, .. } in &layout.axes {
        comment += &format!(
            "// {} in [{:?}, {:?}]{}\n",
            axis.parameter,
            axis.min,
            axis.max,
            meaning(axis)
        );
    }
    let wgsl = format!(
        "@group(0) @binding({texture_binding}) var {texture}: texture_{dimensions}d<f32>;\n\
         @group(0) @binding({sampler_binding}) var {texture}_sampler: sampler;\n\n\
         {comment}fn {function}({}) -> {kind} {{\n{body}    let at = vec{dimensions}f({});\n    \
         return textureSampleLevel({texture}, {texture}_sampler, at, 0.0).{swizzle};\n}}\n",
        signature.join(", "),
        at.join(", ")
    );
    Sampler {
        texture,
        function,
        arguments,
        index,
        wgsl,
    }
}

/// The axis over its parameter held within its range: roots and logarithms of what lies outside are no numbers, which the edge of a
/// texture would not mend.
fn clamped(axis: &TextureAxis) -> TextureAxis {
    let Axis {
        parameter, min, max, ..
    } = &axis.axis;
    TextureAxis {
        axis: Axis {
            parameter: format!("clamp({parameter}, {min:?}, {max:?})"),
            ..axis.axis.clone()
        },
        flipped: axis.flipped,
    }
}

/// What the parameters of tables mean, after their range.
fn meaning(axis: &Axis) -> &'static str {
    match axis.parameter.as_str() {
        "mu" => ", the cosine of the angle between the direction and the normal",
        "phi" => ", in radians: atan(abs(w.y), abs(w.x)) in the tangent frame",
        "alpha" => ", the width of the slopes, a tangent: the square of what engines call perceptual roughness",
        "m" => ", the root-mean-square slope, a tangent",
        "kappa" => ", the concentration of the von Mises-Fisher distribution",
        "n" => ", the exponent of the Phong distribution",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_safe_and_different() {
        assert_eq!(identifier("ggx-smith.split-sum.rho_hd"), "ggx_smith_split_sum_rho_hd");
        assert_eq!(identifier("__Größe 17; discard"), "gr_e_17_discard");
        assert_eq!(identifier("金"), "unnamed");
        assert_eq!(
            identifiers(["gold", "Gold", "gold_2", "gold!"]),
            ["gold", "gold_2", "gold_2_2", "gold_3"]
        );
        assert!(identifier(&"x".repeat(1000)).len() <= 100);
    }
}
