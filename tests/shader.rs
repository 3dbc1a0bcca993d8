//! Shader texts: every language compiles, and reads as if a person had written it.

mod skip;

use skip::skip;
use std::path::Path;
use std::process::Command;
use whitefurnace::engine::{Profile, Sizes};
use whitefurnace::plan::{Economy, Plan, Request};
use whitefurnace::scene::Scene;
use whitefurnace::shader::{Language, SceneShader, library, translate};
use whitefurnace::table::axis::Mapping;

/// Whether glslangValidator takes `text`; `None`, with a word, where it is not installed.
fn glslang(text: &str, arguments: &[&str], name: &str) -> Option<Result<(), String>> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, text).unwrap();
    match Command::new("glslangValidator").args(arguments).arg(&path).output() {
        Ok(output) if output.status.success() => Some(Ok(())),
        Ok(output) => Some(Err(String::from_utf8_lossy(&output.stdout).into_owned())),
        Err(_) => {
            skip("glslangValidator is not installed");
            None
        }
    }
}

/// A program around functions: what a person adds to them, who calls one of each kind.
fn program(language: Language, functions: &str) -> (String, Vec<&'static str>, &'static str) {
    match language {
        Language::GlslEs => (
            format!(
                "#version 300 es\nprecision highp float;\nprecision highp int;\n{functions}\nout vec4 colour;\n\
                 void main() {{\n    FurnaceLobe lobe;\n    lobe.family = FURNACE_GGX;\n    lobe.roughness = 0.3;\n    \
                 lobe.masking = FURNACE_SMITH_CORRELATED;\n    lobe.fresnel = FURNACE_SCHLICK;\n    lobe.reflectance = vec3(1.0);\n    \
                 lobe.eta = vec3(0.04);\n    lobe.k = vec3(0.0);\n    \
                 colour = vec4(furnace_f(lobe, vec3(0.0, 0.0, 1.0), vec3(0.6, 0.0, 0.8)), 1.0);\n}}\n"
            ),
            vec!["-S", "frag"],
            "library.frag",
        ),
        Language::Glsl => (
            format!(
                "#version 450\n{functions}\nlayout(location = 0) out vec4 colour;\n\
                 void main() {{\n    colour = vec4(furnace_turquin(vec3(0.5), 0.8), 1.0);\n}}\n"
            ),
            vec!["-S", "frag"],
            "library.frag",
        ),
        Language::Hlsl => (
            format!(
                "{functions}\nfloat4 main() : SV_Target\n{{\n    FurnaceLobe lobe = (FurnaceLobe)0;\n    \
                 return float4(furnace_f(lobe, float3(0.0, 0.0, 1.0), float3(0.6, 0.0, 0.8)), 1.0);\n}}\n"
            ),
            vec!["-D", "-V", "-S", "frag", "-e", "main", "-o", "/dev/null"],
            "library.hlsl",
        ),
        Language::Wgsl | Language::Msl => unreachable!("glslang does not read it"),
    }
}

#[test]
fn the_library_compiles_in_the_languages_that_glslang_reads() {
    for language in [Language::GlslEs, Language::Glsl, Language::Hlsl] {
        let (text, arguments, name) = program(language, &library(language).unwrap());
        match glslang(&text, &arguments, name) {
            Some(Err(message)) => panic!("{}: {message}\n{text}", language.name()),
            Some(Ok(())) => {}
            None => return,
        }
        // and the compiler does look
        let broken = text.replacen("return", "retrun", 1);
        assert!(glslang(&broken, &arguments, name).unwrap().is_err());
    }
}

#[test]
fn libraries_are_functions_that_can_be_pasted() {
    for language in Language::ALL {
        let text = library(language).unwrap();
        for foreign in [
            "void main",
            "#version",
            "precision ",
            "naga",
            "_group_",
            "@fragment",
            "_pad",
            "simd",
        ] {
            assert!(!text.contains(foreign), "{}: {foreign}", language.name());
        }
        for function in [
            "furnace_fresnel(",
            "furnace_f(",
            "furnace_base(",
            "furnace_kulla_conty(",
            "furnace_turquin(",
            "furnace_albedo_schlick(",
            "furnace_scale_bias(",
        ] {
            assert!(text.contains(function), "{}: {function}", language.name());
        }
        assert!(
            text.contains("// Schlick's r0 + (1 - r0) (1 - cos)^5."),
            "{}",
            language.name()
        );
        assert!(!text.contains("r0_"), "{}: {text}", language.name());
        // every name begins alike: others may define theirs beside it
        let defined = text
            .lines()
            .filter(|line| !line.starts_with([' ', '}', '/', '#', '{']) && !line.starts_with("using "));
        for line in defined.filter(|line| !line.is_empty()) {
            assert!(
                line.to_lowercase().contains("furnace") || line.starts_with(')'),
                "{}: {line}",
                language.name()
            );
        }
    }
}

