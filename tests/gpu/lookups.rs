//! What the generated functions read is what the texture holds there.

use crate::device::gpu;
use whitefurnace::integrate::fill;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::plan::{Plan, Request};
use whitefurnace::scene::Scene;
use whitefurnace::shader::{Language, SceneShader};
use whitefurnace::table::axis::Mapping;
use whitefurnace::table::texture::Texture;
use whitefurnace::table::{Storage, Table};

/// Tables of one, two and three channels, over one axis and two, with all mappings that plans choose.
const SCENE: &str = r#"
[[material]]
name = "smooth"
bxdf = { type = "microfacet", distribution = { type = "ggx", alpha = 0.05 }, masking = "smith-correlated", fresnel = { type = "schlick", r0 = 0.04 } }
[[material]]
name = "rough"
bxdf = { type = "microfacet", distribution = { type = "ggx", alpha = 1.0 }, masking = "smith-correlated", fresnel = { type = "schlick", r0 = [0.9, 0.6, 0.3] } }
[[material]]
name = "metal"
bxdf = { type = "microfacet", distribution = { type = "beckmann", m = 0.3 }, masking = "v-groove", fresnel = { type = "conductor", eta = [1.1978, 0.93, 0.66], k = [6.95, 6.4, 5.2] } }
[[material]]
name = "velvet 2"
bxdf = { type = "microfacet", distribution = { type = "vmf", kappa = { min = 0.0, max = 4096.0 } }, masking = "v-groove", fresnel = { type = "dielectric", eta = 1.5 } }
[[material]]
name = "slopes"
bxdf = { type = "microfacet", distribution = { type = "beckmann", m = { min = 0.01, max = 1.0 } }, masking = "smith", fresnel = { type = "none" } }
[[material]]
name = "brushed"
bxdf = { type = "microfacet", distribution = { type = "ggx", alpha_x = 0.1, alpha_y = 0.4 }, masking = "smith", fresnel = { type = "none" } }
"#;

fn tables() -> (Plan, Vec<Table>) {
    let scene = Scene::parse(SCENE, "gpu.toml").unwrap();
    let request = Request {
        resolution: 16,
        roughness_resolution: 9,
        azimuth_resolution: 4,
        tolerance: Some(1e-3),
        ..Request::default()
    };
    let mut plan = Plan::new(&scene, &request).unwrap();
    let tables: Vec<Table> = plan.tables.iter().map(|table| fill(table, &|_| {}).unwrap()).collect();
    for (plan, table) in plan.tables.iter_mut().zip(&tables) {
        plan.alternatives = vec![table.axes.clone()];
    }
    (plan, tables)
}

/// Largest difference of neighbours along each axis.
fn steps(texture: &Texture) -> Vec<f64> {
    let [width, height, depth] = texture.size();
    let mut steps = vec![0.0f64; texture.axes.len()];
    for (z, y, x) in (0..depth).flat_map(|z| (0..height).flat_map(move |y| (0..width).map(move |x| (z, y, x)))) {
        for (k, step) in steps.iter_mut().enumerate() {
            let mut next = [x, y, z];
            next[k] += 1;
            if next[k] < texture.size()[k] {
                let pairs = texture.texel([x, y, z]).iter().zip(texture.texel(next));
                *step = pairs.map(|(a, b)| (a - b).abs()).fold(*step, f64::max);
            }
        }
    }
    steps
}

