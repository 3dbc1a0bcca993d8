//! Published models that are known to depart from physics: found, shown with their numbers, and no failure of the program.

use super::Test;

/// A known property of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Departure {
    /// What is known, for people.
    pub reason: &'static str,
    /// No test can see it in the model itself: it is a finding even where everything that is tested holds.
    pub untestable: bool,
}

/// Key and value of a parameter, as a scene names them, the test that they bear on, and what is known.
type Known = (&'static str, &'static str, Test, Departure);

const fn tested(reason: &'static str) -> Departure {
    Departure {
        reason,
        untestable: false,
    }
}

const MEASURED: &str = "measured data is taken as it is, and reaches to the horizon by extrapolation";

const NEUBELT: &str =
    "masking = \"neubelt\" is not made from the distribution: narrow ones gain energy at grazing angles";
const FITTED: &str = "masking = \"charlie\" is a fit: narrow distributions gain energy at grazing angles";

/// All known departures.
const KNOWN: [Known; 17] = [
    (
        "masking",
        "none",
        Test::Energy,
        tested("masking = \"none\": the albedo grows without bound at grazing angles"),
    ),
    (
        "masking",
        "none",
        Test::EnergyBelow,
        tested("masking = \"none\": the albedo grows without bound at grazing angles"),
    ),
    (
        "masking",
        "none",
        Test::WhiteFurnace,
        tested("masking = \"none\": the albedo grows without bound at grazing angles"),
    ),
    ("masking", "neubelt", Test::Energy, tested(NEUBELT)),
    ("masking", "neubelt", Test::WhiteFurnace, tested(NEUBELT)),
    ("masking", "charlie", Test::Energy, tested(FITTED)),
    ("masking", "charlie", Test::WhiteFurnace, tested(FITTED)),
    (
        "type",
        "layered",
        Test::Reciprocity,
        tested("layered: what lies below is dimmed by the direction of sight alone, as in glTF"),
    ),
    (
        "type",
        "oren-nayar",
        Test::Energy,
        tested("Oren-Nayar's printed approximation exceeds 1 at grazing angles for sigma below 18.7 degrees"),
    ),
    ("type", "irregular", Test::Energy, tested(MEASURED)),
    ("type", "irregular", Test::EnergyBelow, tested(MEASURED)),
    ("type", "merl", Test::Energy, tested(MEASURED)),
    ("type", "merl", Test::EnergyBelow, tested(MEASURED)),
    (
        "type",
        "fresnel-blend",
        Test::Energy,
        tested("FresnelBlend masks nothing: lobes of facets that are wide enough gain energy at grazing angles"),
    ),
    (
        "type",
        "fresnel-blend",
        Test::EnergyBelow,
        tested("FresnelBlend masks nothing: lobes of facets that are wide enough gain energy at grazing angles"),
    ),
    (
        "type",
        "brdf-to-btdf",
        Test::Reciprocity,
        Departure {
            reason: "mirrors through the surface without refraction: no index, no eta^2 scaling",
            untestable: true,
        },
    ),
    (
        "fresnel",
        "conductor-approximate",
        Test::Fresnel,
        tested("the approximation of pbrt, 2nd edition, which is good for large eta and k only"),
    ),
];

/// What is known of a model in one respect; `parameters` are its scene-file names and values, prefixes of nested models
/// included, see [`ModelSpec::describe`](crate::scene::ModelSpec::describe).
pub fn known_departure(parameters: &[(String, String)], test: Test) -> Option<Departure> {
    let has = |key: &str, value: &str| {
        let last = |name: &str| name.rsplit('.').next() == Some(key);
        parameters.iter().any(|(name, found)| last(name) && found == value)
    };
    KNOWN
        .into_iter()
        .find(|(key, value, of, _)| *of == test && has(key, value))
        .map(|(.., departure)| departure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn departures_are_found_in_nested_models_and_only_for_their_test() {
        let nested = [("specular.masking".to_string(), "none".to_string())];
        assert!(known_departure(&nested, Test::Energy).is_some());
        assert_eq!(known_departure(&nested, Test::Reciprocity), None);
        let other = [("masking".to_string(), "v-groove".to_string())];
        assert_eq!(known_departure(&other, Test::Energy), None);
    }
}
