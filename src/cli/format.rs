//! Tables and numbers for people.

use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, Table};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::process::exit;
use std::time::Duration;

/// A table without borders; columns named in `right` are aligned to the right.
pub(super) fn table(header: &[&str], right: &[&str], rows: Vec<Vec<String>>) -> Table {
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.to_vec());
    table.add_rows(rows);
    for (index, name) in header.iter().enumerate() {
        if let Some(column) = table.column_mut(index) {
            column.set_padding((0, 2));
            if right.contains(name) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
    }
    table
}

/// Prints lines to standard output.
///
/// A reader that goes away is no error of ours. Any other failure ends the program with exit code 2: output that is not
/// there must not look like success.
pub(super) fn say(text: impl AsRef<str>) {
    let mut out = stdout().lock();
    for line in text.as_ref().lines() {
        if let Err(error) = writeln!(out, "{}", line.trim_end()) {
            if error.kind() != ErrorKind::BrokenPipe {
                eprintln!("error: cannot write to standard output: {error}");
                exit(2);
            }
            return;
        }
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
    match seconds {
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
    fn counts_are_grouped() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_234_567), "1 234 567");
    }
}
