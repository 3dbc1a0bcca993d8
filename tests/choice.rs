//! Tables chosen for an error as a shader sees it keep it, on materials that the chooser was not made with.

use glam::DVec3;
use rayon::prelude::*;
use whitefurnace::estimate::{Effort, Estimate, Estimator};
use whitefurnace::integrate::choice::{Chooser, Obstacle, Wish};
use whitefurnace::integrate::{Coordinates, Integrator, fill_within, texels};
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::plan::{Plan, Request, TablePlan};
use whitefurnace::scene::Scene;
use whitefurnace::table::axis::MAX_SIZE;
use whitefurnace::table::{Goal, Storage, Table};

fn stream(cell: u64) -> Stream {
    Stream::new(StreamId {
        seed: 31_000,
        cell,
        batch: 0,
    })
}

fn plans(scene: &str) -> Vec<TablePlan> {
    let request = Request::default();
    let scene = Scene::parse(scene, "chosen").unwrap_or_else(|error| panic!("{error} in\n{scene}"));
    Plan::new(&scene, &request).unwrap().tables
}

fn lobe(name: &str, distribution: &str, masking: &str, fresnel: &str) -> String {
    format!(
        "[[material]]\nname = \"{name}\"\n[material.bxdf]\ntype = \"microfacet\"\ndistribution = {distribution}\n\
         masking = \"{masking}\"\nfresnel = {fresnel}\n"
    )
}

/// The tables over mu of materials drawn from the legal ranges.
fn drawn(count: usize) -> Vec<TablePlan> {
    let mut stream = stream(0);
    let scenes = (0..count).map(|i| {
        let mut log = |from: f64, to: f64| from * (to / from).powf(stream.uniform());
        let distribution = match i % 4 {
            0 => format!("{{ type = \"vmf\", kappa = {} }}", log(1.0, 1e6)),
            1 => format!("{{ type = \"beckmann\", m = {} }}", log(0.01, 1.5)),
            2 => format!("{{ type = \"phong\", n = {} }}", log(1.0, 1e5)),
            _ => format!("{{ type = \"ggx\", alpha = {} }}", log(0.01, 2.0)),
        };
        let masking = match i % 4 {
            1 | 3 => ["smith", "v-groove", "smith-correlated"][i / 4 % 3],
            _ => "v-groove",
        };
        let fresnel = match i % 5 {
            0 => "{ type = \"none\" }".to_string(),
            1 => format!("{{ type = \"dielectric\", eta = {} }}", log(1.1, 3.0)),
            2 => format!(
                "{{ type = \"conductor\", eta = {}, k = {} }}",
                log(0.1, 3.0),
                log(1.0, 8.0)
            ),
            3 => "{ type = \"schlick\", r0 = [0.9, 0.5, 0.1] }".to_string(),
            _ => format!("{{ type = \"dielectric\", eta = {} }}", log(0.4, 0.95)),
        };
        let text = lobe("lobe", &distribution, masking, &fresnel);
        if i % 3 != 2 {
            return text;
        }
        let coupling = ["mikkelsen", "energy-preserving"][i % 2];
        text.replace(
            "[material.bxdf]\n",
            &format!(
                "[material.bxdf]\ntype = \"diffuse-specular\"\ncoupling = \"{coupling}\"\nks = 0.9\n\
                 kd = [0.1, 0.5, 1.0]\n[material.bxdf.specular]\n"
            ),
        )
    });
    // the whole material, last but its mean
    scenes
        .map(|scene| plans(&scene).into_iter().rev().nth(1).unwrap())
        .collect()
}

