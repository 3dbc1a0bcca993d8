//! What a plan saves, in evaluations of integrands: each saving against the same plan without it.

use whitefurnace::estimate::Estimator;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Target, fill};
use whitefurnace::plan::{Economy, Plan, Request, Source};
use whitefurnace::scene::{ModelSpec, Scene};
use whitefurnace::spectrum::{Channels, Spectrum};
use whitefurnace::table::{Quantity, Table};

fn request() -> Request {
    Request {
        resolution: 8,
        roughness_resolution: 4,
        azimuth_resolution: 3,
        tolerance: Some(1e-4),
        ..Request::default()
    }
}

/// Materials `a`, `b`, ... of the given bxdfs.
fn scene(bxdfs: &[String]) -> Scene {
    let materials = bxdfs.iter().zip('a'..='z');
    let materials = materials.map(|(bxdf, name)| format!("[[material]]\nname = \"{name}\"\nbxdf = {bxdf}\n"));
    Scene::parse(&materials.collect::<String>(), "economy.toml").unwrap()
}

fn lobe(distribution: &str, fresnel: &str, reflectance: &str) -> String {
    format!(
        "{{ type = \"microfacet\", distribution = {distribution}, masking = \"smith\", fresnel = {fresnel}, reflectance = \
         {reflectance} }}"
    )
}

fn glossy(reflectance: &str) -> String {
    lobe("{ type = \"ggx\", alpha = 0.4 }", GLASS, reflectance)
}

fn coupled(ks: &str, kd: &str, specular: &str) -> String {
    format!("{{ type = \"diffuse-specular\", coupling = \"mikkelsen\", ks = {ks}, kd = {kd}, specular = {specular} }}")
}

const GLASS: &str = "{ type = \"dielectric\", eta = 1.5 }";

fn plan(scene: &Scene, request: Request) -> Plan {
    Plan::new(scene, &request).unwrap()
}

fn filled(plan: &Plan) -> Vec<Table> {
    plan.tables.iter().map(|table| fill(table, &|_| {}).unwrap()).collect()
}

/// Evaluations at the texels of all tables.
fn evaluations(scene: &Scene, request: Request) -> u64 {
    filled(&plan(scene, request))
        .iter()
        .map(|table| table.evaluations)
        .sum()
}

fn without(edit: impl FnOnce(&mut Economy)) -> Request {
    let mut request = request();
    edit(&mut request.economy);
    request
}

#[test]
fn factors_and_names_cost_nothing() {
    let five = scene(&[
        glossy("1.0"),
        glossy("[0.2, 0.5, 0.9]"),
        format!("{{ type = \"scaled\", scale = 0.3, bxdf = {} }}", glossy("0.5")),
        coupled("0.5", "[0.1, 0.2, 0.3]", &glossy("1.0")),
        coupled("[0.5, 0.6, 0.7]", "0.9", &glossy("0.8")),
    ]);
    let one = evaluations(&scene(&[glossy("1.0")]), request());
    assert_eq!(evaluations(&five, request()), one);
    let apart = evaluations(&five, without(|economy| economy.sharing = false));
    // somewhat less than five times: an error of half a lobe may be twice as large a share of it
    assert!(apart > 4 * one, "{apart} where the lobe takes {one}");
    let shared = plan(&five, request());
    assert_eq!(shared.tables.len(), 2);
    assert_eq!(shared.tables[0].materials, ["a", "b", "c", "d", "e"]);
    // the colour of a factor is none of the table's
    assert_eq!(shared.tables[0].channels, Channels::Grey);
    let scale = |index: usize| shared.materials[index].terms[0].scale.value().to_array();
    assert_eq!(scale(1), [0.2, 0.5, 0.9]);
    assert_eq!(scale(2), [0.15; 3]);
    let base = shared.materials[4].terms[0].base.unwrap();
    assert_eq!(
        (scale(4), base.kd, base.ks.value().to_array()),
        ([0.8; 3], Spectrum::grey(0.9), [0.5, 0.6, 0.7])
    );
}

