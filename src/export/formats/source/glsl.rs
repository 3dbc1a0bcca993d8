//! GLSL from 3.30 and ES 3.00 on.

use super::Parts;

pub(super) fn text(parts: &Parts) -> String {
    let (name, upper) = (&parts.name, &parts.upper);
    let [width, height, depth] = parts.size;
    let kind = ["float", "vec2", "vec3", "vec4"][parts.channels - 1];
    let values = parts.list("    ", &|numbers| match numbers {
        [number] => number.clone(),
        numbers => format!("{kind}({})", numbers.join(", ")),
    });
    let count = parts.texture.values.len() / parts.channels;
    let mut lines = String::new();
    for axis in &parts.axes {
        let (letter, size, expression) = (axis.letter, axis.size, &axis.expression);
        lines += &format!(
            "    float p{letter} = clamp(({expression})*{size}.0 - 0.5, 0.0, {last}.0);\n    int {letter}0 = int(p{letter});\n    \
             int {letter}1 = min({letter}0 + 1, {last});\n    float t{letter} = p{letter} - float({letter}0);\n",
            last = size - 1,
        );
    }
    let mixed = parts.mixed("mix", &|indices| format!("TEXELS_{upper}[{}]", parts.index(indices)));
    let meanings: String = parts
        .channel_meanings()
        .iter()
        .zip(["x", "y", "z", "w"])
        .map(|(meaning, part)| format!("// {part} is {meaning}\n"))
        .collect();
    let facts = parts.comments("//");
    let arguments = parts.arguments("float {}");
    format!(
        "{facts}
const int WIDTH_{upper} = {width};
const int HEIGHT_{upper} = {height};
const int DEPTH_{upper} = {depth};

// texel (x, y, z) is [(z*HEIGHT + y)*WIDTH + x]
const {kind} TEXELS_{upper}[{count}] = {kind}[{count}](
{values});

// linear between the centres of texels, clamped to the edge
{meanings}{kind} lookup_{name}({arguments}) {{
{lines}    return {mixed};
}}
"
    )
}
