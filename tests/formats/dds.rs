//! DDS by the crate that wrote the header, by its bytes as documented, and by OpenImageIO.

use super::sample::all;
use super::tools::{python, script, written};
use whitefurnace::export::formats::{Format, files};

#[test]
fn the_crate_reads_its_own() {
    for texture in all() {
        let bytes = files(&texture, Format::Dds).unwrap().remove(0).1;
        let dds = ddsfile::Dds::read(bytes.as_slice()).unwrap();
        let [width, height, depth] = texture.size().map(|size| size as u32);
        assert_eq!(
            (dds.get_width(), dds.get_height(), dds.get_depth()),
            (width, height, depth)
        );
        let padded = [1, 2, 4, 4][texture.channels.len() - 1];
        assert_eq!(
            dds.get_bits_per_pixel(),
            Some((8 * padded * texture.storage.bytes()) as u32)
        );
        assert_eq!(dds.data.len(), padded * texture.bytes() / texture.channels.len());
    }
}

#[test]
fn a_reader_of_the_documented_layout_finds_the_same() {
    let directory = tempfile::tempdir().unwrap();
    written(directory.path(), all(), Format::Dds);
    script(python(), "dds.py", &[directory.path()]);
}
