//! Scenes of every format, and what has to be true of those that are taken.

use crate::targets::{directions, text};
use std::collections::HashSet;
use std::convert::Infallible;
use whitefurnace::bxdf::{Bxdf, Model, Needs};
use whitefurnace::plan::{Plan, Request};
use whitefurnace::printable::is_hidden;
use whitefurnace::scene::{Effect, Material, ModelSpec, Scene, SceneError};

/// Longest text about a material, in characters: two statements with a quotation each, or a sentence with some numbers.
const LONGEST_TEXT: usize = 1000;

pub(crate) fn scene(bytes: &[u8]) -> Result<String, String> {
    // names of files are relative to the directory of the package, where tests run
    taken(Scene::parse(text(bytes)?, "fuzz.toml"))
}

pub(crate) fn gltf(bytes: &[u8]) -> Result<String, String> {
    taken(Scene::parse_gltf(bytes, "fuzz.gltf"))
}

pub(crate) fn glb(bytes: &[u8]) -> Result<String, String> {
    taken(Scene::parse_gltf(bytes, "fuzz.glb"))
}

pub(crate) fn pbrt(bytes: &[u8]) -> Result<String, String> {
    taken(Scene::parse_pbrt(text(bytes)?, "fuzz.pbrt"))
}

/// Looks at a scene, unless it was refused.
fn taken(read: Result<Scene, SceneError>) -> Result<String, String> {
    let scene = read.map_err(|error| error.to_string())?;
    let names: HashSet<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names.len(), scene.materials.len(), "names differ");
    assert!(!scene.name.trim().is_empty() && names.iter().all(|name| !name.trim().is_empty()));
    assert!(
        scene.warnings.iter().all(|warning| is_readable(warning)),
        "{:?}",
        scene.warnings
    );
    scene.materials.iter().for_each(well_told);
    let mut models: Vec<&ModelSpec> = scene.materials.iter().map(|material| &material.model).collect();
    // a short text makes many of the same
    models.dedup();
    models.into_iter().for_each(well);
    let request = Request::default();
    let plan = Plan::new(&scene, &request).expect("a scene that is taken has a plan");
    let ids: HashSet<&str> = plan.tables.iter().map(|table| table.id.as_str()).collect();
    assert_eq!(ids.len(), plan.tables.len(), "every table has a file of its own");
    for id in ids {
        let safe = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._-".contains(c);
        assert!(
            id.chars().all(safe) && id.len() < 120 && !id.starts_with(['.', '-']) && !id.contains(".."),
            "{id}"
        );
    }
    Ok(kinds(&scene))
}

/// Whether `text` can be shown as it is.
fn is_readable(text: &str) -> bool {
    !text.trim().is_empty() && !text.contains(is_hidden) && text.chars().count() < LONGEST_TEXT
}

/// Whether what a material calls for and leaves out is told in order and in texts that can be shown.
fn well_told(material: &Material) {
    let order = material.calls.iter().map(|call| {
        assert!(is_readable(&call.by), "{call:?}");
        Effect::ALL.iter().position(|effect| *effect == call.effect)
    });
    assert!(order.is_sorted_by(|a, b| a < b), "{:?}", material.calls);
    for gap in &material.gaps {
        assert!(is_readable(&gap.what) && is_readable(&gap.why), "{gap:?}");
    }
}

/// The types of the first materials, and what all of them call for.
fn kinds(scene: &Scene) -> String {
    let mut words: Vec<&str> = scene
        .materials
        .iter()
        .map(|material| material.model.type_name())
        .take(4)
        .collect();
    let calls = scene.materials.iter().flat_map(|material| &material.calls);
    let called: HashSet<Effect> = calls.map(|call| call.effect).collect();
    // in few letters, as the beginning of the words tells answers apart
    words.extend(
        Effect::ALL
            .iter()
            .filter(|effect| called.contains(effect))
            .map(|effect| &effect.name()[..3]),
    );
    words.join(" ")
}

/// Whether a model describes itself and has values that are numbers, at both ends of its range.
fn well(spec: &ModelSpec) {
    let facts = spec.describe();
    assert!(
        facts.iter().all(|(key, value)| !key.is_empty() && !value.is_empty()),
        "{facts:?}"
    );
    let ends = match spec.roughness_range() {
        Some((_, min, max)) => {
            assert!(min < max && min >= 0.0 && max.is_finite());
            vec![Some(min), Some(max)]
        }
        None => vec![None],
    };
    for roughness in ends {
        let model = spec.at(roughness).expect("both ends of a range are legal");
        let bxdf = uncoupled(&model);
        for (wo, wi) in directions().iter().flat_map(|wo| directions().map(|wi| (*wo, wi))) {
            let f = bxdf.f(wo, wi);
            assert!(
                f.is_finite() && f.min_element() >= 0.0,
                "{facts:?}: f({wo}, {wi}) = {f}"
            );
        }
    }
}

/// The model, its specular lobe in place of a coupling and its base in place of layers, which would have to be integrated first.
fn uncoupled(model: &Model) -> Box<dyn Bxdf + '_> {
    let specular = |needs| {
        Ok::<_, Infallible>(match needs {
            Needs::Coupling(coupled) => uncoupled(coupled.specular()),
            Needs::Layers(layered) => uncoupled(layered.base()),
        })
    };
    model.as_bxdf(&specular).unwrap_or_else(|never| match never {})
}
