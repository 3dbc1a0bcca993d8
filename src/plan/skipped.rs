//! The effects that no material calls for.

use super::{Economy, TablePlan};
use crate::scene::{Effect, Scene};
use crate::table::axis::{AZIMUTH, MU};
use std::collections::HashSet;

/// An effect of the program that is not computed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// The effect.
    pub effect: Effect,
    /// Why not.
    pub reason: String,
}

/// Every effect that no material of `scene` calls for, with what that spares the `tables`.
pub(super) fn skipped(scene: &Scene, tables: &[TablePlan], economy: Economy) -> Vec<Skipped> {
    let called: HashSet<Effect> = scene
        .materials
        .iter()
        .flat_map(|material| material.calls.iter().map(|call| call.effect))
        .collect();
    let missing = Effect::ALL.into_iter().filter(|effect| !called.contains(effect));
    missing
        .map(|effect| Skipped {
            effect,
            reason: match economy {
                Economy::NONE => format!("{}, and what all effects add is computed regardless", bare(effect)),
                _ => reason(effect, tables),
            },
        })
        .collect()
}

/// The reason without what it spares.
fn bare(effect: Effect) -> String {
    let reason = reason(effect, &[]);
    reason.split(':').next().unwrap_or_default().to_owned()
}

fn reason(effect: Effect, tables: &[TablePlan]) -> String {
    let text = match effect {
        Effect::Metal => "no material reflects like a conductor",
        Effect::Dielectric => "no material is an opaque dielectric",
        Effect::Diffuse => "no material has a diffuse base that scatters light: rho_hh couples to nothing",
        Effect::Transmission => "no material transmits light: tables have no second side",
        Effect::Anisotropy => "no roughness differs between the tangents: tables have no axis of azimuth",
        Effect::Sheen => "no material has a sheen",
        Effect::Clearcoat => "no material has a clearcoat",
        Effect::Iridescence => "no material has a thin film",
        Effect::Dispersion => "no material disperses light",
        Effect::Measured => "no material is measured",
        Effect::RoughnessRange if has_sheet(tables) => {
            "every material has one roughness; the axis of roughness spans those of the materials that share the table"
        }
        Effect::RoughnessRange => "every material has one roughness: tables have no axis of roughness",
        Effect::Colour => {
            "every Fresnel term is grey or Schlick's, whose r0 is a factor: tables have one channel or two"
        }
    };
    text.to_owned()
}

fn has_sheet(tables: &[TablePlan]) -> bool {
    let mut axes = tables.iter().flat_map(|table| table.alternatives.iter().flatten());
    axes.any(|axis| axis.parameter != MU && axis.parameter != AZIMUTH)
}