#[test]
fn wrong_sources_are_refused_with_the_place() {
    for language in Language::ALL {
        let wrong = translate("fn f(x: f32) -> f32 { return x + y; }", language)
            .unwrap_err()
            .to_string();
        assert!(wrong.contains('y') && wrong.contains("wgsl:1:"), "{wrong}");
        // what the parser alone lets pass
        let wrong = translate("fn f(x: f32) -> vec2f { return x; }", language);
        assert!(wrong.is_err(), "{wrong:?}");
    }
}

/// Two functions that use one name, a name with a digit, and a reserved one.
#[test]
fn counters_go_and_meanings_stay() {
    let wgsl = "// Head.\n\n// First.\nfn one(x: f32, r0: f32) -> f32 { let step = x * r0; return step + x; }\n\
                // Second.\nfn two(x: f32) -> f32 { let step = one(x, x); if x > 0.0 { let x = step; return x; } return x; }\n";
    for language in Language::ALL {
        let text = translate(wgsl, language).unwrap();
        assert!(text.contains("// Head.") && text.contains("// First.\n") && text.contains("// Second.\n"));
        assert!(!text.contains("r0_") && text.contains("r0"), "{text}");
    }
    let glsl = translate(wgsl, Language::GlslEs).unwrap();
    assert!(glsl.contains("float two(float x)"), "{glsl}");
    // `step` is a function of GLSL
    assert!(!glsl.contains("float step "), "{glsl}");
}

/// The built-in scene and materials with names that no language takes.
fn scenes() -> Vec<SceneShader> {
    let odd = r#"
[[material]]
name = "discard; 金 2"
bxdf = { type = "fresnel-specular", eta_b = 1.5, transport = "radiance" }
[[material]]
name = "Discard - 2"
bxdf = { type = "sum", bxdfs = [{ type = "oren-nayar", reflectance = 0.5, sigma_deg = 20.0 }, { type = "specular-reflection", fresnel = { type = "conductor", eta = 0.2, k = 3.9 }, reflectance = 0.4 }] }
[[material]]
name = "main"
bxdf = { type = "brdf-to-btdf", bxdf = { type = "lambertian", reflectance = [0.1, 0.2, 0.3] } }
[[material]]
name = "coated"
bxdf = { type = "diffuse-specular", coupling = "energy-preserving", ks = 0.5, kd = [0.1, 0.5, 0.9], specular = { type = "sum", bxdfs = [
    { type = "microfacet", distribution = { type = "ggx", alpha = 0.3 }, masking = "smith", fresnel = { type = "schlick", r0 = 0.04 }, reflectance = 0.5 },
    { type = "microfacet", distribution = { type = "ggx", alpha = 0.6 }, masking = "smith", fresnel = { type = "schlick", r0 = 0.04 }, reflectance = 0.5 }] } }
[[material]]
name = "cloth under varnish"
[material.bxdf]
type = "layered"
veil = "fresnel"
top = { type = "microfacet", distribution = { type = "ggx", alpha = 0.1 }, masking = "smith-correlated", fresnel = { type = "schlick", r0 = 0.04 }, reflectance = 0.9 }
[material.bxdf.base]
type = "layered"
veil = "albedo"
top = { type = "microfacet", distribution = { type = "charlie", alpha = 0.25 }, masking = "neubelt", fresnel = { type = "none" }, reflectance = [0.5, 0.1, 0.1] }
base = { type = "lambertian", reflectance = 0.4 }
[[material]]
name = "frosted"
bxdf = { type = "rough-dielectric", eta_b = 1.5, distribution = { type = "ggx", alpha = { min = 0.1, max = 0.5 } }, masking = "smith" }
"#;
    let scenes = [Scene::default_scene(), Scene::parse(odd, "odd.toml").unwrap()];
    let economies = [Economy::FULL, Economy::NONE];
    let request = |economy| Request {
        economy,
        mapping: Some(Mapping::SqrtMu),
        ..Request::default()
    };
    let plans = scenes
        .iter()
        .flat_map(|scene| economies.map(|economy| Plan::new(scene, &request(economy)).unwrap()));
    let engines = Profile::ALL
        .map(|profile| SceneShader::of_textures(profile.name(), profile.layouts(Sizes::default()).unwrap()));
    plans.map(|plan| SceneShader::new(&plan)).chain(engines).collect()
}

