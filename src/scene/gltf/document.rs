//! What a file holds besides its materials: whether it is glTF 2, which extensions it declares, and what is out of place.

use super::node::Keep;
use super::place::{At, Notes, Problem, quote};
use super::vocabulary::VARIANTS;
use std::collections::HashSet;

const ELSEWHERE: Keep = Keep::Each(&Keep::Only(&[("extensions", Keep::Names)]));

/// What is kept of a file.
pub(super) const ROOT: Keep = Keep::Only(&[
    ("asset", Keep::All),
    ("extensions", Keep::Names),
    ("extensionsUsed", Keep::All),
    ("extensionsRequired", Keep::All),
    ("materials", Keep::All),
    (
        "meshes",
        Keep::Each(&Keep::Only(&[("primitives", Keep::Each(&PRIMITIVE))])),
    ),
    ("accessors", ELSEWHERE),
    ("animations", ELSEWHERE),
    ("buffers", ELSEWHERE),
    ("bufferViews", ELSEWHERE),
    ("cameras", ELSEWHERE),
    ("images", ELSEWHERE),
    ("nodes", ELSEWHERE),
    ("samplers", ELSEWHERE),
    ("scenes", ELSEWHERE),
    ("skins", ELSEWHERE),
    ("textures", ELSEWHERE),
]);

const PRIMITIVE: Keep = Keep::Only(&[
    ("material", Keep::Kind),
    ("attributes", Keep::Only(&[("TANGENT", Keep::Kind)])),
    (
        "extensions",
        Keep::Only(&[(
            VARIANTS,
            Keep::Only(&[("mappings", Keep::Each(&Keep::Only(&[("material", Keep::Kind)])))]),
        )]),
    ),
]);

/// Parts of a file that no material depends on but for what they are named after.
const COLLECTIONS: [&str; 11] = [
    "accessors",
    "animations",
    "buffers",
    "bufferViews",
    "cameras",
    "images",
    "nodes",
    "samplers",
    "scenes",
    "skins",
    "textures",
];

/// Extensions that may be required without changing what a material is made of: how meshes and textures are stored, and what
/// this reader knows.
const HARMLESS: [&str; 12] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    VARIANTS,
];

/// The file as materials see it.
pub(super) struct Document<'d> {
    /// How many textures there are.
    pub(super) textures: usize,
    /// The extensions that the file says it uses.
    pub(super) declared: HashSet<&'d str>,
}

/// Looks at all but materials and meshes; `known` are the extensions of materials that this reader knows.
pub(super) fn document<'d>(root: &At<'d>, known: &[&str], notes: &mut Notes) -> Result<Document<'d>, Problem> {
    root.object()
        .map_err(|_| Problem::new("the file", format!("holds {}, and a glTF an object", root.node.kind())))?;
    version(root)?;
    let declared = names(root, "extensionsUsed", notes);
    let required = names(root, "extensionsRequired", notes);
    let harmless: HashSet<&str> = known.iter().chain(&HARMLESS).copied().collect();
    for name in required {
        let place = format!("extensionsRequired holds \"{}\",", quote(name));
        if !declared.contains(name) {
            notes.add(&place, "which extensionsUsed does not");
        }
        if !harmless.contains(name) {
            notes.add(&place, "which is not known: what it changes is left out");
        }
    }
    root_extensions(root, &declared, notes);
    for name in COLLECTIONS {
        if let Some(at) = root.get(name) {
            collection(&at, notes);
        }
    }
    let textures = root.get("textures").and_then(|at| Some(at.elements().ok()?.len()));
    Ok(Document {
        textures: textures.unwrap_or(0),
        declared,
    })
}

