//! Rust: a module of its own, without dependencies.

use super::Parts;

pub(super) fn text(parts: &Parts) -> String {
    let (name, upper, channels) = (&parts.name, &parts.upper, parts.channels);
    let [width, height, depth] = parts.size;
    let values = parts.list("    ", &|numbers| format!("[{}]", numbers.join(", ")));
    let count = parts.texture.values.len() / channels;
    let mut lines = String::new();
    for axis in &parts.axes {
        let (letter, size, expression) = (axis.letter, axis.size, &axis.expression);
        lines += &format!(
            "    let p{letter} = position({expression}, {size}.0);\n    let {letter}0 = p{letter} as usize;\n    \
             let {letter}1 = ({letter}0 + 1).min({last});\n    let t{letter} = p{letter} - {letter}0 as f64;\n",
            last = size - 1,
        );
    }
    let mixed = parts.mixed("mix", &|indices| {
        format!("f64::from(TEXELS_{upper}[{}][c])", parts.index(indices))
    });
    let meanings: String = parts
        .channel_meanings()
        .iter()
        .map(|meaning| format!("// - {meaning}\n"))
        .collect();
    let facts = parts.comments("//");
    let arguments = parts.arguments("{}: f64");
    format!(
        "{facts}
pub const WIDTH_{upper}: usize = {width};
pub const HEIGHT_{upper}: usize = {height};
pub const DEPTH_{upper}: usize = {depth};

// texel (x, y, z) is [(z*HEIGHT + y)*WIDTH + x]
#[rustfmt::skip]
#[allow(clippy::all)]
pub static TEXELS_{upper}: [[f32; {channels}]; {count}] = [
{values}];

{meanings}#[rustfmt::skip]
#[allow(clippy::all, unused_parens, dead_code)]
pub fn lookup_{name}({arguments}) -> [f32; {channels}] {{
    fn sqrt(x: f64) -> f64 {{ x.sqrt() }}
    fn log(x: f64) -> f64 {{ x.ln() }}
    // texture coordinate u to a place among the centres of n texels, clamped to the edge; NaN becomes 0
    fn position(u: f64, n: f64) -> f64 {{
        let p = u*n - 0.5;
        if p > 0.0 {{ p.min(n - 1.0) }} else {{ 0.0 }}
    }}
    fn mix(a: f64, b: f64, t: f64) -> f64 {{ a*(1.0 - t) + b*t }}
{lines}    std::array::from_fn(|c| ({mixed}) as f32)
}}
"
    )
}
