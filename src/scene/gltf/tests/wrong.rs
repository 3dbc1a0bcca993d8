//! What is in the way, what is looked past, and what there is too much of.

use super::*;

#[test]
fn what_is_in_the_way_is_refused_with_its_place() {
    let refused = |members: &str, expected: &str| {
        let error = file(members).map(|scene| scene.warnings).unwrap_err().to_string();
        assert_eq!(error, format!("{SOURCE}: {expected}"));
    };
    let of = |properties: &str| library(&format!("{{}},{{{properties}}}"));
    refused(
        &of("\"pbrMetallicRoughness\":{\"roughnessFactor\":7}"),
        "materials[1].pbrMetallicRoughness.roughnessFactor = 7 is not allowed: roughnessFactor lies in [0, 1]",
    );
    refused(
        &of("\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1.5,1]}"),
        "materials[1].pbrMetallicRoughness.baseColorFactor[2] = 1.5 is not allowed: baseColorFactor lies in [0, 1]",
    );
    refused(
        &of("\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1]}"),
        "materials[1].pbrMetallicRoughness.baseColorFactor has 3 elements, which is not allowed: it is an array of 4 numbers",
    );
    refused(
        &of("\"pbrMetallicRoughness\":{\"metallicFactor\":\"0\"}"),
        "materials[1].pbrMetallicRoughness.metallicFactor = \"0\" is not allowed: it is a number, and metallicFactor lies in [0, 1]",
    );
    refused(
        &of("\"pbrMetallicRoughness\":[]"),
        "materials[1].pbrMetallicRoughness is an array, which is not allowed: it is an object",
    );
    refused(
        &of("\"extensions\":5"),
        "materials[1].extensions = 5 is not allowed: it is an object",
    );
    refused(
        &of("\"extensions\":{\"KHR_materials_ior\":null}"),
        "materials[1].extensions.KHR_materials_ior is null, which is not allowed: it is an object",
    );
    let dielectric = |extension: (&str, &str)| of(&properties("\"metallicFactor\":0.5", &[extension]));
    for ior in ["-0.5", "0.5"] {
        refused(
            &dielectric(("ior", &format!("\"ior\":{ior}"))),
            &format!("materials[1].extensions.KHR_materials_ior.ior = {ior} is not allowed: ior is 0 or at least 1"),
        );
    }
    refused(
        &dielectric(("specular", "\"specularColorFactor\":[0,-1,0]")),
        "materials[1].extensions.KHR_materials_specular.specularColorFactor[1] = -1 is not allowed: \
         specularColorFactor is at least 0",
    );
    refused(
        "\"materials\":{}",
        "materials is an object, which is not allowed: it is an array",
    );
    refused("\"materials\":[7]", "materials[0] = 7 is not allowed: it is an object");
    for material in ["1", "-1", "0.5", "1e300", "18446744073709551616"] {
        let error = message(&format!(
            "\"materials\":[{{}}],\"meshes\":[{{\"primitives\":[{{\"material\":{material}}}]}}]"
        ));
        assert!(
            error.starts_with("dir/test.gltf: meshes[0].primitives[0].material = "),
            "{error}"
        );
        assert!(
            error.ends_with("is not allowed: of materials the file has one, with the index 0"),
            "{error}"
        );
    }
    refused("\"meshes\":7", "meshes = 7 is not allowed: it is an array");
}

#[test]
fn what_has_no_effect_is_told_and_looked_past() {
    for (properties, expected) in [
        // the dielectric part of a metal
        (properties("", &[("ior", "\"ior\":0.5")]), "ior = 0.5"),
        (
            properties("", &[("transmission", "\"transmissionFactor\":2")]),
            "transmissionFactor = 2",
        ),
        // behind a factor of 0
        (
            properties("", &[("clearcoat", "\"clearcoatRoughnessFactor\":2")]),
            "clearcoatRoughnessFactor = 2",
        ),
        (
            properties("", &[("iridescence", "\"iridescenceIor\":0.5")]),
            "iridescenceIor = 0.5",
        ),
        // no table depends on it
        (
            properties("", &[("emissive_strength", "\"emissiveStrength\":-1")]),
            "emissiveStrength = -1",
        ),
        (
            properties("", &[("volume", "\"attenuationDistance\":0")]),
            "attenuationDistance = 0",
        ),
        ("\"emissiveFactor\":[2,0,0]".to_owned(), "emissiveFactor[0] = 2"),
        ("\"normalTexture\":7".to_owned(), "normalTexture = 7"),
    ] {
        let scene = file(&library(&format!("{{{properties}}}"))).unwrap();
        assert_eq!(effects(&scene.materials[0]), ["metal"], "{properties}");
        assert!(
            scene.warnings.len() == 1 && scene.warnings[0].contains(expected),
            "{:?}",
            scene.warnings
        );
    }
    for (members, expected) in [
        ("\"samplers\":{}", "samplers is an object"),
        ("\"nodes\":[null]", "nodes[0] is null"),
        ("\"extensionsUsed\":[1]", "extensionsUsed[0] = 1"),
        ("\"extensions\":{\"X\":[]}", "extensions.X is an array"),
        (
            "\"materials\":[{\"extensions\":{\"X\":1}}]",
            "materials[0].extensions.X is not declared",
        ),
        (
            "\"materials\":[{\"pbrMetallicRoughness\":{\"metalicFactor\":0}}]",
            "did you mean metallicFactor?",
        ),
        (
            "\"textures\":[{}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":1}}}]",
            "index = 1",
        ),
    ] {
        assert!(file(members).is_ok(), "{members}");
        assert!(message(members).contains(expected), "{}", message(members));
    }
}

