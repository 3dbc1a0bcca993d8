//! The functions of a material: its albedo on both sides, the base under its lobes, and its BRDF where lobes have one in closed form.

use super::sampler::Sampler;
use crate::bxdf::{Coupling, Transport};
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::integrate::Target;
use crate::integrate::deterministic::closed_form;
use crate::masking::Masking;
use crate::plan::{Base, MaterialPlan, Source, Term};
use crate::printable::printable;
use crate::scene::{DistributionSpec, ModelSpec, Roughness};
use crate::spectrum::Spectrum;
use crate::table::Lobe;
use crate::table::axis::{AZIMUTH, MU};
use glam::DVec3;
use std::collections::BTreeMap;

/// A table in a shader.
pub(super) struct Table {
    pub(super) sampler: Sampler,
    /// Number of its channels: 2 for one of every r0.
    pub(super) channels: usize,
}

/// A function of a material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialFunction {
    /// Its name.
    pub name: String,
    /// Its arguments in their order.
    pub arguments: Vec<String>,
    /// What it gives.
    pub meaning: String,
}

/// Functions of a material and their text.
pub(super) struct Functions {
    pub(super) all: Vec<MaterialFunction>,
    pub(super) wgsl: String,
}

/// Writes the functions of one material, called `name` in the shader.
pub(super) fn functions(material: &MaterialPlan, name: &str, tables: &BTreeMap<&str, Table>) -> Functions {
    let writer = Writer { material, name, tables };
    let mut functions = Functions {
        all: Vec::new(),
        wgsl: String::new(),
    };
    for side in Lobe::ALL {
        let terms: Vec<&Term> = material.terms.iter().filter(|term| term.lobe == side).collect();
        // a lobe that never leaves on this side
        if terms.iter().any(|term| !is_dark(term)) {
            writer.albedo(side, &terms, &mut functions);
        }
    }
    let mut indices: Vec<usize> = writer.bases().map(|base| base.index).collect();
    indices.dedup();
    for index in &indices {
        let number = if indices.len() > 1 {
            format!("_{index}")
        } else {
            String::new()
        };
        writer.base(*index, &number, &mut functions);
    }
    writer.brdf(&indices, &mut functions);
    functions
}

fn is_dark(term: &Term) -> bool {
    term.scale.value() == DVec3::ZERO
        || term
            .model
            .at(None)
            .is_ok_and(|model| !model.flags().contains(term.lobe.flag()))
}

struct Writer<'a> {
    material: &'a MaterialPlan,
    name: &'a str,
    tables: &'a BTreeMap<&'a str, Table>,
}

/// Whether a function takes the direction as one (`mu`) or as both (`mu_o`, `mu_i`) or takes none: the suffix of its names.
type Suffix = &'static str;

