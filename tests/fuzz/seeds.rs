//! Good files to start from, and words of their languages.

use ::exr::prelude::*;
use glam::DVec3;
use std::collections::BTreeMap;
use std::io::Cursor;
use whitefurnace::export::exr::to_bytes;
use whitefurnace::export::formats::{Format, files};
use whitefurnace::export::manifest::{Manifest, TableEntry};
use whitefurnace::export::sha256_hex;
use whitefurnace::spectrum::Channels;
use whitefurnace::table::axis::{Axis, Mapping, TexelRule};
use whitefurnace::table::texture::Texture;
use whitefurnace::table::{Between, ErrorKind, Lobe, Quantity, Storage, Table};

pub(crate) const SCENE_WORDS: [&str; 49] = [
    "[[material]]\n",
    "[material.bxdf]\n",
    "[scene]\n",
    "[material.bxdf.specular]\n",
    "name = \"b\"\n",
    "bxdf = ",
    "type = ",
    "\"lambertian\"",
    "\"oren-nayar\"",
    "\"microfacet\"",
    "\"fresnel-blend\"",
    "\"specular-reflection\"",
    "\"specular-transmission\"",
    "\"fresnel-specular\"",
    "\"rough-dielectric\"",
    "\"irregular\"",
    "\"merl\"",
    "\"brdf-to-btdf\"",
    "\"scaled\"",
    "\"sum\"",
    "\"diffuse-specular\"",
    "\"layered\"",
    "{ type = \"charlie\", alpha = 1e-3 }",
    "\"charlie\"",
    "\"neubelt\"",
    "{ type = \"vmf\", kappa = 17 }",
    "{ type = \"ggx\", alpha_x = 1e-6, alpha_y = 10 }",
    "{ min = 1, max = 2 }",
    "{ type = \"beckmann\", m = { min = 1e-6, max = 10 } }",
    "{ type = \"ashikhmin-shirley\", e_x = 0, e_y = 1e8 }",
    "{ type = \"phong\", n = 1e8 }",
    "\"smith\"",
    "\"smith-correlated\"",
    "\"v-groove\"",
    "\"none\"",
    "{ type = \"conductor\", metal = \"Au\" }",
    "{ type = \"dielectric\", eta = 0.01 }",
    "{ type = \"schlick\", r0 = 1 }",
    "{ type = \"conductor\", eta = 100, k = 100 }",
    "{ type = \"lambertian\", reflectance = 1 }",
    "[0.5, 0, 1]",
    "\"../../x\"",
    "\"\\u0000\\u001b[2J\\u202e\"",
    "\"\"\"",
    "'''",
    "a.b.c.d = ",
    "{",
    "[",
    "# ",
];

pub(crate) const GLTF_WORDS: [&str; 60] = [
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "{},",
    "null",
    "true",
    "\"\"",
    "\"\\u0000\\u202e\"",
    "\"\\ud800\"",
    "\"\\ue000\": {},",
    "1e999",
    "1e300",
    "5e-324",
    "[0, 0, 0]",
    "[1, 1, 1, 1]",
    "\"asset\": {\"version\": \"2.0\"},",
    "\"minVersion\": \"2.0\",",
    "\"materials\": [",
    "\"meshes\": [{\"primitives\": [",
    "\"material\": 1",
    "\"attributes\": {\"TANGENT\": 0}",
    "\"extensionsUsed\": [",
    "\"extensionsRequired\": [",
    "\"extensions\": {",
    "\"extras\": ",
    "\"name\": \"gold (2)\",",
    "\"textures\": [{}],",
    "{\"index\": 0}",
    "\"pbrMetallicRoughness\": {",
    "\"baseColorFactor\": ",
    "\"metallicFactor\": 0.5,",
    "\"roughnessFactor\": 0,",
    "\"metallicRoughnessTexture\": {\"index\": 0},",
    "\"normalTexture\": {\"index\": 0},",
    "\"KHR_materials_anisotropy\": {\"anisotropyStrength\": 1},",
    "\"KHR_materials_clearcoat\": {\"clearcoatFactor\": 1, \"clearcoatRoughnessFactor\": 0.5},",
    "\"KHR_materials_dispersion\": {\"dispersion\": 0.1},",
    "\"KHR_materials_emissive_strength\": {\"emissiveStrength\": 2},",
    "\"KHR_materials_ior\": {\"ior\": 0},",
    "\"KHR_materials_ior\": {\"ior\": 1e300},",
    "\"KHR_materials_iridescence\": {\"iridescenceFactor\": 1},",
    "\"KHR_materials_sheen\": {\"sheenColorFactor\": [1, 0, 0], \"sheenRoughnessFactor\": 1},",
    "\"KHR_materials_specular\": {\"specularFactor\": 0.5},",
    "\"specularColorFactor\": [1e300, 0, 1]",
    "\"KHR_materials_pbrSpecularGlossiness\": {\"glossinessFactor\": 0.5},",
    "\"specularGlossinessTexture\": {\"index\": 0}",
    "\"KHR_materials_transmission\": {\"transmissionFactor\": 1},",
    "\"transmissionTexture\": {\"index\": 0}",
    "\"KHR_materials_unlit\": {},",
    "\"KHR_materials_variants\": {\"mappings\": [{\"material\": 0}]},",
    "\"KHR_materials_volume\": {},",
    "\"VENDOR_unknown\": {},",
    "glTF\u{2}\0\0\0",
    "JSON",
    "BIN\0",
    "\u{8}\0\0\0BIN\0",
    "\u{feff}",
];

