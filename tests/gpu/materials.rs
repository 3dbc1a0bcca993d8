//! The albedos that shaders of a scene give are those of its materials.

use crate::device::gpu;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Target, fill};
use whitefurnace::plan::{Plan, Request, Source};
use whitefurnace::scene::Scene;
use whitefurnace::shader::{Language, SceneShader};
use whitefurnace::table::texture::Texture;
use whitefurnace::table::{Lobe, Storage, Table};

/// One of each kind of closed form, beside the materials of the built-in scene.
const CLOSED: &str = r#"
[[material]]
name = "glass from within"
bxdf = { type = "fresnel-specular", eta_a = 1.5, eta_b = 1.0, reflectance = 0.9, transmittance = [0.9, 0.8, 0.7], transport = "radiance" }
[[material]]
name = "window"
bxdf = { type = "specular-transmission", eta_b = 1.33 }
[[material]]
name = "mirror"
bxdf = { type = "scaled", scale = 0.5, bxdf = { type = "specular-reflection", fresnel = { type = "conductor", eta = [0.2, 0.9, 1.1], k = [3.9, 2.4, 2.2] } } }
[[material]]
name = "leaf"
bxdf = { type = "sum", bxdfs = [{ type = "oren-nayar", reflectance = [0.1, 0.4, 0.2], sigma_deg = 25.0 }, { type = "brdf-to-btdf", bxdf = { type = "lambertian", reflectance = 0.3 } }] }
[[material]]
name = "clay"
[material.bxdf]
type = "scaled"
scale = [0.9, 0.8, 0.7]
bxdf = { type = "diffuse-specular", coupling = "energy-preserving", ks = [0.5, 0.7, 0.9], kd = [0.2, 0.5, 0.8], specular = { type = "microfacet", distribution = { type = "ggx", alpha = 0.4 }, masking = "smith", fresnel = { type = "schlick", r0 = [0.1, 0.5, 0.9] }, reflectance = 0.8 } }
"#;

#[test]
fn albedos_are_those_of_the_materials() {
    let Some(gpu) = gpu() else { return };
    if !gpu.filters(Storage::F32) {
        return;
    }
    let mut compared = 0;
    for scene in [Scene::default_scene(), Scene::parse(CLOSED, "closed.toml").unwrap()] {
        let mut plan = Plan::new(&scene, &Request::default()).unwrap();
        let tables: Vec<Table> = plan.tables.iter().map(|table| fill(table, &|_| {}).unwrap()).collect();
        for (plan, table) in plan.tables.iter_mut().zip(&tables) {
            plan.alternatives = vec![table.axes.clone()];
        }
        let textures: Vec<Texture> = tables
            .iter()
            .map(|table| Texture::of(table, Storage::F32).unwrap())
            .collect();
        let shader = SceneShader::new(&plan);
        let wgsl = shader.text(Language::Wgsl).unwrap();
        for (index, (name, functions)) in shader.materials.iter().enumerate() {
            let model = scene.materials[index].model.at(Some(17.0)).unwrap();
            for function in functions.iter().filter(|function| function.name.starts_with("albedo_")) {
                let side = match function.name.starts_with("albedo_reflection_") {
                    true => Lobe::Reflection,
                    false => Lobe::Transmission,
                };
                // 17 is within the range of the one material that has one, and an azimuth that is not 0
                let rest = function
                    .arguments
                    .iter()
                    .skip(1)
                    .map(|argument| match argument.as_str() {
                        "phi" => ", 0.4",
                        _ => ", 17.0",
                    });
                let call = format!("{}(inputs[i]{})", function.name, rest.collect::<String>());
                let body = format!(
                    "let rho = {call};\n    outputs[3u * i] = rho.x;\n    outputs[3u * i + 1u] = rho.y;\n    \
                     outputs[3u * i + 2u] = rho.z;"
                );
                let sources = plan.materials[index].terms.iter().filter(|term| term.lobe == side);
                let sources: Vec<&Source> = sources
                    .flat_map(|term| [Some(&term.albedo), term.mean.as_ref()])
                    .flatten()
                    .collect();
                let mut used = Vec::new();
                for (number, table) in tables.iter().enumerate() {
                    let is_source = |source: &&&Source| matches!(source, Source::Table { id, .. } if *id == table.id);
                    // a function that does not call for a mean has no binding for it
                    let is_called = calls(&wgsl, &function.name, &shader.tables[number].sampler.function);
                    if sources.iter().any(|source| is_source(&source)) && is_called {
                        used.push((number, &textures[number]));
                    }
                }
                let inputs: Vec<f32> = (0..40).map(|i| (i as f32 + 0.5) / 40.0).collect();
                let found = gpu.run(&wgsl, &body, &used, &inputs, (40, 120));
                // every albedo enters with a slope of at most 1, and the mean with one as well; then f32
                let stated: f64 = used.iter().map(|(number, _)| tables[*number].max_lookup_error()).sum();
                for (mu, found) in inputs.iter().zip(found.chunks(3)) {
                    let target = Target::rho_hd(f64::from(*mu), 0.4).of(side);
                    let expected = quadrature(&model, target, 1e-6).unwrap().value.to_array();
                    for (found, expected) in found.iter().zip(expected) {
                        let off = (f64::from(*found) - expected).abs();
                        assert!(
                            off <= stated + 5e-6,
                            "{name} {call} {mu}: {found} and {expected}, {stated:e} stated"
                        );
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 120 * 15, "{compared}");
}

/// Whether the body of the function `name` calls `other`.
fn calls(wgsl: &str, name: &str, other: &str) -> bool {
    let start = wgsl.find(&format!("fn {name}(")).unwrap();
    let body = &wgsl[start..];
    body[..body.find("\n}\n").unwrap()].contains(&format!("{other}("))
}
