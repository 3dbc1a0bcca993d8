//! Tables as source text: compiled by the compilers of the languages, and in C and Rust run against the lookup of a texture.

use super::sample::{all, shapes, texture};
use super::tools::output_of;
use std::fs;
use std::path::Path;
use std::process::Command;
use whitefurnace::export::formats::{Format, Language, files};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

/// The text of a texture.
fn text(texture: &Texture, language: Language) -> String {
    String::from_utf8(files(texture, Format::Source(language)).unwrap().remove(0).1).unwrap()
}

/// Its name in the text.
fn name(texture: &Texture) -> String {
    texture.id.replace(['-', '.'], "_")
}

/// Places within the domain and beyond its ends, which a lookup clamps; logarithms need the places above -1.
fn places(texture: &Texture) -> Vec<Vec<f64>> {
    let value = |i: usize, k: usize| ((i * (k + 3)) as f64 * 0.754_877_666_246_693).fract();
    let place = |i: usize| {
        let axes = texture.axes.iter().enumerate();
        axes.map(|(k, axis)| axis.axis.value(value(i, k)) * if i.is_multiple_of(7) { 1.25 } else { 1.0 })
            .collect()
    };
    (0..60).map(place).collect()
}

/// Runs a program that prints one number per line, channels of one place after the other, and compares.
fn compare(textures: &[Texture], out: &str) {
    let mut found = out.lines().map(|line| line.parse::<f64>().unwrap());
    for texture in textures {
        for place in places(texture) {
            for (expected, channel) in texture.lookup(&place).into_iter().zip(&texture.channels) {
                let found = found.next().unwrap();
                // values up to 1 and results are f32: half a unit each, 2^-25, and as much again for weights of f64
                let tolerance = 1.5 * 2f64.powi(-24);
                assert!(
                    (found - expected).abs() <= tolerance,
                    "{} {} at {place:?}: {found} {expected}",
                    texture.id,
                    channel.name
                );
            }
        }
    }
    assert_eq!(found.next(), None);
}

/// A place as the arguments of a call.
fn arguments(place: &[f64]) -> String {
    place
        .iter()
        .map(|value| format!("{value:?}"))
        .collect::<Vec<_>>()
        .join(", ")
}

#[test]
fn c_compiles_and_looks_up_as_a_texture() {
    let directory = tempfile::tempdir().unwrap();
    let textures: Vec<Texture> = all().collect();
    let (mut includes, mut calls) = (String::new(), String::new());
    for texture in &textures {
        let file = format!("{}.h", texture.id);
        fs::write(directory.path().join(&file), text(texture, Language::C)).unwrap();
        includes += &format!("#include \"{file}\"\n#include \"{file}\"\n");
        for place in places(texture) {
            calls += &format!("lookup_{}({}, r); ", name(texture), arguments(&place));
            calls += &format!(
                "for (c = 0; c < {}; c++) printf(\"%.9g\\n\", r[c]);\n",
                texture.channels.len()
            );
        }
    }
    let main = format!("#include <stdio.h>\n{includes}int main(void) {{ float r[4]; int c;\n{calls}return 0; }}\n");
    for (compiler, standard, file) in [("cc", "-std=c99", "main.c"), ("c++", "-std=c++11", "main.cpp")] {
        let (path, program) = (directory.path().join(file), directory.path().join("main"));
        fs::write(&path, &main).unwrap();
        let mut compile = Command::new(compiler);
        compile
            .args([standard, "-Wall", "-Wextra", "-pedantic", "-Werror", "-o"])
            .arg(&program)
            .arg(&path)
            .arg("-lm");
        if output_of(&mut compile).is_none() {
            return;
        }
        compare(&textures, &output_of(&mut Command::new(&program)).unwrap());
    }
}

#[test]
fn rust_compiles_and_looks_up_as_a_texture() {
    let directory = tempfile::tempdir().unwrap();
    let textures: Vec<Texture> = all().collect();
    let (mut modules, mut calls) = (String::new(), String::new());
    for texture in &textures {
        let file = format!("{}.rs", texture.id);
        fs::write(directory.path().join(&file), text(texture, Language::Rust)).unwrap();
        let name = name(texture);
        modules += &format!("#[path = \"{file}\"]\npub mod {name};\n");
        for place in places(texture) {
            calls += &format!("    print(&{name}::lookup_{name}({}));\n", arguments(&place));
        }
    }
    let print = "fn print(values: &[f32]) { for value in values { println!(\"{value:?}\"); } }\n";
    let (path, program) = (directory.path().join("main.rs"), directory.path().join("main"));
    fs::write(&path, format!("{modules}{print}fn main() {{\n{calls}}}\n")).unwrap();
    let mut compile = Command::new(std::env::var("RUSTC").unwrap_or("rustc".into()));
    compile
        .args(["--edition", "2021", "-D", "warnings", "-o"])
        .arg(&program)
        .arg(&path);
    if output_of(&mut compile).is_some() {
        compare(&textures, &output_of(&mut Command::new(&program)).unwrap());
    }
}