#[test]
fn shaders_of_scenes_compile_in_every_language() {
    for shader in scenes() {
        for language in Language::ALL {
            let text = shader.text(language).unwrap();
            for ugly in ["_group_", "nagaSampler", "_fs;", "void main"] {
                assert!(!text.contains(ugly), "{}: {ugly} in {text}", language.name());
            }
            for table in &shader.tables {
                let named = [&table.sampler.function, &table.sampler.texture, &table.layout.file];
                assert!(
                    named.iter().all(|name| text.contains(*name)),
                    "{}: {named:?} in {text}",
                    language.name()
                );
            }
            for function in shader.materials.iter().flat_map(|(_, functions)| functions) {
                let defined = format!("{}(", function.name);
                assert!(text.contains(&defined), "{}: {defined} in {text}", language.name());
            }
            let (head, tail, arguments, name) = match language {
                Language::GlslEs => (
                    "#version 300 es\nprecision highp float;\nprecision highp int;\n",
                    "\nout vec4 colour;\nvoid main() { colour = vec4(1.0); }\n",
                    vec!["-S", "frag"],
                    "scene.frag",
                ),
                Language::Glsl => (
                    "#version 450\n",
                    "\nlayout(location = 0) out vec4 colour;\nvoid main() { colour = vec4(1.0); }\n",
                    vec!["-S", "frag"],
                    "scene.frag",
                ),
                Language::Hlsl => (
                    "",
                    "\nfloat4 main() : SV_Target { return (1.0).xxxx; }\n",
                    vec!["-D", "-V", "-S", "frag", "-e", "main", "-o", "/dev/null"],
                    "scene.hlsl",
                ),
                Language::Wgsl | Language::Msl => continue,
            };
            if let Some(Err(message)) = glslang(&format!("{head}{text}{tail}"), &arguments, name) {
                panic!("{}: {message}\n{text}", language.name());
            }
        }
    }
}

/// One function for both materials of nearly one name, and each with what it is made of.
#[test]
fn materials_become_functions_of_their_lobes() {
    let shaders = scenes();
    let names = |shader: &SceneShader, material: usize| -> Vec<String> {
        shader.materials[material]
            .1
            .iter()
            .map(|function| function.name.clone())
            .collect()
    };
    let odd = &shaders[2];
    assert_eq!(
        names(odd, 0),
        ["albedo_reflection_discard_2", "albedo_transmission_discard_2"]
    );
    assert_eq!(names(odd, 1), ["albedo_reflection_discard_2_2"]);
    assert_eq!(names(odd, 2), ["albedo_transmission_main"]);
    assert_eq!(
        names(odd, 3),
        ["albedo_reflection_coated", "base_coated", "brdf_coated"]
    );
    let text = odd.text(Language::Wgsl).unwrap();
    // 1/eta^2 of radiance from the near side
    assert!(
        text.contains("vec3f(0.44444445) * (1.0 - furnace_dielectric(mu, 1.5))"),
        "{text}"
    );
    assert!(
        text.contains("furnace_oren_nayar(") && !text.contains("fn furnace_conductor_approximate_"),
        "{text}"
    );
    assert!(text.contains(", 0.3)") && text.contains(", 0.6)"), "{text}");
    // each layer dims what lies below it, in the direction of sight
    assert_eq!(
        names(odd, 4),
        ["albedo_reflection_cloth_under_varnish", "brdf_cloth_under_varnish"]
    );
    assert_eq!(text.matches(" * furnace_veil(").count(), 6, "{text}"); // one for the cloth and two for its base, twice
    assert_eq!(
        names(odd, 5),
        ["albedo_reflection_frosted", "albedo_transmission_frosted"]
    );
}

