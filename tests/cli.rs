//! The binary as its users meet it: exit codes, files, messages, JSON.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use whitefurnace::export::read::{Contents, read_exr};
use whitefurnace::export::sha256_hex;
use whitefurnace::table::Table;

fn furnace(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Standard output of a run that succeeds and says nothing else but notes.
fn good(directory: &Path, arguments: &[&str]) -> String {
    let output = furnace(directory, arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    // no progress, no escape sequences where no terminal looks on
    assert!(
        errors.lines().all(|line| line.starts_with("note: ")),
        "{arguments:?}: {errors}"
    );
    let out = text(&output.stdout);
    assert!(!out.contains('\u{1b}') && !out.contains('\r'), "{arguments:?}: {out}");
    out
}

fn good_json(directory: &Path, arguments: &[&str]) -> Value {
    let out = good(directory, arguments);
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{arguments:?}: {error} in\n{out}"))
}

/// Standard error of a run that is refused with exit code 2 and prints nothing.
fn refused(directory: &Path, arguments: &[&str]) -> String {
    let output = furnace(directory, arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    assert!(errors.starts_with("error: "), "{arguments:?}: {errors}");
    assert!(!errors.contains("panicked"), "{arguments:?}: {errors}");
    errors
}

/// Names of the files of a directory, hidden ones included.
fn files(directory: &Path) -> BTreeSet<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    fs::read_dir(directory).unwrap().map(name).collect()
}

fn table(path: &Path) -> Table {
    match read_exr(path).unwrap().contents {
        Contents::Table { table, .. } => *table,
        Contents::Foreign(_) => panic!("{} is no table", path.display()),
    }
}

/// A scene with the given `distribution`, `masking` and `fresnel` of its material `lobe`.
fn scene(distribution: &str, masking: &str, fresnel: &str) -> String {
    format!(
        "[scene]\nname = \"a lobe\"\n\n[[material]]\nname = \"lobe\"\n[material.bxdf]\ntype = \"microfacet\"\n\
         distribution = {distribution}\nmasking = \"{masking}\"\nfresnel = {fresnel}\n"
    )
}

fn write_scene(directory: &Path, name: &str, text: &str) {
    fs::write(directory.join(name), text).unwrap();
}

const VMF: &str = "{ type = \"vmf\", kappa = 17.0 }";
const METHANOL: &str = "{ type = \"dielectric\", eta = 1.329 }";
/// Small tables, for what does not depend on their size.
const SMALL: [&str; 4] = ["--resolution", "8", "--roughness-resolution", "3"];

#[test]
fn a_bake_writes_the_files_of_its_manifest_and_no_others() {
    let directory = tempfile::tempdir().unwrap();
    let out = good(directory.path(), &[&["bake"], &SMALL[..]].concat());
    for part in [
        "default: 18 tables",
        "methanol-k17.specular.rho_hd",
        "texel error",
        "lookup error",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    let baked = directory.path().join("outputs/default");
    let manifest: Value = serde_json::from_slice(&fs::read(baked.join("manifest.json")).unwrap()).unwrap();
    let mut named = BTreeSet::from(["manifest.json", ".furnace"].map(String::from));
    for entry in manifest["tables"].as_array().unwrap() {
        let file = entry["file"].as_str().unwrap();
        let bytes = fs::read(baked.join(file)).unwrap();
        assert_eq!(entry["bytes"], bytes.len(), "{file}");
        assert_eq!(entry["sha256"], sha256_hex(&bytes), "{file}");
        assert!(named.insert(file.to_string()), "{file} twice");
        let table = table(&baked.join(file));
        assert_eq!(entry["id"], table.id);
        assert_eq!(entry["min"].as_f64(), Some(table.range().0));
        assert_eq!(entry["max"].as_f64(), Some(table.range().1));
        assert_eq!(entry["max_texel_error"].as_f64(), Some(table.max_texel_error()));
        assert_eq!(entry["evaluations"], table.evaluations);
        let between = table.between.as_ref().map(|between| between.error);
        assert_eq!(entry["between"]["error"].as_f64(), between);
    }
    assert_eq!(files(&baked), named);

    // a second bake goes over the first
    let mut json = good_json(directory.path(), &[&["bake", "--json"], &SMALL[..]].concat());
    assert_eq!(files(&baked), named);
    // which differs from the first in that it has nothing to compute, and says so
    let again: Value = serde_json::from_slice(&fs::read(baked.join("manifest.json")).unwrap()).unwrap();
    assert_eq!(json["manifest"], again);
    let ids: Vec<&Value> = manifest["tables"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| &entry["id"])
        .collect();
    assert_eq!(manifest["reused"], serde_json::json!([]));
    assert_eq!(again["reused"], serde_json::json!(ids));
    json["manifest"]["reused"] = serde_json::json!([]);
    assert_eq!(json["manifest"], manifest);
    assert_eq!(json["directory"], "outputs/default");
    assert!(json["seconds"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_plan_lists_the_tables_that_a_bake_writes() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(
        here,
        "range.toml",
        &scene("{ type = \"phong\", n = { min = 0, max = 1e4 } }", "v-groove", METHANOL),
    );
    for arguments in [&SMALL[..], &[&SMALL[..], &["range.toml"]].concat()] {
        let plan = good_json(here, &[&["plan", "--json"], arguments].concat());
        let bake = good_json(here, &[&["bake", "--json", "--out", "out"], arguments].concat());
        let bake = &bake["manifest"];
        assert_eq!(plan["scene"], bake["scene"]);
        let (planned, written) = (plan["tables"].as_array().unwrap(), bake["tables"].as_array().unwrap());
        assert_eq!(planned.len(), written.len());
        for (planned, written) in planned.iter().zip(written) {
            for key in ["id", "quantity", "channels", "materials", "estimator", "tolerance"] {
                assert_eq!(planned[key], written[key], "{key} of {}", planned["id"]);
            }
            // one of the alternatives is kept
            let shape = |axes: &Value| -> Vec<[String; 4]> {
                let keys = ["parameter", "mapping", "texel_rule", "size"];
                let axes = axes.as_array().unwrap().iter();
                axes.map(|axis| keys.map(|key| axis[key].to_string())).collect()
            };
            let alternatives = planned["alternative_axes"].as_array().unwrap().iter();
            let mut choices = alternatives.chain([&planned["axes"]]).map(shape);
            assert!(
                choices.any(|choice| choice == shape(&written["axes"])),
                "{}",
                planned["id"]
            );
        }
        assert!(!plan["skipped"].as_array().unwrap().is_empty());
    }
}

#[test]
fn a_bake_that_fails_leaves_nothing_half_written() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(
        here,
        "narrow.toml",
        &scene("{ type = \"vmf\", kappa = 1e9 }", "v-groove", METHANOL),
    );
    let uniform = ["bake", "narrow.toml", "--estimator", "mc-uniform", "--samples", "1000"];

    // a lobe that uniform samples never hit
    let errors = refused(here, &[&uniform[..], &["--out", "new"]].concat());
    for part in ["lobe.rho_hd", "mu = ", "mc-uniform", "mc-normals"] {
        assert!(errors.contains(part), "{part} is not in {errors}");
    }
    assert!(!here.join("new").exists());

    // older tables stay what they were
    good(here, &[&["bake", "narrow.toml", "--out", "old"], &SMALL[..]].concat());
    let read = || -> Vec<Vec<u8>> {
        let names = files(&here.join("old")).into_iter();
        names
            .filter(|name| name != ".furnace")
            .map(|name| fs::read(here.join("old").join(name)).unwrap())
            .collect()
    };
    let before = read();
    refused(here, &[&uniform[..], &["--out", "old"]].concat());
    assert_eq!(read(), before);

    // a directory in the place of a table is found when the tables are to take their names: no manifest, no parts of files, and
    // what is finished is kept
    fs::create_dir_all(here.join("taken/lobe.rho_hd.exr/inside")).unwrap();
    let errors = refused(here, &[&["bake", "narrow.toml", "--out", "taken"], &SMALL[..]].concat());
    assert!(errors.contains("taken/lobe.rho_hd.exr"), "{errors}");
    assert_eq!(
        files(&here.join("taken")),
        BTreeSet::from([".furnace".to_string(), "lobe.rho_hd.exr".to_string()])
    );
    assert!(errors.contains("2 tables are finished and kept in taken"), "{errors}");
    assert!(
        files(&here.join("taken/.furnace"))
            .iter()
            .all(|name| name.ends_with(".exr"))
    );

    fs::write(here.join("file"), b"mine").unwrap();
    for out in ["file", "file/deeper"] {
        let errors = refused(here, &["bake", "--out", out]);
        assert!(errors.contains(out) && errors.contains("file is a file"), "{errors}");
    }
    assert_eq!(fs::read(here.join("file")).unwrap(), b"mine");
}

/// Root may write anywhere, but not even root into /proc.
#[cfg(target_os = "linux")]
#[test]
fn directories_that_cannot_be_written_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let errors = refused(directory.path(), &["bake", "--out", "/proc/furnace/tables"]);
    assert!(errors.contains("/proc/furnace/tables"), "{errors}");
}

/// The keys of one result, in order, for materials without a roughness range.
const KEYS: [&str; 13] = [
    "material",
    "quantity",
    "lobe",
    "mu",
    "phi_deg",
    "value",
    "error",
    "tolerance",
    "error_kind",
    "estimator",
    "evaluations",
    "seconds",
    "roughness",
];

fn check_result(result: &Value, grey: bool) {
    let keys: Vec<&String> = result.as_object().unwrap().keys().collect();
    let range = result["material"] == "vmf-any-roughness";
    assert_eq!(keys, KEYS[..if range { 13 } else { 12 }]);
    let numbers = |key: &str| -> Vec<f64> {
        let list = result[key].as_array().unwrap();
        list.iter().map(|number| number.as_f64().unwrap()).collect()
    };
    let (value, error) = (numbers("value"), numbers("error"));
    assert_eq!(
        (value.len(), error.len()),
        if grey { (1, 1) } else { (3, 3) },
        "{result}"
    );
    assert!(value.iter().all(|value| (0.0..=1.0 + 1e-6).contains(value)), "{result}");
    assert!(error.iter().all(|error| *error > 0.0), "{result}");
    assert_eq!(result["lobe"], "reflection");
    assert!(["bound", "ci99", "exact"].contains(&result["error_kind"].as_str().unwrap()));
    assert!(result["evaluations"].is_u64() && result["seconds"].as_f64().unwrap() >= 0.0);
    match result["quantity"].as_str().unwrap() {
        "rho_hd" => assert!(result["mu"].is_f64() && result["phi_deg"].is_f64(), "{result}"),
        "rho_hh" => assert!(result["mu"].is_null() && result["phi_deg"].is_null(), "{result}"),
        other => panic!("{other}"),
    }
}

#[test]
fn rho_prints_one_result_for_every_combination() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let materials: [(&str, bool); 3] = [
        ("methanol-k17", false),
        ("beckmann-m0.2", true),
        ("vmf-any-roughness", true),
    ];
    for (name, grey) in materials {
        let json = good_json(
            here,
            &[
                "rho",
                "--json",
                "--material",
                name,
                "--mu",
                "0,0.25",
                "--theta-deg",
                "30",
                "--phi-deg",
                "0,-90.5,360",
                "--hh",
                "--roughness",
                "2,3,4",
            ],
        );
        assert_eq!(
            json.as_object().unwrap().keys().collect::<Vec<_>>(),
            ["scene", "results"]
        );
        assert_eq!(json["scene"], "default");
        let results = json["results"].as_array().unwrap();
        let roughnesses = if name == "vmf-any-roughness" { 3 } else { 1 };
        assert_eq!(results.len(), roughnesses * (3 * 3 + 1), "{name}");
        let mut seen = BTreeSet::new();
        for result in results {
            check_result(result, grey);
            assert_eq!(result["material"], name);
            let place = ["mu", "phi_deg", "roughness"].map(|key| result[key].to_string());
            assert!(seen.insert(place.clone()), "{place:?} twice");
        }
        let cos_30 = 60f64.to_radians().sin();
        for mu in [0.0, 0.25, cos_30] {
            for phi in [0.0, -90.5, 360.0] {
                let here = |r: &&Value| r["mu"].as_f64() == Some(mu) && r["phi_deg"].as_f64() == Some(phi);
                assert_eq!(results.iter().filter(here).count(), roughnesses, "{name} {mu} {phi}");
            }
        }
    }
    // nothing asked for: seven angles and rho_hh of every material, both ends of a range
    let json = good_json(here, &["rho", "--json"]);
    assert_eq!(json["results"].as_array().unwrap().len(), 8 * (8 + 2));
    // rho_hh alone
    let json = good_json(here, &["rho", "--json", "--hh", "--material", "phong-n48"]);
    assert_eq!(json["results"].as_array().unwrap().len(), 1);
}

/// One row for every tolerance, those of one direction below each other, and fewer evaluations for fewer digits.
#[test]
fn rho_shows_what_digits_cost() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let asked = [
        "rho",
        "--material",
        "ggx-a0.3",
        "--mu",
        "0.1,0.5",
        "--hh",
        "--tolerance",
    ];
    let json = good_json(here, &[&asked[..], &["1e-3,1e-6,1e-9", "--json"]].concat());
    let results = json["results"].as_array().unwrap();
    assert_eq!(results.len(), 3 * 3);
    for direction in results.chunks(3) {
        let tolerances: Vec<f64> = direction.iter().map(|row| row["tolerance"].as_f64().unwrap()).collect();
        assert_eq!(tolerances, [1e-3, 1e-6, 1e-9]);
        let evaluations: Vec<u64> = direction
            .iter()
            .map(|row| row["evaluations"].as_u64().unwrap())
            .collect();
        assert!(
            evaluations.is_sorted() && evaluations[0] < evaluations[2],
            "{evaluations:?}"
        );
        for row in direction {
            assert_eq!(
                (&row["mu"], &row["quantity"]),
                (&direction[0]["mu"], &direction[0]["quantity"])
            );
            let off = (row["value"][0].as_f64().unwrap() - direction[2]["value"][0].as_f64().unwrap()).abs();
            assert!(row["error"][0].as_f64() <= row["tolerance"].as_f64());
            assert!(off <= row["error"][0].as_f64().unwrap() + direction[2]["error"][0].as_f64().unwrap());
        }
    }
    let shown = good(here, &[&asked[..], &["1e-3,1e-6"]].concat());
    assert!(
        shown.lines().next().unwrap().contains("phi/deg  tolerance  value"),
        "{shown}"
    );
    assert!(!good(here, &[&asked[..], &["1e-3"]].concat()).contains("tolerance"));
}

/// A bake to a tolerance keeps it as a shader sees it, and the plan tells its sizes; given sizes stay and are told of.
#[test]
fn a_tolerance_chooses_sizes() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(here, "lobe.toml", &scene(VMF, "v-groove", METHANOL));
    for tolerance in ["1e-2", "1e-3", "1e-4"] {
        let allowed: f64 = tolerance.parse().unwrap();
        let plan = good_json(here, &["plan", "lobe.toml", "--tolerance", tolerance, "--json"]);
        let bake = good_json(
            here,
            &[
                "bake",
                "lobe.toml",
                "--tolerance",
                tolerance,
                "--json",
                "--out",
                tolerance,
            ],
        );
        assert_eq!(bake["unmet"], serde_json::json!({}));
        let tables = bake["manifest"]["tables"].as_array().unwrap();
        for (planned, written) in plan["tables"].as_array().unwrap().iter().zip(tables) {
            let written_table = table(&here.join(tolerance).join(written["file"].as_str().unwrap()));
            let lookup = written["between"]["error"].as_f64();
            assert!(lookup.unwrap_or(0.0) <= allowed, "{written}");
            assert!(written["max_texel_error"].as_f64().unwrap() <= allowed);
            assert_eq!(written["tolerance"].as_f64(), Some(written_table.tolerance));
            assert!(written_table.tolerance < allowed && planned["tolerance"] == written["tolerance"]);
            // one axis: the measured size is the planned one
            assert_eq!(
                planned["axes"].as_array().unwrap().len(),
                written["axes"].as_array().unwrap().len()
            );
            for (planned, written) in planned["axes"]
                .as_array()
                .unwrap()
                .iter()
                .zip(written["axes"].as_array().unwrap())
            {
                for key in ["parameter", "mapping", "texel_rule", "size"] {
                    assert_eq!(planned[key], written[key], "{key}");
                }
            }
            assert!(planned["lookup_error"].as_f64().unwrap() <= allowed);
            assert!(planned["smallest"]["bytes"].as_u64() <= planned["bytes"].as_u64());
            assert!(planned["half_the_error"]["lookup_error"].as_f64().unwrap() <= 0.5 * allowed);
        }
    }
    let shown = good(here, &["plan", "lobe.toml", "--tolerance", "1e-3"]);
    for part in ["half the error", "f32 bytes", "unorm16", "evaluations/texel"] {
        assert!(shown.contains(part), "{part} is not in\n{shown}");
    }
    let given = [
        "bake",
        "lobe.toml",
        "--tolerance",
        "1e-4",
        "--resolution",
        "8",
        "--out",
        "given",
    ];
    let shown = good(here, &given);
    for part in [
        "exceeded: lookups of lobe.rho_hd",
        "more than 1e-4",
        "8 texels along mu",
    ] {
        assert!(shown.contains(part), "{part} is not in\n{shown}");
    }
    let json = good_json(here, &[&given[..], &["--json"]].concat());
    assert!(json["unmet"]["lobe.rho_hd"].is_string(), "{json}");
}

