//! Ctrl-C during a bake.

use crate::cli::format;
use std::io::{IsTerminal, stderr};
use std::process::exit;
use std::sync::Arc;
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
