//! Rows of the table of regimes in the README.

use crate::big::{Big, nearest, off};

/// One regime: an example of it, what the straightforward formula gives there, what the library gives, and the truth.
pub(crate) struct Row {
    /// The regime and the example.
    pub(crate) example: &'static str,
    /// What the straightforward formula gives.
    pub(crate) straightforward: f64,
    /// What the library gives.
    pub(crate) ours: f64,
    /// The true value.
    pub(crate) truth: Big,
    /// The test of the whole regime.
    pub(crate) test: &'static str,
}

const TITLES: [&str; 5] = [
    "regime, with an example",
    "straightforward (error)",
    "here (error)",
    "true value",
    "test",
];

impl Row {
    fn cells(&self) -> [String; 5] {
        let with_error = |found: f64| {
            if found.is_finite() {
                format!("{} ({})", digits(found), rounded(off(found, &self.truth)))
            } else {
                digits(found)
            }
        };
        [
            self.example.into(),
            with_error(self.straightforward),
            with_error(self.ours),
            digits(nearest(&self.truth)),
            format!("`{}`", self.test),
        ]
    }
}

/// Seven digits.
fn digits(x: f64) -> String {
    if !x.is_finite() || [0.0, 1.0, 2.0].contains(&x) {
        return format!("{x}");
    }
    if (1e-3..1e6).contains(&x.abs()) {
        let after = 6 - x.abs().log10().floor() as i32;
        return format!("{x:.*}", after as usize);
    }
    format!("{x:.6e}")
}

/// One digit of a relative error.
fn rounded(error: f64) -> String {
    let digit = format!("{error:.0e}");
    match digit.parse() {
        Ok(plain @ 1e-2..1e3) => format!("{plain}"),
        _ if error == 0.0 => "0".into(),
        _ => digit,
    }
}

/// The table in Markdown, aligned.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut lines = vec![TITLES.map(String::from)];
    lines.extend(rows.iter().map(Row::cells));
    let widths = [0, 1, 2, 3, 4].map(|column| lines.iter().map(|cells| cells[column].len()).max().unwrap_or(0));
    let line = |cells: &[String; 5]| {
        let padded: Vec<String> = (0..5).map(|i| format!("{:1$}", cells[i], widths[i])).collect();
        format!("| {} |\n", padded.join(" | "))
    };
    let rule = widths.map(|width| "-".repeat(width));
    lines.insert(1, rule);
    lines.iter().map(line).collect()
}
