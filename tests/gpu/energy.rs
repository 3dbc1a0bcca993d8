//! What the shader's own BRDFs reflect, integrated on the GPU.

use crate::device::{Gpu, gpu};
use std::f64::consts::{FRAC_PI_2, TAU};
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Target, fill};
use whitefurnace::plan::{Plan, Request};
use whitefurnace::scene::Scene;
use whitefurnace::shader::{Language, SceneShader};
use whitefurnace::table::texture::Texture;
use whitefurnace::table::{Storage, Table};

fn material(name: &str, coupling: &str, alpha: f64) -> String {
    format!(
        "[[material]]\nname = \"{name}\"\nbxdf = {{ type = \"diffuse-specular\", coupling = \"{coupling}\", ks = 1.0, kd = 1.0, \
         specular = {{ type = \"microfacet\", distribution = {{ type = \"ggx\", alpha = {alpha:?} }}, masking = \
         \"smith-correlated\", fresnel = {{ type = \"schlick\", r0 = [0.9, 0.5, 0.04] }} }} }}\n"
    )
}

/// Cosines of wo.
const MUS: [f64; 8] = [0.05, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0];

/// int f cos dwi for each of [`MUS`] and three channels, by the midpoint rule over `rings` polar angles and 256 azimuths, where a
/// periodic function leaves nothing; `f` is an expression in wo and wi.
fn reflected(gpu: &Gpu, wgsl: &str, f: &str, textures: &[(usize, &Texture)], rings: usize) -> Vec<[f64; 3]> {
    let mut inputs: Vec<f32> = Vec::new();
    let step = FRAC_PI_2 / rings as f64;
    for mu in MUS {
        for ring in 0..rings {
            let (sin, cos) = ((ring as f64 + 0.5) * step).sin_cos();
            inputs.extend([mu, sin, cos].map(|value| value as f32));
        }
    }
    let body = format!(
        "let mu = inputs[3u * i];\n    let wo = vec3f(sqrt((1.0 - mu) * (1.0 + mu)), 0.0, mu);\n    \
         let sine = inputs[3u * i + 1u];\n    let cosine = inputs[3u * i + 2u];\n    var sum = vec3f(0.0);\n    \
         for (var k = 0u; k < 256u; k++) {{\n        let phi = (f32(k) + 0.5) * (6.2831853 / 256.0);\n        \
         let wi = vec3f(sine * cos(phi), sine * sin(phi), cosine);\n        sum += {f};\n    }}\n    \
         sum = sum * (cosine * sine / 256.0);\n    outputs[3u * i] = sum.x;\n    outputs[3u * i + 1u] = sum.y;\n    \
         outputs[3u * i + 2u] = sum.z;"
    );
    let count = MUS.len() * rings;
    let sums = gpu.run(wgsl, &body, textures, &inputs, (count, 3 * count));
    let of_mu = sums.chunks(3 * rings).map(|rings| {
        let mut total = [0.0; 3];
        for ring in rings.chunks(3) {
            for (total, part) in total.iter_mut().zip(ring) {
                *total += TAU * step * f64::from(*part);
            }
        }
        total
    });
    of_mu.collect()
}

