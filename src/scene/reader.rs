//! From the tables of a scene file to its materials.

use super::bxdfs::{BXDF_RULE, material_bxdf};
use super::error::SceneError;
use super::table::Table;
use super::text::Text;
use super::{MOST_MATERIALS, Material, Scene, stem, too_large};
use std::collections::HashMap;
use toml::de::DeTable;

/// Reads the scene in `content`, which `source` names.
pub(super) fn scene(content: &str, source: &str) -> Result<Scene, SceneError> {
    let text = Text::new(source, content);
    let root = DeTable::parse(text.content()).map_err(|error| syntax_error(&text, &error))?;
    let root = Table::new(&text, root.get_ref(), 0..0);
    root.only("a scene", &["scene", "material"])?;
    Ok(Scene {
        source: source.to_owned(),
        ..Scene::new(scene_name(&root, source)?, materials(&root, source)?)
    })
}

fn syntax_error(text: &Text<'_>, error: &toml::de::Error) -> SceneError {
    // the limit on dotted keys is the one complaint that comes without a place; the line with the most dots exceeds it
    let span = error.span().unwrap_or_else(|| {
        let lines = text.content().split_inclusive('\n').scan(0, |end, line| {
            let start = *end;
            *end += line.len();
            Some((line.bytes().filter(|byte| *byte == b'.').count(), start))
        });
        let (_, start) = lines.max_by_key(|(dots, _)| *dots).unwrap_or_default();
        start..start
    });
    text.refuse(span, format!("not valid TOML: {}", error.message()))
}

fn scene_name(root: &Table<'_>, source: &str) -> Result<String, SceneError> {
    if let Some(entry) = root.optional("scene") {
        let table = entry.table(&"scene is one table, [scene]")?;
        table.only("[scene]", &["name"])?;
        if let Some(name) = table.optional("name") {
            return Ok(name.name()?.to_owned());
        }
    }
    Ok(stem(source))
}

fn materials(root: &Table<'_>, source: &str) -> Result<Vec<Material>, SceneError> {
    const RULE: &str = "a scene holds at least one [[material]], each with name and bxdf";
    let entry = root.required("material", &RULE)?;
    let mut materials = Vec::new();
    let mut lines = HashMap::new();
    for element in entry.elements(&"materials are tables, each under a header [[material]]")? {
        if materials.len() == MOST_MATERIALS {
            return Err(too_large(source, "materials", MOST_MATERIALS));
        }
        let table = element.table(&"materials are tables with name and bxdf")?;
        table.only("[[material]]", &["name", "bxdf"])?;
        let name = table.required("name", &"every material has a name of its own")?;
        let material = Material {
            line: Some(table.line()),
            ..Material::new(name.name()?, material_bxdf(table.required("bxdf", &BXDF_RULE)?)?)
        };
        if let Some(line) = lines.insert(name.name()?, table.line()) {
            let verdict = format!("is not allowed: the material at line {line} has that name already");
            return Err(name.refuse(verdict));
        }
        materials.push(material);
    }
    if materials.is_empty() {
        return Err(entry.refuse(format!("is not allowed: {RULE}")));
    }
    Ok(materials)
}
