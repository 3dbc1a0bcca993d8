//! C99 that is C++ too: a header with a static array of floats.

use super::Parts;

pub(super) fn text(parts: &Parts) -> String {
    let (name, upper, channels) = (&parts.name, &parts.upper, parts.channels);
    let [width, height, depth] = parts.size;
    let values = parts.list("    ", &|numbers| {
        let floats: Vec<String> = numbers.iter().map(|number| format!("{number}f")).collect();
        floats.join(", ")
    });
    let count = parts.texture.values.len();
    let mut lines = String::new();
    for axis in &parts.axes {
        let (letter, size, expression) = (axis.letter, axis.size, &axis.expression);
        lines += &format!(
            "    double p{letter} = furnace_position_{name}({expression}, {size});\n    int {letter}0 = (int)p{letter};\n    \
             int {letter}1 = {letter}0 + 1 < {size} ? {letter}0 + 1 : {letter}0;\n    double t{letter} = p{letter} - {letter}0;\n"
        );
    }
    let mixed = parts.mixed(&format!("furnace_mix_{name}"), &|indices| {
        format!("TEXELS_{upper}[({})*{channels} + c]", parts.index(indices))
    });
    let meanings: String = parts
        .channel_meanings()
        .iter()
        .enumerate()
        .map(|(c, meaning)| format!("// result[{c}] {meaning}\n"))
        .collect();
    let facts = parts.comments("//");
    let arguments = parts.arguments("double {}");
    format!(
        "{facts}
#ifndef FURNACE_{upper}_H
#define FURNACE_{upper}_H

#include <math.h>

#define WIDTH_{upper} {width}
#define HEIGHT_{upper} {height}
#define DEPTH_{upper} {depth}
#define CHANNELS_{upper} {channels}

// channel c of texel (x, y, z) is [((z*HEIGHT + y)*WIDTH + x)*CHANNELS + c]
static const float TEXELS_{upper}[{count}] = {{
{values}}};

// texture coordinate u to a place among the centres of n texels, clamped to the edge; NaN becomes 0
static inline double furnace_position_{name}(double u, int n) {{
    double p = u*n - 0.5;
    return p > 0.0 ? (p < n - 1.0 ? p : n - 1.0) : 0.0;
}}

static inline double furnace_mix_{name}(double a, double b, double t) {{
    return a*(1.0 - t) + b*t;
}}

{meanings}static inline void lookup_{name}({arguments}, float result[{channels}]) {{
{lines}    for (int c = 0; c < {channels}; c++) {{
        result[c] = (float)({mixed});
    }}
}}

#endif
"
    )
}
