//! Tables in the layouts of engines, read as the engines read them.

mod check;
mod choice;
mod cli;
mod docs;
mod engines;
mod files;
mod furnace;
mod gpu;
mod layout;
mod lookups;
mod metric;
mod published;
mod shared;
mod sizes;
#[path = "../skip/mod.rs"]
mod skip;
mod truth;
