//! Mean albedos of what lookups in another texture read.
//!
//! Compensated lobes keep energy where the mean belongs to the very E that the shader sees: 1 - E_avg may be 1e-5, far less than what
//! interpolation leaves of E. E is linear between texels along every axis, so that its mean over mu is linear between
//! the rows: of the same other axes the means at the texels are those everywhere.

use super::bake::{SheetError, total_of};
use super::grid::{Grid, Places, borders};
use super::sheet::{Parameter, Sheet, Term};
use crate::table::axis::{Axis, Mapping};
use crate::table::texture::{Texture, TextureAxis};

/// Texels per channel of a sheet without mu, from the last of `earlier` that has its axes and mu.
pub(super) fn means(
    sheet: &Sheet,
    axes: &[TextureAxis],
    earlier: &[(&Sheet, &Texture)],
) -> Result<Vec<Vec<f64>>, SheetError> {
    let over_mu = |sheet: &Sheet| sheet.axes.iter().position(|along| along.parameter == Parameter::Mu);
    let is_source = |(source, texture): &&(&Sheet, &Texture)| {
        over_mu(source).is_some_and(|k| {
            let mut rest = texture.axes.clone();
            rest.remove(k);
            rest == axes && read(source, texture.texel([0, 0, 0])).is_some()
        })
    };
    let Some((source, texture)) = earlier.iter().rev().find(is_source) else {
        return Err(SheetError::Mean { sheet: sheet.name });
    };
    let k = over_mu(source).unwrap_or(0);
    let grid = Grid::new(axes, axes.iter().map(Places::texels).collect());
    let mean = |texel: usize| -> f64 {
        let place = grid.values(texel);
        let e = |mu: f64| {
            let mut at = place.clone();
            at.insert(k, mu);
            read(source, &texture.lookup(&at)).unwrap_or(f64::NAN)
        };
        mean_over(&texture.axes[k], &e)
    };
    let totals: Vec<f64> = (0..grid.len()).map(mean).collect();
    let column = |term: &Term| match term {
        Term::MeanLoss => totals.iter().map(|mean| 1.0 - mean).collect(),
        _ => totals.clone(),
    };
    Ok(sheet.channels.iter().map(column).collect())
}

/// What is averaged: E, or the share of an interface.
fn read(sheet: &Sheet, channels: &[f64]) -> Option<f64> {
    let interface = sheet.channels.iter().position(|term| *term == Term::Interface);
    total_of(&sheet.channels, channels).or(interface.map(|k| channels[k]))
}

/// int_0^1 e d(mu^2) of an `e` that is linear in u between the texels of `axis`, where mu = u^k.
///
/// With e = e_0 + s (u - u_0) on a cell it is e_0 (u_1^2k - u_0^2k) + s (2k/(2k+1) (u_1^(2k+1) - u_0^(2k+1)) - u_0 (u_1^2k - u_0^2k)).
fn mean_over(axis: &TextureAxis, e: &dyn Fn(f64) -> f64) -> f64 {
    let k = power(&axis.axis);
    let cell = |pair: &[f64]| {
        let (from, to) = (pair[0], pair[1]);
        let (start, end) = (e(axis.axis.value(from)), e(axis.axis.value(to)));
        let slope = (end - start) / (to - from);
        let even = libm::pow(to, 2.0 * k) - libm::pow(from, 2.0 * k);
        let odd = libm::pow(to, 2.0 * k + 1.0) - libm::pow(from, 2.0 * k + 1.0);
        start * even + slope * (2.0 * k / (2.0 * k + 1.0) * odd - from * even)
    };
    borders(axis).windows(2).map(cell).sum()
}

/// k of mu = u^k.
fn power(axis: &Axis) -> f64 {
    match axis.mapping {
        Mapping::SqrtMu | Mapping::Sqrt => 2.0,
        Mapping::FourthRootMu => 4.0,
        Mapping::ThreeQuarters => 4.0 / 3.0,
        Mapping::Mu | Mapping::Linear | Mapping::Log | Mapping::Log1p => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::axis::TexelRule;

    /// e = u itself: int u d(u^2k) = 2k/(2k+1), cell by cell or at once, and of clamped half cells a little more.
    #[test]
    fn means_are_exact_for_what_is_linear() {
        for (mapping, k) in [(Mapping::Mu, 1.0), (Mapping::SqrtMu, 2.0), (Mapping::FourthRootMu, 4.0)] {
            let axis = TextureAxis::along(Axis::new("mu", mapping, TexelRule::Ends, [0.0, 1.0], 7).unwrap());
            let found = mean_over(&axis, &|mu| axis.axis.u(mu));
            let expected = 2.0 * k / (2.0 * k + 1.0);
            assert!((found - expected).abs() < 1e-14, "{mapping:?}: {found} {expected}");
            assert!((mean_over(&axis, &|_| 1.0) - 1.0).abs() < 1e-14);
        }
    }
}