impl Writer<'_> {
    fn bases(&self) -> impl Iterator<Item = Base> {
        let reflected = self.material.terms.iter().filter(|term| term.lobe == Lobe::Reflection);
        reflected.filter_map(|term| term.base)
    }

    fn of_base(&self, index: usize) -> Vec<&Term> {
        let mut terms = self.material.terms.iter().collect::<Vec<_>>();
        terms.retain(|term| term.lobe == Lobe::Reflection && term.base.is_some_and(|base| base.index == index));
        terms
    }

    /// `mu`, `phi` where a table of these terms has it, and the roughness where that is a range.
    fn arguments(&self, terms: &[&Term], suffixes: &[Suffix]) -> Vec<String> {
        let mut has_azimuth = false;
        let mut roughness = None;
        for term in terms {
            if let Some(Table { sampler, .. }) = self.table(&term.albedo) {
                has_azimuth |= sampler.arguments.iter().any(|name| name == AZIMUTH);
            }
            let range = term.model.roughness_range();
            roughness = roughness.or_else(|| range.map(|(family, ..)| family.legal().name.to_owned()));
        }
        let mut arguments: Vec<String> = suffixes.iter().map(|suffix| format!("{MU}{suffix}")).collect();
        if has_azimuth {
            arguments.extend(suffixes.iter().map(|suffix| format!("{AZIMUTH}{suffix}")));
        }
        arguments.extend(roughness);
        arguments
    }

    fn table(&self, source: &Source) -> Option<&Table> {
        match source {
            Source::Table { id, .. } => self.tables.get(id.as_str()),
            Source::ClosedForm(_) => None,
        }
    }

    /// The albedo of one lobe at `mu` with its suffix, without its scale, as an expression of type `vec3f`.
    fn rho(&self, term: &Term, suffix: Suffix) -> String {
        match &term.albedo {
            Source::Table { r0, .. } => self.sampled(term, &term.albedo, *r0, suffix),
            Source::ClosedForm(_) => closed(&term.model, term.lobe, &format!("{MU}{suffix}")),
        }
    }

    /// Its mean.
    fn mean(&self, term: &Term) -> String {
        match &term.mean {
            Some(source @ Source::Table { r0, .. }) => self.sampled(term, source, *r0, ""),
            _ => {
                let model = term.model.at(None).ok();
                let mean = model.and_then(|model| closed_form(&model, Target::rho_hh().of(term.lobe)));
                vector(mean.map_or(DVec3::ZERO, |mean| mean.value))
            }
        }
    }

    fn sampled(&self, term: &Term, source: &Source, r0: Option<Spectrum>, suffix: Suffix) -> String {
        let Some(Table { sampler, channels }) = self.table(source) else {
            return vector(DVec3::ZERO);
        };
        let argument = |name: &String| match name.as_str() {
            MU | AZIMUTH => format!("{name}{suffix}"),
            name => match term.model.roughness() {
                Some(Roughness::Fixed(value)) => number(value),
                _ => name.to_owned(),
            },
        };
        let arguments: Vec<String> = sampler.arguments.iter().map(argument).collect();
        let call = format!("{}({})", sampler.function, arguments.join(", "));
        match (channels, r0) {
            (2, Some(r0)) => format!("furnace_albedo_schlick({call}, {})", vector(r0.value())),
            (1, _) => format!("vec3f({call})"),
            _ => call,
        }
    }

    /// The sum of the scaled albedos of `terms`, as statements that end in `let {into} = ...;`.
    fn sum(&self, terms: &[&Term], into: &str, one: impl Fn(&Term) -> String) -> String {
        let parts = terms.iter().map(|term| scaled(term.scale.value(), &one(term)));
        let parts: Vec<String> = parts.collect();
        let sum = if parts.is_empty() {
            vector(DVec3::ZERO)
        } else {
            parts.join("\n        + ")
        };
        format!("    let {into} = {sum};\n")
    }

    fn albedo(&self, side: Lobe, terms: &[&Term], functions: &mut Functions) {
        let is_coupled = |term: &&&Term| term.base.is_some() && side == Lobe::Reflection;
        let arguments = self.arguments(terms, &[""]);
        let plain: Vec<&Term> = terms.iter().filter(|term| !is_coupled(term)).copied().collect();
        let mut body = self.sum(&plain, "rho", |term| {
            let rho = self.rho(term, "");
            term.base
                .map_or(rho.clone(), |base| scaled(base.ks.value() * base.outer.value(), &rho))
        });
        let mut total = String::from("rho");
        let mut bases: Vec<Base> = terms.iter().filter(is_coupled).filter_map(|term| term.base).collect();
        bases.dedup_by_key(|base| base.index);
        for base in bases {
            let (rho, mean, index) = (
                format!("rho_{}", base.index),
                format!("mean_{}", base.index),
                base.index,
            );
            let coupled = self.of_base(index);
            body += &self.sum(&coupled, &rho, |term| self.rho(term, ""));
            let (ks, kd) = (vector(base.ks.value()), vector(base.kd.value()));
            let mut under = format!("(vec3f(1.0) - {ks} * {rho}) * {kd}");
            if base.coupling == Coupling::Mikkelsen {
                body += &self.sum(&coupled, &mean, |term| self.mean(term));
                under += &format!(" * (vec3f(1.0) - {ks} * {mean})");
            }
            let outer = vector(base.outer.value());
            total += &format!("\n        + {outer} * ({ks} * {rho} + {under})");
        }
        let name = format!("albedo_{}_{}", side.name(), self.name);
        let meaning = format!("rho_hd of {}, {}", self.shown(), side.name());
        body += &format!("    return {total};\n");
        functions.add(name, arguments, meaning, "vec3f", &body);
    }

    fn shown(&self) -> String {
        printable(&self.material.name)
    }

    /// The diffuse part of eq. 28.
    fn base(&self, index: usize, number: &str, functions: &mut Functions) {
        let terms = self.of_base(index);
        let Some(base) = terms.iter().find_map(|term| term.base) else {
            return;
        };
        let mut body = self.sum(&terms, "rho_o", |term| self.rho(term, "_o"));
        body += &self.sum(&terms, "rho_i", |term| self.rho(term, "_i"));
        body += &self.sum(&terms, "rho_mean", |term| self.mean(term));
        let coupling = match base.coupling {
            Coupling::Mikkelsen => "FURNACE_MIKKELSEN",
            Coupling::EnergyPreserving => "FURNACE_ENERGY_PRESERVING",
        };
        let (ks, kd) = (vector(base.ks.value()), vector(base.kd.value()));
        let whole = format!("furnace_base({coupling}, {ks}, {kd}, rho_o, rho_i, rho_mean)");
        body += &format!("    return {};\n", scaled(base.outer.value(), &whole));
        let arguments = self.arguments(&terms, &["_o", "_i"]);
        let meaning = format!(
            "the diffuse base of {} in sr^-1 by the cosines of wo and wi, {}: add ks f of the lobes",
            self.shown(),
            base.coupling.name()
        );
        functions.add(
            format!("base_{}{number}", self.name),
            arguments,
            meaning,
            "vec3f",
            &body,
        );
    }

    /// The whole BRDF, where all its lobes are isotropic microfacets or Lambertian and its tables have no axis of azimuth.
    fn brdf(&self, indices: &[usize], functions: &mut Functions) {
        let terms: Vec<&Term> = self.material.terms.iter().filter(|term| !is_dark(term)).collect();
        let parts: Option<Vec<String>> = terms.iter().map(|term| lobe_value(term)).collect();
        let Some(parts) = parts.filter(|parts| !parts.is_empty()) else {
            return;
        };
        let mut sum = parts.join("\n        + ");
        for index in indices {
            let number = if indices.len() > 1 {
                format!("_{index}")
            } else {
                String::new()
            };
            let arguments = self.arguments(&self.of_base(*index), &["_o", "_i"]);
            if arguments.iter().any(|name| name.starts_with(AZIMUTH)) {
                return;
            }
            let arguments = arguments.iter().map(|name| match name.as_str() {
                "mu_o" => "abs(wo.z)",
                "mu_i" => "abs(wi.z)",
                other => other,
            });
            sum += &format!(
                "\n        + base_{}{number}({})",
                self.name,
                arguments.collect::<Vec<_>>().join(", ")
            );
        }
        let roughness = self.arguments(&terms, &[]);
        let signature = ["wo: vec3f".to_owned(), "wi: vec3f".to_owned()];
        let arguments: Vec<String> = signature.into_iter().chain(roughness).collect();
        let body = format!("    if wo.z * wi.z <= 0.0 {{\n        return vec3f(0.0);\n    }}\n    return {sum};\n");
        let meaning = format!("the BRDF of {} in sr^-1, without the cosine; normal +z", self.shown());
        functions.add(format!("brdf_{}", self.name), arguments, meaning, "vec3f", &body);
    }
}

