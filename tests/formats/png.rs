//! PNG by its chunks, by the crate, and by Pillow and OpenImageIO.

use super::sample::{shapes, texture};
use super::tools::{python, script, written};
use whitefurnace::export::formats::{Format, files};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

fn integers() -> impl Iterator<Item = Texture> {
    [Storage::Unorm16, Storage::Unorm8].into_iter().flat_map(shapes)
}

/// The chunks of a file: kind and data.
fn chunks(mut bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    bytes = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n").unwrap();
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let length = u32::from_be_bytes(bytes[..4].try_into().unwrap()) as usize;
        let kind = String::from_utf8(bytes[4..8].to_vec()).unwrap();
        found.push((kind, bytes[8..8 + length].to_vec()));
        bytes = &bytes[12 + length..];
    }
    found
}

#[test]
fn files_say_that_they_are_linear() {
    for texture in integers() {
        let bytes = files(&texture, Format::Png).unwrap().remove(0).1;
        let chunks = chunks(&bytes);
        let all = |kind: &str| -> Vec<&Vec<u8>> {
            let found = chunks.iter().filter(|(found, _)| found == kind);
            found.map(|(_, data)| data).collect()
        };
        assert_eq!(all("gAMA"), [&100_000u32.to_be_bytes().to_vec()], "{}", texture.id);
        assert!(all("sRGB").is_empty() && all("iCCP").is_empty() && all("cHRM").is_empty());
        let colour = [0, 2, 2, 6][texture.channels.len() - 1];
        assert_eq!(all("IHDR")[0][8..10], [texture.storage.bytes() as u8 * 8, colour]);
        assert!(
            all("tEXt")
                .iter()
                .any(|text| text.starts_with(b"whitefurnace.storage\0unorm"))
        );
        assert!(
            all("iTXt")
                .iter()
                .any(|text| text.starts_with("whitefurnace.facts.1.name\0".as_bytes()))
        );
    }
}

/// Slices of three axes stand side by side, in their order.
#[test]
fn slices_stand_side_by_side() {
    let texture = texture(3, 1, Storage::Unorm8);
    let bytes = files(&texture, Format::Png).unwrap().remove(0).1;
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let [width, height, depth] = texture.size();
    let mut pixels = vec![0; width * height * depth];
    reader.next_frame(&mut pixels).unwrap();
    for (z, y, x) in [(0, 0, 0), (1, 2, 3), (2, 4, 6)] {
        let pixel = f64::from(pixels[y * width * depth + z * width + x]);
        assert_eq!(pixel / 255.0, texture.texel([x, y, z])[0]);
    }
}

#[test]
fn pillow_and_openimageio_read_the_same() {
    let directory = tempfile::tempdir().unwrap();
    written(directory.path(), integers(), Format::Png);
    script(python(), "png.py", &[directory.path()]);
}