/// A fragment shader around a snippet, which writes the first channel.
fn fragment(version: &str, texture: &Texture) -> String {
    let (mut inputs, mut names) = (String::new(), Vec::new());
    for (k, _) in texture.axes.iter().enumerate() {
        inputs += &format!("uniform float p{k};\n");
        names.push(format!("p{k}"));
    }
    let call = format!("lookup_{}({})", name(texture), names.join(", "));
    let first = if texture.channels.len() == 1 {
        call
    } else {
        format!("{call}.x")
    };
    let snippet = text(texture, Language::Glsl);
    format!("{version}\n{snippet}{inputs}out vec4 colour;\nvoid main() {{ colour = vec4({first}); }}\n")
}

fn validate(directory: &Path, file: &str, text: &str, arguments: &[&str]) -> bool {
    let path = directory.join(file);
    fs::write(&path, text).unwrap();
    output_of(Command::new("glslangValidator").args(arguments).arg(&path)).is_some()
}

#[test]
fn glsl_compiles() {
    let directory = tempfile::tempdir().unwrap();
    for texture in shapes(Storage::F16).chain(shapes(Storage::F32)) {
        for version in [
            "#version 330",
            "#version 300 es\nprecision highp float;\nprecision highp int;",
        ] {
            if !validate(directory.path(), "snippet.frag", &fragment(version, &texture), &[]) {
                return;
            }
        }
    }
}

#[test]
fn hlsl_compiles() {
    let directory = tempfile::tempdir().unwrap();
    for texture in shapes(Storage::F16).chain(shapes(Storage::F32)) {
        let places = ["p.x", "p.y", "p.z"][..texture.axes.len()].join(", ");
        let call = format!("lookup_{}({places})", name(&texture));
        let first = if texture.channels.len() == 1 {
            call
        } else {
            format!("{call}.x")
        };
        let snippet = text(&texture, Language::Hlsl);
        let text = format!("{snippet}float4 main(float3 p : TEXCOORD) : SV_Target {{ return {first}; }}\n");
        if !validate(
            directory.path(),
            "snippet.hlsl",
            &text,
            &["-D", "-V", "-S", "frag", "-e", "main", "-o", "/dev/null"],
        ) {
            return;
        }
    }
}

/// Parsed and validated by naga, and written as HLSL by it.
#[test]
fn wgsl_compiles() {
    for texture in all() {
        let places = ["p.x", "p.y", "p.z"][..texture.axes.len()].join(", ");
        let call = format!("lookup_{}({places})", name(&texture));
        let first = if texture.channels.len() == 1 {
            call
        } else {
            format!("{call}.x")
        };
        let text = format!(
            "{}@fragment fn main(@location(0) p: vec3<f32>) -> @location(0) vec4<f32> {{ return vec4<f32>({first}); }}\n",
            text(&texture, Language::Wgsl)
        );
        let module =
            naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
        let mut validator =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        let info = validator.validate(&module).unwrap();
        let mut out = String::new();
        let options = naga::back::hlsl::Options::default();
        let pipeline = naga::back::hlsl::PipelineOptions::default();
        naga::back::hlsl::Writer::new(&mut out, &options, &pipeline)
            .write(&module, &info, None)
            .unwrap();
        assert!(out.contains("lookup_sample"), "{out}");
    }
}

/// A table of the size of a real one: compilers and validators have limits for arrays.
#[test]
fn tables_of_64_by_32_texels_compile() {
    let directory = tempfile::tempdir().unwrap();
    let mut big = texture(2, 2, Storage::F16);
    (big.axes[0].axis.size, big.axes[1].axis.size) = (64, 32);
    big.values = (0..64 * 32 * 2).map(|i| f64::from(i % 1000) / 1024.0).collect();
    let version = "#version 300 es\nprecision highp float;\nprecision highp int;";
    validate(directory.path(), "big.frag", &fragment(version, &big), &[]);
    let module = naga::front::wgsl::parse_str(&text(&big, Language::Wgsl)).unwrap();
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap();
}
