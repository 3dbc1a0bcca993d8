//! Text of others made harmless for a terminal.
//!
//! Names of materials, of files and of channels are free text, and a file of unknown origin may hold anything. Escape
//! sequences would move the cursor or change the title of the window, directional overrides would let one name pass for another
//! [Unicode UAX 9, UTR 36], and what has no width would hide. Each such character becomes U+FFFD, so that columns and carets
//! stay where they are.

/// `text` as one line: every control character, line breaks among them, is replaced; a tab becomes a space.
///
/// ```
/// use whitefurnace::printable::printable;
///
/// assert_eq!(printable("gold\u{1b}[31m\u{202e}\n"), "gold\u{fffd}[31m\u{fffd}\u{fffd}");
/// ```
pub fn printable(text: &str) -> String {
    let shown = |c| match c {
        '\t' => ' ',
        c if is_hidden(c) => char::REPLACEMENT_CHARACTER,
        c => c,
    };
    text.chars().map(shown).collect()
}

/// `text` as it is but for its control characters; line breaks stay.
pub fn printable_lines(text: &str) -> String {
    let lines: Vec<String> = text.split('\n').map(printable).collect();
    lines.join("\n")
}

/// Whether `c` acts on what displays it, or shows nothing: controls (C0, DEL, C1), marks and overrides of direction, line and
/// paragraph separators, blanks without width, annotation and tag characters.
///
/// Joiners (U+200C, U+200D) and variation selectors stay: scripts and emoji need them.
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
                | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_is_replaced_one_for_one_and_the_rest_stays() {
        let hostile = "a\u{1b}[2J\r\u{7}\u{9b}31m\u{202e}b\u{2066}\u{200b}\u{feff}\u{e0041}\u{7f}";
        let shown = printable(hostile);
        assert!(!shown.chars().any(is_hidden), "{shown:?}");
        assert_eq!(shown.chars().count(), hostile.chars().count());
        assert_eq!(printable("a\tb\nc\u{2028}d"), "a b\u{fffd}c\u{fffd}d");
        let harmless = "Größe 金 👩\u{200d}🔬 e\u{301} \u{fffd}";
        assert_eq!(printable(harmless), harmless);
    }

    #[test]
    fn lines_stay_lines() {
        assert_eq!(printable_lines("a\n\u{1b}b\r\n"), "a\n\u{fffd}b\u{fffd}\n");
        assert_eq!(printable_lines(""), "");
    }
}