#[test]
fn one_roughness_is_a_line_and_several_a_sheet_over_their_own_range() {
    let schlick = |alpha: f64| {
        let distribution = format!("{{ type = \"ggx\", alpha = {alpha:?} }}");
        lobe(&distribution, "{ type = \"schlick\", r0 = 0.04 }", "1.0")
    };
    let axes = |scene: &Scene, request: Request| plan(scene, request).tables[0].alternatives[0].clone();
    let line = scene(&[schlick(0.3), schlick(0.3)]);
    assert_eq!(axes(&line, request()).len(), 1);
    let sheet = scene(&[schlick(0.3), schlick(0.5)]);
    let own = axes(&sheet, request());
    assert_eq!((own[1].min, own[1].max), (0.3, 0.5));
    let whole = without(|economy| economy.own_range = false);
    let wide = axes(&sheet, whole);
    assert_eq!((wide[1].min, wide[1].max), (1e-6, 1.0));
    let [one, all] = [request(), whole].map(|request| evaluations(&line, request));
    // as many rows as a sheet has
    assert!(3 * one < all, "{one} and {all}");
    // of the same size, the narrow sheet errs less
    let worst = |request: Request| filled(&plan(&sheet, request))[0].max_lookup_error();
    assert!(2.0 * worst(request()) < worst(whole));
}

#[test]
fn grey_tables_have_one_channel() {
    let grey = scene(&[glossy("1.0")]);
    let channels = |scene: &Scene, request: Request| plan(scene, request).tables[0].channels;
    assert_eq!(channels(&grey, request()), Channels::Grey);
    let coloured = scene(&[lobe(
        "{ type = \"ggx\", alpha = 0.4 }",
        "{ type = \"dielectric\", eta = [1.4, 1.5, 1.6] }",
        "1.0",
    )]);
    assert_eq!(channels(&coloured, request()), Channels::Rgb);
    assert_eq!(
        channels(&grey, without(|economy| economy.channels = false)),
        Channels::Rgb
    );
    // three Fresnel terms at each node cost no node, but never fewer
    assert!(evaluations(&grey, request()) <= evaluations(&coloured, request()));
}

#[test]
fn one_pair_serves_every_r0_of_schlick() {
    let metal = |r0: &str| {
        let fresnel = format!("{{ type = \"schlick\", r0 = {r0} }}");
        lobe("{ type = \"ggx\", alpha = 0.4 }", &fresnel, "1.0")
    };
    let metals = [
        "[1.0, 0.77, 0.34]",
        "[0.96, 0.64, 0.54]",
        "0.04",
        "[0.97, 0.96, 0.92]",
        "0.5",
    ]
    .map(metal);
    let one = evaluations(&scene(&metals[..1]), request());
    let all = scene(&metals);
    assert_eq!(evaluations(&all, request()), one);
    let apart = evaluations(&all, without(|economy| economy.split_sum = false));
    // the pair takes half as much again as one of them: (1 - cos)^5 alone is the steepest
    assert!(apart > 3 * one, "{apart} where the pair takes {one}");

    // and it tells the albedo of each, within the error that it states
    let plan = plan(&all, request());
    let tables = filled(&plan);
    assert_eq!((plan.tables.len(), plan.tables[0].channels), (2, Channels::Pair));
    assert_eq!(plan.tables[0].id, "ggx-smith.split-sum.rho_hd");
    for (material, planned) in all.materials.iter().zip(&plan.materials) {
        let Source::Table { id, r0: Some(r0) } = &planned.terms[0].albedo else {
            panic!("{planned:?}")
        };
        let pair = tables.iter().find(|table| table.id == *id).unwrap();
        let model = material.model.at(None).unwrap();
        for mu in [0.0, 1e-3, 0.1, 0.5, 0.77, 1.0] {
            let [at_0, at_1] = [0, 1].map(|channel| pair.sample(&[mu])[channel]);
            let truth = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-9).unwrap().value;
            for channel in 0..3 {
                let r0 = r0.value()[channel];
                let found = (1.0 - r0) * at_0 + r0 * at_1;
                let off = (found - truth[channel]).abs();
                assert!(
                    off <= pair.max_lookup_error() + 1e-9,
                    "{} at {mu}: {off:e}",
                    material.name
                );
            }
        }
    }
}

