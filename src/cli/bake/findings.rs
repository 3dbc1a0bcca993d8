//! What is wrong with materials as a whole, found out from their finished tables.

use super::BATCH;
use crate::cli::Failure;
use std::collections::HashMap;
use std::path::Path;
use whitefurnace::export::manifest::Manifest;
use whitefurnace::export::read::{Contents, read_exr};
use whitefurnace::integrate::whole_excess;
use whitefurnace::plan::Plan;
use whitefurnace::table::Table;

/// Materials whose lobes reflect more than they get, together.
pub(super) fn findings(plan: &Plan, directory: &Path, manifest: &Manifest) -> Result<Vec<String>, Failure> {
    let entries = manifest.tables.iter();
    let files: HashMap<&str, &str> = entries.map(|entry| (entry.id.as_str(), entry.file.as_str())).collect();
    let mut read: HashMap<String, Table> = HashMap::new();
    let mut table = |id: &str| -> Result<Table, Failure> {
        if let Some(table) = read.get(id) {
            return Ok(table.clone());
        }
        let path = directory.join(files.get(id).copied().unwrap_or_default());
        let Contents::Table { table, .. } = read_exr(&path)?.contents else {
            return Err(format!("{} is not the table that was written", path.display()).into());
        };
        // neighbours in a scene share tables; those of all need not be in memory at once
        if read.len() >= BATCH {
            read.clear();
        }
        read.insert(id.to_owned(), (*table).clone());
        Ok(*table)
    };
    let mut findings = Vec::new();
    for material in &plan.materials {
        if let Some(worst) = whole_excess(material, &mut table)? {
            let roughness = worst.roughness;
            let roughness = roughness.map_or_else(String::new, |value| format!(", roughness {value:.6}"));
            findings.push(format!(
                "{}: its lobes reflect {:.3} more than they get at mu = {:.6}{roughness}",
                material.name, worst.excess, worst.mu
            ));
        }
    }
    Ok(findings)
}
