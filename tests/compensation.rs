//! The white furnace through tables as shaders sample them: what the formulae that tables are for add to a lobe makes the energy
//! whole, within what the stated error of a lookup explains.

use glam::DVec3;
use std::f64::consts::TAU;
use whitefurnace::bxdf::Coupling;
use whitefurnace::compensation::{base, kulla_conty, turquin};
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Target, fill};
use whitefurnace::plan::{Plan, Request, TablePlan};
use whitefurnace::scene::Scene;
use whitefurnace::table::texture::Texture;
use whitefurnace::table::{Storage, Table};

/// Sheets of rho_hd and rho_hh over mu and the roughness, for every r0.
struct Sheets {
    plan: TablePlan,
    albedo: Table,
    mean: Table,
}

fn sheets(family: &str, parameter: &str, masking: &str) -> Sheets {
    let material = |name: &str, roughness: f64| {
        format!(
            "[[material]]\nname = \"{name}\"\nbxdf = {{ type = \"diffuse-specular\", coupling = \"energy-preserving\", ks = 1.0, \
             kd = 0.5, specular = {{ type = \"microfacet\", distribution = {{ type = \"{family}\", {parameter} = {roughness:?} }}, \
             masking = \"{masking}\", fresnel = {{ type = \"schlick\", r0 = 0.5 }} }} }}\n"
        )
    };
    let text = material("smooth", 0.2) + &material("rough", 1.0);
    let scene = Scene::parse(&text, "furnace.toml").unwrap();
    let request = Request {
        resolution: 24,
        roughness_resolution: 12,
        ..Request::default()
    };
    let plan = Plan::new(&scene, &request).unwrap();
    let [albedo, mean] = &plan.tables[..] else {
        panic!("{} tables", plan.tables.len())
    };
    Sheets {
        albedo: fill(albedo, &|_| {}).unwrap(),
        mean: fill(mean, &|_| {}).unwrap(),
        plan: albedo.clone(),
    }
}

/// 2 pi int f(mu) mu dmu of what is a polynomial between the texels of `texture` in s = sqrt(mu): Gauss-Legendre rules of four
/// points in each piece leave rounding only.
fn over_the_hemisphere(texture: &Texture, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let axis = &texture.axes[0];
    let texels = (0..axis.axis.size).map(|i| axis.texel(i));
    let cuts: Vec<f64> = [0.0].into_iter().chain(texels).chain([1.0]).collect();
    let mut sum = 0.0;
    for cut in cuts.windows(2) {
        let (from, to) = (cut[0].sqrt(), cut[1].sqrt());
        for (x, weight) in NODES {
            let s = 0.5 * (from + to) + 0.5 * (to - from) * x;
            sum += TAU * f(s * s) * 2.0 * s * s * s * 0.5 * (to - from) * weight;
        }
    }
    sum
}

#[test]
fn energy_is_whole_through_sampled_tables() {
    for (family, parameter, masking) in [
        ("ggx", "alpha", "smith-correlated"),
        ("ggx", "alpha", "smith"),
        ("beckmann", "m", "smith-correlated"),
    ] {
        let sheets = sheets(family, parameter, masking);
        for storage in [Storage::F32, Storage::F16, Storage::Unorm16] {
            let (albedo, mean) = (
                Texture::of(&sheets.albedo, storage).unwrap(),
                Texture::of(&sheets.mean, storage).unwrap(),
            );
            // how far a lookup is off: what the table states, and the rounding of its values, which are at most 1
            let stated = |table: &Table| table.max_lookup_error() + storage.rounding(1.0);
            let (delta, delta_mean) = (stated(&sheets.albedo), stated(&sheets.mean));
            let mut worst: f64 = 0.0;
            for roughness in [0.2, 0.37, 0.61, 1.0] {
                // the second channel is the lobe with F = 1
                let sampled = |mu: f64| albedo.lookup(&[mu, roughness])[1];
                let e_mean = mean.lookup(&[roughness])[1];
                let model = sheets.plan.model.at(Some(roughness)).unwrap();
                for mu in [0.0, 0.003, 0.08, 0.3, 0.55, 0.8, 1.0] {
                    let e = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-8).unwrap().value.y;
                    let e_o = sampled(mu);
                    let place = format!("{family} {masking} {} {roughness} {mu}", storage.name());

                    // Turquin: E/E_s, off by |E - E_s|/E_s
                    let furnace = e * turquin(DVec3::ONE, e_o).x;
                    assert!(
                        (1.0 - furnace).abs() <= (delta + 1e-8) / e_o,
                        "turquin {place}: {furnace}"
                    );

                    // Kulla and Conty: E + (1 - E_s(o)) q with q = (1 - mean of E_s)/(1 - E_avg). The mean of E_s is off by at
                    // most delta, as E_s is everywhere, and E_avg by delta_mean: |1 - q| <= (delta + delta_mean)/(1 - E_avg)
                    let bound = delta + (1.0 - e_o).abs() * (delta + delta_mean) / (1.0 - e_mean) + 1e-8;
                    let lost =
                        over_the_hemisphere(&albedo, |mu_i| kulla_conty(DVec3::ONE, e_o, sampled(mu_i), e_mean).x);
                    assert!((1.0 - e - lost).abs() <= bound, "kulla-conty {place}: {}", e + lost);
                    worst = worst.max((1.0 - e - lost).abs() / bound);

                    // eq. 28 that preserves energy is the same at ks = kd = 1; as printed it has not the quotient, and
                    // leaves (1 - E) (1 - E_avg)
                    let one = [DVec3::ONE; 2];
                    let under = |coupling| {
                        over_the_hemisphere(&albedo, |mu_i| {
                            let [o, i, mean] = [e_o, sampled(mu_i), e_mean].map(DVec3::splat);
                            base(coupling, one, o, i, mean).x
                        })
                    };
                    let whole = e + under(Coupling::EnergyPreserving);
                    assert!((1.0 - whole).abs() <= bound, "energy-preserving {place}: {whole}");
                    let printed = under(Coupling::Mikkelsen);
                    let expected = (1.0 - e) * (1.0 - e_mean);
                    // both factors are off by delta, and the mean that is compared with by delta_mean
                    let bound = delta * (1.0 - e_mean) + (1.0 - e_o).abs() * (delta + delta_mean) + 1e-8;
                    assert!((printed - expected).abs() <= bound, "mikkelsen {place}: {printed}");
                    assert!(e + printed < 1.0 - 1e-3, "mikkelsen {place} loses");
                }
            }
            println!("{family} {masking} {}: {worst} of the bound", storage.name());
            // the bound is no better than it has to be: it is used
            assert!(worst > 0.01, "{worst}");
        }
    }
}
