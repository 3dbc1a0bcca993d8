//! Distributions of normals with two principal directions, the tangents x and y.
//!
//! Along any azimuth phi an anisotropic distribution has the profile of an isotropic one: with semi-axes a_x, a_y of the
//! lobe and the radius of their ellipse r(phi) = a_x a_y/hypot(a_y cos phi, a_x sin phi),
//!
//! p(theta, phi) = p_iso(theta; r(phi)) r(phi)^2/(a_x a_y).
//!
//! The second factor is 2 pi times the density of the azimuth. For Beckmann and GGX the semi-axes are m or alpha; for
//! Ashikhmin-Shirley, whose exponents interpolate as e_x cos^2 + e_y sin^2, they are 1/sqrt(e + 2). An azimuth with
//! direction (a_x cos psi, a_y sin psi) has that density for uniform psi.

use super::{Beckmann, Family, Ggx, Isotropic, Phong};
use crate::geometry::at_azimuth;
use crate::parameter::{Legal, ParameterError};
use glam::DVec2;

/// A distribution with one roughness parameter along each tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anisotropic {
    kind: Elliptic,
    /// Parameter along the tangents x and y.
    parameters: [f64; 2],
    /// Semi-axes of the lobe.
    axes: DVec2,
}

/// The families of distributions that may be anisotropic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elliptic {
    /// Beckmann with slopes m_x, m_y.
    Beckmann,
    /// GGX with slopes alpha_x, alpha_y.
    Ggx,
    /// Ashikhmin-Shirley with exponents e_x, e_y [pbrt 2010, section 8.4.3]; normalised Phong where they are equal.
    AshikhminShirley,
}

impl Elliptic {
    /// Names and legal ranges of the parameters along x and y.
    pub fn legal(self) -> [Legal; 2] {
        let [x, y] = match self {
            Self::Beckmann => ["m_x", "m_y"],
            Self::Ggx => ["alpha_x", "alpha_y"],
            Self::AshikhminShirley => ["e_x", "e_y"],
        };
        let legal = self.family().legal();
        [Legal { name: x, ..legal }, Legal { name: y, ..legal }]
    }

    /// The family of the profiles.
    pub fn family(self) -> Family {
        match self {
            Self::Beckmann => Family::Beckmann,
            Self::Ggx => Family::Ggx,
            Self::AshikhminShirley => Family::Phong,
        }
    }

    /// Name as it stands in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beckmann => "beckmann",
            Self::Ggx => "ggx",
            Self::AshikhminShirley => "ashikhmin-shirley",
        }
    }
}

impl Anisotropic {
    /// Parameters along the tangents x and y, each in the range of [`Elliptic::legal`]: slopes m or alpha in [1e-6, 10],
    /// exponents in [0, 1e8]. Any ratio is allowed.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range, for x before y.
    pub fn new(kind: Elliptic, x: f64, y: f64) -> Result<Self, ParameterError> {
        let [legal_x, legal_y] = kind.legal();
        let parameters = [legal_x.check(x)?, legal_y.check(y)?];
        let axes = match kind {
            Elliptic::Beckmann | Elliptic::Ggx => DVec2::new(x, y),
            Elliptic::AshikhminShirley => DVec2::new(x + 2.0, y + 2.0).map(|n| n.sqrt().recip()),
        };
        Ok(Self { kind, parameters, axes })
    }

    /// The family.
    pub fn kind(&self) -> Elliptic {
        self.kind
    }

    /// Parameters along x and y.
    pub fn parameters(&self) -> [f64; 2] {
        self.parameters
    }

    /// Semi-axes of the lobe along x and y: the slopes m or alpha, or 1/sqrt(e + 2).
    pub fn axes(&self) -> DVec2 {
        self.axes
    }

    /// The profile along the unit vector `azimuth`.
    pub fn along(&self, azimuth: DVec2) -> Isotropic {
        match self.kind {
            Elliptic::Beckmann => Isotropic::Beckmann(Beckmann::between(self.radius(azimuth))),
            Elliptic::Ggx => Isotropic::Ggx(Ggx::between(self.radius(azimuth))),
            Elliptic::AshikhminShirley => {
                let [x, y] = self.parameters;
                let squares = azimuth * azimuth;
                Isotropic::Phong(Phong::between(x * squares.x + y * squares.y))
            }
        }
    }

    /// 2 pi times the density of normals over azimuth, in 1/rad; 1 on average.
    pub fn azimuth_weight(&self, azimuth: DVec2) -> f64 {
        let radius = self.radius(azimuth);
        (radius / self.axes.x) * (radius / self.axes.y)
    }

    /// The azimuth whose share of the normals before it is psi/(2 pi).
    pub fn azimuth(&self, psi: f64) -> DVec2 {
        // relative to the larger axis: their products may underflow
        let axes = self.axes / self.axes.max_element();
        (axes * at_azimuth(psi)).normalize_or(DVec2::X)
    }

    fn radius(&self, azimuth: DVec2) -> f64 {
        let DVec2 { x, y } = self.axes;
        x * y / libm::hypot(y * azimuth.x, x * azimuth.y)
    }
}