pub(crate) const PBRT_WORDS: [&str; 62] = [
    "WorldBegin\n",
    "WorldEnd\n",
    "AttributeBegin\n",
    "AttributeEnd\n",
    "ObjectBegin \"o\"\n",
    "ObjectEnd\n",
    "ObjectInstance \"o\"\n",
    "Shape \"sphere\"\n",
    "Include \"tests/data/corpus/pbrt/included.pbrt\"\n",
    "Include \".\"\n",
    "Material \"\"\n",
    "Material \"matte\"\n",
    "Material \"plastic\"\n",
    "Material \"metal\"\n",
    "Material \"glass\"\n",
    "Material \"mirror\"\n",
    "Material \"uber\"\n",
    "Material \"substrate\"\n",
    "Material \"translucent\"\n",
    "Material \"disney\"\n",
    "Material \"subsurface\"\n",
    "Material \"\u{7}\u{202e}\"\n",
    "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"\n",
    "MakeNamedMaterial \"a\" \"string type\" \"uber\"\n",
    "MakeNamedMaterial \"b\" \"string type\" \"mix\"\n",
    "NamedMaterial \"a\"\n",
    "Texture \"t\" \"float\" \"imagemap\"\n",
    "Texture \"t\" \"spectrum\" \"imagemap\"\n",
    "Texture \"t\" \"float\" \"scale\" \"float tex1\" 1e200 \"texture tex2\" \"t\"\n",
    "Texture \"t\" \"float\" \"mix\" \"texture tex1\" \"t\" \"float tex2\" -1\n",
    "Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 ]\n",
    "LookAt 0 0 0 1 1 1 0 0 1\n",
    "MediumInterface \"a\" \"\"\n",
    "ActiveTransform All\n",
    "\"rgb Kd\" [ 0.5 0 1 ] ",
    "\"rgb Ks\" [ 1 1 1 ] ",
    "\"rgb Kr\" [ 0 0 0 ] ",
    "\"rgb Kt\" [ 1 0 0 ] ",
    "\"xyz Kd\" [ 0.1 0.9 0 ] ",
    "\"rgb opacity\" [ 0.5 0.5 0.5 ] ",
    "\"rgb amount\" [ 0 1 0.5 ] ",
    "\"texture amount\" \"t\" ",
    "\"texture Kd\" \"t\" ",
    "\"texture roughness\" \"t\" ",
    "\"texture uroughness\" \"t\" ",
    "\"float vroughness\" 0 ",
    "\"float roughness\" 1e-3 ",
    "\"bool remaproughness\" \"false\" ",
    "\"float sigma\" 90 ",
    "\"float index\" 0.01 ",
    "\"float eta\" 100 ",
    "\"spectrum eta\" \"Au.eta.spd\" ",
    "\"spectrum k\" [ 400 1 700 1e300 ] ",
    "\"spectrum k\" \"\" ",
    "\"blackbody Kd\" [ 6500 1 ] ",
    "\"blackbody Kd\" [ 1 1e300 ] ",
    "\"point P\" [ 0 0 0 ] ",
    "\"bogus name\" 1 ",
    "\\n",
    "# ",
    "[",
    "]",
];

pub(crate) const NUMBER_WORDS: [&str; 12] = [
    "31",
    "0.000001",
    "1.570797",
    "-6.283185",
    "1e12",
    "-1e12",
    "380.0 ",
    "# ",
    "\r\n",
    "\n",
    "\u{feff}",
    "1001",
];

pub(crate) const YAML_WORDS: [&str; 22] = [
    "DATA:",
    "  - type: tabulated nk\n",
    "  - type: tabulated n\n",
    "  - type: tabulated k\n",
    "  - type: formula 1\n",
    "    data: |\n",
    "    data: >\n",
    "        0.5 1.0 2.0\n",
    "&a ",
    "*a",
    "<<: ",
    "- ",
    ": ",
    "? ",
    "[",
    "{",
    "!!binary ",
    "---\n",
    "...\n",
    "%YAML 1.2\n",
    "\t",
    "\u{feff}",
];

