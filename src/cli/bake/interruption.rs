//! Ctrl-C during a bake.

use crate::cli::format;
use std::io::{IsTerminal, stderr};
use std::path::Path;
use std::process::exit;
use std::sync::{Arc, Mutex, PoisonError};
use whitefurnace::export::store::Store;

/// What shells expect of a program that SIGINT ended.
const INTERRUPTED: i32 = 130;

/// On SIGINT lets a file that is being written be finished, says what is kept, and ends the program.
///
/// Nothing but the message depends on it: what is finished is on the disk already, however the program ends. Where somebody
/// has decided that the signal be ignored, as `nohup` does, that stays so.
pub(super) fn tell_what_is_kept(store: &Arc<Store>, tables: usize) {
    let store = Arc::clone(store);
    let tell = move || {
        let finished = store.abandon();
        let directory = store.directory().display();
        if stderr().is_terminal() {
            // below the bar
            format::complain("");
        }
        let command = match store.uses_cache() {
            true => "the same command",
            false => "the same command without --no-cache",
        };
        if finished.published {
            format::complain(format!("interrupted: all {tables} tables are in {directory}"));
        } else if finished.tables > 0 {
            format::complain(format!(
                "interrupted: {} of {tables} tables are finished and kept in {directory}; {command} goes on from there",
                finished.tables
            ));
        } else {
            format::complain("interrupted: no table was finished, nothing is kept");
        }
        exit(INTERRUPTED);
    };
    // an error here means that somebody else handles the signal
    drop(ctrlc::try_set_handler(tell));
}

/// Files that are to appear together.
pub(super) struct Publication {
    /// Whether they have appeared; locked while they do.
    done: Arc<Mutex<bool>>,
}

impl Publication {
    /// Runs `write` without being interrupted.
    pub(super) fn publish<E>(&self, write: impl FnOnce() -> Result<(), E>) -> Result<(), E> {
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        write()?;
        *done = true;
        Ok(())
    }
}

/// On SIGINT lets files that are being written be finished, says what `directory` holds, and ends the program.
pub(super) fn tell_nothing_is_written(directory: &Path) -> Publication {
    let done = Arc::new(Mutex::new(false));
    let (told, directory) = (Arc::clone(&done), directory.display().to_string());
    let tell = move || {
        // held until the end: nothing begins to be written any more
        let done = told.lock().unwrap_or_else(PoisonError::into_inner);
        if stderr().is_terminal() {
            format::complain("");
        }
        match *done {
            true => format::complain(format!("interrupted: all tables are in {directory}")),
            false => format::complain(format!("interrupted: nothing is written, {directory} is as it was")),
        }
        exit(INTERRUPTED);
    };
    drop(ctrlc::try_set_handler(tell));
    Publication { done }
}
