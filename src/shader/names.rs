//! Translated text as a person would have written it: names without counters, comments, textures by their names, and nothing of
//! the program around it.

use super::Language;
use naga::{AddressSpace, Module, TypeInner};
use std::collections::{BTreeMap, BTreeSet};

/// `text`, which naga wrote of `module` in `language`, with the comments of its source `wgsl`.
pub(super) fn readable(text: &str, wgsl: &str, module: &Module, language: Language) -> String {
    let text = match language {
        Language::GlslEs | Language::Glsl => glsl_parts(text, module, language),
        Language::Hlsl => hlsl_parts(text),
        Language::Msl => msl_parts(text),
        Language::Wgsl => text.to_owned(),
    };
    let text = without_counters(&text, &global_names(module));
    with_comments(&text, wgsl)
}

/// Version, precision and the entry point go; textures are called as in the source, and take the numbers of their order.
fn glsl_parts(text: &str, module: &Module, language: Language) -> String {
    let text = text.find("\nvoid main()").map_or(text, |end| &text[..end]);
    let mut text: String = text
        .lines()
        .filter(|line| !line.starts_with("#version") && !line.starts_with("precision "))
        .flat_map(|line| [line, "\n"])
        .collect();
    let mut order = 0;
    for (_, global) in module.global_variables.iter() {
        let is_texture = matches!(module.types[global.ty].inner, TypeInner::Image { .. });
        if let (Some(name), Some(binding), AddressSpace::Handle, true) =
            (&global.name, &global.binding, global.space, is_texture)
        {
            let (group, binding) = (binding.group, binding.binding);
            text = text.replace(&format!("_group_{group}_binding_{binding}_fs"), name);
            if language == Language::Glsl {
                let declaration = format!(" {name};");
                let numbered =
                    text.lines().map(
                        |line| match line.starts_with("uniform ") && line.ends_with(&declaration) {
                            true => format!("layout(binding = {order}) {line}\n"),
                            false => format!("{line}\n"),
                        },
                    );
                text = numbered.collect();
            }
            order += 1;
        }
    }
    text
}

/// naga keeps samplers in one heap, an index for each in a buffer; here each has a register, as its texture. Padding of structs,
/// which only buffers need, goes.
fn hlsl_parts(text: &str) -> String {
    let (mut textures, mut samplers) = (0, 0);
    let mut lines = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_padding = matches!(words[..], ["int", name] if name.starts_with("_pad") || name.starts_with("_end_pad"));
        if let ["static", "const", "SamplerState", name, "=", ..] = words[..] {
            lines.push(format!("SamplerState {name} : register(s{samplers});"));
            samplers += 1;
        } else if let [kind @ ("Texture2D<float4>" | "Texture3D<float4>"), name, ":", _] = words[..] {
            lines.push(format!("{kind} {name} : register(t{textures});"));
            textures += 1;
        } else if !line.contains("nagaSamplerHeap")
            && !line.contains("nagaComparisonSamplerHeap")
            && !line.contains("nagaGroup")
            && !is_padding
        {
            lines.push(line.to_owned());
        }
    }
    lines.join("\n") + "\n"
}

/// The version and a header that nothing here needs.
fn msl_parts(text: &str) -> String {
    let kept = text
        .lines()
        .filter(|line| !line.starts_with("// language") && *line != "#include <simd/simd.h>");
    kept.flat_map(|line| [line, "\n"]).collect()
}

/// Names that mean the same in every function.
fn global_names(module: &Module) -> BTreeSet<String> {
    let functions = module.functions.iter().map(|(_, function)| &function.name);
    let variables = module.global_variables.iter().map(|(_, variable)| &variable.name);
    let constants = module.constants.iter().map(|(_, constant)| &constant.name);
    let types = module.types.iter().map(|(_, kind)| &kind.name);
    let all = functions.chain(variables).chain(constants).chain(types);
    all.flatten().cloned().collect()
}

/// Identifiers and what stands between them, in order.
pub(super) fn tokens(text: &str) -> Vec<&str> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let inside = is_word(first);
        let end = rest.find(|c| is_word(c) != inside).unwrap_or(rest.len());
        let (token, after) = rest.split_at(end);
        tokens.push(token);
        rest = after;
    }
    tokens
}

/// What naga made a name from: it appends `_` to names that end in a digit or are reserved, and `_` with a number to those that it
/// has met before, in whichever function.
fn stem(token: &str) -> Option<&str> {
    if !token.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return None;
    }
    if let Some(name) = token.strip_suffix('_') {
        return name.ends_with(|c: char| c.is_ascii_digit()).then_some(name);
    }
    let name = token.trim_end_matches(|c: char| c.is_ascii_digit());
    let is_counted = name.len() < token.len() && name.ends_with('_');
    is_counted.then(|| name.trim_end_matches('_'))
}

/// Each function has names of its own, so that counters go wherever that leaves them different; names that mean the same
/// everywhere, and reserved words, are never arrived at by it.
fn without_counters(text: &str, globals: &BTreeSet<String>) -> String {
    let all: BTreeSet<&str> = tokens(text).into_iter().collect();
    let is_reserved =
        |name: &str| !name.ends_with(|c: char| c.is_ascii_digit()) && all.contains(format!("{name}_").as_str());
    let mut readable = String::with_capacity(text.len());
    for function in text.split_inclusive("\n}\n") {
        let tokens = tokens(function);
        let own: BTreeSet<&str> = tokens.iter().copied().collect();
        let mut sources: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for token in &own {
            if let Some(stem) = stem(token) {
                sources.entry(stem).or_default().push(token);
            }
        }
        for token in tokens {
            let shorter = stem(token).filter(|stem| {
                let is_global = globals.contains(*stem);
                let global_again = is_global && token.strip_suffix('_') == Some(stem);
                let alone = sources[stem].len() == 1 && !own.contains(stem);
                global_again || (alone && !is_global && !is_reserved(stem))
            });
            readable.push_str(shorter.unwrap_or(token));
        }
    }
    readable
}

/// Comments at the head of `wgsl`, and those above its functions and structs, back in their places.
fn with_comments(text: &str, wgsl: &str) -> String {
    let mut above: BTreeMap<&str, String> = BTreeMap::new();
    let mut head = String::new();
    let mut comment = String::new();
    let mut in_head = true;
    for line in wgsl.lines() {
        let mut words = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        match (words.next(), words.next()) {
            _ if line.starts_with("//") => comment.extend([line, "\n"]),
            (Some("fn" | "struct"), Some(name)) => {
                in_head = false;
                above.insert(name, std::mem::take(&mut comment));
            }
            _ if line.is_empty() && in_head => {
                head.push_str(&std::mem::take(&mut comment));
                head.push('\n');
            }
            _ => {
                in_head = in_head && line.is_empty();
                comment.clear();
            }
        }
    }
    let mut commented = head.trim_end().to_owned();
    commented.push_str(if commented.is_empty() { "" } else { "\n\n" });
    let mut blank = true;
    for line in text.lines() {
        if line.is_empty() && blank {
            continue;
        }
        // a definition stands at the margin and names itself before its bracket
        let name = match line.strip_prefix("struct ") {
            Some(rest) => rest.split_whitespace().next(),
            None if line.starts_with([' ', '}', '#', '/']) || line.contains(" = ") => None,
            None => line
                .split_once('(')
                .and_then(|(before, _)| before.split_whitespace().last()),
        };
        if let Some(comment) = name.and_then(|name| above.remove(name)) {
            commented.push_str(&comment);
        }
        commented.extend([line, "\n"]);
        blank = line.is_empty();
    }
    commented.trim_end().to_owned() + "\n"
}