#[test]
fn rho_names_what_its_errors_mean() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(
        here,
        "grey.toml",
        "[[material]]\nname = \"grey\"\nbxdf = { type = \"lambertian\", reflectance = 0.25 }\n",
    );
    let json = good_json(here, &["rho", "grey.toml", "--json", "--mu", "0.5"]);
    let result = &json["results"][0];
    assert_eq!(
        (&result["error_kind"], &result["estimator"]),
        (&"exact".into(), &"closed-form".into())
    );
    assert_eq!(
        (result["value"][0].as_f64(), &result["evaluations"]),
        (Some(0.25), &0.into())
    );
    let visible = [
        "rho",
        "--json",
        "--mu",
        "0.5",
        "--material",
        "phong-n48",
        "--samples",
        "5000",
    ];
    let json = good_json(here, &[&visible[..], &["--estimator", "mc-visible"]].concat());
    let result = &json["results"][0];
    assert_eq!(
        (&result["error_kind"], &result["estimator"]),
        (&"ci99".into(), &"mc-visible".into())
    );
    assert_eq!(result["evaluations"], 5000);
    let json = good_json(here, &visible);
    assert_eq!(
        (&json["results"][0]["error_kind"], &json["results"][0]["estimator"]),
        (&"bound".into(), &"quadrature".into())
    );
}

