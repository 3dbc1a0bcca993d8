//! Which materials there are, and what they are called.

use super::*;

#[test]
fn materials_in_use_are_those_of_primitives_and_variants() {
    let variants = "{\"material\":1.0,\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[{\"material\":3,\"variants\":[0]}]}}}";
    let scene = file(&format!(
        "\"materials\":[{{\"name\":\"a\"}},{{\"name\":\"b\"}},{{\"name\":\"c\",\"pbrMetallicRoughness\":{{\"roughnessFactor\":7}}}},\
         {{\"name\":\"d\"}}],\"meshes\":[{{\"primitives\":[{variants},{{}},{{\"mode\":0}}]}}]"
    ))
    .unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|material| &*material.name).collect();
    assert_eq!(
        (names, &*scene.unused),
        (
            vec!["b", "d", "default material"],
            &["a".to_owned(), "c".to_owned()][..]
        )
    );
    let implied = &scene.materials[2];
    assert!(implied.implied && !scene.materials[0].implied);
    assert_eq!(implied.calls[0].by, "2 primitives that name no material");
    assert_eq!(implied.model, material("").model);
    assert!(
        scene.warnings[0].ends_with("roughnessFactor lies in [0, 1]; nothing uses the material"),
        "{:?}",
        scene.warnings
    );
    assert!(!scene.means);
    assert_eq!((&*scene.name, &*scene.source), ("test", SOURCE));

    let one = file("\"meshes\":[{\"primitives\":[{}]}]").unwrap();
    assert_eq!(one.materials[0].calls[0].by, "1 primitive that names no material");
    for nothing in ["\"scene\":0", "\"materials\":[]", "\"meshes\":[]"] {
        let scene = file(nothing).unwrap();
        assert!(scene.materials.is_empty());
        assert!(
            scene.warnings.join(" ").contains("the file has no materials"),
            "{:?}",
            scene.warnings
        );
    }
}

#[test]
fn names_are_made_unique_and_never_empty() {
    let names = |materials: &str| -> Vec<String> {
        let members = format!("\"materials\":[{materials}],\"meshes\":[]");
        file(&members)
            .unwrap()
            .materials
            .into_iter()
            .map(|material| material.name)
            .collect()
    };
    let a = "{\"name\":\"a\"}";
    assert_eq!(
        names(&format!("{a},{a},{{\"name\":\"a (2)\"}},{a}")),
        ["a", "a (2)", "a (2) (2)", "a (3)"]
    );
    assert_eq!(
        names(&format!("{a},{{\"name\":\"a (2)\"}},{a}")),
        ["a", "a (2)", "a (3)"]
    );
    assert_eq!(
        names("{},{\"name\":\"\"},{\"name\":\"  \"},{\"name\":7},{\"name\":\"material 0\"}"),
        ["material 0", "material 1", "material 2", "material 3", "material 0 (2)"]
    );
    assert_eq!(names("{\"name\":\"\\u001b[31m\\n金\"}"), ["\u{1b}[31m\n金"]);
    let default =
        file("\"materials\":[{\"name\":\"default material\"}],\"meshes\":[{\"primitives\":[{},{\"material\":0}]}]");
    assert_eq!(default.unwrap().materials[1].name, "default material (2)");
    // in time that grows with their number
    let many = vec![a; 20_000].join(",");
    assert_eq!(names(&many).last().unwrap(), "a (20000)");
}
