//! Textures as OpenEXR by the reader of this crate, which takes them for images of others, and by that of Python.

use super::sample::shapes;
use super::tools::{python, script, written};
use std::path::Path;
use whitefurnace::export::formats::{Format, files};
use whitefurnace::export::read::{Contents, parse_exr};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

fn floats() -> impl Iterator<Item = Texture> {
    [Storage::F32, Storage::F16].into_iter().flat_map(shapes)
}

#[test]
fn a_texture_is_no_table() {
    for texture in floats() {
        let (name, bytes) = files(&texture, Format::Exr).unwrap().remove(0);
        let Contents::Foreign(layers) = parse_exr(Path::new(&name), &bytes).unwrap().contents else {
            panic!("{name} passes for a table");
        };
        let [width, height, depth] = texture.size();
        assert_eq!(layers[0].size, [width * depth, height]);
        assert_eq!(layers[0].channels.len(), texture.channels.len());
        assert!(
            layers[0]
                .channels
                .iter()
                .all(|channel| channel.kind == texture.storage.name())
        );
    }
}

#[test]
fn the_openexr_of_python_reads_the_same() {
    let directory = tempfile::tempdir().unwrap();
    written(directory.path(), floats(), Format::Exr);
    script(python(), "exr.py", &[directory.path()]);
}
