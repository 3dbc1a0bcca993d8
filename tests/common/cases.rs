//! Materials by name, and random materials and directions over the whole legal ranges.

use whitefurnace::bxdf::Microfacet;
use whitefurnace::distribution::{Anisotropic, Distribution, Elliptic, Family, Isotropic};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::masking::Masking;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::spectrum::Spectrum;

pub(crate) fn vmf(kappa: f64) -> Isotropic {
    Family::Vmf.with(kappa).unwrap()
}

pub(crate) fn beckmann(m: f64) -> Isotropic {
    Family::Beckmann.with(m).unwrap()
}

pub(crate) fn phong(n: f64) -> Isotropic {
    Family::Phong.with(n).unwrap()
}

pub(crate) fn dielectric(eta: f64) -> Fresnel {
    Fresnel::dielectric(Spectrum::grey(eta)).unwrap()
}

pub(crate) fn conductor(eta: f64, k: f64) -> Fresnel {
    Fresnel::conductor(Spectrum::grey(eta), Spectrum::grey(k)).unwrap()
}

pub(crate) fn ggx(alpha: f64) -> Isotropic {
    Family::Ggx.with(alpha).unwrap()
}

pub(crate) fn charlie(alpha: f64) -> Isotropic {
    Family::Charlie.with(alpha).unwrap()
}

/// One of the maskings of sheen, with R = 1.
pub(crate) fn sheen(alpha: f64, masking: Masking, fresnel: Fresnel) -> Microfacet {
    Microfacet::new(Spectrum::grey(1.0), charlie(alpha), masking, fresnel).unwrap()
}

fn elliptic(kind: Elliptic, x: f64, y: f64) -> Distribution {
    Anisotropic::new(kind, x, y).unwrap().into()
}

pub(crate) fn ggx_xy(alpha_x: f64, alpha_y: f64) -> Distribution {
    elliptic(Elliptic::Ggx, alpha_x, alpha_y)
}

pub(crate) fn beckmann_xy(m_x: f64, m_y: f64) -> Distribution {
    elliptic(Elliptic::Beckmann, m_x, m_y)
}

pub(crate) fn ashikhmin_shirley(e_x: f64, e_y: f64) -> Distribution {
    elliptic(Elliptic::AshikhminShirley, e_x, e_y)
}

/// Methanol of [Mikkelsen 2009, section 3].
pub(crate) fn methanol() -> Fresnel {
    dielectric(1.329)
}

/// Aluminium at 500 nm of [Mikkelsen 2009, section 3].
pub(crate) fn aluminium() -> Fresnel {
    conductor(0.769, 6.08)
}

/// V-grooves with R = 1.
pub(crate) fn grooves(distribution: impl Into<Distribution>, fresnel: Fresnel) -> Microfacet {
    Microfacet::new(Spectrum::grey(1.0), distribution, Masking::VGroove, fresnel).unwrap()
}

/// Smith with R = 1, of Beckmann and GGX.
pub(crate) fn smith(distribution: impl Into<Distribution>, fresnel: Fresnel, correlated: bool) -> Microfacet {
    let masking = if correlated {
        Masking::SmithCorrelated
    } else {
        Masking::Smith
    };
    Microfacet::new(Spectrum::grey(1.0), distribution, masking, fresnel).unwrap()
}

/// Members of every family from the widest to the narrowest.
pub(crate) fn distributions() -> Vec<Isotropic> {
    let mut all = Vec::new();
    all.extend([0.0, 1e-9, 0.5, 17.0, 720.0, 1e5, 1e9, 1e12].map(vmf));
    all.extend([1e-6, 1e-3, 0.2, 1.0, 10.0].map(beckmann));
    all.extend([0.0, 1e-3, 1.0, 48.0, 1e4, 1e8].map(phong));
    all.extend([1e-6, 1e-3, 0.2, 1.0, 10.0].map(ggx));
    all
}

/// Random numbers of one case.
pub(crate) struct Dice(Stream);

impl Dice {
    pub(crate) fn new(seed: u64, case: u64) -> Self {
        Self(Stream::new(StreamId {
            seed,
            cell: case,
            batch: 0,
        }))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    pub(crate) fn uniform3(&mut self) -> [f64; 3] {
        self.0.uniform3()
    }

    /// 10 to a power uniform in the given range.
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        10f64.powf(from + (to - from) * self.uniform())
    }

