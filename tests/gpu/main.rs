//! The shader texts on a GPU: what they read of textures, what their BRDFs are, and what these reflect.
//!
//! `cargo test --test gpu`, with any Vulkan driver; Mesa's lavapipe needs none but itself. Without an adapter the tests
//! say that they skip, and with `FURNACE_REQUIRE_GPU=1` they fail.

mod brdfs;
mod device;
mod energy;
mod lookups;
mod materials;
#[path = "../skip/mod.rs"]
mod skip;
