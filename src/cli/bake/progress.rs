//! How far a bake is, and what is left.

use super::Job;
use crate::cli::{Failure, format};
use indicatif::ProgressBar;
use std::collections::VecDeque;
use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use whitefurnace::integrate::{Forecasts, forecasts, work};
use whitefurnace::plan::TablePlan;
use whitefurnace::table::Table;

/// Longest look at what the tables of a batch will cost, beyond the last integral that it begins.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bake that takes more seconds than this is announced also where no terminal looks on.
const LONG: f64 = 10.0;

/// Microseconds in a second: the unit of the bar.
const MICROS: f64 = 1e6;

/// A bar that advances by the time that tables are expected to take, since integrals of one may take a thousand times those
/// of another.
pub(super) struct Progress {
    /// Nothing is shown before it is known how long it will take.
    bar: Option<ProgressBar>,
    /// Tables of the bake, and those of them that are done or being done.
    tables: usize,
    begun: usize,
    /// Expected microseconds of the tables in hand.
    expected: VecDeque<f64>,
    /// Expected microseconds of those that are done.
    done: f64,
    threads: f64,
}

impl Progress {
    /// For a bake of so many tables, from within its thread pool.
    pub(super) fn new(tables: usize) -> Self {
        Self {
            bar: None,
            tables,
            begun: 0,
            expected: VecDeque::new(),
            done: 0.0,
            threads: rayon::current_num_threads() as f64,
        }
    }

    /// Runs `choose` under a bar of its own, or, in later batches, under the message of the one that is there.
    pub(super) fn choosing<'a>(
        &self,
        choose: impl FnOnce(&ProgressBar) -> Result<Vec<Job<'a>>, Failure>,
    ) -> Result<Vec<Job<'a>>, Failure> {
        match &self.bar {
            Some(bar) => {
                bar.set_message("choosing sizes");
                choose(&ProgressBar::hidden())
            }
            None => {
                let bar = format::progress_of(self.tables.min(super::BATCH) as u64, "choosing sizes", "tables");
                let jobs = choose(&bar);
                bar.finish_and_clear();
                jobs
            }
        }
    }

    /// Looks at what the next `jobs` will cost. Before the first of them the whole is announced.
    pub(super) fn expect(&mut self, jobs: &[Job<'_>]) {
        let plans: Vec<&TablePlan> = jobs.iter().map(Job::plan).collect();
        let Forecasts { each, studied, .. } = forecasts(&plans, PATIENCE);
        // rules run on all threads, nearly
        let expected = jobs.iter().zip(each);
        self.expected = expected
            .map(|(job, forecast)| job.repeats() * forecast.seconds * MICROS / self.threads)
            .collect();
        let batch: f64 = self.expected.iter().sum();
        let left = self.tables - self.begun;
        let total = self.done + batch * left as f64 / jobs.len().max(1) as f64;
        match &self.bar {
            Some(bar) => bar.set_length(total as u64),
            None => {
                self.announce(total / MICROS, studied);
                self.bar = Some(format::progress_in_time(total as u64));
            }
        }
    }

    fn announce(&self, seconds: f64, studied: usize) {
        let looks_on = stderr().is_terminal();
        if !looks_on && seconds < LONG {
            return;
        }
        let judged = if studied < self.tables {
            format!(", judged by {studied} of them")
        } else {
            String::new()
        };
        format::note(format!(
            "{} to compute, about {} on {} threads{judged}; Ctrl-C keeps what is finished",
            format::counted(self.tables, "table"),
            format::seconds(seconds),
            self.threads,
        ));
    }

    /// Runs `fill` for the table of `plan`, the next of those in hand.
    pub(super) fn during<E>(
        &mut self,
        plan: &TablePlan,
        fill: impl FnOnce(&(dyn Fn(u64) + Sync)) -> Result<Table, E>,
    ) -> Result<Table, E> {
        let micros = self.expected.pop_front().unwrap_or(0.0);
        self.begun += 1;
        let (done, all) = (AtomicU64::new(0), work(plan) as f64);
        let table = match &self.bar {
            None => fill(&|_| {}),
            Some(bar) => {
                bar.set_message(format!("{}/{} {}", self.begun, self.tables, plan.id));
                fill(&|integrals| {
                    let done = done.fetch_add(integrals, Ordering::Relaxed) + integrals;
                    bar.set_position((self.done + micros * (done as f64 / all).min(1.0)) as u64);
                })
            }
        };
        self.done += micros;
        if let Some(bar) = &self.bar {
            bar.set_position(self.done as u64);
        }
        table
    }

    /// Clears the bar.
    pub(super) fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
