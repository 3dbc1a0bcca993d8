//! Which materials are in use.
//!
//! Those of primitives and of the variants of primitives; nodes and scenes are not asked, as a mesh is there to be placed. A
//! file without any primitive is a library, whose materials are there for others.

use super::document::PASSED_OVER;
use super::place::{At, Notes, Problem};
use super::vocabulary::VARIANTS;

/// How the primitives of a file use its materials.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Uses {
    /// Whether each material is in use.
    pub(super) used: Vec<bool>,
    /// How many primitives name no material, which gives them the default one.
    pub(super) nameless: usize,
    /// The first primitive of each material that has no tangents.
    pub(super) without_tangents: Vec<Option<String>>,
}

/// Looks through the meshes of a file with `count` materials.
///
/// What stands in the way of knowing the materials is a problem: an index of none, and meshes that are no meshes.
pub(super) fn uses(root: &At<'_>, count: usize, notes: &mut Notes) -> Result<Uses, Problem> {
    let mut uses = Uses {
        used: vec![false; count],
        nameless: 0,
        without_tangents: vec![None; count],
    };
    let mut primitives = 0_usize;
    if let Some(meshes) = root.get("meshes") {
        for mesh in meshes.elements()? {
            mesh.object()?;
            match mesh.get("primitives") {
                None => notes.add(&mesh.place, "has no primitives"),
                Some(of_mesh) => {
                    for primitive in of_mesh.elements()? {
                        primitives += 1;
                        uses.add(&primitive, notes)?;
                    }
                }
            }
        }
    }
    if primitives == 0 {
        uses.used.fill(true);
    }
    Ok(uses)
}

impl Uses {
    fn add(&mut self, primitive: &At<'_>, notes: &mut Notes) -> Result<(), Problem> {
        primitive.object()?;
        let count = self.used.len();
        match primitive.get("material") {
            None => self.nameless += 1,
            Some(material) => self.note(material.index(count, "materials")?, primitive),
        }
        let Some(extensions) = primitive.get("extensions") else {
            return Ok(());
        };
        if let Err(problem) = extensions.object() {
            notes.excuse(&problem, PASSED_OVER);
        }
        let Some(variants) = extensions.get(VARIANTS) else {
            return Ok(());
        };
        variants.object()?;
        let Some(mappings) = variants.get("mappings") else {
            notes.add(&variants.place, "has no mappings");
            return Ok(());
        };
        for mapping in mappings.elements()? {
            mapping.object()?;
            match mapping.get("material") {
                None => notes.add(&mapping.place, "names no material"),
                Some(material) => self.note(material.index(count, "materials")?, primitive),
            }
        }
        Ok(())
    }

    fn note(&mut self, material: usize, primitive: &At<'_>) {
        self.used[material] = true;
        let tangents = primitive
            .get("attributes")
            .and_then(|attributes| attributes.get("TANGENT"));
        if tangents.is_none() && self.without_tangents[material].is_none() {
            self.without_tangents[material] = Some(primitive.place.clone());
        }
    }
}
