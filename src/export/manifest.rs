//! `manifest.json`: all tables of a scene with the facts of their files, and which material uses which.

mod file;
mod material;

pub use file::FileEntry;
pub use material::{AlbedoEntry, BaseEntry, LayerEntry, LobeEntry, MaterialEntry};

use super::{ExportError, FORMAT, SOFTWARE, VERSION, json_reason};
use crate::regular;
use crate::table::axis::Axis;
use crate::table::{Between, Table};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::io::Read;
use std::path::Path;

/// Name of the manifest in the directory of the tables.
pub const FILE_NAME: &str = "manifest.json";

/// Longest manifest that is read, in bytes: a table takes some 1300.
pub const MAX_BYTES: u64 = 1 << 28;

/// Most brackets, braces and commas in a manifest that is read: a table has some 50, and each may cost a hundred bytes of memory.
pub const MAX_PARTS: usize = 1 << 24;

/// Everything that was written for one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of this layout.
    pub format: i32,
    /// The program.
    pub software: String,
    /// Version of the program.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of the random streams.
    pub seed: u64,
    /// The tables, in the order of the plan.
    pub tables: Vec<TableEntry>,
    /// Whether every effect was computed for every material, whatever the scene calls for.
    pub all_effects: bool,
    /// The materials, in the order of the scene.
    pub materials: Vec<MaterialEntry>,
    /// By the id of a table the key of what it answers, see [`key`](super::store::key): a later bake takes a table over
    /// whose key is the one that it would have.
    pub requests: BTreeMap<String, String>,
    /// Ids of the tables that this bake did not compute, but found finished. The only part that depends on what was there
    /// before: all others are the same for the same scene, settings, seed and version.
    pub reused: Vec<String>,
}

/// One table and its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TableEntry {
    /// Stem of the file name.
    pub id: String,
    /// Name of the file, beside the manifest.
    pub file: String,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// `rho_hd` or `rho_hh`.
    pub quantity: String,
    /// `reflection` or `transmission`.
    pub lobe: String,
    /// Number of channels, 1 or 3.
    pub channels: usize,
    /// Width and height in texels.
    pub size: [usize; 2],
    /// Along the width, then along the height.
    pub axes: Vec<AxisEntry>,
    /// Materials that use the table.
    pub materials: Vec<String>,
    /// Parameters that are constant over the table, by name; all are strings.
    #[serde(deserialize_with = "strings")]
    pub parameters: Map<String, Value>,
    /// Name of the estimator.
    pub estimator: String,
    /// `bound`, `ci99` or `exact`.
    pub error_kind: String,
    /// Largest absolute error asked for.
    pub tolerance: f64,
    /// Largest lookup error asked for; null where axes and sizes were not chosen for one.
    pub lookup_tolerance: Option<f64>,
    /// Why lookups err by more than that, and what to do; null where they do not.
    pub unmet: Option<String>,
    /// Largest error of any texel: the tolerance reached.
    pub max_texel_error: f64,
    /// Error of a lookup between texels; null while nobody has measured it.
    pub between: Option<BetweenEntry>,
    /// Smallest stored value.
    pub min: f64,
    /// Largest stored value.
    pub max: f64,
    /// Integrand evaluations.
    pub evaluations: u64,
    /// Seed of the random streams.
    pub seed: u64,
    /// The table in further formats, in the order in which they were asked for.
    #[serde(default)]
    pub files: Vec<FileEntry>,
}

/// One axis of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisEntry {
    /// Name of the parameter.
    pub parameter: String,
    /// Name of the mapping.
    pub mapping: String,
    /// `centres` or `ends`.
    pub texel_rule: String,
    /// Value at u = 0.
    pub min: f64,
    /// Value at u = 1.
    pub max: f64,
    /// Number of texels.
    pub size: usize,
    /// The texture coordinate, as a shader computes it.
    pub shader: String,
}

/// The error of a lookup between texels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BetweenEntry {
    /// Largest absolute error found.
    pub error: Option<f64>,
    /// Where: one value per axis.
    pub at: Vec<f64>,
    /// Number of places looked at.
    pub probes: u64,
}

impl TableEntry {
    /// The entry of `table`, stored in the file `file` of `bytes` bytes with the given hash, which `materials` use.
    pub fn new(table: &Table, file: impl Into<String>, bytes: u64, sha256: String, materials: &[String]) -> Self {
        let (min, max) = table.range();
        let parameters = table.parameters.iter().cloned();
        Self {
            id: table.id.clone(),
            file: file.into(),
            bytes,
            sha256,
            quantity: table.quantity.name().into(),
            lobe: table.lobe.name().into(),
            channels: table.channels.count(),
            size: table.size(),
            axes: table.axes.iter().map(AxisEntry::new).collect(),
            materials: materials.to_vec(),
            parameters: parameters.map(|(name, value)| (name, Value::String(value))).collect(),
            estimator: table.estimator.clone(),
            error_kind: table.error_kind.name().into(),
            tolerance: table.tolerance,
            lookup_tolerance: table.goal.as_ref().map(|goal| goal.tolerance),
            unmet: table.goal.as_ref().and_then(|goal| goal.unmet.clone()),
            max_texel_error: table.max_texel_error(),
            between: table.between.as_ref().map(BetweenEntry::new),
            min,
            max,
            evaluations: table.evaluations,
            seed: table.seed,
            files: Vec::new(),
        }
    }
}

impl AxisEntry {
    fn new(axis: &Axis) -> Self {
        Self {
            parameter: axis.parameter.clone(),
            mapping: axis.mapping.name().into(),
            texel_rule: axis.rule.name().into(),
            min: axis.min,
            max: axis.max,
            size: axis.size,
            shader: axis.shader_formula(),
        }
    }
}