/// What channels mean is in the functions: nobody has to know it.
#[test]
fn tables_of_engines_have_functions_that_know_their_channels() {
    for (profile, expected) in [
        (Profile::Three, ["read.x + read.y", "vec3f(read.y) + r0 *"]),
        (Profile::Generic, ["1.0 - read.y", "vec3f(read.x) + r0 *"]),
        (Profile::Godot, ["return read.y", "1.0 - (clamp(roughness, 0.0, 1.0))"]),
        (Profile::Cycles, ["return read;", "texture_3d<f32>"]),
    ] {
        let shader = SceneShader::of_textures(profile.name(), profile.layouts(Sizes::default()).unwrap());
        let text = shader.text(Language::Wgsl).unwrap();
        assert!(
            expected.iter().all(|part| text.contains(part)),
            "{expected:?} in {text}"
        );
    }
}

fn furnace(directory: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

const LOBE: &str = "[scene]\nname = \"one lobe\"\n[[material]]\nname = \"lobe\"\nbxdf = { type = \"microfacet\", distribution = \
                    { type = \"ggx\", alpha = 0.3 }, masking = \"smith\", fresnel = { type = \"none\" } }\n";

/// The axes of a shader are those of the bake, whichever it chose, also without its manifest.
#[test]
fn the_command_takes_the_axes_of_a_bake() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    std::fs::write(at.join("lobe.toml"), LOBE).unwrap();
    let baked = furnace(at, &["bake", "lobe.toml", "--resolution", "11", "--out", "tables"]);
    assert_eq!(baked.0, Some(0), "{}", baked.2);
    let shader = ["shader", "lobe.toml", "--tables", "tables"];
    let (code, wgsl, errors) = furnace(at, &shader);
    assert_eq!((code, errors.as_str()), (Some(0), ""));
    assert!(
        wgsl.contains("fn sample_lobe_rho_hd(mu: f32) -> f32") && wgsl.contains("11 x 1 texels"),
        "{wgsl}"
    );
    assert_eq!(furnace(at, &["shader", "lobe.toml", "--resolution", "11"]).1, wgsl);
    // a file, a directory, and JSON
    let (code, said, _) = furnace(at, &[&shader[..], &["--language", "hlsl", "--out", "shaders"]].concat());
    assert_eq!(code, Some(0));
    let written = std::fs::read_to_string(at.join("shaders/one-lobe.hlsl"));
    let written = written.or_else(|_| {
        let file = said.split(':').next().unwrap_or_default();
        std::fs::read_to_string(at.join(file))
    });
    assert!(
        written
            .unwrap()
            .contains("SamplerState table_lobe_rho_hd_sampler : register(s0);")
    );
    let (_, json, _) = furnace(at, &[&shader[..], &["--json"]].concat());
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["tables"][0]["function"], "sample_lobe_rho_hd");
    assert_eq!(value["materials"][0]["functions"][0]["name"], "albedo_reflection_lobe");
    assert_eq!(value["text"].as_str().unwrap().trim_end(), wgsl.trim_end());
}

#[test]
fn what_does_not_fit_the_scene_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    std::fs::write(at.join("lobe.toml"), LOBE).unwrap();
    std::fs::write(at.join("other.toml"), LOBE.replace("\"lobe\"", "\"other\"")).unwrap();
    assert_eq!(
        furnace(at, &["bake", "lobe.toml", "--resolution", "8", "--out", "tables"]).0,
        Some(0)
    );
    let refused = |arguments: &[&str], reasons: &[&str]| {
        let (code, out, errors) = furnace(at, arguments);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{errors}");
        assert!(reasons.iter().all(|reason| errors.contains(reason)), "{errors}");
    };
    let here = "tables/manifest.json";
    refused(
        &["shader", "other.toml", "--tables", "tables"],
        &[here, "no table other.rho_hd", "one lobe"],
    );
    // the same names, another lobe: its tables would be those of the first
    std::fs::write(at.join("wider.toml"), LOBE.replace("0.3", "0.5")).unwrap();
    refused(
        &["shader", "wider.toml", "--tables", "tables"],
        &[here, "tables/lobe.rho_hd.exr", "another model", "bake the scene again"],
    );
    refused(
        &["shader", "lobe.toml", "--tables", "tables", "--resolution", "16"],
        &["--resolution is not allowed with --tables"],
    );
    refused(
        &["shader", "--profile", "three", "--tables", "tables"],
        &["tables/profile.json", "cannot be read"],
    );
    refused(&["shader", "--language", "cg"], &["wgsl, glsl-es, glsl, hlsl, msl"]);
    refused(
        &["shader", "lobe.toml", "--tables", "nowhere"],
        &["nowhere/manifest.json"],
    );
    let manifest = std::fs::read_to_string(at.join(here)).unwrap();
    for (from, to, reasons) in [
        (
            "\"texel_rule\": \"",
            "\"texel_rule\": \"off-",
            ["axis mu", "not a texel rule"],
        ),
        ("\"mapping\": \"", "\"mapping\": \"cube-", ["axis mu", "not a mapping"]),
        (
            "\"max\": 1.0,\n          \"size\"",
            "\"max\": -1.0,\n          \"size\"",
            ["axis mu", "-1"],
        ),
        (
            "\"parameter\": \"mu\"",
            "\"parameter\": \"nu\"",
            ["lobe.rho_hd", "other axes"],
        ),
    ] {
        assert!(manifest.contains(from), "{from} in {manifest}");
        std::fs::write(at.join(here), manifest.replace(from, to)).unwrap();
        refused(
            &["shader", "lobe.toml", "--tables", "tables"],
            &[&reasons[..], &[here]].concat(),
        );
    }
}