pub(crate) const EXR_WORDS: [&str; 22] = [
    "channels\0chlist\0",
    "compression\0compression\0\u{1}\0\0\0\u{3}",
    "compression\0compression\0\u{1}\0\0\0\u{4}",
    "dataWindow\0box2i\0",
    "displayWindow\0box2i\0",
    "lineOrder\0lineOrder\0",
    "tiles\0tiledesc\0",
    "chunkCount\0int\0",
    "type\0string\0",
    "deepscanline",
    "preview\0preview\0",
    "whitefurnaceFormat\0int\0",
    "sampleSha256\0string\0",
    "parameters\0stringvector\0",
    "axis0.size\0int\0",
    "betweenAt0\0double\0",
    "betweenError\0string\0",
    "timeCode\0timecode\0",
    "keyCode\0keycode\0",
    "m44f\0m44f\0",
    "\0",
    "R\0",
];

pub(crate) const JSON_WORDS: [&str; 20] = [
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "null",
    "true",
    "\"\"",
    "\"\\ud800\"",
    "\"\\u0000\"",
    "1e999",
    "-0.0",
    "\"tables\":",
    "\"file\": \"../x\"",
    "\"parameters\": {\"a\": []}",
    "\"format\": 3",
    "\"size\": [18446744073709551615, 1]",
    "\"between\": null",
    "\"error\": null",
];

pub(crate) fn scenes() -> Vec<Vec<u8>> {
    let every = include_bytes!("../data/every-type.toml").to_vec();
    let built_in = include_bytes!("../../src/scene/default.toml").to_vec();
    let small = b"[[material]]\nname='a'\nbxdf={type='lambertian',reflectance=1}\n".to_vec();
    vec![every, built_in, small]
}

/// A published file, one with every extension that is known, and one with defaults.
pub(crate) fn gltf() -> Vec<Vec<u8>> {
    let published = include_bytes!("../data/gltf/UnlitTest.gltf").to_vec();
    let every = include_bytes!("../data/corpus/gltf/every-extension.gltf").to_vec();
    let small = br#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{}]}]}"#.to_vec();
    vec![published, every, small]
}

/// Small containers, so that damage hits their headers: of JSON alone, and with chunks behind it.
pub(crate) fn glb() -> Vec<Vec<u8>> {
    let json = br#"{"asset":{"version":"2.0"},"materials":[{"name":"a"}]} "#;
    let chunk = |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes(), &kind[..], data].concat();
    let contained = |behind: &[u8]| {
        let chunks = [&chunk(b"JSON", json), behind].concat();
        let length = 12 + chunks.len() as u32;
        [b"glTF", &2u32.to_le_bytes(), &length.to_le_bytes(), &chunks[..]].concat()
    };
    let binary = chunk(b"BIN\0", &[7; 8]);
    let more = [&binary[..], &chunk(b"MORE", &[0; 4])].concat();
    vec![contained(b""), contained(&binary), contained(&more)]
}

/// Every material together and each by itself, with the textures and materials that they refer to.
pub(crate) fn pbrt() -> Vec<Vec<u8>> {
    let every = include_str!("../data/corpus/pbrt/every-material.pbrt");
    let lines = |begins: &'static [&str]| {
        let wanted = move |line: &&str| begins.iter().any(|begin| line.starts_with(begin));
        every.lines().filter(wanted)
    };
    let definitions: Vec<&str> = lines(&["Texture", "MakeNamedMaterial"]).collect();
    let definitions = definitions.join("\n");
    let each = lines(&["Material"]).map(|line| format!("{definitions}\n{line}\nShape \"sphere\"\n").into_bytes());
    let small = b"Material \"mirror\" Shape \"sphere\"\n".to_vec();
    [every.as_bytes().to_vec(), small].into_iter().chain(each).collect()
}

pub(crate) fn merl() -> Vec<Vec<u8>> {
    let header = [90i32, 90, 180].map(i32::to_le_bytes).concat();
    let with = |values: &[f64]| {
        let cells: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        [header.clone(), cells].concat()
    };
    vec![with(&[1.0]), with(&[0.5, -1.0, 1e12, 0.0])]
}

pub(crate) fn irregular() -> Vec<Vec<u8>> {
    let few = include_bytes!("../data/acryl-blue-30.brdf").to_vec();
    vec![few, b"2\n400 700\n0 0 0 0 .1 .2\n1.5 -3 1.5 3 1 -1\n".to_vec()]
}

