//! File names from free text: safe on every system, stable, and unique.
//!
//! A name that is already safe stays as it is. Any other is cleaned and gets a hash of the original, whatever other
//! names there are: adding a material to a scene never renames the files of the others.

use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};

/// Longest stem in bytes, so that stem, extension and directory stay within the limits of all file systems.
pub const MAX_LENGTH: usize = 80;

/// Hexadecimal digits of the hash after a cleaned name.
const HASH_DIGITS: usize = 8;

/// A file stem for the free text `original`: `[a-z0-9._-]` only, at most [`MAX_LENGTH`] bytes, no leading or trailing
/// dot or dash, no `..`, no name that Windows reserves.
///
/// Where that loses anything, `-` and 8 digits of the hash of `original` follow, so that `Gold`, `gold` and `gold!`
/// differ. Names that look hashed already are hashed again, lest they pass for the hash of another.
pub fn file_stem(original: &str) -> String {
    stem_with(original, HASH_DIGITS)
}

/// Stems for all `originals`, in their order: [`file_stem`], and the whole hash for those few whose short hashes
/// collide. Equal originals get equal stems.
pub fn file_stems(originals: &[&str]) -> Vec<String> {
    let short: Vec<String> = originals.iter().map(|original| file_stem(original)).collect();
    let mut owners: HashMap<&str, &str> = HashMap::new();
    let mut contested = HashSet::new();
    for (stem, original) in short.iter().zip(originals) {
        if *owners.entry(stem).or_insert(original) != *original {
            contested.insert(stem.as_str());
        }
    }
    let settle = |(stem, original): (&String, &&str)| {
        if contested.contains(stem.as_str()) {
            stem_with(original, 64)
        } else {
            stem.clone()
        }
    };
    short.iter().zip(originals).map(settle).collect()
}

fn stem_with(original: &str, digits: usize) -> String {
    let clean = clean(original);
    if !clean.is_empty() && clean == original && clean.len() <= MAX_LENGTH && !looks_hashed(&clean) {
        return clean;
    }
    let hash: String = Sha256::digest(original.as_bytes())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let hash = &hash[..digits];
    let kept = &clean[..clean.len().min(MAX_LENGTH - 1 - digits)];
    match kept.trim_end_matches(['.', '-']) {
        "" => format!("unnamed-{hash}"),
        kept => format!("{kept}-{hash}"),
    }
}

/// Lower-case ASCII; anything else becomes a dash, runs of dashes one dash, runs of dots one dot.
fn clean(original: &str) -> String {
    let mut clean = String::new();
    for c in original.chars() {
        let c = match c.to_ascii_lowercase() {
            c @ ('a'..='z' | '0'..='9' | '_' | '.') => c,
            _ => '-',
        };
        if !(matches!(c, '.' | '-') && clean.ends_with(c)) {
            clean.push(c);
        }
    }
    let clean = clean.trim_matches(['.', '-']);
    if is_reserved(clean) {
        return format!("_{clean}");
    }
    clean.to_string()
}

/// Devices on Windows, with any extension.
fn is_reserved(name: &str) -> bool {
    let device = name.split('.').next().unwrap_or(name);
    let numbered = |prefix| {
        device
            .strip_prefix(prefix)
            .is_some_and(|rest| rest.len() == 1 && rest.chars().all(|c| c.is_ascii_digit()))
    };
    matches!(device, "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
}

fn looks_hashed(name: &str) -> bool {
    name.rsplit_once('-')
        .is_some_and(|(_, end)| matches!(end.len(), HASH_DIGITS | 64) && end.chars().all(|c| c.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn safe_names_stay_and_others_are_marked() {
        for name in [
            "gold",
            "methanol-k17",
            "vmf_1.5",
            "a.b-c_d",
            "_x",
            "7",
            "console",
            "com10",
        ] {
            assert_eq!(file_stem(name), name);
        }
        let figure = file_stem("Mikkelsen 2009, figure 7");
        assert!(figure.starts_with("mikkelsen-2009-figure-7-"), "{figure}");
        assert_eq!(figure.len(), "mikkelsen-2009-figure-7-".len() + 8);
        assert_eq!(file_stem(""), "unnamed-e3b0c442");
    }

    #[test]
    fn hostile_names_become_safe_and_distinct() {
        let long = "x".repeat(300);
        let longer = "x".repeat(301);
        let names = [
            "",
            " ",
            ".",
            "..",
            "../../etc/passwd",
            "/",
            "\\\\server\\share",
            "C:\\x",
            "con",
            "CON",
            "nul.txt",
            "com1",
            "LPT9.x",
            "-rf",
            ".hidden",
            "a..b",
            "a.",
            "a-",
            "a",
            "A",
            "gold",
            "Gold",
            "GOLD",
            "gold ",
            "gold\0",
            "gold\n",
            "Größe",
            "金",
            "銀",
            "\u{202e}dlog",
            "a--b",
            "a-b",
            &long,
            &longer,
            "gold-0123abcd",
            "💡",
        ];
        let stems = file_stems(&names);
        for (stem, name) in stems.iter().zip(names) {
            let safe = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._-".contains(c);
            assert!(!stem.is_empty() && stem.len() <= MAX_LENGTH, "{name:?} {stem}");
            assert!(stem.chars().all(safe), "{name:?} {stem}");
            assert!(!stem.starts_with(['.', '-']) && !stem.ends_with(['.', '-']), "{stem}");
            assert!(!stem.contains("..") && !is_reserved(stem), "{name:?} {stem}");
            assert_eq!(*stem, file_stem(name), "no other name changes it");
        }
        assert_eq!(stems.iter().collect::<HashSet<_>>().len(), names.len());
        // What a cleaned name became is itself no way to claim the same file.
        assert_ne!(file_stem(&file_stem("Gold")), file_stem("Gold"));
    }

    #[test]
    fn colliding_hashes_grow_for_both() {
        // Names of blanks and tabs all clean to nothing; some two of them share 8 digits of hash.
        let name = |i: u32| -> String { (0..20).map(|bit| if i >> bit & 1 == 0 { ' ' } else { '\t' }).collect() };
        let mut seen = HashMap::new();
        let (one, other) = (0..1 << 20)
            .find_map(|i| seen.insert(file_stem(&name(i)), i).map(|j| (name(i), name(j))))
            .unwrap();
        assert_eq!(file_stem(&one), file_stem(&other));
        let stems = file_stems(&[&one, "gold", &other, "gold"]);
        assert_eq!(stems, file_stems(&[&one, "gold", &other, "gold"]));
        assert!(stems[0] != stems[2] && stems[0].len() == "unnamed-".len() + 64);
        assert_eq!((stems[1].as_str(), stems[3].as_str()), ("gold", "gold"));
    }
}
