//! Axes, sizes, texel tolerance and storage such that a lookup errs by no more than asked for, at least bytes.
//!
//! A lookup errs by the interpolation, by the texels, and by the rounding of the storage format; the three add up at worst.
//! Texels get a share of the tolerance, since digits of an integral are cheap; the format takes its rounding; the rest
//! is for the interpolation, which lines through the domain (`profile.rs`) tell for every mapping, rule and size. With two axes the rest is split so
//! that the product of the sizes is least. [`fill_within`](super::fill_within) then computes the table, measures its error as for any table, and
//! corrects the sizes where the profile was wrong.

use super::fill::FillError;
use super::profile::{Lines, Profile, Stop};
use super::{Effort, Estimator};
use crate::plan::TablePlan;
use crate::table::Storage;
use crate::table::axis::{AZIMUTH, Axis, MAX_SIZE, MU, Mapping, TexelRule};

/// What a table has to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// Largest absolute error of a linear-filtered lookup anywhere in the domain.
    pub tolerance: f64,
    /// Texels along mu; `None` chooses them.
    pub mu: Option<usize>,
    /// Texels along a roughness axis; `None` chooses them.
    pub roughness: Option<usize>,
    /// Texels along the azimuth; `None` chooses them.
    pub azimuth: Option<usize>,
    /// Mapping of the mu axis; `None` chooses it.
    pub mapping: Option<Mapping>,
}

impl Wish {
    /// Nothing but an error.
    pub fn within(tolerance: f64) -> Self {
        Self {
            tolerance,
            mu: None,
            roughness: None,
            azimuth: None,
            mapping: None,
        }
    }

    pub(super) fn size(&self, axis: &Axis) -> Option<usize> {
        match axis.parameter.as_str() {
            MU => self.mu,
            AZIMUTH => self.azimuth,
            _ => self.roughness,
        }
    }
}

/// Why sizes are not chosen, and those of the plan are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacle {
    /// rho grows without bound at grazing angles.
    Diverges,
    /// rho is known from samples, too few to tell interpolation from noise.
    Samples,
    /// rho has too many kinks to be followed.
    Rough,
}

impl Obstacle {
    /// What to tell people, and what to do.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Diverges => "rho_hd grows without bound as mu -> 0: choose another masking or distribution",
            Self::Samples => {
                "irregular samples know rho too coarsely for sizes to be chosen; set them with --resolution"
            }
            Self::Rough => "rho has too many kinks for sizes to be chosen; set them with --resolution",
        }
    }
}

/// Settings of a table, and what they lead to expect.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The plan with the chosen axes as its only alternative, and the tolerance of its texels.
    pub plan: TablePlan,
    /// How the values are kept.
    pub storage: Storage,
    /// Bytes of the texels, without padding.
    pub bytes: usize,
    /// Expected error of a lookup; infinite where nothing is known of it.
    pub error: f64,
    /// Whether `error` follows from rho over the whole domain, as with one axis, and not from a few lines through it.
    pub whole: bool,
    /// Why no size was chosen.
    pub obstacle: Option<Obstacle>,
}

impl Choice {
    /// How often its texels are computed, as a rule: sizes of two axes are estimated along lines, measured, and corrected.
    pub fn repeats(&self) -> f64 {
        if self.whole { 1.0 } else { SHEETS }
    }
}

/// Sheets that are computed until one has the size that is wanted, as a rule: 1 to 6, see `tests/forecast.rs`.
const SHEETS: f64 = 2.0;

/// Share of the tolerance that texels computed by rules may be off: 5 per cent cost 3 per cent more texels along each axis.
const TEXEL_SHARE: f64 = 0.05;

/// The same for samples, whose number goes with the square of what they gain.
const SAMPLED_SHARE: f64 = 0.5;

/// The same where there is nothing to interpolate.
const ONLY_SHARE: f64 = 0.9;

/// What the search for the worst place adds, see `between`, and what curves and steps of sizes leave uncertain.
const SLACK: f64 = 0.97;

