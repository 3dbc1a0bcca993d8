//! `furnace`, the command line of `whitefurnace`.
fn main() {}
