//! Numerical ground floor: nested quadrature, branch-free functions for vector loops, interpolating curves, running moments,
//! random streams, points of the unit cube, Gaussian integrals.

pub mod curve;
pub mod gaussian;
pub mod integral;
pub mod lanes;
pub mod moments;
pub mod patterson;
pub mod points;
pub mod quadrature;
pub mod stream;
pub mod surface;
