//! The command line: arguments, and one file per command.

mod bake;
mod cost;
mod format;
mod inspect;
mod lobes;
mod number;
mod plan;
mod rho;
mod shader;
mod verify;
mod view;

use clap::{Args, Parser, Subcommand};
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::exit;
use whitefurnace::bxdf::Model;
use whitefurnace::estimate::{Effort, Estimator, default_tolerance};
use whitefurnace::export::write;
use whitefurnace::integrate::choice::Wish;
use whitefurnace::plan::{Economy, Request};
use whitefurnace::printable::is_hidden;
use whitefurnace::scene::{Material, Scene};
use whitefurnace::table::axis::Mapping;

const TEACH: &str = "\
Examples:
  furnace bake                              the built-in scene, into outputs/
  furnace plan scene.toml                   what a bake would compute, and what it would cost
  furnace rho --theta-deg 0,60,85           directional albedo at three angles
  furnace verify --tables outputs/default   whether models and tables keep their promises
  furnace cost --quick                      what accuracy costs in time, with charts
  furnace view                              a page for a browser: lobes, tables and furnace
  furnace inspect outputs/default/FILE.exr  what a table holds
  furnace shader --tables outputs/default   functions that sample the tables, to paste into a shader
  furnace bake --profile three              the tables of an engine, in its layout

rho_hd is the share of light from one direction that a material reflects into all others; rho_hh is its mean.
Every number comes with an error: a bound (quadrature), a 99 % interval (Monte Carlo), or rounding alone (closed forms).

Exit codes: 0 good, 1 a verification failed, 2 wrong usage, input or output, 130 a bake was interrupted.";

/// Precomputes energy-conserving BRDFs: reflectance integrals to a stated error, as lookup tables.
#[derive(Debug, Parser)]
#[command(name = "furnace", version, about, after_help = TEACH, arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