/// One number in three places: `rho`, the texel, the manifest.
#[test]
fn rho_texels_and_manifest_agree() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let bake = good_json(here, &[&["bake", "--json", "--out", "out"], &SMALL[..]].concat());
    for entry in bake["manifest"]["tables"].as_array().unwrap() {
        let id = entry["id"].as_str().unwrap();
        // those are of a lobe of the material, and of two of its kind
        if id.contains(".specular.") || entry["channels"] == 2 {
            continue;
        }
        let table = table(&here.join("out").join(entry["file"].as_str().unwrap()));
        for i in [0, table.values.len() / 2, table.values.len() - 1] {
            let at = table.texel_values(i);
            let mut flags = vec![
                "rho".to_string(),
                "--json".into(),
                "--material".into(),
                entry["materials"][0].as_str().unwrap().into(),
            ];
            if table.quantity.name() == "rho_hh" {
                flags.push("--hh".into());
            }
            for (axis, value) in table.axes.iter().zip(&at) {
                let flag = if axis.parameter == "mu" { "--mu" } else { "--roughness" };
                flags.extend([flag.to_string(), format!("{value:?}")]);
            }
            let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
            let json = good_json(here, &flags);
            let result = &json["results"][0];
            for (channel, value) in result["value"].as_array().unwrap().iter().enumerate() {
                let value = value.as_f64().unwrap();
                // the same integral to the same tolerance: the texel is its rounding to f32
                let stored = table.stored(i)[channel];
                assert_eq!(stored, f64::from(value as f32), "{id} at {at:?}");
                let (min, max) = (entry["min"].as_f64().unwrap(), entry["max"].as_f64().unwrap());
                assert!((min..=max).contains(&stored), "{id}");
                let error = result["error"][channel].as_f64().unwrap();
                assert!(table.texel_error(i)[channel] >= error, "{id}");
                assert!(entry["max_texel_error"].as_f64().unwrap() >= error, "{id}");
            }
        }
    }
}

