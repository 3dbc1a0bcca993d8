//! placeholder
use super::{Check, Settings};
use crate::export::ExportError;
use crate::scene::{Material, Scene};
use std::path::Path;
/// x
pub fn verify_tables(_: &Scene, _: &[&Material], _: &Path, _: &Settings) -> Result<Vec<Check>, ExportError> {
    Ok(vec![])
}
