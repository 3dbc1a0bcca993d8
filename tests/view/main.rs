//! The page of `furnace view`: its bytes, and what a browser makes of it, against integrals that the page never saw.

mod browser;
mod command;
mod furnace;
#[path = "../skip/mod.rs"]
mod skip;