#[test]
fn inspect_tells_tables_from_others_and_from_damage() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(here, "lobe.toml", &scene(VMF, "v-groove", METHANOL));
    let bake = good_json(
        here,
        &[&["bake", "lobe.toml", "--json", "--out", "out"], &SMALL[..]].concat(),
    );
    let file = "out/lobe.rho_hd.exr";
    let shown = good(here, &["inspect", file]);
    for part in [
        "rho_hd, reflection",
        "u = ",
        "lookup error",
        "quadrature, tolerance 1e-6, seed 0",
        "kappa = 17",
    ] {
        assert!(shown.contains(part), "{part} is not in\n{shown}");
    }
    let mut json = good_json(here, &["inspect", file, "--json"]);
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    // all that the manifest says of the table, said of the file as it was named
    json["file"] = "lobe.rho_hd.exr".into();
    for (key, value) in bake["manifest"]["tables"][0].as_object().unwrap() {
        assert_eq!(json[key], *value, "{key}");
    }

    let pixels = exr::prelude::SpecificChannels::rgb(|at: exr::prelude::Vec2<usize>| (at.x() as f32, 0.5f32, f32::NAN));
    exr::prelude::WritableImage::write(&exr::prelude::Image::from_channels((5, 2), pixels))
        .to_file(here.join("foreign.exr"))
        .unwrap();
    let shown = good(here, &["inspect", "foreign.exr"]);
    for part in [
        "5 x 2",
        "R (f32): 0 .. 4",
        "B (f32): no finite sample, 10 not finite",
        "no attributes of whitefurnace",
    ] {
        assert!(shown.contains(part), "{part} is not in\n{shown}");
    }
    // who uses a table is said by the manifest alone
    fs::copy(here.join(file), here.join("alone.exr")).unwrap();
    let alone = good_json(here, &["inspect", "alone.exr", "--json"]);
    assert_eq!(
        (&alone["materials"], &alone["id"]),
        (&serde_json::json!([]), &"alone".into())
    );
    assert!(good(here, &["inspect", "alone.exr"]).contains("no manifest beside it lists the file"));

    let json = good_json(here, &["inspect", "foreign.exr", "--json"]);
    assert_eq!(json["foreign"][0]["size"], serde_json::json!([5, 2]));

    let bytes = fs::read(here.join(file)).unwrap();
    let mut flipped = bytes.clone();
    let last = flipped.len() - 3;
    flipped[last] ^= 4;
    let half = &bytes[..bytes.len() / 2];
    for (name, bytes, reason) in [
        ("short.exr", half, "cannot read short.exr"),
        ("flipped.exr", &flipped[..], "hash"),
        ("empty.exr", b"", "cannot read empty.exr"),
        ("text.exr", b"no image at all", "cannot read text.exr"),
    ] {
        fs::write(here.join(name), bytes).unwrap();
        let errors = refused(here, &["inspect", name]);
        assert!(errors.contains(reason) && errors.contains(name), "{name}: {errors}");
        assert_eq!(refused(here, &["inspect", name, "--json"]), errors);
    }
    assert!(refused(here, &["inspect", "missing.exr"]).contains("missing.exr"));
    assert!(refused(here, &["inspect", "out"]).contains("out"));
}

