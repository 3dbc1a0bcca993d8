//! Bad scenes and what they are told.

use super::*;

/// What `text` is told.
pub(super) fn refusal(text: &str) -> Refusal {
    match Scene::parse(text, "scene.toml") {
        Err(SceneError::Refused(refusal)) => *refusal,
        other => panic!("{text}\n{other:?}"),
    }
}

/// Every text, put into a scene by `scene`, is refused at `line` with words that hold the ones beside it.
pub(super) fn all_refused(line: usize, scene: impl Fn(&str) -> String, cases: &[(&str, &str)]) {
    for (text, words) in cases {
        let refusal = refusal(&scene(text));
        let shown = refusal.to_string();
        assert!(shown.contains(words), "{words}\n{shown}");
        assert_eq!(refusal.line, line, "{shown}");
        assert!(shown.starts_with(&format!("scene.toml:{line}:{}: ", refusal.column)));
        assert_eq!(shown.lines().count(), 3, "{shown}");
    }
}

const HEAD: &str = "[[material]]\nname = 'a'\n";
const WHITE: &str = "bxdf = { type = 'lambertian', reflectance = 1 }\n";

/// A material with the given bxdf on line 3.
fn with_bxdf(bxdf: &str) -> String {
    format!("{HEAD}bxdf = {bxdf}\n")
}

/// A microfacet material on line 3.
fn microfacet(distribution: &str, masking: &str, fresnel: &str) -> String {
    with_bxdf(&format!(
        "{{ type = 'microfacet', distribution = {distribution}, masking = {masking}, fresnel = {fresnel} }}"
    ))
}

#[test]
fn wrong_files() {
    let only = str::to_owned;
    all_refused(
        1,
        only,
        &[
            ("# nothing\n\n", "missing key material: a scene holds at least one"),
            (
                "material = []\n",
                "material = [] is not allowed: a scene holds at least one",
            ),
            ("material = 3\n", "each under a header [[material]], not an integer"),
            (
                "[material]\n",
                "material as a table is not allowed: materials are tables, each under a header",
            ),
            ("material = [1]\n", "material = 1 is not allowed: materials are tables"),
        ],
    );
    let before = |text: &str| format!("{text}{HEAD}{WHITE}");
    all_refused(
        1,
        before,
        &[
            (
                "[scenes]\n",
                "unknown key scenes: the keys of a scene are scene, material; did you mean scene?",
            ),
            (
                "scene = 'x'\n",
                "scene = 'x' is not allowed: scene is one table, [scene], not a string",
            ),
            ("[[scene]]\n", "scene is one table, [scene], not an array"),
        ],
    );
    all_refused(
        2,
        before,
        &[
            (
                "[scene]\ntitle = 'x'\n",
                "unknown key title: the keys of [scene] are name",
            ),
            ("[scene]\nname = 3\n", "name = 3 is not allowed: name is a string"),
            (
                "[scene]\nname = ' '\n",
                "name = ' ' is not allowed: name is a string, and not empty",
            ),
        ],
    );
}

#[test]
fn wrong_materials() {
    let material = |text: &str| format!("[[material]]\n{text}{WHITE}");
    all_refused(
        5,
        |text| format!("{HEAD}{WHITE}[[material]]\nname = {text}\n{WHITE}"),
        &[
            (
                "'a'",
                "name = 'a' is not allowed: the material at line 1 has that name already",
            ),
            ("\"\\u0061\"", "the material at line 1 has that name already"),
        ],
    );
    all_refused(
        1,
        material,
        &[("", "missing key name: every material has a name of its own")],
    );
    all_refused(
        2,
        material,
        &[
            (
                "nam = 'a'\n",
                "unknown key nam: the keys of [[material]] are name, bxdf; did you mean name?",
            ),
            ("name = ''\n", "name = '' is not allowed"),
            ("name = true\n", "name is a string, and not empty, not a boolean"),
            ("\"a b\" = 1\n", "unknown key \"a b\""),
        ],
    );
    all_refused(
        1,
        |_| HEAD.to_owned(),
        &[("", "missing key bxdf: bxdf is a table with a type")],
    );
}

