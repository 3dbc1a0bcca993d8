//! Parameters of a material that nothing looks up: most are slips.

use super::lookup::{Warnings, hint};
use super::materials;
use super::parameters::{Family, Parameters, Unknown};
use super::tokens::quote;

/// Tells about the parameters of a material of the type `kind` that are not read.
pub(super) fn tell(kind: &str, own: &Parameters, unknown: &[Unknown], warnings: &Warnings) {
    let Some(names) = materials::names(kind) else {
        return;
    };
    let mut nameless = Vec::new();
    for parameter in own.iter() {
        let (name, found) = (parameter.name, parameter.kind.family());
        if matches!(name, "type" | "bumpmap") {
            continue;
        }
        if !names.contains(&name) {
            nameless.push((name, &parameter.place));
            continue;
        }
        let (family, rule) = wanted(kind, name);
        let is_textured = found == Family::Texture && matches!(family, Family::Float | Family::Colour);
        if found != family && !is_textured {
            let what = format!("{} is not read: {name} is {rule}", parameter.declared);
            warnings.add(&parameter.place, what);
        }
    }
    nameless.extend(unknown.iter().map(|unknown| (unknown.name.as_str(), &unknown.place)));
    for (name, place) in nameless {
        warnings.add_with(place, || {
            format!(
                "{} is not read: a material of type {} has no parameter of that name{}",
                quote(name),
                quote(kind),
                hint(name, names.iter().copied())
            )
        });
    }
}

/// What the parameter `name` of the type `kind` is made of.
fn wanted(kind: &str, name: &str) -> (Family, &'static str) {
    match name {
        "remaproughness" => (Family::Bool, "a bool"),
        "namedmaterial1" | "namedmaterial2" => (Family::String, "a string"),
        "eta" | "k" if kind == "metal" => (Family::Colour, COLOUR),
        "Kd" | "Ks" | "Kr" | "Kt" | "opacity" | "reflect" | "transmit" | "amount" => (Family::Colour, COLOUR),
        _ => (Family::Float, "a float or a texture"),
    }
}

const COLOUR: &str = "an rgb, xyz, spectrum, blackbody or a texture";
