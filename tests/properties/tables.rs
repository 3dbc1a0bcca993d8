//! Small tables of random models, from the text of a scene to texels.

use crate::strategies::{log_uniform, parameter};
use crate::{check, ensure};
use proptest::prelude::*;
use proptest::sample::select;
use whitefurnace::estimate::Estimator;
use whitefurnace::integrate::{FillError, IntegrateError, fill, texels};
use whitefurnace::parameter::{BECKMANN_M, GGX_ALPHA};
use whitefurnace::parameter::{ETA, EXTINCTION, KAPPA, PHONG_N};
use whitefurnace::plan::{Economy, Plan, Request};
use whitefurnace::scene::Scene;
use whitefurnace::table::{Storage, Table};

fn request(tolerance: f64) -> Request {
    Request {
        resolution: 4,
        roughness_resolution: 2,
        azimuth_resolution: 2,
        mapping: None,
        estimator: Estimator::Auto,
        tolerance: Some(tolerance),
        samples: None,
        seed: 0,
        economy: Economy::FULL,
    }
}

/// A lobe with its masking, as scenes write them.
fn lobe() -> BoxedStrategy<String> {
    let anything = select(vec!["v-groove"]);
    let slopes = || select(vec!["v-groove", "smith", "smith-correlated"]);
    let one = |name: &'static str, key: &'static str, legal| {
        parameter(legal).prop_map(move |x| format!("{{ type = \"{name}\", {key} = {x:e} }}"))
    };
    let two = |name: &'static str, [x, y]: [&'static str; 2], legal| {
        (parameter(legal), parameter(legal))
            .prop_map(move |(a, b)| format!("{{ type = \"{name}\", {x} = {a:e}, {y} = {b:e} }}"))
    };
    let with =
        |(distribution, masking): (String, &str)| format!("distribution = {distribution}\nmasking = \"{masking}\"");
    prop_oneof![
        2 => (one("vmf", "kappa", KAPPA), anything.clone()).prop_map(with),
        2 => (one("phong", "n", PHONG_N), anything.clone()).prop_map(with),
        2 => (one("beckmann", "m", BECKMANN_M), slopes()).prop_map(with),
        2 => (one("ggx", "alpha", GGX_ALPHA), slopes()).prop_map(with),
        1 => (two("ggx", ["alpha_x", "alpha_y"], GGX_ALPHA), slopes()).prop_map(with),
        1 => (two("ashikhmin-shirley", ["e_x", "e_y"], PHONG_N), anything).prop_map(with),
    ]
    .boxed()
}

/// A material of such a lobe, alone or over a base, that conserves energy.
fn material() -> BoxedStrategy<String> {
    let fresnel = prop_oneof![
        Just("\"none\"".to_owned()),
        parameter(ETA).prop_map(|eta| format!("{{ type = \"dielectric\", eta = {eta:e} }}")),
        (parameter(ETA), parameter(EXTINCTION))
            .prop_map(|(eta, k)| format!("{{ type = \"conductor\", eta = {eta:e}, k = {k:e} }}")),
        (0.0..=1.0).prop_map(|r0| format!("{{ type = \"schlick\", r0 = {r0:e} }}")),
    ];
    let coupling = select(vec!["", "mikkelsen", "energy-preserving"]);
    (lobe(), fresnel, coupling, 0.0..=1.0)
        .prop_map(|(lobe, fresnel, coupling, kd)| {
            let lobe = format!("type = \"microfacet\"\n{lobe}\nfresnel = {fresnel}\n");
            if coupling.is_empty() {
                return format!("[material.bxdf]\n{lobe}");
            }
            format!(
                "[material.bxdf]\ntype = \"diffuse-specular\"\ncoupling = \"{coupling}\"\nks = 1.0\nkd = {kd:e}\n\
                 [material.bxdf.specular]\n{lobe}"
            )
        })
        .boxed()
}

fn scene(material: &str) -> Scene {
    let text = format!("[scene]\nname = \"random\"\n[[material]]\nname = \"m\"\n{material}")
        .replace("\"none\"", "{ type = \"none\" }");
    Scene::parse(&text, "random.toml").unwrap()
}

/// A table of a single texel.
pub(crate) fn one_texel() -> Table {
    static TABLE: std::sync::LazyLock<Table> = std::sync::LazyLock::new(|| {
        let scene = scene(
            "[material.bxdf]\ntype = \"microfacet\"\ndistribution = { type = \"vmf\", kappa = 3.0 }\nmasking = \"v-groove\"\nfresnel = \"none\"\n",
        );
        let tables = Plan::new(&scene, &request(1e-3)).unwrap().tables;
        let single = tables.iter().find(|table| table.texels() == 1).unwrap();
        fill(single, &|_| {}).unwrap()
    });
    TABLE.clone()
}

/// Texels lie in [0, 1] within their errors, errors are finite and within the tolerance, and every format states its rounding.
#[test]
fn tables_of_models_that_conserve_energy_stay_below_one() {
    check(24, &(material(), log_uniform(-6.0, -2.0)), |(material, tolerance)| {
        let scene = scene(&material);
        for plan in Plan::new(&scene, &request(tolerance)).unwrap().tables {
            let is_streak = material.contains("_x");
            // means over streaks take minutes, and so do places between the texels of two axes: one direction at a time does
            if is_streak && (plan.texels() == 1 || material.contains("coupling")) {
                continue;
            }
            let filled = if is_streak {
                texels(&plan, &plan.alternatives[0], &|_| {})
            } else {
                fill(&plan, &|_| {})
            };
            let table = match filled {
                Ok(table) => table,
                Err(FillError::Integral {
                    at,
                    source: IntegrateError::NotConverged(failure),
                    ..
                }) => {
                    ensure!(tolerance < 1e-4, "{} at {at}: {failure}", plan.id);
                    continue;
                }
                Err(error) => return Err(TestCaseError::fail(error.to_string())),
            };
            ensure!(
                table.energy_excess().is_none(),
                "{}: {:?}",
                plan.id,
                table.energy_excess()
            );
            for i in 0..table.values.len() {
                let (stored, error) = (table.stored(i), table.texel_error(i));
                ensure!(
                    stored.is_finite() && error.is_finite() && (stored + error).min_element() >= 0.0,
                    "{} texel {i}: {stored:?} +- {error:?}",
                    plan.id
                );
                // and the rounding to f32, itself rounded up
                let most = tolerance + 2f64.powi(-24) + 1e-13;
                ensure!(
                    error.max_element() <= most * (1.0 + 2e-7),
                    "{} texel {i}: {error:?}",
                    plan.id
                );
            }
            if let Some(between) = &table.between {
                ensure!(
                    between.error.is_finite() && between.error >= 0.0,
                    "{}: {between:?}",
                    plan.id
                );
            }
            ensure!(table.fits(Storage::F16), "{}", plan.id);
        }
        Ok(())
    });
}
