//! `furnace`: energy-conserving BRDFs precomputed, from a scene file to lookup tables.
//!
//! A command reads a scene, plans the tables that it calls for, integrates their texels and exports them:
//! scene -> plan -> integrate -> table -> export. Each arrow is one function of the library; the commands under `cli` hold
//! them together and talk to people.

mod cli;

use cli::Outcome;
use std::process::ExitCode;

/// 0: good, 1: a verification failed, 2: usage, input or output; an interrupted bake ends with 130.
fn main() -> ExitCode {
    let arguments = cli::Arguments::of_this_process();
    match cli::run(&arguments) {
        Ok(Outcome::Good) => ExitCode::SUCCESS,
        Ok(Outcome::Failed) => ExitCode::from(1),
        Err(failure) => {
            failure.tell();
            ExitCode::from(2)
        }
    }
}
