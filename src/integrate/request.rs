//! Everything that the texels, errors and facts of a table depend on, in words.

use super::choice::Wish;
use crate::plan::TablePlan;
use crate::table::Table;
use crate::table::axis::Axis;
use std::fmt::Write;

/// What `plan` asks for under `wish`: the same text for the same table, and another for any other. Its id and the names of
/// materials are no part of it.
///
/// Numbers are the shortest decimals that read back as the same f64, measured data stand for themselves by their hashes, and
/// names are quoted, so that no two requests run into each other. Timings, threads and the order of tables are not part of it.
pub fn request(plan: &TablePlan, wish: Option<&Wish>) -> String {
    let mut text = subject(plan);
    let mut line = |name: &str, value: &dyn std::fmt::Debug| {
        // writing to a string does not fail
        let _ = writeln!(text, "{name}: {value:?}");
    };
    line("channels", &plan.channels.count());
    for axes in &plan.alternatives {
        line("axes", &axes.iter().map(facts).collect::<Vec<_>>());
    }
    line("estimator", &plan.estimator.name());
    line(
        "effort",
        &(plan.effort.tolerance, plan.effort.samples, plan.effort.seed),
    );
    if let Some(wish) = wish {
        let mapping = wish.mapping.map(|mapping| mapping.name());
        line(
            "wish",
            &(wish.tolerance, wish.mu, wish.roughness, wish.azimuth, mapping),
        );
    }
    text
}

/// The integral of `plan` and the model under it, in words: what its tables over any axes share.
pub(super) fn subject(plan: &TablePlan) -> String {
    let integral = (plan.quantity.name(), plan.lobe.name());
    format!("integral: {integral:?}\nmodel: {:?}\n", plan.model.describe())
}

/// Whether `table` is one that `plan` may have given, by its integral, its model and its seed.
pub fn answers(plan: &TablePlan, table: &Table) -> bool {
    let asked = (plan.quantity, plan.lobe, plan.channels, plan.effort.seed);
    (table.quantity, table.lobe, table.channels, table.seed) == asked && table.parameters == plan.model.describe()
}

fn facts(axis: &Axis) -> (&str, &str, &str, f64, f64, usize) {
    let names = (axis.parameter.as_str(), axis.mapping.name(), axis.rule.name());
    (names.0, names.1, names.2, axis.min, axis.max, axis.size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::fill::{fill, stable_hash};
    use crate::plan::{Plan, Request};
    use crate::scene::Scene;
    use crate::table::axis::Mapping;
    use std::collections::HashSet;

    fn plans(edit: impl FnOnce(&mut Request), scene: &Scene) -> Vec<TablePlan> {
        let mut request = Request::default();
        edit(&mut request);
        Plan::new(scene, &request).unwrap().tables
    }

    #[test]
    fn names_are_no_part_of_a_request_and_tables_of_a_scene_have_streams_of_their_own() {
        let scene = Scene::default_scene();
        let plans = plans(|_| {}, &scene);
        for plan in &plans {
            let renamed = TablePlan {
                id: "other".into(),
                materials: vec!["some".into(), "more".into()],
                ..plan.clone()
            };
            assert_eq!(request(plan, None), request(&renamed, None));
            // neither are axes a part of what names the streams
            let reshaped = TablePlan {
                alternatives: Vec::new(),
                ..renamed
            };
            assert_eq!(subject(plan), subject(&reshaped));
        }
        let streams: HashSet<u64> = plans.iter().map(|plan| stable_hash(&subject(plan))).collect();
        assert_eq!(streams.len(), plans.len());
    }

    #[test]
    fn tables_answer_the_plans_that_they_are_of() {
        let plans = plans(|request| request.resolution = 2, &Scene::default_scene());
        let quick = plans.iter().filter(|plan| plan.texels() <= 2).take(4);
        let quick: Vec<&TablePlan> = quick.collect();
        let tables: Vec<Table> = quick.iter().map(|plan| fill(plan, &|_| {}).unwrap()).collect();
        for (i, plan) in quick.iter().enumerate() {
            for (j, table) in tables.iter().enumerate() {
                assert_eq!(answers(plan, table), i == j, "{} and {}", plan.id, table.id);
            }
            let mut other = (*plan).clone();
            other.effort.seed = 1;
            assert!(!answers(&other, &tables[i]));
        }
        assert!(quick.len() == 4);
    }

    #[test]
    fn whatever_changes_a_table_changes_its_request() {
        let scene = Scene::default_scene();
        let all = |plans: &[TablePlan], wish: Option<&Wish>| -> Vec<String> {
            plans.iter().map(|plan| request(plan, wish)).collect()
        };
        let first = all(&plans(|_| {}, &scene), None);
        assert_eq!(first, all(&plans(|_| {}, &scene), None));
        assert_eq!(first.iter().collect::<HashSet<_>>().len(), first.len());
        let edits: [fn(&mut Request); 3] = [
            |request| request.resolution = 65,
            |request| request.mapping = Some(Mapping::SqrtMu),
            |request| request.tolerance = Some(1e-5),
        ];
        for edit in edits {
            let changed = all(&plans(edit, &scene), None);
            // of one table at least, and of most; a table of one texel has no resolution
            let same = first.iter().zip(&changed).filter(|(a, b)| a == b).count();
            assert!(same <= first.len() / 2, "{same} of {} are the same", first.len());
        }
        // seed and number of samples are for those who draw some
        let draws: [fn(&mut Request); 2] = [|request| request.seed = 1, |request| request.samples = Some(100)];
        for draw in draws {
            assert_eq!(first, all(&plans(draw, &scene), None));
            let sampled = |request: &mut Request| request.estimator = "mc-cosine".parse().unwrap();
            let other = |request: &mut Request| {
                sampled(request);
                draw(request);
            };
            let [one, other] = [all(&plans(sampled, &scene), None), all(&plans(other, &scene), None)];
            assert!(one.iter().zip(&other).all(|(a, b)| a != b));
        }
        let plans = plans(|_| {}, &scene);
        let wishes = [
            Wish::within(1e-3),
            Wish::within(1e-3_f64.next_up()),
            Wish {
                mu: Some(64),
                ..Wish::within(1e-3)
            },
            Wish {
                mapping: Some(Mapping::Mu),
                ..Wish::within(1e-3)
            },
        ];
        let mut texts: HashSet<String> = first.into_iter().collect();
        let before = texts.len();
        texts.extend(wishes.iter().flat_map(|wish| all(&plans, Some(wish))));
        assert_eq!(texts.len(), before * (1 + wishes.len()));
    }
}
