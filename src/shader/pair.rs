//! What the channels of an engine's table mean, as functions, so that nobody has to remember it.

use super::sampler::{Sampler, TextureLayout};

/// `total_TABLE`, E for r0 = 1, and `albedo_TABLE`, that of any r0, of a texture whose channels are called scale, bias, total and loss;
/// nothing of others.
pub(super) fn functions(layout: &TextureLayout, sampler: &Sampler) -> String {
    let names: Vec<&str> = layout.channels.iter().map(|channel| channel.name.as_str()).collect();
    let channel = |name: &str| {
        let k = names.iter().position(|other| *other == name)?;
        // a function of one channel returns a number
        Some(match names.len() {
            1 => "read".to_owned(),
            _ => format!("read.{}", ["x", "y", "z", "w"][k.min(3)]),
        })
    };
    let (bias, scale) = (channel("bias"), channel("scale"));
    let sum = scale.zip(bias.clone()).map(|(scale, bias)| format!("{scale} + {bias}"));
    let Some(total) = channel("total")
        .or(channel("loss").map(|loss| format!("1.0 - {loss}")))
        .or(sum)
    else {
        return String::new();
    };
    let table = sampler.function.trim_start_matches("sample_");
    let typed: Vec<String> = sampler
        .arguments
        .iter()
        .map(|argument| format!("{argument}: f32"))
        .collect();
    let (typed, call) = (typed.join(", "), sampler.arguments.join(", "));
    let mut text = format!(
        "\n// E, the albedo with F = 1, from what {table} holds.\nfn total_{table}({typed}) -> f32 {{\n    \
         let read = sample_{table}({call});\n    return {total};\n}}\n"
    );
    if let Some(bias) = bias {
        text += &format!(
            "\n// The albedo for any r0 of Schlick's Fresnel term, from what {table} holds.\nfn albedo_{table}({typed}, r0: vec3f) -> vec3f \
             {{\n    let read = sample_{table}({call});\n    return vec3f({bias}) + r0 * (({total}) - {bias});\n}}\n"
        );
    }
    text
}
