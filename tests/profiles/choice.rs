//! Whether the axes of the generic pair are the best of those at hand.

use crate::shared::{baked_with, generic_16, stated};
use whitefurnace::engine::{Along, Parameter, Profile, Sheet, Sizes, Term};
use whitefurnace::table::axis::{Mapping, TexelRule};

/// What a fit minimises: its largest error, or 45 times the mean where that is more.
fn score(sheet: Sheet) -> f64 {
    let name = sheet.name;
    let baked = baked_with(vec![sheet]);
    let error = stated(&baked, name, "furnace");
    error.max.max(45.0 * error.mean)
}

/// The pair with 16 x 16 texels along other axes, the loss alone.
fn candidate(mu: (Mapping, TexelRule), roughness: (Mapping, TexelRule)) -> Sheet {
    let along = |parameter, (mapping, rule)| Along {
        parameter,
        mapping,
        rule,
        flipped: false,
        size: 16,
    };
    let mut sheet = Profile::Generic.sheets(Sizes::default()).remove(0);
    sheet.axes = vec![along(Parameter::Mu, mu), along(Parameter::Roughness, roughness)];
    sheet.channels = vec![Term::Loss];
    sheet
}

#[test]
fn the_generic_axes_leave_the_least_error() {
    let (centres, ends) = (TexelRule::Centres, TexelRule::Ends);
    let is_long = std::env::var_os("FURNACE_LONG").is_some();
    let mut others = Vec::new();
    for mu in [Mapping::Mu, Mapping::SqrtMu] {
        for roughness in [Mapping::Linear, Mapping::ThreeQuarters] {
            for mu_rule in [centres, ends] {
                others.extend([centres, ends].map(|rule| ((mu, mu_rule), (roughness, rule))));
            }
        }
    }
    let chosen = ((Mapping::SqrtMu, ends), (Mapping::ThreeQuarters, ends));
    others.retain(|other| *other != chosen);
    assert_eq!(others.len(), 15);
    if !is_long {
        eprintln!("two of 15 candidates: FURNACE_LONG=1 for all");
        others.retain(|other| {
            [
                ((Mapping::SqrtMu, ends), (Mapping::Linear, ends)),
                ((Mapping::Mu, centres), (Mapping::Linear, centres)),
            ]
            .contains(other)
        });
        assert_eq!(others.len(), 2);
    }
    let best = stated(generic_16(), "pair", "furnace");
    let best = best.max.max(45.0 * best.mean);
    let sheet = &generic_16()[0].0;
    assert_eq!(sheet.axes, candidate(chosen.0, chosen.1).axes);
    eprintln!("{chosen:?}: {best:.3e}");
    for other in others {
        let found = score(candidate(other.0, other.1));
        eprintln!("{other:?}: {found:.3e}");
        assert!(found > best, "{other:?}: {found} is no more than {best}");
    }
}