#[test]
fn energy_is_conserved_as_stated() {
    let Some(gpu) = gpu() else { return };
    if !gpu.filters(Storage::F32) {
        return;
    }
    for alpha in [0.3, 0.8] {
        let text = material("whole", "energy-preserving", alpha) + &material("printed", "mikkelsen", alpha);
        let scene = Scene::parse(&text, "energy.toml").unwrap();
        let mut plan = Plan::new(&scene, &Request::default()).unwrap();
        let tables: Vec<Table> = plan.tables.iter().map(|table| fill(table, &|_| {}).unwrap()).collect();
        for (plan, table) in plan.tables.iter_mut().zip(&tables) {
            plan.alternatives = vec![table.axes.clone()];
        }
        let shader = SceneShader::new(&plan);
        let wgsl = shader.text(Language::Wgsl).unwrap();
        let textures: Vec<Texture> = tables
            .iter()
            .map(|table| Texture::of(table, Storage::F32).unwrap())
            .collect();
        let used: Vec<(usize, &Texture)> = textures.iter().enumerate().collect();
        let [albedo, mean] = &shader.tables[..] else {
            panic!("{} tables", shader.tables.len())
        };
        let (albedo, mean) = (&albedo.sampler.function, &mean.sampler.function);
        let lobe = format!(
            "furnace_f(FurnaceLobe(FURNACE_GGX, FURNACE_SMITH_CORRELATED, FURNACE_FRESNEL_NONE, {alpha:?}, vec3f(1.0), \
             vec3f(0.0), vec3f(0.0)), wo, wi)"
        );
        let e = |direction: &str| format!("{albedo}({direction}.z).y");
        let kulla_conty = format!(
            "{lobe} + furnace_kulla_conty(vec3f(1.0), {}, {}, {mean}().y)",
            e("wo"),
            e("wi")
        );
        let turquin = format!("{lobe} * furnace_turquin(vec3f(1.0), {})", e("wo"));
        // stated errors of lookups; the mean is a single texel
        let delta = tables[0].max_lookup_error();
        let delta_mean = tables[1].max_lookup_error();
        let e_mean = textures[1].lookup(&[0.5])[1];
        for (name, f, uses) in [
            ("energy-preserving", "brdf_whole(wo, wi)".to_owned(), &used[..]),
            ("mikkelsen", "brdf_printed(wo, wi)".to_owned(), &used[..]),
            ("kulla-conty", kulla_conty, &used[..]),
            ("turquin", turquin, &used[..1]),
        ] {
            let fine = reflected(gpu, &wgsl, &f, uses, 1024);
            let coarse = reflected(gpu, &wgsl, &f, uses, 512);
            for ((mu, fine), coarse) in MUS.iter().zip(&fine).zip(&coarse) {
                let expected = match name {
                    "mikkelsen" => {
                        let model = scene.materials[1].model.at(None).unwrap();
                        quadrature(&model, Target::rho_hd(*mu, 0.0), 1e-7)
                            .unwrap()
                            .value
                            .to_array()
                    }
                    _ => [1.0; 3],
                };
                let e_o = textures[0].lookup(&[*mu])[1];
                for channel in 0..3 {
                    // the bounds of tests/compensation.rs, in which 1 - E_avg stands for the smallest 1 - ks rho_bar
                    let bound = match name {
                        "turquin" => delta / e_o,
                        _ => delta + (delta + delta_mean) / (1.0 - e_mean),
                    };
                    // the midpoint rule errs like the square of its step, by less than the difference of both; f32 sums of
                    // 256 numbers, and BRDFs to 2e-6
                    let allowed = bound + (fine[channel] - coarse[channel]).abs() + 2e-5;
                    let off = (fine[channel] - expected[channel]).abs();
                    assert!(
                        off <= allowed,
                        "{name} alpha {alpha} mu {mu} channel {channel}: {} where {} is expected, {allowed:e} allowed",
                        fine[channel],
                        expected[channel]
                    );
                    assert!(allowed < 0.02, "{name}: {allowed}");
                    if name == "mikkelsen" && channel == 0 {
                        assert!(fine[channel] < 0.999, "{} is no deficit", fine[channel]);
                    }
                }
            }
            println!("{name} alpha {alpha}: {:?}", fine[0]);
        }
        // the lobe alone loses: what is tested above is not for nothing
        let alone = reflected(
            gpu,
            &wgsl,
            &(lobe.clone() + &format!(" + 0.0 * {}", e("wo"))),
            &used[..1],
            512,
        );
        assert!(alone[0][0] < 0.99, "{alone:?}");
    }
}