/// The sizes, the files and the choice of tables are those of the bake of a profile.
#[test]
fn the_command_takes_the_tables_of_a_profile() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    std::fs::write(at.join("lobe.toml"), LOBE).unwrap();
    let sizes = ["--resolution", "9", "--roughness-resolution", "5", "--format", "dds"];
    let bake = [
        &["bake", "lobe.toml", "--profile", "generic", "--out", "tables"],
        &sizes[..],
    ]
    .concat();
    let baked = furnace(at, &bake);
    assert_eq!(baked.0, Some(0), "{}", baked.2);
    let (code, wgsl, errors) = furnace(at, &["shader", "--profile", "generic", "--tables", "tables"]);
    assert_eq!((code, errors.as_str()), (Some(0), ""));
    for part in ["9 x 5 texels", "pair.dds", "pair_mean.dds", "fn albedo_pair("] {
        assert!(wgsl.contains(part), "{part} in {wgsl}");
    }
    // the lobe calls for neither, and they were not baked
    assert!(!wgsl.contains("sheen.") && !wgsl.contains("dielectric"), "{wgsl}");
    let (code, _, errors) = furnace(at, &["shader", "--profile", "three", "--tables", "tables"]);
    assert_eq!(code, Some(2));
    assert!(errors.contains("profile \"generic\" is not \"three\""), "{errors}");
    let path = at.join("tables/profile.json");
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, reason) in [
        ("\"size\": 9", "\"size\": 0", "axes[0].size"),
        ("\"size\": 9", "\"size\": \"x\"", "axes[0].size: missing"),
        (
            "\"id\": \"pair\"",
            "\"id\": \"pears\"",
            "not one that this version knows",
        ),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let (code, _, errors) = furnace(at, &["shader", "--profile", "generic", "--tables", "tables"]);
        assert!(code == Some(2) && errors.contains(reason), "{errors}");
    }
}

/// A file that is there is replaced, a directory is made, and neither a device nor one language takes the place of another.
#[test]
fn shaders_go_where_they_are_sent() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    std::fs::write(at.join("plain"), "x").unwrap();
    let shader = |arguments: &[&str]| {
        let common = ["shader", "--profile", "three", "--language"];
        furnace(at, &[&common[..], arguments].concat())
    };
    for (arguments, file) in [
        (["glsl-es", "--out", "plain"], "plain"),
        (["glsl-es", "--out", "shaders"], "shaders/three.es.glsl"),
        (["glsl", "--out", "shaders"], "shaders/three.glsl"),
        (["wgsl", "--out", "new/deep/x.wgsl"], "new/deep/x.wgsl"),
    ] {
        let (code, said, errors) = shader(&arguments);
        assert_eq!(code, Some(0), "{errors}");
        assert!(said.starts_with(file), "{said}");
        assert!(
            std::fs::read_to_string(at.join(file)).unwrap().contains("dfgLUT.bin"),
            "{file}"
        );
    }
    let (code, _, errors) = shader(&["hlsl", "--out", "/dev/null"]);
    assert!(
        code == Some(2) && errors.contains("/dev/null") && errors.contains("a device"),
        "{errors}"
    );
}