impl Functions {
    fn add(&mut self, name: String, arguments: Vec<String>, meaning: String, result: &str, body: &str) {
        let typed = arguments.iter().map(|argument| match argument.contains(':') {
            true => argument.clone(),
            false => format!("{argument}: f32"),
        });
        let typed: Vec<String> = typed.collect();
        self.wgsl += &format!(
            "\n// {meaning}.\nfn {name}({}) -> {result} {{\n{body}}}\n",
            typed.join(", ")
        );
        let plain = |argument: String| argument.split(':').next().unwrap_or_default().to_owned();
        self.all.push(MaterialFunction {
            name,
            arguments: arguments.into_iter().map(plain).collect(),
            meaning,
        });
    }
}

/// f of a lobe with its scale, for isotropic microfacets and Lambertians that reflect.
fn lobe_value(term: &Term) -> Option<String> {
    if term.lobe != Lobe::Reflection {
        return None;
    }
    let factor = term
        .base
        .map_or(DVec3::ONE, |base| base.ks.value() * base.outer.value())
        * term.scale.value();
    match &term.model {
        ModelSpec::Lambertian(base) => Some(vector(factor * base.albedo() * std::f64::consts::FRAC_1_PI)),
        ModelSpec::Microfacet {
            reflectance,
            distribution: DistributionSpec::Isotropic { family, roughness },
            masking,
            fresnel,
        } => {
            let fresnel = match (&term.albedo, fresnel) {
                (Source::Table { r0: Some(r0), .. }, Fresnel::Schlick { .. }) => Fresnel::Schlick { r0: *r0 },
                (_, fresnel) => *fresnel,
            };
            let roughness = match roughness {
                Roughness::Fixed(value) => number(*value),
                Roughness::Range { .. } => family.legal().name.to_owned(),
            };
            let (family, masking) = (family_name(*family), masking_name(*masking));
            let (kind, eta, k) = fresnel_parts(&fresnel);
            let scale = vector(factor * reflectance.value());
            Some(format!(
                "furnace_f(FurnaceLobe({family}, {masking}, {kind}, {roughness}, {scale}, {eta}, {k}), wo, wi)"
            ))
        }
        _ => None,
    }
}