#[test]
fn wrong_types() {
    all_refused(
        3,
        with_bxdf,
        &[
            (
                "'lambertian'",
                "bxdf is a table with a type and its parameters, not a string",
            ),
            (
                "{}",
                "missing key type: bxdf is one of \"lambertian\", \"oren-nayar\", \"microfacet\", \"fresnel-blend\"",
            ),
            ("{ tpye = 'lambertian' }", "is tpye a misspelling of type?"),
            ("{ type = 1 }", "type = 1 is not allowed: bxdf is one of"),
            ("{ type = 'lambertan' }", "did you mean \"lambertian\"?"),
            (
                "{ type = 'oren-nayar', reflectance = 1, sigma_deg = 91 }",
                "sigma_deg = 91 is not allowed: sigma_deg lies in [0, 90]",
            ),
            (
                "{ type = 'oren-nayar', reflectance = 1 }",
                "missing key sigma_deg: sigma_deg is a number in [0, 90]",
            ),
            ("{ type = 'sum', bxdfs = [] }", "bxdfs is an array of at least one bxdf"),
            ("{ type = 'sum', bxdfs = [1] }", "bxdfs holds tables, each with a type"),
            ("{ type = 'scaled', scale = 2, bxdf = {} }", "scale lies in [0, 1]"),
            (
                "{ type = 'brdf-to-btdf' }",
                "missing key bxdf: bxdf is a table with a type",
            ),
            (
                "{ type = 'merl', path = 'absent' }",
                "path = 'absent' cannot be used: absent: cannot be read",
            ),
            ("{ type = 'irregular', path = '' }", "path is a string, and not empty"),
            ("{ type = 'irregular', path = '.' }", "path = '.' cannot be used: "),
            (
                "{ type = 'specular-transmission', eta_b = 0 }",
                "eta_b = 0 is not allowed: eta_b lies in [0.01, 100]",
            ),
            (
                "{ type = 'fresnel-specular', eta_b = 1.5, transport = 'light' }",
                "transport is one of \"radiance\", \"importance\"",
            ),
            (
                "{ type = 'rough-dielectric', eta_a = 1.5, eta_b = 1.5, masking = 'smith', distribution = { type = 'ggx', alpha = 0.1 } }",
                "eta_b = 1.5 is not allowed: indices 1.5 and 1.5 of a rough interface are as good as equal",
            ),
            (
                "{ type = 'rough-dielectric', eta_b = 1.5, masking = 'v-groove', distribution = { type = 'ggx', alpha = 0.1 } }",
                "masking is one of \"smith\", \"smith-correlated\"",
            ),
            (
                "{ type = 'rough-dielectric', eta_b = 1.5, masking = 'smith', distribution = { type = 'phong', n = 9 } }",
                "it goes with beckmann and ggx only",
            ),
            (
                "{ type = 'rough-dielectric', eta_b = 1.5, masking = 'smith', distribution = { type = 'ggx', alpha_x = 0.1, alpha_y = 0.2 } }",
                "a rough-dielectric has one roughness",
            ),
            (
                "{ type = 'fresnel-blend', rd = 1, distribution = { type = 'phong', n = 1 } }",
                "missing key rs",
            ),
            (
                "{ type = 'lambertian' }",
                "missing key reflectance: reflectance is a number or an array of three",
            ),
            (
                "{ type = 'lambertian', r = 1 }",
                "unknown key r: the keys of lambertian are type, reflectance",
            ),
        ],
    );
}

#[test]
fn wrong_values() {
    let reflectance = |text: &str| with_bxdf(&format!("{{ type = 'lambertian', reflectance = {text} }}"));
    all_refused(
        3,
        reflectance,
        &[
            ("1.5", "reflectance = 1.5 is not allowed: reflectance lies in [0, 1]"),
            ("nan", "reflectance = nan is not allowed: reflectance lies in [0, 1]"),
            ("-inf", "reflectance = -inf is not allowed"),
            ("1e999", "reflectance = 1e999 is not allowed"),
            ("99999999999999999999999999999", "lies in [0, 1]"),
            ("0xffffffffffffffffffffffffffffffffffff", "lies in [0, 1]"),
            (
                "'1'",
                "reflectance = '1' is not allowed: reflectance is a number or an array of three",
            ),
            ("1979-05-27", "not a date or time"),
            ("[1, 1]", "not an array of 2"),
            ("[]", "not an array of 0"),
            (
                "[1, 1, 'a']",
                "reflectance = 'a' is not allowed: reflectance is a number in [0, 1], not a string",
            ),
            (
                "{ min = 0, max = 1 }",
                "only roughness parameters (kappa, m, n, exponent) may be ranges",
            ),
            (
                "[0, 0, { min = 0, max = 1 }]",
                "reflectance = { min = 0, max = 1 } is not allowed: only roughness",
            ),
            ("{ value = 0 }", "in [0, 1], not a table"),
        ],
    );
    all_refused(
        5,
        reflectance,
        &[(
            "[1,\n1,\n2]",
            "reflectance = 2 is not allowed: reflectance lies in [0, 1]",
        )],
    );
}