#[test]
fn closed_forms_have_no_tables() {
    let closed = scene(&[
        "{ type = \"lambertian\", reflectance = [0.1, 0.5, 0.9] }".into(),
        "{ type = \"oren-nayar\", reflectance = 0.5, sigma_deg = 20 }".into(),
        "{ type = \"specular-reflection\", fresnel = { type = \"conductor\", metal = \"Ag\" } }".into(),
        "{ type = \"fresnel-specular\", eta_b = 1.5 }".into(),
        "{ type = \"specular-transmission\", eta_b = 1.5 }".into(),
        "{ type = \"brdf-to-btdf\", bxdf = { type = \"lambertian\", reflectance = 0.5 } }".into(),
        "{ type = \"sum\", bxdfs = [{ type = \"lambertian\", reflectance = 0.3 }, { type = \"specular-reflection\", \
         reflectance = 0.5, fresnel = \"none\" }] }"
            .into(),
        // a lobe that scatters nothing, and a base without one
        glossy("0.0"),
        coupled("0.0", "0.5", &glossy("1.0")),
    ]);
    let economical = plan(&closed, request());
    assert_eq!(economical.tables, []);
    let closed_form = |source: &Source| matches!(source, Source::ClosedForm(_));
    for material in &economical.materials {
        assert!(
            material.terms.iter().all(|term| closed_form(&term.albedo)),
            "{material:?}"
        );
    }
    assert_eq!(economical.materials[6].terms.len(), 2);
    assert_eq!(economical.materials[7].terms.len(), 0);
    let tabulated = plan(&closed, without(|economy| economy.closed_forms = false));
    assert!(tabulated.tables.len() >= 2 * closed.materials.len());

    // of a sum the lobe alone is tabulated
    let paint = scene(&[format!(
        "{{ type = \"sum\", bxdfs = [{{ type = \"lambertian\", reflectance = 0.3 }}, {}] }}",
        glossy("0.5")
    )]);
    let plan = plan(&paint, request());
    assert_eq!(plan.tables.len(), 2);
    assert!(matches!(plan.tables[0].model, ModelSpec::Microfacet { .. }));
    assert_eq!(
        evaluations(&paint, request()),
        evaluations(&scene(&[glossy("1.0")]), request())
    );
}

/// What the integrator computes as a formula is what a plan takes for one.
#[test]
fn a_plan_knows_closed_forms_as_the_integrator_does() {
    let all = scene(&[
        "{ type = \"lambertian\", reflectance = 0.5 }".into(),
        "{ type = \"oren-nayar\", reflectance = 0.5, sigma_deg = 20 }".into(),
        "{ type = \"specular-reflection\", fresnel = \"none\" }".into(),
        "{ type = \"specular-transmission\", eta_b = 1.5 }".into(),
        "{ type = \"fresnel-specular\", eta_b = 1.5 }".into(),
        "{ type = \"fresnel-blend\", rd = 0.3, rs = 0.5, distribution = { type = \"phong\", n = 20 } }".into(),
        glossy("0.5"),
    ]);
    for material in &all.materials {
        let model = material.model.at(None).unwrap();
        let alone = scene(&["{ type = \"lambertian\", reflectance = 0.5 }".into()]);
        let alone = Scene {
            materials: vec![material.clone()],
            ..alone
        };
        let planned = plan(&alone, request())
            .tables
            .iter()
            .any(|table| table.quantity == Quantity::RhoHd);
        let target = Target::rho_hd(0.5, 0.0);
        let is_closed = whitefurnace::integrate::deterministic::closed_form(&model, target).is_some();
        assert_eq!(planned, !is_closed, "{}", material.model.type_name());
    }
}