/// Flags that are refused, and what the message has to name: the flag, the value, what is allowed.
#[test]
fn wrong_flags_say_what_is_allowed() {
    let directory = tempfile::tempdir().unwrap();
    for (arguments, parts) in [
        (&["rho", "--mu", "1.5"][..], &["--mu", "1.5", "[0, 1]"][..]),
        (&["rho", "--mu", "-0.1"], &["--mu", "-0.1", "[0, 1]"]),
        (&["rho", "--mu", "0.5,nan"], &["--mu", "nan", "[0, 1]"]),
        (&["rho", "--mu", "half"], &["--mu", "half", "number"]),
        (&["rho", "--mu", ""], &["--mu", "number"]),
        (&["rho", "--theta-deg", "90.5"], &["--theta-deg", "90.5", "[0, 90]"]),
        (&["rho", "--phi-deg", "inf"], &["--phi-deg", "inf", "[-360, 360]"]),
        (&["rho", "--roughness", "-1"], &["--roughness", "-1", "1e12"]),
        (
            &["rho", "--roughness", "5000", "--material", "vmf-any-roughness"],
            &["--roughness", "5000", "kappa", "[1, 4096]", "vmf-any-roughness"],
        ),
        (
            &["rho", "--material", "gold"],
            &["gold", "methanol-k17", "vmf-any-roughness"],
        ),
        (&["bake", "--tolerance", "0"], &["--tolerance", "0", "1e-12", "0.5"]),
        (&["bake", "--tolerance", "0.6"], &["--tolerance", "0.6", "0.5"]),
        (&["plan", "--tolerance", "1e-13"], &["--tolerance", "1e-12"]),
        (
            &["plan", "--tolerance", "1e-3,1e-4"],
            &["--tolerance", "2 values", "only rho"],
        ),
        (
            &["bake", "--tolerance", "1e-3,1e-4,1e-5"],
            &["--tolerance", "3 values", "only rho"],
        ),
        (&["rho", "--tolerance", "1e-3,1"], &["--tolerance", "1", "0.5"]),
        (
            &["bake", "--samples", "1"],
            &["--samples", "1", "from 2 to 1099511627776"],
        ),
        (&["bake", "--samples", "many"], &["--samples", "many"]),
        (&["bake", "--threads", "0"], &["--threads", "0", "from 1 to 1024"]),
        (&["bake", "--seed", "-1"], &["-1"]),
        (&["bake", "--seed", "1.5"], &["--seed", "1.5"]),
        (&["bake", "--resolution", "1"], &["--resolution", "1", "2 to 16384"]),
        (
            &["bake", "--resolution", "16385"],
            &["--resolution", "16385", "2 to 16384"],
        ),
        (
            &["bake", "--roughness-resolution", "x"],
            &["--roughness-resolution", "x", "whole number"],
        ),
        (
            &["bake", "--axis", "log"],
            &["--axis", "log", "auto, mu, sqrt-mu and fourth-root-mu"],
        ),
        (
            &["bake", "--estimator", "magic"],
            &["--estimator", "magic", "auto, closed-form, quadrature, mc-uniform"],
        ),
        (
            &["bake", "--estimator", "closed-form"],
            &["closed-form", "methanol-k17", "use auto"],
        ),
        (
            &["rho", "--estimator", "closed-form"],
            &["closed-form", "methanol-k17", "use auto"],
        ),
        (&["rho", "--colour"], &["--colour"]),
        (&["bakery"], &["bakery", "bake"]),
        (&["inspect"], &["FILE"]),
        (&["bake", "a.toml", "b.toml"], &["b.toml"]),
    ] {
        let errors = refused(directory.path(), arguments);
        for part in parts {
            assert!(errors.contains(part), "{arguments:?}: {part} is not in\n{errors}");
        }
    }
    assert_eq!(files(directory.path()), BTreeSet::new());
}

