//! Sizes that keep an error, for every table of a plan.

use crate::cli::bake::{BATCH, choosers};
use crate::cli::{Failure, format};
use cpu_time::ProcessTime;
use rayon::prelude::*;
use serde_json::{Value, json};
use whitefurnace::integrate::Forecast;
use whitefurnace::integrate::choice::{Choice, Obstacle, Wish};
use whitefurnace::plan::TablePlan;
use whitefurnace::table::Storage;

/// What is chosen for a table, in 32-bit floats, in the fewest bytes, and for half the error.
pub(super) struct Chosen {
    pub(super) choice: Choice,
    pub(super) smallest: Option<Choice>,
    pub(super) half: Choice,
}

/// What is chosen for each of the `tables`, and the seconds of all processors that a bake takes to choose so, too.
pub(super) fn chosen(tables: &[TablePlan], wish: Wish) -> Result<(Vec<Chosen>, f64), Failure> {
    let bar = format::progress_of(tables.len() as u64, "choosing sizes", "tables");
    let mut chosen = Vec::with_capacity(tables.len());
    let mut seconds = 0.0;
    for batch in tables.chunks(BATCH) {
        let start = ProcessTime::now();
        let choosers = choosers(batch, wish, &bar)?;
        seconds += start.elapsed().as_secs_f64();
        chosen.par_extend(choosers.par_iter().map(|chooser| Chosen {
            choice: chooser.wished(),
            smallest: chooser.smallest(wish.tolerance),
            half: chooser.choice(0.5 * wish.tolerance, Storage::F32),
        }));
    }
    bar.finish_and_clear();
    Ok((chosen, seconds))
}

impl Chosen {
    /// The lookup error that is expected, and whether that is measured.
    pub(super) fn error(&self) -> String {
        if self.choice.error.is_infinite() {
            return "unknown".into();
        }
        let about = if self.choice.whole { "" } else { "~" };
        format!("{about}{}", format::error(self.choice.error))
    }

    /// Adds to the JSON of a table what was chosen; `half` is the cost of half the error.
    pub(super) fn tell(&self, table: &mut Value, half: &Forecast) {
        let finite = |error: f64| error.is_finite().then_some(error);
        let sizes = |choice: &Choice| -> Vec<usize> {
            let axes = choice.plan.alternatives.iter().take(1).flatten();
            axes.map(|axis| axis.size).collect()
        };
        table["bytes"] = json!(self.choice.bytes);
        table["lookup_error"] = json!(finite(self.choice.error));
        table["lookup_error_is"] = json!(if self.choice.whole { "measured" } else { "estimated" });
        table["obstacle"] = json!(self.choice.obstacle.map(Obstacle::reason));
        table["smallest"] = self.smallest.as_ref().map_or(Value::Null, |smallest| {
            json!({
                "storage": smallest.storage.name(),
                "bytes": smallest.bytes,
                "size": sizes(smallest),
                "lookup_error": finite(smallest.error),
            })
        });
        table["half_the_error"] = json!({
            "size": sizes(&self.half),
            "texels": self.half.plan.texels(),
            "bytes": self.half.bytes,
            "lookup_error": finite(self.half.error),
            "evaluations": half.evaluations.round(),
            "seconds": half.seconds,
        });
    }
}