impl BetweenEntry {
    fn new(between: &Between) -> Self {
        Self {
            error: between.error.is_finite().then_some(between.error),
            at: between.at.clone(),
            probes: between.probes,
        }
    }
}

impl Manifest {
    /// The manifest of a scene with the given materials and tables, of which nothing is said to be reused.
    pub fn new(
        scene: impl Into<String>,
        seed: u64,
        materials: &[String],
        tables: Vec<TableEntry>,
        requests: BTreeMap<String, String>,
    ) -> Self {
        let mut of: HashMap<&str, Vec<String>> = HashMap::new();
        for table in &tables {
            for name in &table.materials {
                of.entry(name).or_default().push(table.id.clone());
            }
        }
        let users = |name: &String| MaterialEntry {
            name: name.clone(),
            tables: of.get(name.as_str()).cloned().unwrap_or_default(),
            lobes: Vec::new(),
        };
        let materials = materials.iter().map(users).collect();
        Self {
            format: FORMAT,
            software: SOFTWARE.into(),
            version: VERSION.into(),
            scene: scene.into(),
            seed,
            tables,
            all_effects: false,
            materials,
            requests,
            reused: Vec::new(),
        }
    }

    /// Indented JSON with a final newline; the same text for the same manifest.
    ///
    /// # Errors
    /// [`ExportError::Manifest`], which the types of a manifest do not provoke.
    pub fn to_json(&self) -> Result<String, ExportError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// A manifest from its JSON; every f64 comes back bit by bit.
    ///
    /// # Errors
    /// [`ExportError::Manifest`] with line and column when `json` is damaged or lacks facts.
    pub fn from_json(json: &str) -> Result<Self, ExportError> {
        Ok(serde_json::from_str(json)?)
    }

    /// The manifest in the file at `path`.
    ///
    /// # Errors
    /// [`ExportError::Io`] when the system refuses or it is no regular file; [`ExportError::Unreadable`] when it is longer than
    /// [`MAX_BYTES`], has more parts than [`MAX_PARTS`], is damaged, or is of another layout.
    pub fn read(path: &Path) -> Result<Self, ExportError> {
        let unreadable = |reason: String| ExportError::Unreadable {
            path: path.to_path_buf(),
            reason,
        };
        let (file, _) = regular::open(path).map_err(ExportError::io("read", path))?;
        let mut json = Vec::new();
        let read = file.take(MAX_BYTES + 1).read_to_end(&mut json);
        read.map_err(ExportError::io("read", path))?;
        if json.len() as u64 > MAX_BYTES {
            return Err(unreadable(format!("it is longer than {MAX_BYTES} bytes")));
        }
        if json.iter().filter(|byte| b"[{,".contains(byte)).count() > MAX_PARTS {
            return Err(unreadable(format!(
                "it has more than {MAX_PARTS} brackets, braces and commas"
            )));
        }
        let manifest: Self = serde_json::from_slice(&json).map_err(|error| unreadable(json_reason(&error)))?;
        if manifest.format != FORMAT {
            let found = manifest.format;
            return Err(unreadable(format!(
                "its format is {found}, where this version reads {FORMAT}"
            )));
        }
        Ok(manifest)
    }
}

/// Strings by name. Other values are refused: arrays within arrays would cost many times what they take in the file.
fn strings<'de, D: Deserializer<'de>>(from: D) -> Result<Map<String, Value>, D::Error> {
    struct Strings;
    impl<'de> Visitor<'de> for Strings {
        type Value = Map<String, Value>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("strings by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut pairs: A) -> Result<Self::Value, A::Error> {
            let mut all = Map::new();
            while let Some((name, value)) = pairs.next_entry()? {
                all.insert(name, Value::String(value));
            }
            Ok(all)
        }
    }
    from.deserialize_map(Strings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::exr::to_bytes;
    use crate::export::sha256_hex;
    use crate::table::samples::{grey_2d, rgb_1d, scalar};

    fn manifest() -> Manifest {
        let entry = |table: Table| {
            let bytes = to_bytes(&table).unwrap();
            let file = format!("{}.exr", table.id);
            let materials: &[String] = match table.axes.len() {
                0 => &[],
                _ => &["Größe 17, \"poliert\"".into(), "gold".into()],
            };
            TableEntry::new(&table, file, bytes.len() as u64, sha256_hex(&bytes), materials)
        };
        let tables = [scalar(), rgb_1d(), grey_2d()].map(entry).to_vec();
        let requests = BTreeMap::from([("gold".into(), "0123".into())]);
        Manifest::new(
            "figure 7",
            u64::MAX,
            &["gold".into(), "lambert".into()],
            tables,
            requests,
        )
    }

    #[test]
    fn facts_come_back_bit_by_bit_and_the_text_is_stable() {
        let json = manifest().to_json().unwrap();
        assert_eq!(Manifest::from_json(&json).unwrap(), manifest());
        assert!((0..20).all(|_| manifest().to_json().unwrap() == json));
        assert!(json.contains("\"between\": null"), "{json}");
        assert!(json.contains("\"shader\": \"u = sqrt(mu)\""));
        assert!(json.contains("\"formula\": \"a = b\\n= c\""));
        assert!(json.ends_with("}\n"));
    }

    #[test]
    fn materials_list_their_tables() {
        let materials = manifest().materials;
        assert_eq!(materials[0].tables, ["gold", "vmf.rho_hd"]);
        assert_eq!(materials[1].tables, [""; 0]);
    }

    #[test]
    fn damaged_manifests_are_refused() {
        let json = manifest().to_json().unwrap();
        for cut in (0..json.len() - 2).step_by(7) {
            if let Some(part) = json.get(..cut) {
                assert!(Manifest::from_json(part).is_err());
            }
        }
    }
}
