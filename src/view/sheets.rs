//! The albedos that a page shows: tables of several sizes in several formats, and a reference between their texels.

use super::cast::{Cast, Surface, Term};
use crate::bxdf::ModelError;
use crate::fresnel::Fresnel;
use crate::integrate::{FillError, Progress, texels};
use crate::plan::{Plan, PlanError, Request, TablePlan};
use crate::scene::{DistributionSpec, Material, ModelSpec, Roughness, Scene};
use crate::spectrum::Spectrum;
use crate::table::axis::{Axis, AxisError, MU, Mapping, TexelRule};
use crate::table::texture::{Texture, TextureError};
use crate::table::{Quantity, Storage};
use rayon::prelude::*;
use thiserror::Error;

/// Texels along mu and along the roughness of the tables.
pub const SIZES: [usize; 5] = [8, 16, 32, 64, 128];
/// Formats of the tables.
pub const STORAGES: [Storage; 2] = [Storage::F32, Storage::F16];
/// Largest absolute error of any albedo: a tenth of what tells a step of f16 from the next, and far below what tables err by
/// between their texels.
pub const TOLERANCE: f64 = 1e-5;
/// Points of the reference along mu and along the roughness: with texels at the ends, n - 1 of no table divides that of the
/// reference, so that they meet at the ends alone.
const REFERENCE: [usize; 2] = [129, 65];

/// Everything of one lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheets {
    /// Of [`SIZES`] the tables of rho_hd, each in [`STORAGES`].
    pub albedo: Vec<Vec<Texture>>,
    /// The same of rho_hh, over the roughness alone.
    pub mean: Vec<Vec<Texture>>,
    /// rho_hd where the page compares.
    pub reference: Texture,
    /// rho_hh there.
    pub reference_mean: Texture,
}

/// Why there are no sheets.
#[derive(Debug, Error)]
pub enum SheetError {
    /// The library plans no table for the lobe.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// An integral failed.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// The roughness has no axis.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Values that a texture cannot hold.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// A lobe that is none.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A plan that lacks one of the two integrals.
    #[error("no table was planned for {0}")]
    Unplanned(&'static str),
}

/// Number of integrals that [`sheets`] computes for all of `cast`.
pub fn work(cast: &Cast) -> u64 {
    let sheets: usize = cast.surfaces.iter().map(|surface| surface.terms.len()).sum();
    let shapes = SIZES.map(|n| [n, n]).into_iter().chain([REFERENCE]);
    let each: usize = shapes.map(|[width, height]| width * height + height).sum();
    (sheets * each) as u64
}

/// The sheets of every surface, one for each of its terms, in their order.
///
/// # Errors
/// [`SheetError`]
pub fn sheets(cast: &Cast, progress: Progress<'_>) -> Result<Vec<Vec<Sheets>>, SheetError> {
    let of_surface = |surface: &Surface| surface.terms.iter().map(|term| of(surface, *term, progress)).collect();
    cast.surfaces.iter().map(of_surface).collect()
}

/// The axis of the roughness of `surface`: slopes by their root, the perceptual roughness, and concentrations by their logarithm.
pub(super) fn roughness_axis(surface: &Surface, size: usize) -> Result<Axis, AxisError> {
    let legal = surface.family.legal();
    let is_slope = legal.min > 0.0;
    let mapping = if is_slope { Mapping::Sqrt } else { Mapping::Log1p };
    Axis::new(legal.name, mapping, TexelRule::Ends, surface.range, size)
}

/// Texels crowd towards the horizon, where lobes change quickly, and hold both limits.
pub(super) fn mu_axis(size: usize) -> Result<Axis, AxisError> {
    Axis::new(MU, Mapping::SqrtMu, TexelRule::Ends, [0.0, 1.0], size)
}

fn of(surface: &Surface, term: Term, progress: Progress<'_>) -> Result<Sheets, SheetError> {
    let tables = planned(surface, term)?;
    let plan = |quantity: Quantity| {
        let found = tables.iter().find(|table| table.quantity == quantity);
        found.ok_or(SheetError::Unplanned(quantity.name()))
    };
    let (albedo, mean) = (plan(Quantity::RhoHd)?, plan(Quantity::RhoHh)?);
    let fill = |plan: &TablePlan, [width, height]: [usize; 2], storages: &[Storage]| {
        let roughness = roughness_axis(surface, height)?;
        let axes = match plan.quantity {
            Quantity::RhoHd => vec![mu_axis(width)?, roughness],
            Quantity::RhoHh => vec![roughness],
        };
        let table = texels(plan, &axes, progress)?;
        let textures = storages.iter().map(|storage| Texture::of(&table, *storage));
        Ok::<Vec<Texture>, SheetError>(textures.collect::<Result<_, _>>()?)
    };
    let shapes: Vec<([usize; 2], &[Storage])> = SIZES
        .iter()
        .map(|n| ([*n, *n], &STORAGES[..]))
        .chain([(REFERENCE, &STORAGES[..1])])
        .collect();
    let mut filled: Vec<[Vec<Texture>; 2]> = shapes
        .par_iter()
        .map(|(shape, storages)| Ok([fill(albedo, *shape, storages)?, fill(mean, *shape, storages)?]))
        .collect::<Result<_, SheetError>>()?;
    let [reference, reference_mean] = filled.pop().unwrap_or_default();
    let one = |mut textures: Vec<Texture>| textures.pop().ok_or(SheetError::Unplanned("the reference"));
    let (albedo, mean) = filled.into_iter().map(|[albedo, mean]| (albedo, mean)).unzip();
    Ok(Sheets {
        albedo,
        mean,
        reference: one(reference)?,
        reference_mean: one(reference_mean)?,
    })
}

/// The tables that the library plans for a lobe whose roughness is a range.
fn planned(surface: &Surface, term: Term) -> Result<Vec<TablePlan>, SheetError> {
    let [min, max] = surface.range;
    let model = ModelSpec::Microfacet {
        reflectance: Spectrum::grey(1.0),
        distribution: DistributionSpec::Isotropic {
            family: surface.family,
            roughness: Roughness::Range { min, max },
        },
        masking: surface.masking,
        fresnel: match term {
            // any r0: a plan makes both of its ends
            Term::Pair => Fresnel::Schlick {
                r0: Spectrum::grey(0.5),
            },
            Term::Own(fresnel) => fresnel,
        },
    };
    let scene = Scene::new("view", vec![Material::new("lobe", model)]);
    let request = Request {
        tolerance: Some(TOLERANCE),
        ..Request::default()
    };
    Ok(Plan::new(&scene, &request)?.tables)
}
