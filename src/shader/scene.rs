//! The shader of a scene: its tables and its materials.

use super::materials::{MaterialFunction, Table, functions};
use super::pair;
use super::sampler::{Sampler, TextureLayout, identifiers, sampler_of};
use super::used::used;
use super::{LIBRARY, Language, ShaderError, translate};
use crate::plan::{Plan, TablePlan};
use crate::printable::printable;
use crate::spectrum::Channels;
use crate::table::axis::Axis;
use crate::table::texture::{Channel, TextureAxis};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Functions that sample the tables of a scene, and what its materials make of the samples.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneShader {
    /// The tables, in the order of their bindings.
    pub tables: Vec<TableSampler>,
    /// Functions of the materials: name of the material, its functions.
    pub materials: Vec<(String, Vec<MaterialFunction>)>,
    /// Tables, materials and what they use of the library, in WGSL, without the comment at the head.
    wgsl: String,
    /// Whose they are.
    title: String,
}

/// A table of a shader.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSampler {
    /// What is sampled.
    pub layout: TextureLayout,
    /// How.
    pub sampler: Sampler,
}

impl SceneShader {
    /// The shader of `plan`, whose tables have one choice of axes each: the first counts.
    pub fn new(plan: &Plan) -> Self {
        let tables = samplers(plan.tables.iter().map(layout).collect());
        let of_id = |table: &TableSampler| Table {
            sampler: table.sampler.clone(),
            channels: table.layout.channels.len(),
        };
        let by_id: BTreeMap<&str, Table> = tables
            .iter()
            .map(|table| (table.layout.id.as_str(), of_id(table)))
            .collect();
        let names = identifiers(plan.names());
        let mut own: String = tables.iter().flat_map(|table| ["\n", &table.sampler.wgsl]).collect();
        let mut materials = Vec::new();
        for (material, name) in plan.materials.iter().zip(&names) {
            let functions = functions(material, name, &by_id);
            own += &functions.wgsl;
            materials.push((material.name.clone(), functions.all));
        }
        // for every r0, whatever the materials have
        let always = match tables.iter().any(|table| table.layout.channels.len() == 2) {
            true => COMPENSATION,
            false => "",
        };
        Self {
            wgsl: used(LIBRARY, &(own.clone() + always)) + &own,
            tables,
            materials,
            title: format!("Tables and materials of the scene \"{}\"", printable(&plan.scene)),
        }
    }

    /// The shader of textures without materials, such as those of an engine: their lookups, and what makes albedos, compensation and
    /// the base of eq. 28 of what they read. `title` says whose they are.
    pub fn of_textures(title: &str, layouts: Vec<TextureLayout>) -> Self {
        let tables = samplers(layouts);
        let text = |table: &TableSampler| {
            format!(
                "\n{}{}",
                table.sampler.wgsl,
                pair::functions(&table.layout, &table.sampler)
            )
        };
        let own: String = tables.iter().map(text).collect();
        Self {
            wgsl: used(
                LIBRARY,
                &(own.clone() + " furnace_turquin furnace_kulla_conty furnace_base"),
            ) + &own,
            tables,
            materials: Vec::new(),
            title: printable(title),
        }
    }

    /// The text in `language`: functions, textures and constants, without an entry point.
    ///
    /// # Errors
    /// [`ShaderError`] when a name of an axis is a word of WGSL.
    pub fn text(&self, language: Language) -> Result<String, ShaderError> {
        translate(&(self.head(language) + &self.wgsl), language)
    }

    /// The comment at the head: which texture is bound where.
    fn head(&self, language: Language) -> String {
        let mut head = format!(
            "// {}, by {} {}.\n",
            self.title,
            crate::export::SOFTWARE,
            crate::export::VERSION
        );
        if self.tables.is_empty() {
            return head + "// No table is needed: closed forms say all.\n\n";
        }
        head += "//\n// Every texture: linear filter, clamp to edge, no mipmaps, not sRGB: one sampler serves all. Level 0 is\n// read, from any stage. A shader that uses few of the functions needs few of the textures; most systems bind 16.\n";
        head += "// Formats: 16-bit floats, or 32-bit floats where they can be filtered; rgba where there is none for rgb.\n";
        for TableSampler { layout, sampler } in &self.tables {
            let (index, texture) = (sampler.index, &sampler.texture);
            let place = match language {
                Language::Wgsl => format!("@group(0) @binding({}), sampler @binding({})", 2 * index, 2 * index + 1),
                Language::GlslEs => "uniform".to_owned(),
                Language::Glsl => format!("layout(binding = {index})"),
                Language::Hlsl => format!("register(t{index}), register(s{index})"),
                Language::Msl => "argument, with its sampler, of the functions that use it".to_owned(),
            };
            let size: Vec<String> = layout.axes.iter().map(|axis| axis.axis.size.to_string()).collect();
            let size = match &size[..] {
                [] => "1 x 1".to_owned(),
                [width] => format!("{width} x 1"),
                several => several.join(" x "),
            };
            let channels = match layout.channels.len() {
                1 => "r",
                2 => "rg",
                3 => "rgb",
                _ => "rgba",
            };
            let file = printable(&layout.file);
            let _ = writeln!(head, "//   {texture}: {file}, {size} texels, {channels}; {place}");
        }
        head + "\n"
    }
}

/// What a pair of albedos is good for, of the library.
const COMPENSATION: &str = " furnace_albedo_schlick furnace_scale_bias furnace_turquin furnace_kulla_conty";

fn samplers(layouts: Vec<TextureLayout>) -> Vec<TableSampler> {
    let names = identifiers(layouts.iter().map(|layout| layout.id.as_str()));
    let each = layouts.into_iter().zip(&names).enumerate();
    each.map(|(index, (layout, name))| TableSampler {
        sampler: sampler_of(&layout, name, index),
        layout,
    })
    .collect()
}

fn layout(table: &TablePlan) -> TextureLayout {
    let quantity = match table.quantity.name() {
        "rho_hd" => "rho_hd, the directional albedo",
        _ => "rho_hh, its cosine-weighted mean",
    };
    let named = |name: &str, meaning: String| Channel {
        name: name.into(),
        meaning,
    };
    let channels = match table.channels {
        Channels::Grey => vec![named("rho", quantity.into())],
        Channels::Pair => vec![
            named("rho0", format!("{quantity}, for r0 = 0 of Schlick's Fresnel term")),
            named("rho1", "the same for r0 = 1".into()),
        ],
        Channels::Rgb => ["red", "green", "blue"]
            .map(|name| named(name, format!("{quantity}, linear {name}")))
            .into(),
    };
    let axes: &[Axis] = table.alternatives.first().map_or(&[], Vec::as_slice);
    TextureLayout {
        id: table.id.clone(),
        file: format!("{}.exr", table.id),
        axes: axes.iter().cloned().map(TextureAxis::along).collect(),
        channels,
    }
}
