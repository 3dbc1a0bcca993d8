//! Precomputes energy-conserving BRDFs: reflectance integrals to a stated error, written as lookup tables.

pub mod bxdf;
pub mod distribution;
pub mod estimate;
pub mod export;
pub mod fresnel;
pub mod geometry;
pub mod integrate;
pub mod masking;
pub mod numerics;
pub mod parameter;
pub mod plan;
pub mod scene;
pub mod spectrum;
pub mod table;
