//! From WGSL to the other languages, by naga.

use super::Language;
use super::names::readable;
use naga::back::{glsl, hlsl, msl};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use thiserror::Error;

/// WGSL that does not compile, or that a language cannot say.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ShaderError {
    /// A mistake in the source, with the place.
    #[error("the shader is wrong: {0}")]
    Source(String),
    /// What a language does not have.
    #[error("the shader cannot be written in {language}: {reason}")]
    Language {
        /// Name of the language.
        language: &'static str,
        /// What it lacks.
        reason: String,
    },
}

/// naga writes GLSL for an entry point, with everything else of the module where it is asked to; this one is cut off again.
const KEEPER: &str = "furnace_keeper";

/// Functions, structs, constants and textures of `wgsl`, which has no entry point, in `language`. WGSL itself comes back as it is,
/// after the same checks.
///
/// Comments above functions and structs are kept, and names as well. Of a texture and its sampler, called as the texture with
/// `_sampler` after it, GLSL has one `uniform` called as the texture, with its binding in GLSL 4.50; HLSL has both, at
/// `register(tN)` and `register(sN)` of the binding numbers; in MSL both are arguments of the functions that use them.
///
/// # Errors
/// [`ShaderError::Source`] where naga finds `wgsl` wrong, [`ShaderError::Language`] where the language cannot say it.
pub fn translate(wgsl: &str, language: Language) -> Result<String, ShaderError> {
    let refuse = |reason: String| ShaderError::Language {
        language: language.name(),
        reason,
    };
    match language {
        Language::Wgsl => {
            validated(wgsl)?;
            Ok(wgsl.to_owned())
        }
        Language::GlslEs | Language::Glsl => {
            let (module, info) = validated(&format!("{wgsl}\n@fragment fn {KEEPER}() {{}}\n"))?;
            let text = glsl(&module, &info, language).map_err(|error| refuse(error.to_string()))?;
            Ok(readable(&text, wgsl, &module, language))
        }
        Language::Hlsl => {
            let (module, info) = validated(wgsl)?;
            let mut text = String::new();
            let options = hlsl::Options {
                fake_missing_bindings: true,
                ..hlsl::Options::default()
            };
            let pipeline = hlsl::PipelineOptions::default();
            hlsl::Writer::new(&mut text, &options, &pipeline)
                .write(&module, &info, None)
                .map_err(|error| refuse(error.to_string()))?;
            Ok(readable(&text, wgsl, &module, language))
        }
        Language::Msl => {
            let (module, info) = validated(wgsl)?;
            let options = msl::Options {
                lang_version: (2, 0),
                ..msl::Options::default()
            };
            let (text, _) = msl::write_string(&module, &info, &options, &msl::PipelineOptions::default())
                .map_err(|error| refuse(error.to_string()))?;
            Ok(readable(&text, wgsl, &module, language))
        }
    }
}

/// The module of `wgsl`. The parser alone lets wrong types pass.
fn validated(wgsl: &str) -> Result<(Module, ModuleInfo), ShaderError> {
    let module = naga::front::wgsl::parse_str(wgsl)
        .map_err(|error| ShaderError::Source(error.emit_to_string(wgsl).trim_end().to_owned()))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| ShaderError::Source(error.emit_to_string(wgsl).trim_end().to_owned()))?;
    Ok((module, info))
}

fn glsl(module: &Module, info: &ModuleInfo, language: Language) -> Result<String, glsl::Error> {
    let options = glsl::Options {
        version: match language {
            Language::GlslEs => glsl::Version::new_gles(300),
            _ => glsl::Version::Desktop(450),
        },
        writer_flags: glsl::WriterFlags::INCLUDE_UNUSED_ITEMS,
        ..glsl::Options::default()
    };
    let pipeline = glsl::PipelineOptions {
        shader_stage: ShaderStage::Fragment,
        entry_point: KEEPER.into(),
        multiview: None,
    };
    let mut text = String::new();
    glsl::Writer::new(
        &mut text,
        module,
        info,
        &options,
        &pipeline,
        BoundsCheckPolicies::default(),
    )?
    .write()?;
    Ok(text)
}
