//! WGSL. An array constructor takes 2047 elements in every implementation and no more in some, so that there is one per row.

use super::{Parts, lines, numbers};

/// Most elements of an array constructor [WGSL, limits].
const MOST_ELEMENTS: usize = 2047;

pub(super) fn text(parts: &Parts) -> Result<String, String> {
    let (name, upper) = (&parts.name, &parts.upper);
    let [width, height, depth] = parts.size;
    let rows = height * depth;
    if width.max(rows) > MOST_ELEMENTS {
        return Err(format!(
            "{width} texels in {rows} rows are too many: an array constructor takes {MOST_ELEMENTS} elements; choose ktx2 or raw"
        ));
    }
    let kind = ["f32", "vec2<f32>", "vec3<f32>", "vec4<f32>"][parts.channels - 1];
    let texel = |values: &[f64]| match &numbers(values)[..] {
        [number] => number.clone(),
        numbers => format!("{kind}({})", numbers.join(", ")),
    };
    let row = format!("array<{kind}, {width}>");
    let mut values = String::new();
    for texels in parts.texture.values.chunks(width * parts.channels) {
        let texels: Vec<String> = texels.chunks(parts.channels).map(texel).collect();
        values += &format!("    {row}(\n{}    ),\n", lines("        ", &texels));
    }
    let mut steps = String::new();
    for axis in &parts.axes {
        let (letter, size, expression) = (axis.letter, axis.size, &axis.expression);
        steps += &format!(
            "    let p{letter} = clamp(({expression})*{size}.0 - 0.5, 0.0, {last}.0);\n    let {letter}0 = i32(p{letter});\n    \
             let {letter}1 = min({letter}0 + 1, {last});\n    let t{letter} = p{letter} - f32({letter}0);\n",
            last = size - 1,
        );
    }
    let mixed = parts.mixed("mix", &|indices| match indices {
        [x, y, z] => format!("TEXELS_{upper}[{z}*{height} + {y}][{x}]"),
        [x, y] => format!("TEXELS_{upper}[{y}][{x}]"),
        indices => format!("TEXELS_{upper}[0][{}]", indices.concat()),
    });
    let meanings: String = parts
        .channel_meanings()
        .iter()
        .zip(["x", "y", "z", "w"])
        .map(|(meaning, part)| format!("// {part} is {meaning}\n"))
        .collect();
    let facts = parts.comments("//");
    let arguments = parts.arguments("{}: f32");
    Ok(format!(
        "{facts}
const WIDTH_{upper}: i32 = {width};
const HEIGHT_{upper}: i32 = {height};
const DEPTH_{upper}: i32 = {depth};

// texel (x, y, z) is [z*HEIGHT + y][x]
const TEXELS_{upper} = array<{row}, {rows}>(
{values});

// linear between the centres of texels, clamped to the edge
{meanings}fn lookup_{name}({arguments}) -> {kind} {{
{steps}    return {mixed};
}}
"
    ))
}