/// The finest tolerance that axes are chosen for: rounding to f32 alone costs 3e-8.
const FINEST: f64 = 1e-8;

/// Error of the curves, as a share of the tolerance: good enough for half of it, too.
const CURVE_SHARE: f64 = 0.02;

/// Most texels of two axes that are chosen: minutes of one core. Sizes that are given may be larger.
pub const MOST_TEXELS: usize = 1 << 20;

/// Mappings and rules of the mu axis, the simplest for a shader first.
///
/// Texels that lookups within 1e-4 need at least with the square and with the fourth root: GGX alpha = 1, 149 and 61; alpha =
/// 0.01, 250 and 155; von Mises-Fisher kappa = 1e6 under eta = 1.5, 589 and 242; Beckmann m = 0.2, 54 and 78. A cube root,
/// which shaders have to take as a power, gains 15 per cent over the fourth at most, and loses 25 where lobes are narrow.
const MU_SHAPES: [(Mapping, TexelRule); 6] = [
    (Mapping::Mu, TexelRule::Centres),
    (Mapping::SqrtMu, TexelRule::Centres),
    (Mapping::FourthRootMu, TexelRule::Centres),
    (Mapping::Mu, TexelRule::Ends),
    (Mapping::SqrtMu, TexelRule::Ends),
    (Mapping::FourthRootMu, TexelRule::Ends),
];

/// How much smaller a table has to be for a less simple mapping.
const WORTH: f64 = 0.97;

/// Shares of what is left for interpolation that the first of two axes gets.
///
/// Where both errors fall with the square of the sizes, a half each is best; one that falls more slowly wants more.
const SPLITS: [f64; 3] = [0.5, 0.35, 0.65];

/// A table whose rho is known along lines, ready to choose from.
#[derive(Debug)]
pub struct Chooser<'a> {
    pub(super) plan: &'a TablePlan,
    pub(super) wish: Wish,
    profile: Result<Profile, Obstacle>,
}

impl<'a> Chooser<'a> {
    /// Follows rho through the domain of `plan`, to the tolerance of `wish` and half of it.
    ///
    /// # Errors
    /// [`FillError`] where an integral fails; where it diverges, or cannot be followed, the choice has an [`Obstacle`].
    pub fn new(plan: &'a TablePlan, wish: Wish) -> Result<Self, FillError> {
        let irregular = plan.model.at(None).is_ok_and(|model| model.is_irregular());
        let profile = if irregular {
            Err(Obstacle::Samples)
        } else {
            match Profile::new(plan, CURVE_SHARE * wish.tolerance.max(FINEST)) {
                Ok(profile) => Ok(profile),
                Err(Stop::Diverges) => Err(Obstacle::Diverges),
                Err(Stop::Rough) => Err(Obstacle::Rough),
                Err(Stop::Failed(error)) => return Err(error),
            }
        };
        Ok(Self { plan, wish, profile })
    }

    /// The settings for what is wished for, with values kept as f32: the file that all textures are made from.
    pub fn wished(&self) -> Choice {
        self.choice(self.wish.tolerance, Storage::F32)
    }

    /// The settings for an error of `tolerance`, at least half of the one wished for, with values kept as `storage`.
    pub fn choice(&self, tolerance: f64, storage: Storage) -> Choice {
        let profile = match &self.profile {
            Ok(profile) => profile,
            Err(obstacle) => return self.unchosen(tolerance, storage, *obstacle),
        };
        let texel = self.texel_tolerance(tolerance);
        let effort = Effort {
            tolerance: texel,
            ..self.plan.effort
        };
        let stored = texel + storage.rounding(profile.largest.max(1.0));
        let fixed = match profile.axes.is_empty() {
            true => stored,
            // what measures the error between texels adds its own, which is no larger than theirs
            false => stored + 2.0 * texel.min(1e-6) + profile.error,
        };
        let allowed = SLACK * (tolerance - fixed);
        let (axes, off) = match &profile.axes[..] {
            [] => (Vec::new(), 0.0),
            [only] => {
                let (axis, off) = self.along(only, allowed, MAX_SIZE);
                (vec![axis], off)
            }
            [first, second, ..] => self.sheet([first, second], allowed),
        };
        let clipped = !storage.holds(profile.largest);
        self.settled(
            axes,
            effort,
            storage,
            if clipped { f64::INFINITY } else { off + fixed },
            None,
        )
    }

