//! What tables state about themselves, judged from the bytes of their files by integrals computed afresh.

use glam::DVec3;
use rayon::prelude::*;
use std::sync::OnceLock;
use whitefurnace::bxdf::{Coupling, Model};
use whitefurnace::estimate::{Estimate, Estimator};
use whitefurnace::export::read::{Contents, read_exr};
use whitefurnace::export::{exr, write};
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Coordinates, Target, fill};
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::plan::{Economy, Plan, Request, TablePlan};
use whitefurnace::scene::Scene;
use whitefurnace::table::{Quantity, Table};

/// A plan and the table that its file holds.
struct Stored {
    plan: TablePlan,
    table: Table,
}

fn baked(scene: &Scene, resolution: usize, roughness_resolution: usize) -> Vec<Stored> {
    let request = Request {
        resolution,
        roughness_resolution,
        mapping: None,
        estimator: Estimator::Auto,
        azimuth_resolution: 4,
        tolerance: None,
        samples: None,
        seed: 0,
        economy: Economy::FULL,
    };
    let directory = tempfile::tempdir().unwrap();
    let stored = |plan: TablePlan| {
        let path = directory.path().join(format!("{}.exr", plan.id));
        let table = fill(&plan, &|_| {}).unwrap();
        write::write_whole(&path, &exr::to_bytes(&table).unwrap()).unwrap();
        match read_exr(&path).unwrap().contents {
            Contents::Table { table, .. } => Stored { plan, table: *table },
            Contents::Foreign(_) => panic!("{}: not recognised as a table", plan.id),
        }
    };
    Plan::new(scene, &request)
        .unwrap()
        .tables
        .into_iter()
        .map(stored)
        .collect()
}

/// The tables of the default scene.
fn default_tables() -> &'static [Stored] {
    static TABLES: OnceLock<Vec<Stored>> = OnceLock::new();
    TABLES.get_or_init(|| baked(&Scene::default_scene(), 64, 32))
}

/// Random cosines: half of them uniform, half log-uniform over ten decades, and both ends.
fn cosines(count: u64) -> Vec<f64> {
    let mut stream = Stream::new(StreamId {
        seed: 20_000,
        cell: 0,
        batch: 0,
    });
    let mut random = |i| match i % 2 {
        0 => stream.uniform(),
        _ => 10f64.powf(-10.0 * stream.uniform()),
    };
    [0.0, 1.0].into_iter().chain((2..count).map(&mut random)).collect()
}

/// The integral at `at`, afresh.
fn truth(stored: &Stored, at: &[f64], tolerance: f64) -> Estimate {
    let along = Coordinates::new(&stored.table.axes);
    let model = stored.plan.model.at(along.roughness(at)).unwrap();
    quadrature(&model, along.target(stored.table.quantity, at), tolerance).unwrap()
}

/// Largest by which the difference of `found` and `estimate` exceeds what is stated, `stated` and the reference's error.
fn beyond(found: DVec3, estimate: &Estimate, stated: DVec3) -> f64 {
    ((found - estimate.value).abs() - estimate.error - stated).max_element()
}

#[test]
fn texels_keep_their_stated_errors() {
    for stored in default_tables() {
        let table = &stored.table;
        (0..table.values.len()).into_par_iter().for_each(|i| {
            let at = table.texel_values(i);
            let stated = table.texel_error(i);
            let fresh = truth(stored, &at, 1e-9);
            // no allowance but the error of the reference, three orders below the tolerance
            let beyond = beyond(table.stored(i), &fresh, stated);
            assert!(beyond <= 0.0, "{} at {at:?}: {beyond:e} beyond {stated}", table.id);
            assert!(stated.max_element() <= table.max_texel_error());
        });
        // what is asked for is reached; rounding to f32 adds half a unit in the last place of a number below 1
        assert!(table.max_texel_error() <= 1e-6 + 3e-8, "{}", table.id);
    }
}