#[test]
fn wrong_distributions() {
    all_refused(
        3,
        |text| microfacet(text, "'none'", "'none'"),
        &[
            (
                "'vmf'",
                "distribution is a table such as { type = \"vmf\", kappa = 17.0 }, not a string",
            ),
            ("{ kappa = 1 }", "missing key type: distribution is one of"),
            ("{ type = 'VMF', kappa = 1 }", "did you mean \"vmf\"?"),
            (
                "{ type = 'vmf' }",
                "missing key kappa: kappa is a number or a range { min = .., max = .. } in [0, 1e12]",
            ),
            (
                "{ type = 'vmf', kappa = true }",
                "kappa is a number or a range { min = .., max = .. } in [0, 1e12], not a boolean",
            ),
            ("{ type = 'vmf', kappa = [1, 2, 3] }", "not an array"),
            (
                "{ type = 'vmf', kappa = 1, m = 1 }",
                "unknown key m: the keys of vmf are type, kappa",
            ),
            (
                "{ type = 'beckmann', m = 0 }",
                "m = 0 is not allowed: m lies in [1e-6, 10]",
            ),
            (
                "{ type = 'phong', n = 1e9 }",
                "n = 1e9 is not allowed: n lies in [0, 1e8]",
            ),
            (
                "{ type = 'blinn', n = 1 }",
                "unknown key n: the keys of blinn are type, exponent",
            ),
            (
                "{ type = 'blinn', exponent = -1 }",
                "exponent = -1 is not allowed: exponent lies in [0, 1e8]",
            ),
            (
                "{ type = 'beckmann', m_x = 0.1 }",
                "missing key m_y: m_y is a number in [1e-6, 10]",
            ),
            (
                "{ type = 'beckmann', m_x = 0.1, m_y = 0.2, m = 0.1 }",
                "m = 0.1 is not allowed beside m_x and m_y",
            ),
            (
                "{ type = 'ggx', alpha_x = 0.1, alpha_y = 11 }",
                "alpha_y = 11 is not allowed: alpha_y lies in [1e-6, 10]",
            ),
            (
                "{ type = 'ggx', alpha_x = { min = 0.1, max = 0.2 }, alpha_y = 1 }",
                "a roughness along each tangent is a number",
            ),
            (
                "{ type = 'ashikhmin-shirley' }",
                "missing key e_x: e_x is a number in [0, 1e8]",
            ),
            (
                "{ type = 'phong', n = 1, e_x = 2 }",
                "unknown key e_x: the keys of phong are type, n",
            ),
        ],
    );
    all_refused(
        3,
        |text| microfacet(&format!("{{ type = 'vmf', kappa = {text} }}"), "'none'", "'none'"),
        &[
            (
                "{ min = 4, max = 4 }",
                "kappa = { min = 4, max = 4 } is not allowed: in a range min is smaller than max",
            ),
            ("{ min = 5, max = 4 }", "in a range min is smaller than max"),
            (
                "{ min = -4, max = 4 }",
                "min = -4 is not allowed: kappa lies in [0, 1e12]",
            ),
            ("{ min = 4, max = inf }", "max = inf is not allowed: kappa lies in"),
            ("{ min = 4 }", "missing key max"),
            (
                "{ min = 4, max = 5, steps = 3 }",
                "unknown key steps: the keys of a range are min, max",
            ),
            (
                "{ min = { min = 1 }, max = 5 }",
                "min = { min = 1 } is not allowed: only roughness parameters",
            ),
        ],
    );
}