    /// The settings in the format that takes the fewest bytes, of those that keep `tolerance`.
    pub fn smallest(&self, tolerance: f64) -> Option<Choice> {
        // where rounding alone takes all, there is nothing to search for
        let possible = Storage::ALL
            .into_iter()
            .filter(|storage| storage.rounding(1.0) < tolerance);
        let choices = possible.map(|storage| self.choice(tolerance, storage));
        let kept = choices.filter(|choice| choice.error <= tolerance);
        // of equal ones the first, which is the most exact
        kept.reduce(|a, b| if b.bytes < a.bytes { b } else { a })
    }

    fn texel_tolerance(&self, tolerance: f64) -> f64 {
        let share = match self.plan.estimator {
            _ if matches!(&self.profile, Ok(profile) if profile.axes.is_empty()) => ONLY_SHARE,
            Estimator::MonteCarlo { .. } => SAMPLED_SHARE,
            _ => TEXEL_SHARE,
        };
        // below that quadrature ends in rounding
        (share * tolerance).max(1e-12)
    }

    /// Sizes of the plan.
    fn unchosen(&self, tolerance: f64, storage: Storage, obstacle: Obstacle) -> Choice {
        let effort = Effort {
            tolerance: match obstacle {
                Obstacle::Samples => tolerance,
                _ => self.texel_tolerance(tolerance),
            },
            ..self.plan.effort
        };
        let axes = self.plan.alternatives.first().cloned().unwrap_or_default();
        let choice = self.settled(axes, effort, storage, f64::INFINITY, Some(obstacle));
        let plan = TablePlan {
            alternatives: self.plan.alternatives.clone(),
            ..choice.plan
        };
        Choice { plan, ..choice }
    }

    fn settled(
        &self,
        axes: Vec<Axis>,
        effort: Effort,
        storage: Storage,
        error: f64,
        obstacle: Option<Obstacle>,
    ) -> Choice {
        let texels: usize = axes.iter().map(|axis| axis.size).product();
        Choice {
            bytes: texels * self.plan.channels.count() * storage.bytes(),
            whole: axes.len() < 2,
            plan: TablePlan {
                alternatives: vec![axes],
                effort,
                ..self.plan.clone()
            },
            storage,
            error,
            obstacle,
        }
    }

    /// Mappings and rules that an axis may have, the simplest first.
    fn shapes(&self, lines: &Lines) -> Vec<(Mapping, TexelRule)> {
        let axis = &lines.axis;
        match (axis.parameter.as_str(), self.wish.mapping) {
            (MU, None) => MU_SHAPES.to_vec(),
            (MU, Some(mapping)) => TexelRule::ALL.map(|rule| (mapping, rule)).to_vec(),
            (AZIMUTH, _) => vec![(axis.mapping, axis.rule)],
            // texels at the ends: clamping half a texel before them errs by a few per cent
            _ => vec![(Mapping::Linear, TexelRule::Ends), (axis.mapping, axis.rule)],
        }
    }

