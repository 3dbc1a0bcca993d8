//! Tables and numbers for people.

use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, Table};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::process::exit;
use std::time::Duration;
use whitefurnace::printable::{is_hidden, printable, printable_lines};

/// A table without borders; columns named in `right` are aligned to the right. Cells may hold the names of others.
pub(super) fn table(header: &[&str], right: &[&str], rows: Vec<Vec<String>>) -> Table {
    let header: Vec<String> = header.iter().map(|name| printable(name)).collect();
    let rows = rows
        .iter()
        .map(|row| row.iter().map(|cell| printable(cell)).collect::<Vec<String>>());
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.clone());
    table.add_rows(rows);
    for (index, name) in header.iter().enumerate() {
        if let Some(column) = table.column_mut(index) {
            column.set_padding((0, 2));
            if right.contains(&name.as_str()) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
    }
    table
}

/// Columns without a header, indented.
pub(super) fn rows(rows: Vec<Vec<String>>) -> String {
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let text = table(&vec![""; width], &[], rows).to_string();
    text.lines()
        .skip(1)
        .map(|line| format!("  {}\n", line.trim_end()))
        .collect()
}

/// Prints lines, text or JSON, to standard output, harmless to a terminal whatever names they hold: see [`escaped`].
///
/// A reader that goes away is no error of ours. Any other failure ends the program with exit code 2: output that is not
/// there must not look like success.
pub(super) fn say(text: impl AsRef<str>) {
    let mut out = stdout().lock();
    for line in text.as_ref().lines() {
        if let Err(error) = writeln!(out, "{}", escaped(line.trim_end())) {
            if error.kind() != ErrorKind::BrokenPipe {
                complain(format!("error: cannot write to standard output: {error}"));
                exit(2);
            }
            return;
        }
    }
}

/// Characters that act on a terminal or hide, written as JSON writes them in strings, `\u001b`. So JSON stays the JSON that it was,
/// where nothing else may hold such characters, and a person sees what there is.
fn escaped(line: &str) -> Cow<'_, str> {
    let acts = |c: char| is_hidden(c) && c != '\t';
    if !line.contains(acts) {
        return line.into();
    }
    let mut text = String::new();
    for c in line.chars() {
        if acts(c) {
            let units = &mut [0; 2];
            text.extend(c.encode_utf16(units).iter().map(|unit| format!("\\u{unit:04x}")));
        } else {
            text.push(c);
        }
    }
    text.into()
}

/// Prints to standard error. There is nobody to tell when that fails, and no reason to stop.
pub(super) fn complain(text: impl AsRef<str>) {
    let _ = writeln!(stderr(), "{}", printable_lines(text.as_ref()));
}

/// Prints a note to standard error.
pub(super) fn note(text: impl AsRef<str>) {
    complain(format!("note: {}", text.as_ref()));
}

/// Some of the names, and how many more there are.
pub(super) fn some<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    const MOST: usize = 40;
    let more = names.len().saturating_sub(MOST);
    let shown = names.take(MOST).collect::<Vec<_>>().join(", ");
    match more {
        0 => shown,
        more => format!("{shown} and {} more", count(more as u64)),
    }
}

/// Up to three numbers, one for each channel.
pub(super) fn channels(values: &[f64], one: impl Fn(f64) -> String) -> String {
    values.iter().map(|value| one(*value)).collect::<Vec<_>>().join(" ")
}

/// An error with two digits, never rounded down.
pub(super) fn error(error: f64) -> String {
    if error.is_infinite() {
        return "unbounded".into();
    }
    let text = format!("{error:.1e}");
    match text.parse::<f64>() {
        Ok(shown) if shown < error => {
            // one more in the last digit shown
            let digit = 10f64.powf(error.log10().floor() - 1.0);
            format!("{:.1e}", shown + digit)
        }
        _ => text,
    }
}

/// So many things, as `1 table` or `3 tables`.
pub(super) fn counted(count: usize, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// A count with its thousands set apart.
pub(super) fn count(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A duration in the unit that suits it.
pub(super) fn seconds(seconds: f64) -> String {
    // the sum of no times at all is -0
    match seconds + 0.0 {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s => format!("{:.1} min", s / 60.0),
    }
}

/// A progress bar on standard error, when that is a terminal.
pub(super) fn progress_of(length: u64, what: &'static str, units: &str) -> ProgressBar {
    let target = if stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target).with_message(what);
    let style = ProgressStyle::with_template(&format!(
        "{{msg}} [{{bar:32}}] {{human_pos}}/{{human_len}} {units}, {{elapsed}} so far, {{eta}} left"
    ));
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    // a single integral may take minutes: the clock shows that it runs
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A progress bar of expected time on standard error, when that is a terminal; positions are microseconds.
pub(super) fn progress_in_time(length: u64) -> ProgressBar {
    let bar = progress_of(length, "", "");
    let style =
        ProgressStyle::with_template("[{bar:32}] {percent:>3} %, {elapsed} so far, about {eta} left: {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_never_rounded_down() {
        for value in [1.04e-7, 9.96e-3, 1.0, 0.123, 2.05e-15, 1.049_999e-3] {
            let shown: f64 = error(value).parse().unwrap();
            assert!(
                shown >= value && shown <= 1.1 * value,
                "{value} shown as {}",
                error(value)
            );
        }
        assert_eq!(error(4.63e-4), "4.7e-4");
        assert_eq!(error(9.96e-3), "1.0e-2");
        assert_eq!(error(0.0), "0.0e0");
        assert_eq!(error(f64::INFINITY), "unbounded");
    }

    #[test]
    fn what_acts_on_a_terminal_is_escaped_and_json_stays_the_same() {
        let name = "gold\u{1b}[2J\u{9b}m\u{7f}\u{202e}\u{e0041}é👩\u{200d}🔬\t\"\\";
        let json = serde_json::to_string(name).unwrap();
        let shown = escaped(&json);
        assert!(!shown.chars().any(is_hidden), "{shown}");
        assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), name);
        assert_eq!(escaped("a\u{1b}b"), "a\\u001bb");
        let rows = vec![vec!["a\nb\u{1b}".to_string()]];
        assert_eq!(
            table(&["x"], &[], rows).to_string().lines().nth(1).map(str::trim_end),
            Some("a\u{fffd}b\u{fffd}")
        );
    }

    #[test]
    fn long_lists_are_cut() {
        let names: Vec<String> = (0..1041).map(|i| i.to_string()).collect();
        let names = || names.iter().map(String::as_str);
        assert_eq!(some(names().take(3)), "0, 1, 2");
        assert!(some(names()).ends_with("38, 39 and 1 001 more"));
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_234_567), "1 234 567");
    }
}