#[test]
fn wrong_masking_and_fresnel() {
    let vmf = "{ type = 'vmf', kappa = 1 }";
    all_refused(
        3,
        |text| microfacet(vmf, text, "'none'"),
        &[
            (
                "'smith'",
                "masking \"smith\" is not allowed with distribution \"vmf\": it goes with beckmann and ggx only",
            ),
            ("'vgroove'", "did you mean \"v-groove\"?"),
            (
                "{ type = 'none' }",
                "masking is one of \"none\", \"v-groove\", \"smith\", \"smith-correlated\", \"neubelt\", \"ashikhmin\", \"charlie\", not a table",
            ),
        ],
    );
    all_refused(
        3,
        |text| microfacet(vmf, "'none'", text),
        &[
            (
                "'dielectric'",
                "dielectric has parameters, and stands in a table { type = \"dielectric\", .. }",
            ),
            (
                "1",
                "fresnel is a table such as { type = \"dielectric\", eta = 1.5 }, or \"none\", not an integer",
            ),
            (
                "{ type = 'none', eta = 1 }",
                "unknown key eta: the keys of none are type",
            ),
            (
                "{ type = 'dielectric', eta = 0 }",
                "eta = 0 is not allowed: eta lies in [0.01, 100]",
            ),
            (
                "{ type = 'conductor', eta = 1 }",
                "missing key k: k is a number, an array of three numbers, or the name of an .spd file, in [0, 100]",
            ),
            (
                "{ type = 'conductor', metal = 'Fe' }",
                "metal = 'Fe' is not allowed: metal is one of \"Ag\", \"Al\", \"Au\", \"Cu\"",
            ),
            (
                "{ type = 'conductor', metal = 'Au', k = 1 }",
                "k = 1 is not allowed beside metal or nk",
            ),
            (
                "{ type = 'conductor', eta = 1, k = 'x.spd' }",
                "k = 'x.spd' is not allowed beside a number eta",
            ),
            (
                "{ type = 'conductor', eta = 'absent.spd', k = 'x.spd' }",
                "eta = 'absent.spd' cannot be used: absent.spd: cannot be read",
            ),
            (
                "{ type = 'conductor', nk = 'absent.yml' }",
                "nk = 'absent.yml' cannot be used: absent.yml: cannot be read",
            ),
            (
                "{ type = 'conductor', eta = 1, k = [0, -1, 0] }",
                "k = -1 is not allowed: k lies in [0, 100]",
            ),
            (
                "{ type = 'schlick', r0 = 2 }",
                "r0 = 2 is not allowed: r0 lies in [0, 1]",
            ),
            ("{ type = 'schlik', r0 = 2 }", "did you mean \"schlick\"?"),
        ],
    );
}

#[test]
fn tables_without_braces_are_named_by_their_headers() {
    let header = |text: &str| format!("{HEAD}[material.bxdf]\ntype = 'microfacet'\n{text}");
    all_refused(
        3,
        header,
        &[(
            "masking = 'none'\n",
            "missing key distribution: distribution is a table such as",
        )],
    );
    all_refused(
        6,
        |text| header(&format!("distribution = {{ type = 'vmf', kappa = 1 }}\n{text}\n")),
        &[
            (
                "masking.type = 'none'",
                "masking as a table is not allowed: masking is one of",
            ),
            (
                "[material.bxdf.masking]",
                "masking as a table is not allowed: masking is one of",
            ),
        ],
    );
}

#[test]
fn wrong_couplings() {
    let white = "{ type = 'lambertian', reflectance = 1 }";
    let coupled = |specular: &str, coupling: &str| {
        format!("{{ type = 'diffuse-specular', ks = 1, kd = 1, coupling = {coupling}, specular = {specular} }}")
    };
    all_refused(
        3,
        |text| with_bxdf(&coupled(white, text)),
        &[(
            "'ashikhmin'",
            "coupling = 'ashikhmin' is not allowed: coupling is one of \"mikkelsen\", \"energy-preserving\"",
        )],
    );
    all_refused(
        3,
        |text| with_bxdf(&coupled(text, "'mikkelsen'")),
        &[
            (
                &coupled(white, "'mikkelsen'"),
                "a diffuse-specular cannot be the specular lobe of another",
            ),
            (
                "'lambertian'",
                "specular is a table with a type and its parameters, not a string",
            ),
            (
                "{ type = 'fresnel-specular', eta_b = 1.5 }",
                "the specular lobe reflects and lets nothing through",
            ),
            (
                "{ type = 'scaled', scale = 1, bxdf = { type = 'brdf-to-btdf', bxdf = { type = 'lambertian', reflectance = 1 } } }",
                "the specular lobe reflects and lets nothing through",
            ),
        ],
    );
}
