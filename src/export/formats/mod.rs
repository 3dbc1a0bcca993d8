//! Textures as files that engines load: one module per format.
//!
//! All of them say the same facts, those of [`facts`], in whatever way the format has: key/value data, text chunks, attributes,
//! comments. Only DDS has no room for any. Bytes depend on the texture alone.

pub mod beside;
pub mod facts;
pub mod read;

mod dds;
mod exr;
mod ktx2;
mod png;
mod raw;
mod source;
mod texels;

pub use source::identifier;

use crate::table::Storage;
use crate::table::texture::{Texture, TextureError};
use thiserror::Error;

/// Most numbers that are written as source text: compilers take minutes for more.
pub const MAX_SOURCE_VALUES: usize = 1 << 20;

/// A language whose source text holds a table as an array, and the lookup as a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Language {
    /// C99, as a header that C++ takes as well.
    C,
    /// Rust without dependencies.
    Rust,
    /// GLSL from 3.30 and ES 3.00 on.
    Glsl,
    /// HLSL from shader model 4 on.
    Hlsl,
    /// WGSL.
    Wgsl,
}

/// A file format of textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// OpenEXR, one part, f16 or f32.
    Exr,
    /// KTX 2.0 without supercompression.
    Ktx2,
    /// DirectDraw Surface with the header of Direct3D 10.
    Dds,
    /// PNG, 16 or 8 bits.
    Png,
    /// Little-endian numbers, and JSON that says what they are.
    Raw,
    /// An array in source text.
    Source(Language),
}

/// A texture that a format cannot hold.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FormatError {
    /// The texture breaks its own rules, or a value does not fit its storage.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// A storage that the format does not know.
    #[error("texture {id}: {storage} is not allowed in {format}: choose {allowed}", storage = storage.name(), format = format.name())]
    Storage {
        /// The texture.
        id: String,
        /// The format.
        format: Format,
        /// The refused storage.
        storage: Storage,
        /// What the format takes.
        allowed: String,
    },
    /// An id that is no stem of a file name.
    #[error(
        "texture {0:?}: the name is not allowed: it begins with a letter, a digit or '_', and goes on with those, '.' and '-'"
    )]
    Name(String),
    /// A name that another file of the same directory has.
    #[error("texture {id}: its file {file} would replace another of that name: choose another format, or another name")]
    Taken {
        /// The texture.
        id: String,
        /// The contested name.
        file: String,
    },
    /// A texture that the format cannot hold for another reason.
    #[error("texture {id} as {format}: {reason}", format = format.name())]
    Encode {
        /// The texture.
        id: String,
        /// The format.
        format: Format,
        /// What does not fit.
        reason: String,
    },
}

impl Format {
    /// Every format, in the order in which people are told of them.
    pub const ALL: [Self; 10] = [
        Self::Exr,
        Self::Ktx2,
        Self::Dds,
        Self::Png,
        Self::Raw,
        Self::Source(Language::C),
        Self::Source(Language::Rust),
        Self::Source(Language::Glsl),
        Self::Source(Language::Hlsl),
        Self::Source(Language::Wgsl),
    ];

    /// The name on the command line and in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Ktx2 => "ktx2",
            Self::Dds => "dds",
            Self::Png => "png",
            Self::Raw => "raw",
            Self::Source(Language::C) => "c",
            Self::Source(Language::Rust) => "rust",
            Self::Source(Language::Glsl) => "glsl",
            Self::Source(Language::Hlsl) => "hlsl",
            Self::Source(Language::Wgsl) => "wgsl",
        }
    }

    /// The format called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// What file names end with; of two files the one with the texels comes first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Exr => &["exr"],
            Self::Ktx2 => &["ktx2"],
            Self::Dds => &["dds"],
            Self::Png => &["png"],
            Self::Raw => &["bin", "json"],
            Self::Source(Language::C) => &["h"],
            Self::Source(Language::Rust) => &["rs"],
            Self::Source(Language::Glsl) => &["glsl"],
            Self::Source(Language::Hlsl) => &["hlsl"],
            Self::Source(Language::Wgsl) => &["wgsl"],
        }
    }

    /// Whether the format keeps values in `storage`: PNG knows integers only, OpenEXR floats only.
    pub fn takes(self, storage: Storage) -> bool {
        let is_float = matches!(storage, Storage::F32 | Storage::F16);
        match self {
            Self::Exr => is_float,
            Self::Png => !is_float,
            Self::Ktx2 | Self::Dds | Self::Raw | Self::Source(_) => true,
        }
    }

    /// The storage where nobody asks for another: f16 for textures, unorm16 for PNG, and f32 for source text, whose arrays are
    /// of f32 whatever the numbers were rounded to.
    pub fn default_storage(self) -> Storage {
        match self {
            Self::Exr | Self::Ktx2 | Self::Dds | Self::Raw => Storage::F16,
            Self::Png => Storage::Unorm16,
            Self::Source(_) => Storage::F32,
        }
    }
}

/// The files of `texture` in `format`: names and bytes, the one with the texels first. The same bytes for the same texture, always.
///
/// # Errors
/// [`FormatError`] when the texture breaks its own rules, or the format cannot hold it.
pub fn files(texture: &Texture, format: Format) -> Result<Vec<(String, Vec<u8>)>, FormatError> {
    let texture = &texture.clone().rounded()?;
    check_name(&texture.id)?;
    if !format.takes(texture.storage) {
        let allowed: Vec<&str> = Storage::ALL
            .into_iter()
            .filter(|storage| format.takes(*storage))
            .map(Storage::name)
            .collect();
        return Err(FormatError::Storage {
            id: texture.id.clone(),
            format,
            storage: texture.storage,
            allowed: format!("--storage {}", allowed.join(" or ")),
        });
    }
    let encoded = match format {
        Format::Exr => exr::encode(texture).map(one),
        Format::Ktx2 => ktx2::encode(texture).map(one),
        Format::Dds => dds::encode(texture).map(one),
        Format::Png => png::encode(texture).map(one),
        Format::Raw => raw::encode(texture),
        Format::Source(language) => source::encode(texture, language).map(one),
    };
    let contents = encoded.map_err(|reason| FormatError::Encode {
        id: texture.id.clone(),
        format,
        reason,
    })?;
    let names = format.extensions().iter();
    let names = names.map(|extension| format!("{}.{extension}", texture.id));
    Ok(names.zip(contents).collect())
}

fn one(bytes: Vec<u8>) -> Vec<Vec<u8>> {
    vec![bytes]
}

/// Whether `id` can be the stem of a file name anywhere, and of an identifier in source text.
fn check_name(id: &str) -> Result<(), FormatError> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if id.starts_with(is_word) && id.chars().all(|c| is_word(c) || ".-".contains(c)) {
        return Ok(());
    }
    Err(FormatError::Name(id.into()))
}

#[cfg(test)]
mod tests;
