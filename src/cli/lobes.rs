//! The lobes of planned materials, as plans and manifests tell of them.

use serde_json::Value;
use whitefurnace::export::manifest::{AlbedoEntry, BaseEntry, LayerEntry, LobeEntry};
use whitefurnace::plan::{Layer, MaterialPlan, Source, Term};
use whitefurnace::spectrum::Spectrum;

/// Every lobe of `material`.
pub(super) fn entries(material: &MaterialPlan) -> Vec<LobeEntry> {
    material.terms.iter().map(lobe).collect()
}

fn lobe(term: &Term) -> LobeEntry {
    let parameters = term.model.describe().into_iter();
    LobeEntry {
        side: term.lobe.name().into(),
        model: parameters.map(|(key, value)| (key, Value::String(value))).collect(),
        scale: spectrum(term.scale),
        rho_hd: albedo(&term.albedo),
        rho_hh: term.mean.as_ref().map(albedo),
        diffuse_base: term.base.map(|base| BaseEntry {
            ks: spectrum(base.ks),
            kd: spectrum(base.kd),
            coupling: base.coupling.name().into(),
            scale: spectrum(base.outer),
            coupled: base.index,
        }),
        under: term.layers.iter().map(layer).collect(),
    }
}

fn layer(layer: &Layer) -> LayerEntry {
    LayerEntry {
        lobes: layer.lobes.clone(),
        factor: layer.veil.formula().into(),
    }
}

fn albedo(source: &Source) -> AlbedoEntry {
    match source {
        Source::Table { id, r0 } => AlbedoEntry {
            table: Some(id.clone()),
            r0: r0.map(spectrum),
            closed_form: None,
        },
        Source::ClosedForm(formula) => AlbedoEntry {
            table: None,
            r0: None,
            closed_form: Some((*formula).into()),
        },
    }
}

fn spectrum(spectrum: Spectrum) -> Vec<f64> {
    spectrum.channels().of(spectrum.value())
}
