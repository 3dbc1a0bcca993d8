//! Statistical tests of models and of the tables made from them.
//!
//! Tests are functions of a [`Bxdf`](crate::bxdf::Bxdf) and of what else is known of it ([`Facts`], [`Stated`]), so that they
//! can be tested themselves with models that are wrong on purpose. Each gives an [`Outcome`]: a statistic, what chance has
//! to say about it, and where the worst case lies. The verdicts are spoken over all outcomes of a run together, in
//! [`Report::judge`]: the significance of the family is fixed beforehand and shared among its tests.
//!
//! | test | what is compared | by |
//! | --- | --- | --- |
//! | energy | the largest rho_hd, searched for, with 1 | quadrature, or a one-sided test of fresh samples |
//! | white furnace | f \|cos\|/pdf of a coupling with its stated albedo and with 1 | Monte Carlo |
//! | reciprocity | f(wo, wi) with f(wi, wo), deltas both ways | rounding |
//! | density | int pdf with 1 | quadrature of pdf |
//! | directions | counts of `sample_f` with integrals of `pdf` | Pearson's chi-squared |
//! | weights | weight with f \|cos\|/pdf, its pdf with `pdf` | rounding |
//! | albedo | the mean weight with rho_hd computed in another way | Monte Carlo |
//! | normals, visible normals | int D (n.h) dh and int G1 (o.h)+ D dh with 1 and n.o | quadrature of the densities |
//! | fresnel | an approximate conductor with the exact one | a search for the largest difference |
//! | tables | texels and lookups with fresh integrals | both kinds of integration |
//!
//! Deterministic comparisons hold or fail by the errors that both sides state, and take no share of the significance.

mod cells;
mod chart;
mod departures;
pub mod energy;
mod facts;
mod fresnel;
pub mod furnace;
mod material;
pub mod normalisation;
mod outcome;
pub mod reciprocity;
mod report;
pub mod sampling;
mod search;
mod source;
pub mod statistics;
pub mod tables;

pub use departures::{Departure, known_departure};
pub use facts::{Density, Facts, Normals, TransmissionRule, VisibleDensity, facts};
pub use material::{Stated, Subject, verify_bxdf, verify_material};
pub use outcome::{Evidence, Outcome, Place, Statistic, Test};
pub use report::{CONFIDENCE, Check, Report, Verdict};
pub use source::{Settings, Source};
pub use tables::verify_tables;
