//! The tables of an engine as `furnace bake --profile` wrote them.

use crate::cli::Failure;
use crate::cli::bake::DESCRIPTION;
use serde_json::Value;
use std::fs;
use std::path::Path;
use whitefurnace::engine::{Profile, Sizes};
use whitefurnace::printable::printable;
use whitefurnace::shader::TextureLayout;
use whitefurnace::table::axis::Axis;

/// The tables that profile.json in `directory` lists, with the sizes and the file names that it has for them.
pub(super) fn layouts_in(directory: &Path, profile: Profile) -> Result<Vec<TextureLayout>, Failure> {
    let path = directory.join(DESCRIPTION);
    let shown = path.display();
    let text = fs::read(&path).map_err(|error| format!("{shown} cannot be read: {error}; bake --profile writes it"))?;
    let value: Value = serde_json::from_slice(&text).map_err(|error| format!("{shown} is no description: {error}"))?;
    let name = value["profile"].as_str().unwrap_or_default();
    if name != profile.name() {
        let (name, wanted) = (printable(name), profile.name());
        return Err(format!(
            "{shown}: profile \"{name}\" is not \"{wanted}\": give --profile {name}, or another --tables"
        )
        .into());
    }
    let known = profile.layouts(Sizes::default())?;
    let tables = value["tables"].as_array().map_or(&[][..], Vec::as_slice);
    let layouts = tables.iter().map(|table| layout(table, &known, &path));
    layouts.collect()
}

fn layout(table: &Value, known: &[TextureLayout], path: &Path) -> Result<TextureLayout, Failure> {
    let id = table["id"].as_str().unwrap_or_default();
    let wrong = |what: String| format!("{}: table {}: {what}", path.display(), printable(id));
    let found = known.iter().find(|layout| layout.id == id);
    let mut layout = found
        .ok_or_else(|| wrong("is not one that this version knows".into()))?
        .clone();
    let axes = table["axes"].as_array().map_or(&[][..], Vec::as_slice);
    if axes.len() != layout.axes.len() {
        return Err(wrong(format!("axes: {} are not {}", axes.len(), layout.axes.len())).into());
    }
    for (index, (axis, described)) in layout.axes.iter_mut().zip(axes).enumerate() {
        let size = described["size"].as_u64().and_then(|size| usize::try_from(size).ok());
        let size = size.ok_or_else(|| wrong(format!("axes[{index}].size: missing, or no number of texels")))?;
        let Axis {
            parameter,
            mapping,
            rule,
            min,
            max,
            ..
        } = &axis.axis;
        let sized = Axis::new(parameter, *mapping, *rule, [*min, *max], size);
        axis.axis = sized.map_err(|error| wrong(format!("axes[{index}].size: {error}")))?;
    }
    let file = table["files"][0]["file"].as_str();
    layout.file = printable(file.ok_or_else(|| wrong("files: none".into()))?);
    Ok(layout)
}
