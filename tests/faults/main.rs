//! Bakes that are interrupted, disks that are full, directories that are taken away: nothing is lost, nothing is broken, and
//! what is wrong is said.

mod cache;
mod directory;
mod disk;
mod interruption;
mod reuse;
mod textures;
