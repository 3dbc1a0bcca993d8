use super::*;
use crate::table::samples::{grey_2d, rgb_1d, scalar};

fn textures(storage: Storage) -> [Texture; 3] {
    [grey_2d(), rgb_1d(), scalar()].map(|table| Texture::of(&table, storage).unwrap())
}

/// All that a format takes is written, named by the id, and the same twenty times.
#[test]
fn the_same_bytes_every_time() {
    for format in Format::ALL {
        for storage in Storage::ALL.into_iter().filter(|storage| format.takes(*storage)) {
            for texture in textures(storage) {
                let first = files(&texture, format).unwrap();
                let names: Vec<&str> = first.iter().map(|(name, _)| name.as_str()).collect();
                let expected = format.extensions().iter();
                let expected: Vec<String> = expected.map(|end| format!("{}.{end}", texture.id)).collect();
                assert_eq!(names, expected);
                assert!((0..20).all(|_| files(&texture, format).unwrap() == first), "{format:?}");
            }
        }
        assert!(format.takes(format.default_storage()));
        assert_eq!(Format::from_name(format.name()), Some(format));
    }
}

#[test]
fn facts_are_said_in_every_format_that_has_room() {
    let texture = &textures(Storage::F16)[1];
    let list = facts::list(texture, "as they are");
    let find = |name: &str| {
        let found = list.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str()).unwrap_or_default()
    };
    assert_eq!(find("axes.0.shader"), "mu");
    assert_eq!(find("axes.0.flipped"), "false");
    assert_eq!(find("channels.2.name"), "blue");
    assert_eq!(find("storage"), "f16");
    assert_eq!(find("errors"), "not measured");
    assert_eq!(find("size"), "[8,1,1]");
    let names: Vec<&String> = list.iter().map(|(name, _)| name).collect();
    assert!(names.iter().all(|name| name.len() < 32 && name.is_ascii()), "{names:?}");
    for format in Format::ALL {
        let storage = format.default_storage();
        let texture = &textures(storage)[1];
        let (_, bytes) = files(texture, format).unwrap().pop().unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert_eq!(
            text.contains("rho_hd, linear blue"),
            format != Format::Dds,
            "{format:?}"
        );
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused_with_what_to_choose() {
    let [grey, _, _] = textures(Storage::F16);
    let refused = |texture: &Texture, format| files(texture, format).unwrap_err().to_string();
    assert_eq!(
        refused(&grey, Format::Png),
        "texture vmf.rho_hd: f16 is not allowed in png: choose --storage unorm16 or unorm8"
    );
    let mut edited = grey.clone();
    edited.storage = Storage::Unorm8;
    assert_eq!(
        refused(&edited, Format::Exr),
        "texture vmf.rho_hd: unorm8 is not allowed in exr: choose --storage f32 or f16"
    );
    edited.values[3] = 1.5;
    assert!(refused(&edited, Format::Ktx2).contains("1.5 in channel rho at texel [3, 0, 0] is beyond unorm8"));
    for id in ["", ".", "../x", "a/b", "a b", "-rf", "ä"] {
        let mut named = grey.clone();
        named.id = id.into();
        assert!(refused(&named, Format::Raw).contains("the name is not allowed"), "{id}");
    }
    let mut wide = textures(Storage::F32)[1].clone();
    wide.axes[0].axis.size = 4096;
    wide.values = vec![0.5; 3 * 4096];
    assert!(refused(&wide, Format::Source(Language::Wgsl)).contains("4096 texels in 1 rows are too many"));
    assert!(files(&wide, Format::Source(Language::Glsl)).is_ok());
}
