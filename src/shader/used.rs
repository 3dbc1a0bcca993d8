//! Of a library, what somebody uses.

use super::names::tokens;
use std::collections::BTreeSet;

/// Constants, structs and functions of the WGSL `library` that `text` uses, and those that these use, in the order of the library. Each
/// stands behind an empty line or begins one, with its comment above it.
pub(super) fn used(library: &str, text: &str) -> String {
    let items = items(library);
    let mut known: BTreeSet<&str> = tokens(text).into_iter().collect();
    let mut wanted = vec![false; items.len()];
    // users stand behind what they use
    for (item, wanted) in items.iter().zip(&mut wanted).rev() {
        if known.contains(item.name) {
            *wanted = true;
            let code = item.text.lines().filter(|line| !line.trim_start().starts_with("//"));
            known.extend(code.flat_map(tokens));
        }
    }
    let mut kept = String::new();
    let mut was_constant = true;
    for (item, _) in items.iter().zip(&wanted).filter(|(_, wanted)| **wanted) {
        if !(was_constant && item.is_constant) {
            kept.push('\n');
        }
        was_constant = item.is_constant;
        kept.push_str(item.text);
    }
    kept
}

struct Item<'a> {
    name: &'a str,
    /// With its comment and its last line break.
    text: &'a str,
    is_constant: bool,
}

fn items(library: &str) -> Vec<Item<'_>> {
    let mut items = Vec::new();
    let (mut start, mut at) = (0, 0);
    let mut open: Option<&str> = None;
    for line in library.split_inclusive('\n') {
        let end = at + line.len();
        let mut words = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        match (words.next(), words.next()) {
            (Some("const"), Some(name)) => {
                let text = &library[start..end];
                items.push(Item {
                    name,
                    text,
                    is_constant: true,
                });
                start = end;
            }
            (Some("fn" | "struct"), Some(name)) => open = Some(name),
            _ if line == "}\n" => {
                if let Some(name) = open.take() {
                    let text = &library[start..end];
                    items.push(Item {
                        name,
                        text,
                        is_constant: false,
                    });
                }
                start = end;
            }
            _ if open.is_none() && line == "\n" => start = end,
            _ => {}
        }
        at = end;
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::LIBRARY;

    #[test]
    fn what_is_used_comes_with_what_that_uses() {
        let some = used(LIBRARY, "let x = furnace_base(1u, a, b, c, d, e);");
        assert!(
            some.contains("fn furnace_base(")
                && some.contains("const FURNACE_ONE_OVER_PI")
                && some.contains("// The diffuse base")
        );
        for absent in ["furnace_f(", "struct", "FURNACE_GGX:"] {
            assert!(!some.contains(absent), "{absent}: {some}");
        }
        let lobe = used(LIBRARY, "furnace_f");
        for present in [
            "fn furnace_hidden(",
            "fn furnace_ln_cos(",
            "struct FurnaceLobe",
            "const FURNACE_LARGEST",
        ] {
            assert!(lobe.contains(present), "{present}: {lobe}");
        }
        assert_eq!(used(LIBRARY, "nothing"), "");
    }
}
