//! Identifiers that all languages take.

use crate::table::texture::TextureAxis;

/// Words that some language keeps to itself, and those of the functions that are written. Words that cannot begin as axes are named
/// are left out.
const TAKEN: &str = "abs abstract active alias alignas alignof alloc and array as asin asm async atan atomic attribute auto await \
    become binding_array bitcast bool box break buffer builtin case cast catch cbuffer ceil centroid char class clamp common compile \
    const constexpr continue coherent column_major const_assert cos crate decltype default delete demote diagnostic discard do \
    double dword dyn else enable enum exp explicit export extern false filter final fixed flat float floor fn for friend from \
    fract fragment frexp function gen goto groupshared half highp hvec2 if image impl import in inline inout input int interface \
    invariant isampler2D iter layout lerp let line lineadj linear log long loop lowp macro main mat2 mat3 mat4 match matrix max \
    mediump min mix mod module move mut mutable namespace new nil noexcept noinline noise nointerpolation noperspective not null \
    nullptr operator or out output override packed partition pass patch pixel point pow precise precision priv private protected \
    ptr pub public quat read readonly ref register regardless requires resource restrict return row_major sample sampler self \
    set shader shared short signed sin sizeof smooth snorm sqrt static std step str string struct subroutine super superp switch \
    table target technique template texture this thread_local throw trait triangle true try type typedef typeid typename typeof \
    union unless unorm unsafe unsigned unsized usampler2D use using usize uint u8 u16 u32 u64 f16 f32 f64 i8 i16 i32 i64 isize \
    varying var vec2 vec3 vec4 vector vertex virtual void volatile wchar_t where while with workgroup writeonly xor yield \
    c tx ty tz u v w x y z x0 x1 y0 y1 z0 z1 px py pz texel texels result lookup position";

/// The id of a texture as part of an identifier: words of letters and digits, joined by single underscores, as GLSL keeps double
/// ones to itself.
pub fn identifier(id: &str) -> String {
    let words = id.split(|c: char| !c.is_ascii_alphanumeric());
    let name = words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("_");
    // the names that are made of it have a word before it or are in capitals, where only a digit is in the way
    match name.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => name,
        _ => format!("t{name}"),
    }
}

/// The arguments of the lookup: the parameters of the axes, and where some language cannot take one, `axis0` and so on.
pub(super) fn parameter_names(axes: &[TextureAxis]) -> Vec<String> {
    let is_taken = |name: &str| {
        TAKEN.split_whitespace().any(|word| word == name)
            || name.contains("__")
            || name.ends_with('_')
            || name.starts_with("gl_")
    };
    let mut names: Vec<String> = Vec::new();
    for (index, axis) in axes.iter().enumerate() {
        let name = &axis.axis.parameter;
        let is_capital = name.starts_with(|c: char| c.is_ascii_uppercase()); // macros and constants are
        if is_taken(name) || is_capital || names.contains(name) {
            names.push(format!("axis{index}"));
        } else {
            names.push(name.clone());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::axis::{Axis, Mapping, TexelRule};

    #[test]
    fn identifiers_are_taken_by_every_language() {
        for (id, name) in [
            ("gold", "gold"),
            ("vmf.rho_hd", "vmf_rho_hd"),
            ("a--b__c-", "a_b_c"),
            ("7", "t7"),
            ("_", "t"),
        ] {
            assert_eq!(identifier(id), name);
        }
    }

    #[test]
    fn words_of_languages_are_no_arguments() {
        let axis =
            |name: &str| TextureAxis::along(Axis::new(name, Mapping::Linear, TexelRule::Ends, [0.0, 1.0], 2).unwrap());
        let found = parameter_names(&["mu", "mu", "float"].map(axis));
        assert_eq!(found, ["mu", "axis1", "axis2"]);
        let found = parameter_names(&["gl_x", "roughness", "M_PI"].map(axis));
        assert_eq!(found, ["axis0", "roughness", "axis2"]);
    }
}