impl Arguments {
    /// The arguments of this process. Wrong ones end it with exit code 2, and a request for help with 0.
    pub(crate) fn of_this_process() -> Self {
        Self::try_parse().unwrap_or_else(|error| {
            // the shell may have put the names of others here
            let text = error.to_string();
            if error.use_stderr() && text.contains(|c: char| is_hidden(c) && c != '\n') {
                format::complain(text.trim_end());
                exit(2)
            }
            error.exit()
        })
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compute the tables that a scene calls for and write them.
    Bake(bake::Bake),
    /// Say what a bake would compute, what it would leave out and why, and what it would cost.
    Plan(plan::PlanCommand),
    /// Print rho_hd at given directions, and rho_hh.
    Rho(rho::Rho),
    /// Test energy conservation, reciprocity, sampling, normalisation, and baked tables.
    Verify(verify::Verify),
    /// Show what accuracy costs in time: error against seconds, table size and storage, with charts.
    Cost(cost::Cost),
    /// Make a page for a browser that shows the tables of a scene at work.
    View(view::View),
    /// Say what a table holds, how it was made, its range and its error.
    Inspect(inspect::Inspect),
    /// Write functions that sample the tables of a scene and evaluate its materials, in WGSL, GLSL, HLSL or MSL.
    Shader(shader::ShaderCommand),
}

/// What all commands that compute have in common.
#[derive(Debug, Args)]
struct Common {
    /// Scene file: TOML, glTF (.gltf, .glb) or pbrt-v3 (.pbrt); without one the built-in scene is used.
    scene: Option<PathBuf>,
    /// How integrals are computed: auto, closed-form, quadrature, or samples: mc-uniform, mc-cosine, mc-normals, mc-visible,
    /// mc-bxdf, each also as stratified-* (jittered strata) and qmc-* (Owen-scrambled Sobol points).
    #[arg(long, default_value = "auto", value_name = "NAME")]
    estimator: Estimator,
    /// Largest absolute error, 1e-12 to 0.5: of any value, and of bake and plan of any lookup in a table, whose sizes are
    /// then chosen. By default 1e-6 for values and texels, and 1e-2 for irregular measured samples.
    #[arg(long, value_name = "ERROR", value_delimiter = ',', value_parser = number::tolerance, allow_hyphen_values = true)]
    tolerance: Vec<f64>,
    /// Fixed number of Monte Carlo samples instead of the tolerance, 2 to 2^40.
    #[arg(long, value_name = "N", value_parser = number::samples, allow_hyphen_values = true)]
    samples: Option<u64>,
    /// Seed of the random streams; the same seed gives the same bytes on any number of threads.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = number::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Threads to use, 1 to 1024; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = number::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// The shape of tables.
#[derive(Debug, Args)]
struct Shape {
    /// Texels along mu, 2 to 16384; 64, or with --tolerance as many as it takes.
    #[arg(long, value_name = "N", value_parser = number::resolution, allow_hyphen_values = true)]
    resolution: Option<usize>,
    /// Texels along a roughness axis, 2 to 16384; 32, or with --tolerance as many as it takes.
    #[arg(long, value_name = "N", value_parser = number::resolution, allow_hyphen_values = true)]
    roughness_resolution: Option<usize>,
    /// Texels along the azimuth of anisotropic materials, 2 to 16384; 16, or with --tolerance as many as it takes.
    #[arg(long, value_name = "N", value_parser = number::resolution, allow_hyphen_values = true)]
    azimuth_resolution: Option<usize>,
    /// Mapping of the mu axis: mu, sqrt-mu, fourth-root-mu, or auto, which keeps the one that serves best.
    #[arg(long, default_value = "auto", value_name = "MAPPING", value_parser = number::mapping)]
    axis: AxisChoice,
    /// Compute every effect for every material, whether the scene calls for it or not: nothing is shared, closed forms are
    /// tabulated, every lobe has both sides, three channels, and roughness over its whole range or an axis of azimuth.
    #[arg(long)]
    all_effects: bool,
}

impl Shape {
    /// Refuses options that are given and would do nothing beside `with`, but for those that are `allowed`.
    fn refuse(&self, allowed: impl Fn(&str) -> bool, with: &str) -> Result<(), Failure> {
        let given = [
            ("--resolution", self.resolution.is_some()),
            ("--roughness-resolution", self.roughness_resolution.is_some()),
            ("--azimuth-resolution", self.azimuth_resolution.is_some()),
            ("--axis", self.axis.0.is_some()),
            ("--all-effects", self.all_effects),
        ];
        match given.into_iter().find(|(option, given)| *given && !allowed(option)) {
            Some((option, _)) => Err(format!("{option} is not allowed with {with}: leave it out").into()),
            None => Ok(()),
        }
    }
}

/// `--axis`: a mapping, or nothing for the measured choice.
#[derive(Debug, Clone, Copy)]
struct AxisChoice(Option<Mapping>);

/// Why a command stopped.
#[derive(Debug)]
pub(crate) struct Failure(Box<dyn Error + Send + Sync>);

impl<E: Into<Box<dyn Error + Send + Sync>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl Failure {
    /// Writes the error and those of its causes that it does not quote to standard error.
    pub(crate) fn tell(&self) {
        format::complain(format!("error: {self}"));
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = self.0.to_string();
        let mut cause = self.0.source();
        while let Some(error) = cause {
            let next = error.to_string();
            if !text.contains(&next) {
                text = format!("{text}: {next}");
            }
            cause = error.source();
        }
        f.write_str(&text)
    }
}

/// What a command that ran to its end has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All is well.
    Good,
    /// A verification failed.
    Failed,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    match &arguments.command {
        Command::Bake(bake) => bake.run()?,
        Command::Plan(plan) => plan.run()?,
        Command::Rho(rho) => rho.run()?,
        Command::Verify(verify) => return verify.run(),
        Command::Cost(cost) => cost.run()?,
        Command::View(view) => view.run()?,
        Command::Inspect(inspect) => inspect.run()?,
        Command::Shader(shader) => shader.run()?,
    }
    Ok(Outcome::Good)
}

/// The scene in the file at `path`, or the built-in one; says what the reader looked past, and when there is nothing to do.
fn load(path: Option<&Path>) -> Result<Scene, Failure> {
    let Some(path) = path else {
        return Ok(Scene::default_scene());
    };
    let scene = Scene::load(path)?;
    for warning in &scene.warnings {
        format::complain(format!("warning: {}: {warning}", scene.source));
    }
    let is_black = |material: &Material| material.model.at(None).is_ok_and(|model| model.flags().is_empty());
    if !scene.materials.is_empty() && scene.materials.iter().all(is_black) {
        format::note(format!(
            "{}: no material scatters light, so that there is nothing to compute",
            scene.source
        ));
    }
    Ok(scene)
}

/// Makes the directory that `--out` names.
fn output_directory(path: &Path) -> Result<(), Failure> {
    write::create_dir(path).map_err(|error| {
        let failure = Failure::from(error);
        let missing = || path.ancestors().take_while(|part| !part.as_os_str().is_empty());
        // the system says what is wrong with the whole path: whose fault it is stands in its existing part
        let hint = match missing().find(|part| part.exists()) {
            Some(there) if there != path => format!(
                "--out names a directory that can be made, and {} takes none of that name",
                there.display()
            ),
            _ => "--out names a directory that can be made and written into".into(),
        };
        format!("{failure}; {hint}").into()
    })
}

/// The materials called `names`, or all when there are none.
fn select<'a>(materials: &'a [Material], names: &[String]) -> Result<Vec<&'a Material>, Failure> {
    if names.is_empty() {
        return Ok(materials.iter().collect());
    }
    let find = |name: &String| {
        materials.iter().find(|material| material.name == *name).ok_or_else(|| {
            let known = format::some(materials.iter().map(|material| material.name.as_str()));
            format!("the scene has no material `{name}`; it has {known}")
        })
    };
    Ok(names.iter().map(find).collect::<Result<_, String>>()?)
}

