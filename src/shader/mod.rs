//! Shaders: the functions that sample tables, and the BRDFs and formulae that the samples are for, in five languages.
//!
//! Everything is written in WGSL, validated, and translated by naga; `names.rs` then takes out of the translation what only
//! a machine would have written, so that people can read and paste it.

mod materials;
mod names;
mod pair;
mod sampler;
mod scene;
mod translate;
mod used;

pub use materials::MaterialFunction;
pub use sampler::{Sampler, TextureLayout, identifier, identifiers, sampler_of};
pub use scene::{SceneShader, TableSampler};
pub use translate::{ShaderError, translate};

/// A language that shaders are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// WGSL, of WebGPU.
    Wgsl,
    /// GLSL ES 3.00, of WebGL2.
    GlslEs,
    /// GLSL 4.50, of OpenGL and Vulkan.
    Glsl,
    /// HLSL of shader model 5.
    Hlsl,
    /// The Metal shading language.
    Msl,
}

impl Language {
    /// Every language.
    pub const ALL: [Self; 5] = [Self::Wgsl, Self::GlslEs, Self::Glsl, Self::Hlsl, Self::Msl];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::GlslEs => "glsl-es",
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
            Self::Msl => "msl",
        }
    }

    /// The language called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|language| language.name() == name)
    }

    /// The usual ending of file names.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::GlslEs => "es.glsl",
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
            Self::Msl => "metal",
        }
    }
}

/// The library in WGSL, whose comments say what each function is.
pub const LIBRARY: &str = include_str!("library.wgsl");

/// The functions that need no table: lobes, Fresnel terms, eq. 28's base, and what compensates for light that scatters more
/// than once.
///
/// Functions, constants and structs alone, all named `furnace_`, `Furnace` or `FURNACE_`: no entry point, no `#version`, no
/// statement of precision. GLSL ES wants `precision highp float;` and `precision highp int;` before it, MSL
/// `#include <metal_stdlib>`.
///
/// # Errors
/// [`ShaderError`], which the library as it is shipped does not provoke.
pub fn library(language: Language) -> Result<String, ShaderError> {
    translate(LIBRARY, language)
}