pub(crate) fn yaml() -> Vec<Vec<u8>> {
    let gold = include_bytes!("../data/Au__nk__Johnson.yml").to_vec();
    let apart = "DATA:\n  - type: tabulated n\n    data: |\n        0.4 1.5\n        0.7 0.5\n  - type: tabulated k\n    data: |\n        \
                 0.4 1.5\n        0.7 3.5\n";
    vec![gold, apart.into()]
}

pub(crate) fn spd() -> Vec<Vec<u8>> {
    vec![b"# nm value\n380 1.5\r\n550.5 0\n 700\t1e2 # red\n".to_vec()]
}

/// Tables without, with one and with two axes.
pub(crate) fn tables() -> [Table; 3] {
    let table = |channels: Channels, axes: Vec<Axis>| {
        let texels: usize = axes.iter().map(|axis| axis.size).product();
        let grey = |value: f64| DVec3::splat(value);
        Table {
            id: format!("lobe.{}", axes.len()),
            quantity: if axes.is_empty() {
                Quantity::RhoHh
            } else {
                Quantity::RhoHd
            },
            lobe: Lobe::Reflection,
            channels,
            values: (0..texels).map(|i| grey(1.0 / (1.0 + i as f64))).collect(),
            errors: (0..texels).map(|i| grey(1e-9 * i as f64)).collect(),
            error_kind: ErrorKind::Bound,
            parameters: vec![("eta".into(), "1.5".into())],
            estimator: "quadrature".into(),
            tolerance: 1e-6,
            goal: None,
            evaluations: u64::MAX,
            seed: 7,
            between: (!axes.is_empty()).then(|| Between {
                error: 1e-3,
                at: vec![0.5; axes.len()],
                probes: 1000,
            }),
            axes,
        }
    };
    let mu = Axis::new("mu", Mapping::SqrtMu, TexelRule::Centres, [0.0, 1.0], 8).unwrap();
    let roughness = Axis::new("alpha", Mapping::Log, TexelRule::Ends, [0.1, 1.0], 3).unwrap();
    [
        table(Channels::Grey, vec![]),
        table(Channels::Rgb, vec![mu.clone()]),
        table(Channels::Grey, vec![mu, roughness]),
    ]
}

/// Tables and textures of ours, and images in every compression, in lines and in tiles.
pub(crate) fn exr() -> Vec<Vec<u8>> {
    let ours = tables().map(|table| to_bytes(&table).unwrap());
    let kinds = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
    ];
    let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(4, 3))];
    let images = kinds.iter().flat_map(|kind| blocks.map(|blocks| image(*kind, blocks)));
    let textures = tables().map(|table| {
        let texture = Texture::of(&table, Storage::F16).unwrap();
        files(&texture, Format::Exr).unwrap().remove(0).1
    });
    ours.into_iter().chain(textures).chain(images).collect()
}

/// Two parts of halves, floats and integers.
fn image(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let layer = |name: &str| {
        let floats: Vec<f32> = (0..35).map(|i| 0.5 - i as f32).collect();
        let halves = floats.iter().map(|float| f16::from_f32(*float)).collect();
        let list = [
            AnyChannel::new("depth", FlatSamples::F32(floats)),
            AnyChannel::new("id", FlatSamples::U32((7..42).collect())),
            AnyChannel::new("half", FlatSamples::F16(halves)),
        ];
        let encoding = Encoding {
            compression,
            blocks,
            line_order: LineOrder::Increasing,
        };
        let channels = AnyChannels::sort(list.into_iter().collect());
        Layer::new((7, 5), LayerAttributes::named(name), encoding, channels)
    };
    let mut bytes = Vec::new();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((7, 5)));
    let image = Image::from_layers(attributes, vec![layer("one"), layer("two")]);
    image
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .unwrap();
    bytes
}

pub(crate) fn manifests() -> Vec<Vec<u8>> {
    let entry = |table: Table| {
        let bytes = to_bytes(&table).unwrap();
        TableEntry::new(
            &table,
            format!("{}.exr", table.id),
            bytes.len() as u64,
            sha256_hex(&bytes),
            &["Größe".into(), "\u{202e}b\u{1b}".into()],
        )
    };
    let requests = BTreeMap::from([("lobe.0".into(), "0123".into())]);
    let manifest = Manifest::new("figure 7", 1, &["Größe".into()], tables().map(entry).to_vec(), requests);
    let empty = Manifest::new("", 0, &[], vec![], BTreeMap::new());
    [manifest, empty]
        .map(|manifest| manifest.to_json().unwrap().into_bytes())
        .to_vec()
}