/// Random places, half of them at all scales towards mu = 0, with fresh integrals.
fn truths(plan: &TablePlan, count: usize) -> Vec<(Vec<f64>, Estimate)> {
    let axes = &plan.alternatives[0];
    let mut stream = stream(1);
    let mut places: Vec<Vec<f64>> = (0..count)
        .map(|i| {
            let along = axes.iter().map(|axis| match (axis.parameter.as_str(), i % 2) {
                ("mu", 0) => stream.uniform(),
                ("mu", _) => 10f64.powf(-10.0 * stream.uniform()),
                _ => axis.value(stream.uniform()),
            });
            along.collect()
        })
        .collect();
    places.push(axes.iter().map(|axis| axis.min).collect());
    places.push(axes.iter().map(|axis| axis.max).collect());
    let along = Coordinates::new(axes);
    // a thousandth of the finest tolerance that is judged
    let effort = Effort {
        tolerance: 1e-7,
        samples: None,
        seed: 0,
    };
    let at =
        |integrator: &Integrator, place: &[f64]| integrator.estimate(along.target(plan.quantity, place), 0).unwrap();
    // what directions share is prepared once where there is one roughness
    let only = plan.model.at(None).unwrap();
    let shared = Integrator::new(&only, Estimator::Quadrature, effort).unwrap();
    let truth = |place: Vec<f64>| {
        let rho = match along.roughness(&place) {
            None => at(&shared, &place),
            roughness => {
                let model = plan.model.at(roughness).unwrap();
                at(&Integrator::new(&model, Estimator::Quadrature, effort).unwrap(), &place)
            }
        };
        (place, rho)
    };
    places.into_par_iter().map(truth).collect()
}

/// Largest error of lookups in `table`, less what the reference itself is off.
fn worst(table: &Table, storage: Storage, truths: &[(Vec<f64>, Estimate)]) -> f64 {
    let off = |(place, rho): &(Vec<f64>, Estimate)| -> f64 {
        let off: DVec3 = (table.sample_as(storage, place) - rho.value).abs() - rho.error;
        off.max_element()
    };
    truths.iter().map(off).fold(0.0, f64::max)
}

fn filled(plan: &TablePlan, tolerance: f64) -> Table {
    let chooser = Chooser::new(plan, Wish::within(tolerance)).unwrap();
    fill_within(&chooser, &chooser.wished(), &|_| {}).unwrap()
}

fn kept(plan: &TablePlan, tolerance: f64, truths: &[(Vec<f64>, Estimate)]) {
    let what = format!("{tolerance:e} for {:?}", plan.model);
    let table = filled(plan, tolerance);
    let met = Goal { tolerance, unmet: None };
    assert_eq!(table.goal, Some(met), "{what}");
    let stated = table.between.as_ref().unwrap().error;
    let found = worst(&table, Storage::F32, truths);
    println!(
        "{:?} {} {found:.1e} found, {stated:.1e} stated, {tolerance:e} allowed",
        table.size(),
        table
            .axes
            .iter()
            .map(|axis| axis.label())
            .collect::<Vec<_>>()
            .join(", ")
    );
    assert!(found <= stated && stated <= tolerance, "{what}: {found:e}, {stated:e}");
    assert!(table.max_texel_error() <= tolerance && table.tolerance <= tolerance);
    // no table of a thousand texels where ten would do: a texel less in ten changes the error by a fifth. Constant rho
    // needs two texels whatever is asked for.
    if tolerance <= 1e-3 && table.size()[0] > 8 {
        assert!(stated > 0.5 * tolerance, "{what}: {stated:e} with {:?}", table.size());
    }
}

#[test]
fn chosen_tables_keep_the_tolerance() {
    for plan in drawn(20) {
        let truths = truths(&plan, 400);
        for tolerance in [1e-2, 1e-3, 1e-4] {
            kept(&plan, tolerance, &truths);
        }
    }
}

#[test]
fn chosen_sheets_keep_the_tolerance() {
    let scene = lobe(
        "range",
        "{ type = \"ggx\", alpha = { min = 0.02, max = 1.5 } }",
        "v-groove",
        "{ type = \"none\" }",
    );
    let [hd, hh] = &plans(&scene)[..] else { panic!() };
    for (plan, tolerances) in [(hd, &[1e-2, 1e-3][..]), (hh, &[1e-2, 1e-3, 1e-4])] {
        let truths = truths(plan, 600);
        tolerances.iter().for_each(|tolerance| kept(plan, *tolerance, &truths));
    }
    let scene = lobe(
        "brushed",
        "{ type = \"beckmann\", m_x = 0.1, m_y = 0.4 }",
        "v-groove",
        "{ type = \"none\" }",
    );
    let plan = &plans(&scene)[0];
    kept(plan, 1e-2, &truths(plan, 300));
}