/// Scenes that are refused, and what the message has to name: file:line:column, the value, what is allowed.
#[test]
fn wrong_scenes_say_where_and_what_is_allowed() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let lobe = |distribution: &str| scene(distribution, "v-groove", METHANOL);
    for (text, parts) in [
        (
            lobe("{ type = \"vmf\", kappa = -3 }"),
            &["bad.toml:8:40", "kappa = -3", "[0, 1e12]"][..],
        ),
        (
            lobe("{ type = \"vmf\", kapa = 3 }"),
            &["bad.toml:8:32", "kapa", "did you mean kappa?"],
        ),
        (lobe("{ type = \"vmf\" }"), &["bad.toml:8:", "missing", "kappa"]),
        (
            lobe("{ type = \"gauss\", m = 1 }"),
            &["bad.toml:8:", "gauss", "\"vmf\", \"beckmann\""],
        ),
        (
            lobe("{ type = \"vmf\", kappa = { min = 5, max = 2 } }"),
            &["bad.toml:8:", "min", "max"],
        ),
        (
            lobe("{ type = \"vmf\", kappa = \"17\" }"),
            &["bad.toml:8:40", "17", "number"],
        ),
        (
            scene(VMF, "w-groove", METHANOL),
            &["bad.toml:9:11", "w-groove", "\"none\", \"v-groove\""],
        ),
        (
            scene(VMF, "v-groove", "{ type = \"dielectric\", eta = 0 }"),
            &["bad.toml:10:", "eta = 0", "[0.01, 100]"],
        ),
        (
            lobe(VMF).replace("[scene]", "[scenes]"),
            &["bad.toml:1:2", "scenes", "did you mean scene?"],
        ),
        (format!("{}{}", lobe(VMF), &lobe(VMF)[25..]), &["bad.toml:", "lobe"]),
        (
            lobe(VMF).replace(" = \"lobe\"", " ="),
            &["bad.toml:5:", "not valid TOML"],
        ),
        (String::new(), &["bad.toml:1:1", "material"]),
    ] {
        write_scene(here, "bad.toml", &text);
        for command in ["bake", "plan", "rho"] {
            let errors = refused(here, &[command, "bad.toml"]);
            for part in parts {
                assert!(
                    errors.contains(part),
                    "{command}: {part} is not in\n{errors}\nof\n{text}"
                );
            }
        }
    }
    assert_eq!(files(here), BTreeSet::from(["bad.toml".to_string()]));
    for (name, part) in [("missing.toml", "No such file"), (".", "directory")] {
        let errors = refused(here, &["plan", name]);
        assert!(errors.contains(name) && errors.contains(part), "{errors}");
    }
}

/// What a newcomer has to find in the help of each command.
#[test]
fn help_says_what_a_newcomer_needs() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (arguments, parts) in [
        (
            &["--help"][..],
            &[
                "bake",
                "plan",
                "rho",
                "inspect",
                "Examples:",
                "rho_hd is",
                "rho_hh is",
                "Exit codes",
            ][..],
        ),
        (
            &["bake", "--help"],
            &[
                "outputs/<scene>",
                "--tolerance",
                "--estimator",
                "--seed",
                "--threads",
                "--json",
                "manifest.json",
                "lookup",
                "R G B",
            ],
        ),
        (&["plan", "--help"], &["cost", "--resolution", "--tolerance", "--json"]),
        (
            &["rho", "--help"],
            &[
                "--mu",
                "--theta-deg",
                "--phi-deg",
                "--hh",
                "--material",
                "Examples:",
                "0 stands for the limit",
            ],
        ),
        (&["inspect", "--help"], &[".exr", "--json"]),
    ] {
        let help = good(here, arguments);
        for part in parts {
            assert!(help.contains(part), "{arguments:?}: {part} is not in\n{help}");
        }
        assert!(
            help.lines().all(|line| line.chars().count() <= 100),
            "{arguments:?}\n{help}"
        );
    }
    assert!(good(here, &["--version"]).contains(env!("CARGO_PKG_VERSION")));
    // no command: the help, as an error
    let output = furnace(here, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("Examples:"));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    for arguments in [&["rho", "--mu", "0.5"][..], &["rho", "--json"], &["plan", "--json"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_furnace"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        assert!(!line.is_empty());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert_eq!(text(&output.stderr), "", "{arguments:?}");
    }
    // gone before the first line
    let mut child = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .args(["rho", "--mu", "0.5"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

/// Output that does not arrive is a failure; build systems go by the exit code.
#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let directory = tempfile::tempdir().unwrap();
    for arguments in [
        &["rho", "--json", "--mu", "0.5"][..],
        &["plan"],
        &["bake", "--resolution", "4"],
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
            .current_dir(directory.path())
            .args(arguments)
            .stdout(full)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            text(&output.stderr).contains("cannot write to standard output"),
            "{arguments:?}"
        );
    }
}

/// The coupling of the paper is the default.
#[test]
fn coupling_defaults_to_the_printed_equation() {
    let directory = tempfile::tempdir().unwrap();
    let scene = |coupling: &str| {
        format!(
            "[[material]]\nname = \"m\"\n[material.bxdf]\ntype = \"diffuse-specular\"\n{coupling}ks = 1\nkd = 0.5\n\
             specular = {{ type = \"microfacet\", distribution = {{ type = \"vmf\", kappa = 17 }}, masking = \"v-groove\", \
             fresnel = {{ type = \"dielectric\", eta = 1.5 }} }}\n"
        )
    };
    let value = |name: &str, coupling: &str| {
        write_scene(directory.path(), name, &scene(coupling));
        good_json(directory.path(), &["rho", name, "--json", "--mu", "0.5"])["results"][0]["value"].clone()
    };
    let default = value("default.toml", "");
    assert_eq!(default, value("printed.toml", "coupling = \"mikkelsen\"\n"));
    assert_ne!(default, value("other.toml", "coupling = \"energy-preserving\"\n"));
}

/// A changed header and a table of another bake are noticed through the manifest.
#[test]
fn inspect_and_bake_compare_with_the_manifest() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let scene = scene(VMF, "v-groove", "{ type = \"dielectric\", eta = 1.25 }").replace("\"lobe\"", "\"grey\"");
    write_scene(here, "one.toml", &scene);
    write_scene(here, "two.toml", &scene.replace("grey", "other"));
    good(here, &["bake", "one.toml", "--out", "tables"]);
    assert!(good(here, &["inspect", "tables/grey.rho_hd.exr"]).contains("as in the manifest"));
    let path = here.join("tables/grey.rho_hd.exr");
    let bytes = fs::read(&path).unwrap();
    let at = bytes.windows(4).position(|window| window == b"1.25").unwrap();
    let mut changed = bytes.clone();
    changed[at + 3] = b'6';
    fs::write(&path, changed).unwrap();
    assert!(good(here, &["inspect", "tables/grey.rho_hd.exr"]).contains("finding: the manifest"));
    let report = good(here, &["bake", "two.toml", "--out", "tables"]);
    assert!(
        report.contains("did not write: grey.rho_hd.exr, grey.rho_hh.exr"),
        "{report}"
    );
    assert!(good(here, &["inspect", "tables/grey.rho_hd.exr"]).contains("does not list this file"));
}