    /// One of several, equally likely.
    pub(crate) fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.uniform() * of.len() as f64) as usize]
    }

    /// Any distribution of facets that lie in the surface, over the legal range, its ends included.
    pub(crate) fn distribution(&mut self) -> Isotropic {
        let end = self.uniform() < 0.1;
        match self.pick(&[Family::Vmf, Family::Beckmann, Family::Phong, Family::Ggx]) {
            Family::Vmf if end => vmf(self.pick(&[0.0, 1e12])),
            Family::Vmf => {
                let kappa = self.log(-2.0, 12.0);
                vmf(if self.uniform() < 0.1 {
                    self.log(-18.0, -2.0)
                } else {
                    kappa.min(1e12)
                })
            }
            Family::Beckmann if end => beckmann(self.pick(&[1e-6, 10.0])),
            Family::Beckmann => beckmann(self.log(-6.0, 1.0).clamp(1e-6, 10.0)),
            Family::Ggx if end => ggx(self.pick(&[1e-6, 10.0])),
            Family::Ggx => ggx(self.log(-6.0, 1.0).clamp(1e-6, 10.0)),
            Family::Charlie => charlie(self.log(-3.0, 0.0).clamp(1e-3, 1.0)),
            Family::Phong if end => phong(self.pick(&[0.0, 1e8])),
            Family::Phong => {
                let n = self.log(-2.0, 8.0);
                phong(if self.uniform() < 0.1 {
                    self.log(-18.0, -2.0)
                } else {
                    n.min(1e8)
                })
            }
        }
    }

    /// Any Beckmann or GGX distribution of the legal range, its ends included: isotropic or anisotropic, to all ratios.
    pub(crate) fn slopes(&mut self) -> Distribution {
        let mut width = |ends: f64| {
            if self.uniform() < ends {
                self.pick(&[1e-6, 10.0])
            } else {
                self.log(-6.0, 1.0).clamp(1e-6, 10.0)
            }
        };
        let (x, y) = (width(0.1), width(0.2));
        match self.pick(&[0, 1, 2, 2, 3, 3]) {
            0 => beckmann(x).into(),
            1 => ggx(x).into(),
            2 => beckmann_xy(x, y),
            _ => ggx_xy(x, y),
        }
    }

    /// Any microfacet lobe of either Smith term.
    pub(crate) fn smith(&mut self) -> Microfacet {
        let correlated = self.pick(&[true, false]);
        let distribution = self.slopes();
        smith(distribution, self.fresnel(), correlated)
    }

    /// A number or three.
    fn spectrum(&mut self, mut one: impl FnMut(&mut Self) -> f64) -> Spectrum {
        if self.uniform() < 0.2 {
            Spectrum::rgb([one(self), one(self), one(self)])
        } else {
            Spectrum::grey(one(self))
        }
    }

    /// An index of refraction: anywhere, near 1 from both sides, and the usual ones.
    fn eta(&mut self) -> f64 {
        match self.pick(&[0, 0, 1, 2, 3]) {
            0 => self.log(-2.0, 2.0).clamp(0.01, 100.0),
            1 => 1.0 + self.log(-16.0, -0.5) * self.pick(&[-1.0, 1.0]),
            2 => self.pick(&[1.0, 1.00029, 1.0 / 1.00029, 0.01, 100.0]),
            _ => self.pick(&[1.329, 1.5, 1.0 / 1.5, 2.42, 0.769]),
        }
    }

    /// An extinction coefficient, often vanishing.
    fn extinction(&mut self) -> f64 {
        match self.pick(&[0, 0, 1, 2]) {
            0 => self.log(-3.0, 2.0).min(100.0),
            1 => self.log(-18.0, -3.0),
            _ => self.pick(&[0.0, 100.0, 6.08]),
        }
    }

    /// Any of the five Fresnel terms.
    pub(crate) fn fresnel(&mut self) -> Fresnel {
        match self.pick(&[0, 1, 1, 2, 2, 3, 4]) {
            0 => Fresnel::None,
            1 => Fresnel::dielectric(self.spectrum(Self::eta)).unwrap(),
            2 => {
                let eta = self.spectrum(Self::eta);
                Fresnel::conductor(eta, self.spectrum(Self::extinction)).unwrap()
            }
            3 => {
                let eta = self.spectrum(Self::eta);
                Fresnel::conductor_approximate(eta, self.spectrum(Self::extinction)).unwrap()
            }
            _ => Fresnel::schlick(self.spectrum(|dice| match dice.pick(&[0, 1]) {
                0 => dice.uniform(),
                _ => dice.pick(&[0.0, 1.0, 0.04]),
            }))
            .unwrap(),
        }
    }

    /// Any microfacet lobe.
    pub(crate) fn microfacet(&mut self) -> Microfacet {
        let distribution = self.distribution();
        let masking = self.pick(&[Masking::VGroove, Masking::VGroove, Masking::VGroove, Masking::None]);
        let fresnel = self.fresnel();
        let reflectance = self.spectrum(|dice| {
            let u = dice.uniform();
            if u < 0.7 { 1.0 } else { dice.uniform() }
        });
        Microfacet::new(reflectance, distribution, masking, fresnel).unwrap()
    }

    /// cos theta_o, with much weight on both ends.
    pub(crate) fn mu(&mut self) -> f64 {
        match self.pick(&[0, 1, 2, 3, 3, 4, 4, 5, 5, 5]) {
            0 => self.pick(&[0.0, 1e-300, 1e-5]),
            1 => 1.0,
            2 => self.log(-300.0, -5.0),
            3 => self.log(-9.0, 0.0).min(1.0),
            4 => 1.0 - self.log(-16.0, 0.0),
            _ => self.uniform(),
        }
        .clamp(0.0, 1.0)
    }
}