/// Every format that is said to keep the tolerance does, rounding included.
#[test]
fn chosen_formats_keep_the_tolerance() {
    for plan in drawn(5) {
        let truths = truths(&plan, 400);
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let chooser = Chooser::new(&plan, Wish::within(tolerance)).unwrap();
            let smallest = chooser.smallest(tolerance).unwrap();
            for storage in Storage::ALL {
                let choice = chooser.choice(tolerance, storage);
                assert_eq!((choice.whole, choice.obstacle), (true, None));
                if choice.error > tolerance {
                    // the best of formats that are too coarse is theirs, not that of the sizes
                    assert!(
                        storage != Storage::F32 && storage.rounding(1.0) > 0.5 * tolerance,
                        "{storage:?}"
                    );
                    continue;
                }
                assert!(smallest.bytes <= choice.bytes);
                let table = texels(&choice.plan, &choice.plan.alternatives[0], &|_| {}).unwrap();
                assert_eq!(table.texture_bytes(storage), choice.bytes);
                let found = worst(&table, storage, &truths);
                assert!(
                    found <= tolerance,
                    "{storage:?} {tolerance:e} {:?}: {found:e}",
                    plan.model
                );
            }
        }
        // 8 bits are off by 2e-3, 16 by 8e-6
        let of = |tolerance| {
            Chooser::new(&plan, Wish::within(tolerance))
                .unwrap()
                .smallest(tolerance)
                .unwrap()
        };
        assert_eq!(
            [1e-2, 1e-4].map(|tolerance| of(tolerance).storage),
            [Storage::Unorm8, Storage::Unorm16]
        );
    }
}

/// What cannot be kept is said, with the reason and what to do, and the table is the best that is allowed.
/// Why a table does not keep its goal.
fn unmet(table: &Table) -> &str {
    table.goal.as_ref().and_then(|goal| goal.unmet.as_deref()).unwrap()
}

#[test]
fn what_cannot_be_kept_is_said() {
    let vmf = |kappa: f64, masking| {
        let distribution = format!("{{ type = \"vmf\", kappa = {kappa} }}");
        plans(&lobe("lobe", &distribution, masking, "{ type = \"none\" }")).remove(0)
    };
    // linear filtering of 16384 texels is off by more than rounding to f32 leaves
    let plan = vmf(1e5, "v-groove");
    let found = filled(&plan, 3.5e-8);
    assert!(unmet(&found).contains("--tolerance"), "{:?}", found.goal);
    assert_eq!(found.size()[0], MAX_SIZE);
    assert!(found.between.as_ref().unwrap().error < 1e-6);
    // a given size stays, and the mapping does what it can
    let wish = Wish {
        mu: Some(12),
        ..Wish::within(1e-4)
    };
    let chooser = Chooser::new(&plan, wish).unwrap();
    let found = fill_within(&chooser, &chooser.wished(), &|_| {}).unwrap();
    assert!(unmet(&found).contains("12 texels along mu"), "{:?}", found.goal);
    assert_eq!(found.size()[0], 12);
    // no size helps where the integral diverges
    let plan = vmf(17.0, "none");
    let chooser = Chooser::new(&plan, Wish::within(1e-3)).unwrap();
    let choice = chooser.wished();
    assert_eq!(choice.obstacle, Some(Obstacle::Diverges));
    let found = fill_within(&chooser, &choice, &|_| {}).unwrap();
    assert_eq!(unmet(&found), Obstacle::Diverges.reason());
    assert_eq!(found.size()[0], 64);
}