/// Exit code and both outputs of a verification that runs to its end.
fn verified(directory: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = furnace(directory, &[&["verify"], arguments].concat());
    let errors = text(&output.stderr);
    assert!(
        errors.lines().all(|line| line.starts_with("note: ")),
        "{arguments:?}: {errors}"
    );
    (output.status.code(), text(&output.stdout))
}

/// Everything holds for right models; known departures are findings, and failures only when asked for.
#[test]
fn verify_tells_what_holds() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(here, "right.toml", &scene(VMF, "v-groove", METHANOL));
    write_scene(here, "unmasked.toml", &scene(VMF, "none", METHANOL));

    let (code, out) = verified(here, &["right.toml"]);
    assert_eq!(code, Some(0), "{out}");
    for part in [
        "lobe\n",
        "energy",
        "max rho = ",
        "chi2 = ",
        "visible normals",
        "99.9 % of runs",
        "0 failed, 0 findings",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    assert!(!out.contains("FAILS"), "{out}");

    let (code, json) = verified(here, &["right.toml", "--json", "--seed", "5", "--confidence", "0.99"]);
    assert_eq!(code, Some(0), "{json}");
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["scene"], &json["seed"], &json["confidence"], &json["ok"]),
        (&"a lobe".into(), &5.into(), &0.99.into(), &true.into())
    );
    let statistical = json["statistical"].as_f64().unwrap();
    let level = json["level"].as_f64().unwrap();
    assert!((level - (1.0 - 0.99f64.powf(1.0 / statistical))).abs() < 1e-12);
    for result in json["results"].as_array().unwrap() {
        assert_eq!(
            (&result["material"], &result["verdict"]),
            (&"lobe".into(), &"holds".into()),
            "{result}"
        );
        assert!(
            result["statistic"]["value"].is_number() && result["statistic"]["name"].is_string(),
            "{result}"
        );
        assert!(
            result["p_value"].is_null() || result["p_value"].as_f64().unwrap() >= level,
            "{result}"
        );
    }

    let (code, out) = verified(here, &["unmasked.toml"]);
    assert_eq!(code, Some(0), "{out}");
    for part in [
        "finding",
        "max rho = unbounded",
        "theta 90",
        "exceeds 1 beyond",
        "skipped",
        "1 finding,",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    assert_eq!(verified(here, &["unmasked.toml", "--strict"]).0, Some(1));
    let (_, json) = verified(here, &["unmasked.toml", "--strict", "--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["ok"], &json["failed"], &json["findings"]),
        (&false.into(), &0.into(), &1.into())
    );
    assert!(json["results"][0]["statistic"]["value"].is_null());
}

/// The same report for the same seed, on any number of threads.
#[test]
fn verify_repeats_itself() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(here, "right.toml", &scene(VMF, "v-groove", METHANOL));
    let run = |arguments: &[&str]| verified(here, &[&["right.toml", "--json"], arguments].concat());
    let first = run(&["--threads", "1"]);
    assert_eq!(first, run(&["--threads", "3"]));
    assert_ne!(first, run(&["--seed", "1"]));
}

