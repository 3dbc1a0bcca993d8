//! `furnace plan`

mod chosen;
mod json;
pub(super) mod text;

use super::{Common, Failure, Shape, format};
use chosen::chosen;
use clap::Args;
use std::time::Duration;
use whitefurnace::integrate::{FillError, Forecast, Forecasts, IntegrateError, forecast, forecasts};
use whitefurnace::plan::{Economy, Plan, Request, TablePlan};

/// Longest look at what tables will cost, beyond the last integral that it begins.
const PATIENCE: Duration = Duration::from_secs(10);

/// The same for what they would cost otherwise.
const PATIENCE_OTHER: Duration = Duration::from_secs(3);

/// Arguments of `furnace plan`.
#[derive(Debug, Args)]
#[command(after_help = "\
For each material the effects that it calls for and by which property, and what of it no table covers; the tables, with the \
materials that share them; and the effects that are skipped because no material calls for them. A table holds a lobe without its \
factors (reflectance, scale, ks), over the roughnesses that the scene has; closed forms have none.

With --tolerance T axes and sizes are those that keep the error of a lookup within T at least bytes, and the plan says what \
half the error would cost. Sizes of tables with one axis are measured; those with two (~) are estimated along lines through \
their domain, and a bake measures and corrects them. Evaluations and times are measured at a few texels and scaled up.

Examples:
  furnace plan scene.toml
  furnace plan --json asset.glb
  furnace plan --tolerance 1e-3
  furnace plan --all-effects asset.gltf")]
pub(super) struct PlanCommand {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shape: Shape,
}

/// What a plan costs, and what one that saves nothing, or everything, would.
struct Costs {
    own: Forecasts,
    /// Seconds of all processors that sizes take to be chosen.
    choosing: f64,
    other: Other,
    threads: usize,
}

/// The other way to plan.
struct Other {
    /// Whether that is the one for all effects.
    all_effects: bool,
    tables: usize,
    texels: usize,
    costs: Forecasts,
    /// How often it takes the time of the plan, both with the sizes that are usual.
    ratio: f64,
}

impl PlanCommand {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = self.common.load()?;
        let wish = self.common.wish(&self.shape)?;
        let request = self.common.request(&self.shape)?;
        let mut plan = Plan::new(&scene, &request)?;
        let other = Plan::new(
            &scene,
            &Request {
                economy: if self.shape.all_effects {
                    Economy::FULL
                } else {
                    Economy::NONE
                },
                ..request
            },
        )?;
        let usual = forecasts(&plan.tables.iter().collect::<Vec<_>>(), PATIENCE);
        let other_costs = forecasts(&other.tables.iter().collect::<Vec<_>>(), PATIENCE_OTHER);
        let other = Other {
            all_effects: !self.shape.all_effects,
            tables: other.tables.len(),
            texels: other.tables.iter().map(TablePlan::texels).sum(),
            ratio: other_costs.seconds() / usual.seconds(),
            costs: other_costs,
        };
        let (chosen, choosing) = match wish {
            None => (Vec::new(), 0.0),
            Some(wish) => self.common.in_pool(|| chosen(&plan.tables, wish))?,
        };
        let own = if chosen.is_empty() {
            usual
        } else {
            plan.tables = chosen.iter().map(|chosen| chosen.choice.plan.clone()).collect();
            let mut own = forecasts(&plan.tables.iter().collect::<Vec<_>>(), PATIENCE);
            for (forecast, chosen) in own.each.iter_mut().zip(&chosen) {
                forecast.seconds *= chosen.choice.repeats();
            }
            own
        };
        match &own.failed {
            // a bake says where, and writes the rest of the table
            Some(
                failed @ FillError::Integral {
                    source: IntegrateError::Diverges(_),
                    ..
                },
            ) => format::note(format!("{failed}; its cost is a guess")),
            Some(failed) => return Err(failed.clone().into()),
            None => {}
        }
        let halves = chosen.iter().map(|chosen| {
            forecast(&chosen.half.plan).map(|forecast| Forecast {
                seconds: forecast.seconds * chosen.half.repeats(),
                ..forecast
            })
        });
        let halves = halves.collect::<Result<Vec<Forecast>, FillError>>()?;
        let costs = Costs {
            own,
            choosing,
            other,
            threads: self.common.in_pool(|| Ok(rayon::current_num_threads()))?,
        };
        if self.common.json {
            let mut value = json::of_plan(&plan, &costs);
            if let Some(tables) = value["tables"].as_array_mut() {
                for (index, (table, chosen)) in tables.iter_mut().zip(&chosen).enumerate() {
                    chosen.tell(table, &halves[index]);
                }
            }
            format::say(serde_json::to_string_pretty(&value)?);
            return Ok(());
        }
        text::materials(&plan, wish.map(|wish| wish.tolerance));
        match wish {
            None => text::tables(&plan, &costs),
            Some(wish) => text::chosen_tables(&plan, &chosen, (&costs, &halves), wish.tolerance),
        }
        text::savings(&costs, wish.is_some());
        text::skipped(&plan);
        Ok(())
    }
}