/// The lookups of one table at random places; the worst use of the stated error, and where.
fn worst_lookup(table: &Table, places: &[Vec<f64>], truths: &[Estimate]) -> (f64, Vec<f64>) {
    let stated = table.between.as_ref().unwrap().error;
    let used = places.iter().zip(truths).map(|(place, truth)| {
        let used = (beyond(table.sample(place), truth, DVec3::ZERO) / stated, place.clone());
        assert!(
            used.0 <= 1.0,
            "{} at {place:?}: {} of the stated {stated:e}",
            table.id,
            used.0
        );
        used
    });
    used.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// Sheets over roughness ranges that end in narrow lobes, where rho bends within a cell at mu near alpha: no place between the texels
/// errs by more than is stated, whatever search finds it.
#[test]
fn no_search_finds_more_than_sheets_state() {
    let lobe = |name: &str, facets: &str, masking: &str, fresnel: &str| {
        format!(
            "[[material]]\nname = \"{name}\"\n[material.bxdf]\ntype = \"microfacet\"\ndistribution = {facets}\nmasking = \"{masking}\"\n\
             fresnel = {fresnel}\n"
        )
    };
    let ggx = |from: &str, to: &str| format!("{{ type = \"ggx\", alpha = {{ min = {from}, max = {to} }} }}");
    let none = "{ type = \"none\" }";
    let text = [
        "[scene]\nname = \"sheets\"\n".to_owned(),
        lobe(
            "metal",
            &ggx("0.01", "1"),
            "smith-correlated",
            "{ type = \"schlick\", r0 = 0.5 }",
        ),
        lobe("wide", &ggx("0.0025", "0.09"), "smith", none),
        lobe("full", &ggx("0.001", "1"), "smith-correlated", none),
        lobe(
            "grooves",
            "{ type = \"beckmann\", m = { min = 0.01, max = 1.0 } }",
            "v-groove",
            "{ type = \"dielectric\", eta = 1.5 }",
        ),
        lobe(
            "vmf",
            "{ type = \"vmf\", kappa = { min = 1, max = 1e5 } }",
            "v-groove",
            none,
        ),
    ]
    .concat();
    let scene = Scene::parse(&text, "sheets.toml").unwrap();
    for [mu, roughness] in [[16, 8], [32, 16], [64, 32], [23, 41]] {
        for stored in baked(&scene, mu, roughness) {
            let table = &stored.table;
            let [axis, rows] = &table.axes[..] else { continue };
            // places of a grid of its own, which crowd towards mu = 0, in every cell several
            let mut columns: Vec<f64> = (0..=3 * mu).map(|i| axis.value(i as f64 / (3 * mu) as f64)).collect();
            columns.extend((0..60).map(|i| axis.texel(1) * 10f64.powf(-f64::from(i) / 12.0)));
            let rows: Vec<f64> = (0..=3 * roughness)
                .map(|i| rows.value(i as f64 / (3 * roughness) as f64))
                .collect();
            let places: Vec<Vec<f64>> = rows
                .iter()
                .flat_map(|row| columns.iter().map(|column| vec![*column, *row]))
                .collect();
            let error = |place: &[f64]| beyond(table.sample(place), &truth(&stored, place, 1e-7), DVec3::ZERO);
            let mut found: Vec<(f64, Vec<f64>)> = places.into_par_iter().map(|place| (error(&place), place)).collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            found.truncate(24);
            let climbed = found.into_par_iter().enumerate().map(|(index, (mut best, mut at))| {
                let mut stream = Stream::new(StreamId {
                    seed: 7,
                    cell: index as u64,
                    batch: 0,
                });
                for step in 0..120 {
                    let size = 0.3 * 0.96f64.powi(step);
                    let moved = |(axis, value): (&whitefurnace::table::axis::Axis, &f64), by: f64| {
                        axis.value((axis.u(*value) + by * size / axis.size as f64).clamp(0.0, 1.0))
                    };
                    let tried: Vec<f64> = table
                        .axes
                        .iter()
                        .zip(&at)
                        .map(|pair| moved(pair, 2.0 * stream.uniform() - 1.0))
                        .collect();
                    let new = error(&tried);
                    if new > best {
                        (best, at) = (new, tried);
                    }
                }
                (best, at)
            });
            let (largest, at) = climbed.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let used = largest / table.between.as_ref().unwrap().error;
            println!(
                "{} {mu} x {roughness}: {used:.4} of the stated lookup error, at {at:?}",
                table.id
            );
            assert!(
                used <= 1.0,
                "{} {mu} x {roughness} at {at:?}: {used} of what is stated",
                table.id
            );
        }
    }
}

/// Every place within the domain of every table: 20,000 directions each.
#[test]
fn lookups_keep_their_stated_errors() {
    let mus = cosines(20_000);
    for stored in default_tables().iter().filter(|stored| stored.table.axes.len() == 1) {
        let table = &stored.table;
        let model = stored.plan.model.at(None).unwrap();
        if table.quantity == Quantity::RhoHh {
            continue;
        }
        let Model::Microfacet(_) = model else { continue };
        let places: Vec<Vec<f64>> = mus.iter().map(|mu| vec![*mu]).collect();
        let truths: Vec<Estimate> = places.par_iter().map(|at| truth(stored, at, 1e-8)).collect();
        let (used, at) = worst_lookup(table, &places, &truths);
        println!("{}: {used} of the stated lookup error, at {at:?}", table.id);
        // the statement is no better than it has to be: random places come close to it
        assert!(used > 0.9, "{}: {used}", table.id);
    }
}

#[test]
fn lookups_with_a_roughness_axis_keep_their_stated_errors() {
    let mut stream = Stream::new(StreamId {
        seed: 20_000,
        cell: 1,
        batch: 0,
    });
    for stored in default_tables() {
        let table = &stored.table;
        let Some(roughness) = table.axes.iter().find(|axis| axis.parameter != "mu") else {
            continue;
        };
        let mut random = || match stream.uniform() {
            u if u < 0.02 => roughness.min,
            u if u < 0.04 => roughness.max,
            _ => roughness.value(stream.uniform()),
        };
        let places: Vec<Vec<f64>> = match table.quantity {
            Quantity::RhoHd => cosines(20_000).into_iter().map(|mu| vec![mu, random()]).collect(),
            Quantity::RhoHh => (0..2_000).map(|_| vec![random()]).collect(),
        };
        let truths: Vec<Estimate> = places.par_iter().map(|at| truth(stored, at, 1e-8)).collect();
        let (used, at) = worst_lookup(table, &places, &truths);
        println!("{}: {used} of the stated lookup error, at {at:?}", table.id);
        // the peak of a sheet is met less closely than that of a line
        assert!(used > 0.8, "{}: {used}", table.id);
    }
}

#[test]
fn no_table_of_a_conserving_model_exceeds_one() {
    for Stored { table, .. } in default_tables() {
        assert_eq!(table.energy_excess(), None, "{}", table.id);
        for i in 0..table.values.len() {
            let excess = table.stored(i) - table.texel_error(i) - DVec3::ONE;
            assert!(
                excess.max_element() <= 0.0,
                "{} at {:?}",
                table.id,
                table.texel_values(i)
            );
            assert!(table.stored(i).min_element() >= 0.0);
        }
    }
}

/// 2 int (1 - ks R(mu)) mu dmu of a lookup R: piecewise polynomial in u, so that Gauss-Legendre rules of four points per
/// piece leave rounding only.
fn left_over(specular: &Table, ks: DVec3) -> DVec3 {
    const NODES: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let axis = &specular.axes[0];
    let texels = (0..axis.size).map(|i| axis.texel(i));
    let cuts: Vec<f64> = [0.0].into_iter().chain(texels).chain([1.0]).collect();
    let mut sum = DVec3::ZERO;
    for cut in cuts.windows(2).filter(|cut| cut[1] > cut[0]) {
        // in s = sqrt(mu), mu dmu = 2 s^3 ds
        let (from, to) = (cut[0].sqrt(), cut[1].sqrt());
        for (x, weight) in NODES {
            let s = 0.5 * (from + to) + 0.5 * (to - from) * x;
            let left = DVec3::ONE - ks * specular.sample(&[s * s]);
            sum += left * (2.0 * 2.0 * s * s * s * 0.5 * (to - from) * weight);
        }
    }
    sum
}

/// A shader has f_s, the table of rho_hd and the one of rho_bar. With eq. 28 evaluated from these it reflects, over the whole
/// hemisphere, the total albedo of the material, integrated for itself, within the errors that both tables state.
#[test]
fn the_tables_suffice_for_a_shader() {
    let figure = include_str!("../src/scene/default.toml");
    let mut figure = figure[..figure.find("# One of each further distribution.").unwrap()].to_string();
    for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
        if coupling == Coupling::EnergyPreserving {
            figure = figure.replace("coupling = \"mikkelsen\"", "coupling = \"energy-preserving\"");
        }
        let scene = Scene::parse(&figure, "figure 7").unwrap();
        let tables = baked(&scene, 16, 32);
        assert_eq!(tables.len(), 2 * scene.materials.len());
        for (tables, material) in tables.chunks(2).zip(&scene.materials) {
            let [specular, mean] = tables else {
                panic!("{}", tables.len())
            };
            assert!(specular.table.id.ends_with(".specular.rho_hd") && mean.table.id.ends_with(".specular.rho_hh"));
            let model = material.model.at(None).unwrap();
            let Model::DiffuseSpecular(coupled) = &model else {
                panic!("{}", material.name)
            };
            assert_eq!(coupled.coupling(), coupling);
            let (ks, kd) = (coupled.ks().value(), coupled.kd().value());
            let lookup = |stored: &Stored| stored.table.between.as_ref().unwrap().error;
            let unspent = DVec3::ONE - ks * mean.table.stored(0);
            let scale = match coupling {
                Coupling::Mikkelsen => DVec3::ONE,
                Coupling::EnergyPreserving => unspent.recip(),
            };
            let left = left_over(&specular.table, ks);
            // the lookup errs by at most its stated error everywhere, hence so does its mean; that of rho_bar enters where
            // it divides, and in the other coupling not at all
            let mean_error = mean.table.max_texel_error();
            assert!((left - unspent).abs().max_element() <= lookup(specular) + mean_error);
            for mu in cosines(200) {
                let lobe = truth(specular, &[mu], 1e-9).value;
                let sampled = specular.table.sample(&[mu]);
                let reflected = ks * lobe + (DVec3::ONE - ks * sampled) * kd * scale * left;
                let total = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-9).unwrap().value;
                // slopes: kd scale left for the lookup at mu, kd scale (1 - ks rho) for its mean, and for rho_bar
                // kd scale^2 left (1 - ks rho)
                let open = (DVec3::ONE - ks * sampled).abs() + ks * lookup(specular);
                let division = match coupling {
                    Coupling::Mikkelsen => DVec3::ZERO,
                    Coupling::EnergyPreserving => kd * scale * scale * left * open * mean_error,
                };
                let allowed =
                    kd * scale * (left * lookup(specular) + open * lookup(specular)) + division + DVec3::splat(3e-9); // and both references
                let difference = (reflected - total).abs();
                assert!(
                    (difference - allowed).max_element() <= 0.0,
                    "{} at mu = {mu}: {difference} where {allowed} is allowed",
                    material.name
                );
            }
        }
    }
}
