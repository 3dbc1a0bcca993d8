//! Textures as files, read back by the crates and by programs that know nothing of this one.

mod bake;
mod dds;
mod exr;
mod inspect;
mod ktx2;
mod png;
mod raw;
mod sample;
#[path = "../skip/mod.rs"]
mod skip;
mod source;
mod tools;