/// Materials of glTF 1 are other things under the same names, and those of a later one are not known.
fn version(root: &At<'_>) -> Result<(), Problem> {
    const WANTED: &str = "asset.version is \"2.0\"";
    let missing = |what: &str| Problem::new(what, format!("is missing, which is not allowed: {WANTED}"));
    let asset = root.get("asset").ok_or_else(|| missing("asset"))?;
    asset.object()?;
    let version = asset.get("version").ok_or_else(|| missing("asset.version"))?;
    let refuse = |at: &At<'_>, text| {
        let message = format!("= \"{}\" is not allowed: only glTF 2 is known", quote(text));
        Err(Problem::new(&*at.place, message))
    };
    let text = version.text()?;
    match numbers(text) {
        Some((2, _)) => {}
        _ => return refuse(&version, text),
    }
    // later minor versions may be read as 2.0 unless they say otherwise
    if let Some(least) = asset.get("minVersion") {
        let text = least.text()?;
        if numbers(text).is_none_or(|least| least > (2, 0)) {
            return refuse(&least, text);
        }
    }
    Ok(())
}

/// The two numbers of a version.
fn numbers(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.')?;
    let number = |text: &str| {
        text.bytes()
            .all(|byte| byte.is_ascii_digit())
            .then(|| text.parse().ok())?
    };
    Some((number(major)?, number(minor)?))
}

/// The different strings in the array `name`.
fn names<'d>(root: &At<'d>, name: &str, notes: &mut Notes) -> HashSet<&'d str> {
    let mut found = HashSet::new();
    let Some(at) = root.get(name) else { return found };
    match at.elements() {
        Err(problem) => notes.excuse(&problem, PASSED_OVER),
        Ok(elements) => {
            for element in elements {
                match element.text() {
                    Err(problem) => notes.excuse(&problem, PASSED_OVER),
                    Ok(text) if !found.insert(text) => {
                        notes.add(&element.place, &format!("= \"{}\" stands there already", quote(text)));
                    }
                    Ok(_) => {}
                }
            }
        }
    }
    found
}

/// Why something wrong is no error.
pub(super) const PASSED_OVER: &str = "it was passed over, as no material depends on it";

fn root_extensions(root: &At<'_>, declared: &HashSet<&str>, notes: &mut Notes) {
    let Some(extensions) = root.get("extensions") else {
        return;
    };
    match extensions.object() {
        Err(problem) => notes.excuse(&problem, PASSED_OVER),
        Ok(members) => {
            for (name, node) in members {
                let at = At::new(node, format!("extensions.{}", quote(name)));
                if !declared.contains(name.as_str()) {
                    notes.add(&at.place, "is not declared in extensionsUsed");
                }
                if let Err(problem) = at.object() {
                    notes.excuse(&problem, PASSED_OVER);
                }
            }
        }
    }
}

fn collection(at: &At<'_>, notes: &mut Notes) {
    match at.elements() {
        Err(problem) => notes.excuse(&problem, PASSED_OVER),
        Ok(elements) => {
            for element in elements {
                match element.object() {
                    Err(problem) => notes.excuse(&problem, PASSED_OVER),
                    Ok(_) => misplaced(&element, notes),
                }
            }
        }
    }
}

/// Notes extensions of materials on what is no material.
pub(super) fn misplaced(at: &At<'_>, notes: &mut Notes) {
    let Some(extensions) = at.get("extensions") else { return };
    let Ok(members) = extensions.object() else {
        notes.add(&extensions.place, "is no object; it was passed over");
        return;
    };
    for (name, _) in members.iter().filter(|(name, _)| name.starts_with("KHR_materials_")) {
        let place = format!("{}.{}", extensions.place, quote(name));
        notes.add(&place, "is out of place: it belongs to a material; it was passed over");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_have_two_numbers() {
        assert_eq!(numbers("2.0"), Some((2, 0)));
        assert_eq!(numbers("2.10"), Some((2, 10)));
        for odd in ["", "2", "2.", ".0", "2.0.0", "+2.0", "2.-1", "2.99999999999", "two.0"] {
            assert_eq!(numbers(odd), None, "{odd}");
        }
    }
}