#[test]
fn the_mean_is_computed_where_a_base_is_coupled() {
    let specular = glossy("1.0");
    let black = scene(&[coupled("1.0", "0.0", &specular)]);
    let blue = scene(&[coupled("1.0", "[0.0, 0.0, 0.5]", &specular)]);
    let quantities = |scene: &Scene| -> Vec<Quantity> {
        plan(scene, request())
            .tables
            .iter()
            .map(|table| table.quantity)
            .collect()
    };
    assert_eq!(quantities(&black), [Quantity::RhoHd]);
    assert_eq!(quantities(&blue), [Quantity::RhoHd, Quantity::RhoHh]);
    let [none, some] = [&black, &blue].map(|scene| evaluations(scene, request()));
    assert!(none < some, "{none} and {some}");
    assert_eq!(evaluations(&black, without(|economy| economy.coupling = false)), some);
    // a coupling to a smooth metal needs the mean, which is no closed form, and nothing else
    let mirror = "{ type = \"specular-reflection\", fresnel = { type = \"conductor\", metal = \"Cu\" } }";
    assert_eq!(quantities(&scene(&[coupled("1.0", "0.5", mirror)])), [Quantity::RhoHh]);
}

#[test]
fn sides_and_azimuths_that_nothing_goes_to_are_left_out() {
    let one = scene(&[glossy("1.0")]);
    let sampled = |edit: fn(&mut Economy)| Request {
        estimator: "mc-cosine".parse::<Estimator>().unwrap(),
        samples: Some(20_000),
        ..without(edit)
    };
    // samples are drawn for a side whether light goes there or not, where it does not count as a closed form
    let [above, both] = [
        sampled(|_| {}),
        sampled(|economy| (economy.sides, economy.closed_forms) = (false, false)),
    ]
    .map(|request| evaluations(&one, request));
    assert_eq!(both, 2 * above);
    let azimuth = without(|economy| economy.azimuth = false);
    assert_eq!(plan(&one, azimuth).tables[0].alternatives[0].len(), 2);
    let [line, sheet] = [request(), azimuth].map(|request| filled(&plan(&one, request))[0].evaluations);
    assert_eq!(sheet, 3 * line);
    let stretched = "{ type = \"ggx\", alpha_x = 0.4, alpha_y = 0.5 }";
    let stretched = scene(&[lobe(stretched, GLASS, "1.0")]);
    assert_eq!(plan(&stretched, request()).tables[0].alternatives[0].len(), 2);
}

#[test]
fn estimators_are_no_finer_than_the_tolerance() {
    let one = scene(&[glossy("1.0")]);
    let at = |tolerance: f64| {
        evaluations(
            &one,
            Request {
                tolerance: Some(tolerance),
                ..request()
            },
        )
    };
    let counts = [1e-1, 1e-3, 1e-6, 1e-10].map(at);
    assert!(counts.windows(2).all(|pair| pair[0] < pair[1]), "{counts:?}");
}

/// Everything for everyone is more by far, and not another result.
#[test]
fn all_effects_cost_more_and_change_nothing() {
    let few = scene(&[glossy("1.0"), glossy("0.5"), coupled("1.0", "0.5", &glossy("1.0"))]);
    let everything = Request {
        economy: Economy::NONE,
        ..request()
    };
    let [own, all] = [request(), everything].map(|request| evaluations(&few, request));
    assert!(10 * own < all, "{own} and {all}");
    let plan = plan(&few, everything);
    // both sides, rho_hd and rho_hh, of each material
    assert_eq!(plan.tables.len(), 3 * 4);
    for table in filled(&plan) {
        table.check().unwrap();
    }
}

/// The two ends of a pair are the lobe at r0 = 0 and at r0 = 1, which reflects all: no sum of them is more than 1.
#[test]
fn a_pair_is_schlick_at_both_ends() {
    for cos in [0.0, 0.3, 1.0] {
        let pair = Fresnel::schlick(Spectrum::rgb([0.0, 1.0, 1.0]))
            .unwrap()
            .reflectance(cos);
        assert_eq!(pair.y, 1.0);
        assert!((pair.x - (1.0 - cos).powi(5)).abs() < 1e-15); // a few roundings
    }
}