#[test]
fn shaders_read_what_textures_hold() {
    let Some(gpu) = gpu() else { return };
    let (plan, tables) = tables();
    let shader = SceneShader::new(&plan);
    let wgsl = shader.text(Language::Wgsl).unwrap();
    let mut kinds = std::collections::BTreeSet::new();
    for (index, (table, sampled)) in tables.iter().zip(&shader.tables).enumerate() {
        for storage in [Storage::F32, Storage::F16, Storage::Unorm16] {
            if !gpu.filters(storage) {
                continue;
            }
            let texture = Texture::of(table, storage).unwrap();
            let axes = sampled.layout.axes.len();
            kinds.extend(
                sampled
                    .layout
                    .axes
                    .iter()
                    .map(|axis| (axis.axis.mapping.name(), axis.axis.rule.name())),
            );
            let mut stream = Stream::new(StreamId {
                seed: 7,
                cell: index as u64,
                batch: 0,
            });
            let count = 100_000;
            let mut inputs: Vec<f32> = Vec::with_capacity(count * axes + 1);
            for _ in 0..count {
                for axis in &sampled.layout.axes {
                    // a tenth at the ends, the others anywhere
                    let u = (1.2 * stream.uniform() - 0.1).clamp(0.0, 1.0);
                    inputs.push(axis.axis.value(u) as f32);
                }
            }
            inputs.push(0.0); // no buffer is empty
            let channels = texture.channels.len();
            let arguments: Vec<String> = (0..axes).map(|k| format!("inputs[i * {axes}u + {k}u]")).collect();
            let call = format!("{}({})", sampled.sampler.function, arguments.join(", "));
            let parts = (0..channels).map(|channel| match channels {
                1 => "outputs[i] = found;".to_owned(),
                _ => format!("outputs[i * {channels}u + {channel}u] = found[{channel}u];"),
            });
            // buffers that nobody reads would leave the layout
            let body = format!(
                "let found = {call} + inputs[{}u];\n    {}",
                inputs.len() - 1,
                parts.collect::<Vec<_>>().join("\n    ")
            );
            let found = gpu.run(&wgsl, &body, &[(index, &texture)], &inputs, (count, count * channels));
            // per axis: the coordinate is off by a few roundings of numbers up to 1, and a logarithm between 1/2 and 2 by 2^-21,
            // over the logarithm of the range; n texels multiply both, and weights are off as measured
            let allowed: f64 = steps(&texture)
                .iter()
                .zip(&texture.axes)
                .map(|(step, axis)| {
                    let axis = &axis.axis;
                    let spread = match axis.mapping {
                        Mapping::Log => (axis.max / axis.min).ln(),
                        Mapping::Log1p => ((1.0 + axis.max) / (1.0 + axis.min)).ln(),
                        _ => f64::INFINITY,
                    };
                    let coordinate = 4.0 * 2f64.powi(-24) + 2f64.powi(-21) / spread;
                    step * (axis.size as f64 * coordinate + gpu.weight_error)
                })
                .sum();
            // and a mean of up to four numbers up to 1 in f32
            let allowed = allowed + 4.0 * 2f64.powi(-24);
            let mut worst = (0.0, Vec::new());
            for i in 0..count {
                let place: Vec<f64> = inputs[i * axes..(i + 1) * axes]
                    .iter()
                    .map(|value| f64::from(*value))
                    .collect();
                let exact = match axes {
                    0 => texture.lookup(&[0.5]),
                    _ => texture.lookup(&place),
                };
                for (exact, found) in exact.iter().zip(&found[i * channels..]) {
                    let off = (exact - f64::from(*found)).abs();
                    if off > worst.0 || off.is_nan() {
                        worst = (off, place.clone());
                    }
                }
            }
            println!("{} {}: {:e} of {allowed:e}", table.id, storage.name(), worst.0);
            assert!(
                worst.0 <= allowed,
                "{} {} at {:?}: {:e}",
                table.id,
                storage.name(),
                worst.1,
                worst.0
            );
        }
    }
    // the scene is worth its name
    for kind in [("log1p", "ends"), ("log", "ends"), ("sqrt", "ends"), ("linear", "ends")] {
        assert!(kinds.contains(&kind), "{kind:?} of {kinds:?}");
    }
    assert!(kinds.iter().any(|(mapping, _)| *mapping == "sqrt-mu"), "{kinds:?}");
}
