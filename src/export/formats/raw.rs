//! Numbers one after the other, and JSON that says everything about them.

use super::facts;
use super::texels::{PLAIN, plain};
use crate::export::sha256_hex;
use crate::table::Storage;
use crate::table::texture::Texture;
use serde_json::{Value, json};

/// The bytes of `texture`, and the JSON.
pub(super) fn encode(texture: &Texture) -> Result<Vec<Vec<u8>>, String> {
    let bytes = plain(texture);
    let mut tree = facts::tree(texture, PLAIN);
    let about = [
        ("file", json!(format!("{}.bin", texture.id))),
        ("bytes", json!(bytes.len())),
        ("sha256", json!(sha256_hex(&bytes))),
        ("byteOrder", json!("little-endian")),
        ("number", json!(number(texture.storage))),
    ];
    tree.extend(about.map(|(name, value)| (name.to_owned(), value)));
    let json = serde_json::to_string_pretty(&Value::Object(tree)).map_err(|error| error.to_string())?;
    Ok(vec![bytes, (json + "\n").into_bytes()])
}

/// How a number is kept.
fn number(storage: Storage) -> &'static str {
    match storage {
        Storage::F32 => "IEEE 754 binary32",
        Storage::F16 => "IEEE 754 binary16",
        Storage::Unorm16 => "unsigned 16-bit integer i, for i/65535",
        Storage::Unorm8 => "unsigned 8-bit integer i, for i/255",
    }
}