#[test]
fn verify_refuses_what_makes_no_sense() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (arguments, part) in [
        (&["verify", "--confidence", "0.5"][..], "between 0.5 and 1"),
        (&["verify", "--confidence", "1"], "between 0.5 and 1"),
        (&["verify", "--confidence", "nan"], "confidence"),
        (&["verify", "--confidence=-1"], "between 0.5 and 1, ends excluded"),
        (&["verify", "--material", "unobtainium"], "no material `unobtainium`"),
        (&["verify", "missing.toml"], "missing.toml"),
        (&["verify", "--tables", "missing"], "missing/manifest.json"),
        (&["verify", "--threads", "0"], "1 to 1024"),
    ] {
        let errors = refused(here, arguments);
        assert!(errors.contains(part), "{arguments:?}: {errors}");
    }
    fs::create_dir(here.join("damaged")).unwrap();
    fs::write(here.join("damaged/manifest.json"), "{ \"format\": 1,").unwrap();
    let errors = refused(here, &["verify", "--tables", "damaged"]);
    assert!(errors.contains("damaged/manifest.json"), "{errors}");
}

/// Tables are tested against the scene, the manifest and fresh integrals; damage is a failed check that names the file.
#[test]
fn verify_tests_tables() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write_scene(here, "right.toml", &scene(VMF, "v-groove", METHANOL));
    write_scene(
        here,
        "other.toml",
        &scene("{ type = \"vmf\", kappa = 18.0 }", "v-groove", METHANOL),
    );
    good(here, &[&["bake", "right.toml", "--out", "tables"], &SMALL[..]].concat());
    let run = |scene: &str| verified(here, &[scene, "--tables", "tables"]);

    let (code, out) = run("right.toml");
    assert_eq!(code, Some(0), "{out}");
    for part in [
        "table lobe.rho_hd\n",
        "table lobe.rho_hh\n",
        "contents",
        "texels, sampled",
        "lookup",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    // another scene
    let (code, out) = run("other.toml");
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("kappa is 17, the scene says 18"), "{out}");

    // cut short, gone, and not listed
    let path = here.join("tables/lobe.rho_hd.exr");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let (code, out) = run("right.toml");
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("lobe.rho_hd.exr") && out.contains("FAILS"), "{out}");
    fs::remove_file(&path).unwrap();
    assert_eq!(run("right.toml").0, Some(1));
    fs::write(&path, &bytes).unwrap();
    assert_eq!(run("right.toml").0, Some(0));
    let manifest = here.join("tables/manifest.json");
    let mut json: Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    let tables = json["tables"].as_array_mut().unwrap();
    tables[0]["sha256"] = "0".repeat(64).into();
    tables.pop();
    fs::write(&manifest, json.to_string()).unwrap();
    let (code, out) = run("right.toml");
    assert_eq!(code, Some(1), "{out}");
    for part in [
        "its content hash differs from the manifest",
        "the manifest does not list it",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    // what a file does not say, the manifest and the scene have to agree on
    json["tables"][0]["materials"] = serde_json::json!(["lobe", "other"]);
    fs::write(&manifest, json.to_string()).unwrap();
    let (code, out) = run("right.toml");
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("its materials are lobe, other, the scene says lobe"),
        "{out}"
    );
    // a name that leads out of the directory is not followed
    json["tables"][0]["file"] = "../right.toml".into();
    fs::write(&manifest, json.to_string()).unwrap();
    let (code, out) = run("right.toml");
    assert_eq!(code, Some(1), "{out}");
    assert!(out.contains("no name of a file beside the manifest"), "{out}");
}

/// One direction without a value does not take the others with it.
#[test]
fn rho_prints_what_there_is_beside_what_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let material = |name: &str, masking: &str| {
        format!(
            "[[material]]\nname = \"{name}\"\n[material.bxdf]\ntype = \"microfacet\"\nfresnel = \"none\"\n\
             distribution = {{ type = \"vmf\", kappa = 17.0 }}\nmasking = \"{masking}\"\n"
        )
    };
    let text = [
        "[scene]\nname = \"s\"\n".into(),
        material("open", "none"),
        material("grooves", "v-groove"),
    ]
    .concat();
    fs::write(here.join("scene.toml"), text).unwrap();

    let output = furnace(here, &["rho", "scene.toml", "--mu", "0.5,0,1e-300"]);
    let (table, errors) = (self::text(&output.stdout), self::text(&output.stderr));
    assert_eq!(output.status.code(), Some(2), "{errors}");
    let rows: Vec<&str> = table.lines().filter(|line| line.contains("rho_hd")).collect();
    assert_eq!(rows.len(), 6, "{table}");
    let is_refused = |row: &&str| row.contains("refused");
    assert_eq!(
        rows.iter().map(is_refused).collect::<Vec<_>>(),
        [false, true, true, false, false, false]
    );
    for part in [
        "note: material `open`: rho_hd grows without bound",
        "(rho_hd at mu = 0, phi = 0 degrees)",
        "rho_hd at mu = 1e-300, phi = 0 degrees",
        "instead of the 1e-6 asked for",
        "error: 2 of 6 values were refused",
    ] {
        assert!(errors.contains(part), "{part} is not in {errors}");
    }

    let output = furnace(
        here,
        &["rho", "scene.toml", "--mu", "0.5,0", "--material", "open", "--json"],
    );
    assert_eq!(output.status.code(), Some(2));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let [good, bad] = &json["results"].as_array().unwrap()[..] else {
        panic!("{json}")
    };
    assert!(good["value"][0].is_f64() && good.get("refused").is_none(), "{good}");
    assert_eq!(
        [&bad["value"], &bad["error"], &bad["error_kind"], &bad["evaluations"]],
        [&Value::Null; 4]
    );
    assert_eq!(
        (&bad["mu"], &bad["estimator"]),
        (&Value::from(0.0), &Value::from("auto"))
    );
    assert!(bad["refused"].as_str().unwrap().contains("mu -> 0"), "{bad}");
}
