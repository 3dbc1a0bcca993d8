//! Near misses among names, for "did you mean".

/// Longest name that is compared; nobody misspells a longer one by a letter or two.
const LONGEST: usize = 40;

/// The candidate closest to `name`, when it is close enough to be what was meant.
///
/// One slip is forgiven per three letters; case, and `_` for `-`, count as nothing.
pub(super) fn nearest<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    if name.chars().nth(LONGEST).is_some() {
        return None;
    }
    let name = folded(name);
    candidates
        .into_iter()
        .map(|candidate| (distance(&name, &folded(candidate)), candidate))
        .filter(|(distance, candidate)| 3 * distance <= candidate.len())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

fn folded(name: &str) -> Vec<char> {
    name.to_lowercase()
        .chars()
        .map(|c| if c == '_' { '-' } else { c })
        .collect()
}

/// Edits (a letter more, less, changed, or two neighbours swapped) that turn `a` into `b`.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let changed = usize::from(a[i - 1] != b[j - 1]);
            let mut least = (rows[i - 1][j - 1] + changed)
                .min(rows[i - 1][j] + 1)
                .min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_forgiven_and_other_words_are_not() {
        let names = ["type", "kappa", "v-groove", "m", "diffuse-specular"];
        for (name, meant) in [
            ("tpye", Some("type")),
            ("kapa", Some("kappa")),
            ("Kappa", Some("kappa")),
            ("v_groove", Some("v-groove")),
            ("M", Some("m")),
            ("n", None),
            ("difuse-speculr", Some("diffuse-specular")),
            ("glossiness", None),
            ("", None),
        ] {
            assert_eq!(nearest(name, names), meant, "{name}");
        }
        assert_eq!(nearest(&"k".repeat(1_000_000), names), None);
    }

    #[test]
    fn distances() {
        for (a, b, edits) in [("", "", 0), ("", "ab", 2), ("kitten", "sitting", 3), ("ab", "ba", 1)] {
            let [a, b] = [a, b].map(|s| s.chars().collect::<Vec<char>>());
            assert_eq!((distance(&a, &b), distance(&b, &a)), (edits, edits));
        }
    }
}