/// Runs `work` on the given number of threads, or as many as there are cores.
fn in_pool<T: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()?
        .install(work)
}

impl Common {
    fn load(&self) -> Result<Scene, Failure> {
        load(self.scene.as_deref())
    }

    /// Deterministic estimators draw no samples; who fixes their number gets told.
    fn tell_unused(&self) {
        if self.samples.is_some() && !matches!(self.estimator, Estimator::MonteCarlo { .. }) {
            let estimator = self.estimator;
            format::note(format!(
                "--samples has no effect on --estimator {estimator}, which meets the tolerance instead"
            ));
        }
    }

    /// The tolerance of a command that takes one.
    fn tolerance(&self) -> Result<Option<f64>, Failure> {
        match &self.tolerance[..] {
            [] => Ok(None),
            [one] => Ok(Some(*one)),
            several => {
                let count = several.len();
                Err(
                    format!("--tolerance: {count} values are not allowed: only rho takes several, the others one")
                        .into(),
                )
            }
        }
    }

    /// The error that lookups may have, where one is asked for.
    fn wish(&self, shape: &Shape) -> Result<Option<Wish>, Failure> {
        let tolerance = self.tolerance()?;
        Ok(tolerance.map(|tolerance| Wish {
            tolerance,
            mu: shape.resolution,
            roughness: shape.roughness_resolution,
            azimuth: shape.azimuth_resolution,
            mapping: shape.axis.0,
        }))
    }

    fn effort(&self, model: &Model, tolerance: Option<f64>) -> Effort {
        Effort {
            tolerance: tolerance.unwrap_or_else(|| default_tolerance(model)),
            samples: self.samples,
            seed: self.seed,
        }
    }

    fn request(&self, shape: &Shape) -> Result<Request, Failure> {
        self.tell_unused();
        let usual = Request::default();
        Ok(Request {
            resolution: shape.resolution.unwrap_or(usual.resolution),
            roughness_resolution: shape.roughness_resolution.unwrap_or(usual.roughness_resolution),
            azimuth_resolution: shape.azimuth_resolution.unwrap_or(usual.azimuth_resolution),
            mapping: shape.axis.0,
            estimator: self.estimator,
            tolerance: self.tolerance()?,
            samples: self.samples,
            seed: self.seed,
            economy: if shape.all_effects {
                Economy::NONE
            } else {
                Economy::FULL
            },
        })
    }

    /// Runs `work` on the number of threads asked for.
    fn in_pool<T: Send>(&self, work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
        in_pool(self.threads, work)
    }
}