    /// The smallest axis that errs by at most `allowed`, or the best of at most `most` texels, with its error.
    fn along(&self, lines: &Lines, allowed: f64, most: usize) -> (Axis, f64) {
        let shapes = self.shapes(lines);
        let best_of = |size: usize| {
            let shaped = shapes
                .iter()
                .filter_map(|(mapping, rule)| lines.shaped(*mapping, *rule, size));
            let judged = shaped.map(|axis| (lines.error(&axis), axis));
            judged
                .reduce(|a, b| if b.0 < WORTH * a.0 { b } else { a })
                .map_or_else(|| (lines.axis.clone(), f64::INFINITY), |(error, axis)| (axis, error))
        };
        if let Some(size) = self.wish.size(&lines.axis) {
            return best_of(size);
        }
        // the last serves every lobe passably: what needs more texels than it is seen at one glance
        let mut sizes: Vec<Option<usize>> = vec![None; shapes.len()];
        let mut least = most;
        for (index, (mapping, rule)) in shapes.iter().enumerate().rev() {
            let worth = ((least as f64 / WORTH) as usize).min(most);
            let passes = || {
                lines
                    .shaped(*mapping, *rule, worth)
                    .is_some_and(|axis| lines.error(&axis) <= allowed)
            };
            if allowed > 0.0 && passes() {
                sizes[index] = lines.size(*mapping, *rule, allowed, worth);
                least = sizes[index].map_or(least, |size| size.min(least));
            }
        }
        let worth = |size: &usize| *size as f64 * WORTH <= least as f64;
        let simplest = shapes.iter().zip(sizes).find_map(|((mapping, rule), size)| {
            let size = size.filter(worth)?;
            Some((*mapping, *rule, size))
        });
        let kind = |size: usize| {
            if size < 32 {
                size
            } else {
                size.next_multiple_of(4).min(most)
            }
        };
        match simplest.and_then(|(mapping, rule, size)| lines.shaped(mapping, rule, kind(size))) {
            Some(axis) => {
                let error = lines.error(&axis);
                (axis, error)
            }
            None => best_of(most),
        }
    }

    /// Two axes, with the split of `allowed` between them that takes the fewest texels.
    fn sheet(&self, lines: [&Lines; 2], allowed: f64) -> (Vec<Axis>, f64) {
        let given = lines.map(|lines| self.wish.size(&lines.axis));
        let split = |share: f64| {
            let first = self.along(lines[0], share * allowed, MAX_SIZE);
            let second = self.along(lines[1], (1.0 - share) * allowed, MAX_SIZE);
            ([first.0, second.0], first.1 + second.1)
        };
        let texels = |axes: &[Axis; 2]| axes[0].size * axes[1].size;
        let best = match given {
            [None, None] => SPLITS.map(split).into_iter().reduce(|a, b| {
                let better = match (a.1 <= allowed, b.1 <= allowed) {
                    (false, true) => true,
                    (true, false) => false,
                    _ => texels(&b.0) < texels(&a.0),
                };
                if better { b } else { a }
            }),
            // what a given axis leaves, and where that is nothing, no less than a half: it must not make the other endless
            [Some(_), None] | [None, Some(_)] => {
                let fixed = if given[0].is_some() { 0 } else { 1 };
                let (_, off) = self.along(lines[fixed], allowed, MAX_SIZE);
                let share = (off / allowed).clamp(0.0, 0.5);
                Some(split(if fixed == 0 { share } else { 1.0 - share }))
            }
            [Some(_), Some(_)] => Some(split(0.5)),
        };
        let Some((mut axes, mut off)) = best else {
            return (Vec::new(), f64::INFINITY);
        };
        let free = given.map(|given| given.is_none());
        if fit(&mut axes, free) {
            off = axes.iter().zip(lines).map(|(axis, lines)| lines.error(axis)).sum();
        }
        (axes.into(), off)
    }
}

/// Shrinks the free axes until the table has no more than [`MOST_TEXELS`]; whether that was needed.
fn fit(axes: &mut [Axis; 2], free: [bool; 2]) -> bool {
    let texels = axes[0].size * axes[1].size;
    if texels <= MOST_TEXELS || free == [false, false] {
        return false;
    }
    let excess = texels as f64 / MOST_TEXELS as f64;
    let factor = if free == [true, true] { excess.sqrt() } else { excess };
    for (axis, _) in axes.iter_mut().zip(free).filter(|(_, free)| *free) {
        axis.size = ((axis.size as f64 / factor) as usize).max(2);
    }
    true
}
