//! The binary container, whole and broken.

use super::*;
use std::io::Cursor;

/// A container with the chunks, whose types are in front of their data.
fn container(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, data) in chunks {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*data);
    }
    let length = (bytes.len() as u32).to_le_bytes();
    bytes[8..12].copy_from_slice(&length);
    bytes
}

fn of_container(bytes: &[u8]) -> Result<Scene, SceneError> {
    binary(&mut Cursor::new(bytes), "a.glb")
}

#[test]
fn a_container_is_read_as_far_as_its_json() {
    const TEXT: &[u8] = b"{\"asset\":{\"version\":\"2.0\"},\"materials\":[{}]}";
    let whole = container(&[(b"JSON", TEXT), (b"BIN\0", &[0; 8])]);
    let scene = of_container(&whole).unwrap();
    assert_eq!((scene.materials.len(), scene.warnings.len(), &*scene.name), (1, 0, "a"));

    // cut anywhere: before the end of the JSON there is nothing, behind it a warning
    for end in 0..whole.len() {
        match of_container(&whole[..end]) {
            Ok(scene) => assert!(end >= 20 + TEXT.len() && !scene.warnings.is_empty(), "{end}"),
            Err(error) => assert!(
                end < 20 + TEXT.len() && error.to_string().starts_with("a.glb: byte "),
                "{end}: {error}"
            ),
        }
    }
    // any byte changed: an error or a scene
    for at in 0..whole.len() {
        for change in [1, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= change;
            let _ = of_container(&bytes);
        }
    }
    let two = container(&[(b"JSON", TEXT), (b"JSON", TEXT), (b"odd!", b"x")]);
    let told = of_container(&two).unwrap().warnings.join("\n");
    assert!(
        told.contains("a second chunk of JSON") && told.contains("unknown type") && told.contains("multiple of 4"),
        "{told}"
    );
    let many = container(&vec![(b"JSON", TEXT); 100]);
    assert!(
        of_container(&many)
            .unwrap()
            .warnings
            .last()
            .unwrap()
            .contains("more than 16 chunks")
    );

    let error = of_container(&container(&[(b"JSON", b"{\"a\"\n:\xff}")]))
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "a.glb: byte 26 (counted from 0) is not UTF-8; a scene is a UTF-8 text file"
    );
    let error = of_container(&container(&[(b"JSON", b"{]  ")])).unwrap_err().to_string();
    assert!(
        error.starts_with("a.glb:1:2: not valid JSON, in the chunk of JSON"),
        "{error}"
    );
    let mut long = container(&[(b"JSON", TEXT)]);
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = of_container(&long).unwrap_err().to_string();
    assert!(error.contains("more than 67108864 bytes of JSON"), "{error}");
}