#[test]
fn only_gltf_2_is_known() {
    let version = |asset: &str| scene(format!("{{\"asset\":{asset}}}").as_bytes(), SOURCE);
    for good in [
        "{\"version\":\"2.0\"}",
        "{\"version\":\"2.7\"}",
        "{\"version\":\"2.1\",\"minVersion\":\"2.0\"}",
    ] {
        assert!(version(good).is_ok(), "{good}");
    }
    for bad in [
        "{}",
        "7",
        "{\"version\":2.0}",
        "{\"version\":\"1.0\"}",
        "{\"version\":\"3.0\"}",
        "{\"version\":\"2\"}",
        "{\"version\":\"2.1\",\"minVersion\":\"2.1\"}",
    ] {
        let error = version(bad).unwrap_err().to_string();
        assert!(error.starts_with("dir/test.gltf: asset"), "{error}");
    }
}

#[test]
fn text_that_is_no_json_is_refused_with_line_and_column() {
    let error = scene("{\"asset\":\n {\"é\":1,}}".as_bytes(), SOURCE)
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("dir/test.gltf:2:9: not valid JSON: trailing comma"),
        "{error}"
    );
    assert!(error.ends_with("2 |  {\"é\":1,}}\n   |         ^"), "{error}");
    let nested = format!("{{\"materials\":[{}", "[".repeat(100_000));
    let zeros = format!("{{\"extras\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000));
    for (text, expected) in [
        ("", "EOF"),
        ("{\"asset\":{\"version\":\"2.0\"}}x", "trailing characters"),
        (
            "{\"asset\":{\"version\":\"2.0\",\"version\":\"2.0\"}}",
            "two values named \"version\"",
        ),
        ("{\"materials\":[],\"materials\":[]}", "two values named \"materials\""),
        ("{\"materials\":[{\"alphaCutoff\":1e999}]}", "number out of range"),
        (&nested, "recursion limit"),
    ] {
        let error = scene(text.as_bytes(), SOURCE).unwrap_err().to_string();
        assert!(error.contains("not valid JSON") && error.contains(expected), "{error}");
        assert!(error.lines().all(|line| line.chars().count() <= 130), "{error}");
    }
    // what is passed over may be as deep as it likes
    let error = scene(zeros.as_bytes(), SOURCE).unwrap_err().to_string();
    assert!(error.contains("asset is missing"), "{error}");
    let error = scene(b"{\"asset\":\"\xff\"}", SOURCE).unwrap_err().to_string();
    assert!(error.contains("byte 10 (counted from 0) is not UTF-8"), "{error}");
    let bom = scene("\u{feff}{\"asset\":{\"version\":\"2.0\"}}".as_bytes(), SOURCE).unwrap();
    assert!(
        bom.warnings[0].starts_with("byte 0 begins a byte order mark"),
        "{:?}",
        bom.warnings
    );
}

#[test]
fn there_is_a_limit_to_materials_and_to_what_is_kept() {
    let most = vec!["{}"; MOST_MATERIALS].join(",");
    assert_eq!(
        file(&format!("\"materials\":[{most}]")).unwrap().materials.len(),
        MOST_MATERIALS
    );
    let error = file(&format!("\"materials\":[{most},{{}}]")).unwrap_err().to_string();
    assert!(error.contains("more than 65536 materials"), "{error}");
    let many = "0,".repeat(MOST_NODES);
    let error = file(&format!("\"materials\":[{{\"name\":[{many}0]}}]"))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("more than 4194304 values that describe materials"),
        "{error}"
    );
    assert!(file(&format!("\"materials\":[{{\"extras\":[{many}0]}}]")).is_ok());
}

#[test]
fn text_cut_anywhere_is_refused() {
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},{},\"meshes\":[{{\"primitives\":[{{\"material\":0}}]}}]}}",
        library(&format!(
            "{{\"name\":\"é\",{}}}",
            properties(PLASTIC, &[("clearcoat", "\"clearcoatFactor\":1")])
        ))
    );
    assert_eq!(scene(text.as_bytes(), SOURCE).unwrap().materials.len(), 1);
    for end in 0..text.len() {
        let error = scene(&text.as_bytes()[..end], SOURCE).unwrap_err();
        assert!(
            matches!(error, SceneError::Refused(_) | SceneError::NotUtf8 { .. }),
            "{end}: {error}"
        );
    }
}

#[test]
fn whatever_is_changed_there_is_an_error_or_a_scene_of_models() {
    let others = [
        ("transmission", "\"transmissionFactor\":0.5"),
        ("ior", "\"ior\":1.5"),
        ("anisotropy", "\"anisotropyStrength\":0.3"),
    ];
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},{},\"meshes\":[{{\"primitives\":[{{\"material\":0}},{{}}]}}]}}",
        library(&format!("{{{}}},{{}}", properties(PLASTIC, &others)))
    );
    let mut read = 0;
    for at in 0..text.len() {
        for byte in *b"09-.e\"{}[], x" {
            let mut bytes = text.clone().into_bytes();
            bytes[at] = byte;
            match scene(&bytes, SOURCE) {
                Err(error) => assert!(error.to_string().starts_with(SOURCE), "{error}"),
                Ok(scene) => {
                    read += 1;
                    for material in &scene.materials {
                        let model = material.model.at(None);
                        assert!(
                            model.is_ok() && !material.name.is_empty(),
                            "{}",
                            String::from_utf8_lossy(&bytes)
                        );
                    }
                }
            }
        }
    }
    // names and digits may be others
    assert!(read > 1000, "{read}");
}
