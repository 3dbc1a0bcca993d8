//! Precomputes energy-conserving BRDFs: reflectance integrals to a stated error, written as lookup tables.
//!
//! # From a scene to tables
//!
//! | stage | module | takes | gives |
//! | --- | --- | --- | --- |
//! | scene | [`scene`] | a file: TOML, glTF 2.0 or pbrt-v3 | materials, named models whose roughness may be a range |
//! | plan | [`plan`] | a scene | the tables that it calls for, with their axes |
//! | integrate | [`integrate`] | a planned table | its texels, each with an error and a cost |
//! | table | [`table`] | texels | a lookup, its error at and between texels, its range |
//! | export | [`export`] | tables | OpenEXR files and a manifest; [`export::formats`]: KTX 2.0, DDS, PNG, raw numbers, source text |
//!
//! [`engine`] has another way to tables, from an engine instead of a scene: their layouts, and texels that are fitted for what its
//! lookups interpolate. [`shader`] writes what samples the tables of a plan or of an engine, [`compensation`] has the formulae that
//! the samples are for. [`verify`], [`cost`] and [`view`] stand beside them, above [`integrate`]: the first tests models and tables,
//! the second measures what accuracy costs in time, the third makes a page that shows tables at work; nothing below imports them.
//!
//! Below them stand, importing nothing above: [`geometry`], [`spectrum`], [`parameter`], [`numerics`], [`printable`],
//! [`measured`]; on those [`fresnel`],
//! [`distribution`], [`masking`]; on those [`bxdf`]. Only [`integrate`] knows both a BxDF and a table.
//!
//! # Conventions
//!
//! - The local frame has the surface normal n = +z. Directions are unit vectors that point away from the surface.
//! - `wo` is the fixed direction, `wi` the integrated one, `wh` or h their half vector; mu = cos theta_o = |wo.z|.
//! - f is the BxDF without the cosine, in sr^-1. Densities are over solid angle, in sr^-1.
//! - rho_hd(wo) = int f(wo, wi) |cos theta_i| dwi, the directional-hemispherical reflectance, Mikkelsen's rho;
//!   rho_hh = (1/pi) int int f |cos theta_i cos theta_o| dwi dwo, its cosine-weighted mean, his rho_bar.
//! - eta is the index of refraction of the far side over the near side, eta + ik for conductors.
//! - p(h) is a density of facet normals over solid angle, D = p/(n.h), int D (n.h) dh = 1.
//! - Angles are in radians; names that end in `_deg` are in degrees. All arithmetic is f64.
//! - Where a printed equation is wrong or incomplete, the comment at its implementation says what was changed and why.
//!
//! # Errors
//!
//! Every result is an [`estimate::Estimate`]: value, error, meaning of the error, evaluations. Deterministic results state
//! a bound from nested rules, statistical ones the half-width of a 99 % confidence interval.
//!
//! # Example
//!
//! ```
//! use whitefurnace::estimate::{Effort, Estimator};
//! use whitefurnace::integrate::{Integrator, Target};
//! use whitefurnace::scene::Scene;
//!
//! let scene = Scene::default_scene();
//! let model = scene.materials[0].model.at(None)?;
//! let effort = Effort { tolerance: 1e-8, samples: None, seed: 0 };
//! let integrator = Integrator::new(&model, Estimator::Auto, effort)?;
//! let albedo = integrator.estimate(Target::rho_hd(0.5, 0.0), 0)?;
//! assert!(albedo.error.max_element() <= 1e-8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Bibliography
//!
//! - [Abramowitz and Stegun 1964] M. Abramowitz, I. Stegun, *Handbook of Mathematical Functions*.
//! - [Ashikhmin and Premoze 2007] M. Ashikhmin, S. Premoze, *Distribution-based BRDFs*, technical report.
//! - [Burley 2012] B. Burley, *Physically-based shading at Disney*, SIGGRAPH course.
//! - [Chan et al. 1983] T. Chan, G. Golub, R. LeVeque, *Algorithms for computing the sample variance*, The American
//!   Statistician 37.
//! - [Dupuy and Benyoub 2023] J. Dupuy, A. Benyoub, *Sampling visible GGX normals with spherical caps*, Computer Graphics
//!   Forum 42.
//! - [Estevez and Kulla 2017] A. Estevez, C. Kulla, *Production friendly microfacet sheen BRDF*, technical report, Sony Pictures
//!   Imageworks.
//! - [Heitz 2014] E. Heitz, *Understanding the masking-shadowing function in microfacet-based BRDFs*, Journal of Computer
//!   Graphics Techniques 3.
//! - [Heitz and d'Eon 2014] E. Heitz, E. d'Eon, *Importance sampling microfacet-based BSDFs using the distribution of
//!   visible normals*, Computer Graphics Forum 33.
//! - [CIE 015:2018] Commission Internationale de l'Eclairage, *Colorimetry*, fourth edition.
//! - [ITU-R BT.709-6] International Telecommunication Union, *Parameter values for the HDTV standards*.
//! - [Johnson 1978] N. Johnson, *Modified t tests and confidence intervals for asymmetrical populations*, Journal of the
//!   American Statistical Association 73.
//! - [Kulla and Conty 2017] C. Kulla, A. Conty, *Revisiting physically based shading at Imageworks*, SIGGRAPH course.
//! - [Lawson 1961] C. Lawson, *Contributions to the theory of linear least maximum approximation*, dissertation, UCLA.
//! - [Matusik et al. 2003] W. Matusik, H. Pfister, M. Brand, L. McMillan, *A data-driven reflectance model*, SIGGRAPH.
//! - [Maurer and Pontil 2009] A. Maurer, M. Pontil, *Empirical Bernstein bounds and sample-variance penalization*, COLT.
//! - [Mikkelsen 2009] M. Mikkelsen, *Microfacet Based Bidirectional Reflectance Distribution Function*.
//! - [Neubelt and Pettineo 2013] D. Neubelt, M. Pettineo, *Crafting a next-gen material pipeline for The Order: 1886*, SIGGRAPH
//!   course.
//! - [L'Ecuyer et al. 2023] P. L'Ecuyer, M. Nakayama, A. Owen, B. Tuffin, *Confidence intervals for randomized quasi-Monte
//!   Carlo estimators*, Winter Simulation Conference.
//! - [Owen 1997] A. Owen, *Scrambled net variance for integrals of smooth functions*, Annals of Statistics 25.
//! - [Patterson 1968] T. Patterson, *The optimum addition of points to quadrature formulae*, Mathematics of Computation 22.
//! - [pbrt 2010] M. Pharr, G. Humphreys, *Physically Based Rendering*, second edition, chapter 8.
//! - [pbrt 2016] M. Pharr, W. Jakob, G. Humphreys, *Physically Based Rendering*, third edition, section 8.2.
//! - [Khronos 2021] The Khronos Group, *glTF 2.0 specification* 2.0.1, and the extensions of materials that it has ratified.
//! - [Kolmogorov 1933], [Stephens 1970] A. Kolmogorov, M. Stephens: the one-sample test of a distribution and its tables.
//! - [Rusinkiewicz 1998] S. Rusinkiewicz, *A new change of variables for efficient BRDF representation*, Eurographics
//!   Workshop on Rendering.
//! - [Sidak 1967] Z. Sidak, *Rectangular confidence regions for the means of multivariate normal distributions*, JASA 62.
//! - [Smith 1967] B. Smith, *Geometrical shadowing of a random rough surface*, IEEE Transactions on Antennas and
//!   Propagation 15.
//! - [Todhunter 1886] I. Todhunter, *Spherical Trigonometry*, fifth edition.
//! - [Stouffer et al. 1949] S. Stouffer et al., *The American Soldier*, volume 1, on adding up scores of tests.
//! - [Steele et al. 2014] G. Steele, D. Lea, C. Flood, *Fast splittable pseudorandom number generators*, OOPSLA.
//! - [Turquin 2019] E. Turquin, *Practical multiple scattering compensation for microfacet models*, Industrial Light & Magic.
//! - [Walter et al. 2007] B. Walter, S. Marschner, H. Li, K. Torrance, *Microfacet models for refraction through rough
//!   surfaces*, Eurographics Symposium on Rendering.
//! - [Walsh 1926] J. Walsh, *The reflection factor of a polished glass surface for diffused light*, Illumination Research
//!   Technical Paper 2, H. M. Stationery Office.
//!
//! [Abramowitz and Stegun 1964]: #bibliography
//! [Ashikhmin and Premoze 2007]: #bibliography
//! [Burley 2012]: #bibliography
//! [Chan et al. 1983]: #bibliography
//! [Dupuy and Benyoub 2023]: #bibliography
//! [Estevez and Kulla 2017]: #bibliography
//! [Heitz 2014]: #bibliography
//! [Heitz and d'Eon 2014]: #bibliography
//! [CIE 015:2018]: #bibliography
//! [ITU-R BT.709-6]: #bibliography
//! [Johnson 1978]: #bibliography
//! [Kulla and Conty 2017]: #bibliography
//! [Lawson 1961]: #bibliography
//! [Matusik et al. 2003]: #bibliography
//! [Maurer and Pontil 2009]: #bibliography
//! [Mikkelsen 2009]: #bibliography
//! [Neubelt and Pettineo 2013]: #bibliography
//! [L'Ecuyer et al. 2023]: #bibliography
//! [Owen 1997]: #bibliography
//! [Patterson 1968]: #bibliography
//! [pbrt 2010]: #bibliography
//! [pbrt 2016]: #bibliography
//! [Khronos 2021]: #bibliography
//! [Kolmogorov 1933]: #bibliography
//! [Stephens 1970]: #bibliography
//! [Rusinkiewicz 1998]: #bibliography
//! [Sidak 1967]: #bibliography
//! [Smith 1967]: #bibliography
//! [Todhunter 1886]: #bibliography
//! [Stouffer et al. 1949]: #bibliography
//! [Steele et al. 2014]: #bibliography
//! [Turquin 2019]: #bibliography
//! [Walter et al. 2007]: #bibliography
//! [Walsh 1926]: #bibliography

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bxdf;
pub mod compensation;
#[allow(clippy::disallowed_methods)] // its times differ from run to run anyway
pub mod cost;
pub mod distribution;
pub mod engine;
pub mod estimate;
pub mod export;
pub mod fresnel;
pub mod geometry;
pub mod integrate;
pub mod masking;
pub mod measured;
pub mod numerics;
pub mod parameter;
pub mod plan;
pub mod printable;
mod regular;
pub mod scene;
pub mod shader;
pub mod spectrum;
pub mod table;
#[allow(clippy::disallowed_methods)] // nothing of it goes into a table
pub mod verify;
pub mod view;