fn family_name(family: Family) -> &'static str {
    match family {
        Family::Ggx => "FURNACE_GGX",
        Family::Beckmann => "FURNACE_BECKMANN",
        Family::Vmf => "FURNACE_VMF",
        Family::Phong => "FURNACE_PHONG",
    }
}

fn masking_name(masking: Masking) -> &'static str {
    match masking {
        Masking::None => "FURNACE_MASKING_NONE",
        Masking::VGroove => "FURNACE_V_GROOVE",
        Masking::Smith => "FURNACE_SMITH",
        Masking::SmithCorrelated => "FURNACE_SMITH_CORRELATED",
    }
}

/// The fields `fresnel`, `eta` and `k` of a lobe.
fn fresnel_parts(fresnel: &Fresnel) -> (&'static str, String, String) {
    let zero = || vector(DVec3::ZERO);
    match fresnel {
        Fresnel::None => ("FURNACE_FRESNEL_NONE", zero(), zero()),
        Fresnel::Dielectric { eta } => ("FURNACE_DIELECTRIC", vector(eta.value()), zero()),
        Fresnel::Conductor { eta, k } => ("FURNACE_CONDUCTOR", vector(eta.value()), vector(k.value())),
        Fresnel::ConductorApproximate { eta, k } => {
            ("FURNACE_CONDUCTOR_APPROXIMATE", vector(eta.value()), vector(k.value()))
        }
        Fresnel::Schlick { r0 } => ("FURNACE_SCHLICK", vector(r0.value()), zero()),
    }
}

/// The closed form of an albedo to one side of the surface, at the cosine `mu`.
fn closed(model: &ModelSpec, side: Lobe, mu: &str) -> String {
    let reflects = side == Lobe::Reflection;
    let interface = |eta_a: f64, eta_b: f64| format!("furnace_dielectric({mu}, {})", number(eta_b / eta_a));
    let through = |transmittance: Spectrum, [eta_a, eta_b]: [f64; 2], transport: Transport| {
        let scale = match transport {
            Transport::Importance => 1.0,
            Transport::Radiance => (eta_a / eta_b) * (eta_a / eta_b),
        };
        format!(
            "{} * (1.0 - {})",
            vector(transmittance.value() * scale),
            interface(eta_a, eta_b)
        )
    };
    match model {
        ModelSpec::Lambertian(base) if reflects => vector(base.albedo()),
        ModelSpec::OrenNayar(rough) if reflects => {
            let [a, b] = rough.coefficients().map(number);
            format!(
                "{} * furnace_oren_nayar({a}, {b}, {mu})",
                vector(rough.reflectance().value())
            )
        }
        ModelSpec::SpecularReflection(mirror) if reflects => {
            let (kind, eta, k) = fresnel_parts(mirror.fresnel());
            let reflectance = vector(mirror.reflectance().value());
            format!("{reflectance} * furnace_fresnel(FurnaceLobe(0u, 0u, {kind}, 1.0, vec3f(1.0), {eta}, {k}), {mu})")
        }
        ModelSpec::SpecularTransmission(window) if !reflects => through(
            window.transmittance(),
            [window.eta_a(), window.eta_b()],
            window.transport(),
        ),
        ModelSpec::FresnelSpecular(glass) if reflects => {
            format!(
                "{} * {}",
                vector(glass.reflectance().value()),
                interface(glass.eta_a(), glass.eta_b())
            )
        }
        ModelSpec::FresnelSpecular(glass) => {
            through(glass.transmittance(), [glass.eta_a(), glass.eta_b()], glass.transport())
        }
        ModelSpec::BrdfToBtdf(bxdf) => closed(bxdf, side.other(), mu),
        _ => vector(DVec3::ZERO),
    }
}

/// `scale` times an expression, without a factor of 1.
fn scaled(scale: DVec3, expression: &str) -> String {
    if scale == DVec3::ONE {
        expression.to_owned()
    } else {
        format!("{} * {expression}", vector(scale))
    }
}

/// A number that every language takes as f32: with a point or an exponent, and 0 where f32 has nothing smaller.
fn number(value: f64) -> String {
    format!("{:?}", value as f32)
}

fn vector(value: DVec3) -> String {
    let [x, y, z] = value.to_array().map(number);
    if x == y && y == z {
        format!("vec3f({x})")
    } else {
        format!("vec3f({x}, {y}, {z})")
    }
}
