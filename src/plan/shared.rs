//! Lobes that are the same become one table, and every material learns which are its own.

use super::axes::alternatives;
use super::lobes::{Part, formula, parts};
use super::{Economy, MaterialPlan, PlanError, Request, Source, TablePlan, Term};
use crate::bxdf::Model;
use crate::distribution::Family;
use crate::estimate::{Effort, Estimator, default_tolerance};
use crate::masking::Masking;
use crate::scene::{DistributionSpec, ModelSpec, Roughness, Scene};
use crate::spectrum::Channels;
use crate::table::names::file_stems;
use crate::table::{Lobe, MAX_TEXELS, Quantity};
use std::collections::{HashMap, HashSet};

/// Lobes with one pair of tables.
struct Group {
    /// Stem of the ids.
    stem: String,
    model: ModelSpec,
    lobe: Lobe,
    /// Whether the channels of the tables are those of a pair.
    is_pair: bool,
    materials: Vec<String>,
    /// Whether rho_hd is called for, which it is not where it is a closed form.
    albedo: bool,
    /// Whether rho_hh is.
    mean: bool,
    purposes: [&'static str; 2],
}

/// A material's lobe, and the group that it is in.
struct Member {
    part: Part,
    group: Option<usize>,
    /// Whether rho_hd is looked up.
    albedo: bool,
    /// Whether rho_hh is needed.
    mean: bool,
}

/// The materials of `scene` with their lobes, and the tables that these call for.
pub(super) fn tables(scene: &Scene, request: &Request) -> Result<(Vec<MaterialPlan>, Vec<TablePlan>), PlanError> {
    let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    let all = scene.materials.iter().map(|material| parts(material, request.economy));
    let all = all.collect::<Result<Vec<_>, _>>()?;
    let mut groups = Groups::new(request.economy, all.iter().flatten());
    let mut members: Vec<Vec<Member>> = Vec::with_capacity(names.len());
    for ((material, stem), parts) in scene.materials.iter().zip(file_stems(&names)).zip(all) {
        let mut own = Vec::new();
        for part in parts {
            let mean = match (&part.base, part.specular) {
                (Some(_), _) => true,
                (None, true) => !request.economy.coupling,
                (None, false) => scene.means || !request.economy.coupling,
            };
            let (group, albedo) = groups.join(&part, &material.name, &stem, mean);
            own.push(Member {
                part,
                group,
                albedo,
                mean,
            });
        }
        members.push(own);
    }
    let ids = groups.ids();
    let materials = scene
        .materials
        .iter()
        .zip(members)
        .map(|(material, members)| MaterialPlan {
            name: material.name.clone(),
            calls: material.calls.clone(),
            gaps: material.gaps.clone(),
            implied: material.implied,
            terms: members.into_iter().map(|member| term(member, &ids)).collect(),
        });
    let materials = materials.collect();
    let mut tables = Vec::new();
    for (group, ids) in groups.all.iter().zip(&ids) {
        for (quantity, wanted, id, purpose) in [
            (Quantity::RhoHd, group.albedo, &ids[0], group.purposes[0]),
            (Quantity::RhoHh, group.mean, &ids[1], group.purposes[1]),
        ] {
            if wanted {
                tables.push(table(group, quantity, id, purpose, request)?);
            }
        }
    }
    Ok((materials, tables))
}

fn term(member: Member, ids: &[[String; 2]]) -> Term {
    let Member {
        part,
        group,
        albedo,
        mean,
    } = member;
    let of = |quantity: usize| match group {
        Some(group) if quantity == 1 || albedo => Source::Table {
            id: ids[group][quantity].clone(),
            r0: part.r0,
        },
        _ => Source::ClosedForm(formula(&part.model)),
    };
    Term {
        lobe: part.lobe,
        scale: part.scale,
        base: part.base,
        albedo: of(0),
        layers: part.layers,
        mean: mean.then(|| of(1)),
        model: part.model,
    }
}

/// All groups, and where each is found.
struct Groups {
    all: Vec<Group>,
    found: HashMap<String, usize>,
    economy: Economy,
    /// Smallest and largest roughness of the lobes that one sheet may serve, by [`sheet_key`].
    spans: HashMap<String, [f64; 2]>,
}

/// Least share by which roughnesses differ that ask for a sheet: files print the same number in many ways, as f32 and as decimals.
const RANGE: f64 = 1e-4;

impl Groups {
    /// No groups yet, for `parts`.
    fn new<'p>(economy: Economy, parts: impl Iterator<Item = &'p Part>) -> Self {
        let mut spans: HashMap<String, [f64; 2]> = HashMap::new();
        for part in parts.filter(|part| part.r0.is_some()) {
            if let (Some(key), Some(own)) = (sheet_key(&part.model), part.model.roughness()) {
                let [from, to] = own.ends();
                let span = spans.entry(key).or_insert([from, to]);
                *span = [span[0].min(from), span[1].max(to)];
            }
        }
        Self {
            all: Vec::new(),
            found: HashMap::new(),
            economy,
            spans,
        }
    }

    /// Family and masking of a lobe that shares one sheet with those of other roughnesses.
    fn sheet(&self, part: &Part, model: &ModelSpec) -> Option<(Family, Masking)> {
        let [min, max] = self.spans.get(&sheet_key(model)?)?;
        let is_line = max - min < RANGE * max;
        // lines of values that are nearly the same are tables of their own, and equal ones are shared as any others
        let is_own = is_line && min != max;
        part.r0.and_then(|_| slope_lobe(model)).filter(|_| !is_own)
    }

    /// The group that holds `part` of the material `name`, `None` for a closed form, and whether it holds rho_hd.
    fn join(&mut self, part: &Part, name: &str, stem: &str, mean: bool) -> (Option<usize>, bool) {
        // of a mirror of metal the mean is no closed form, and counts where something depends on it
        let needs_mean = mean && part.closed && part.base.is_some() && !has_closed_mean(&part.model);
        if part.closed && self.economy.closed_forms && !needs_mean {
            return (None, false);
        }
        let albedo = !(part.closed && self.economy.closed_forms);
        let mut model = part.model.clone();
        if !self.economy.own_range {
            model = with_whole_range(&model);
        }
        let sheet = self.sheet(part, &model);
        let key = match sheet.and_then(|_| sheet_key(&model)) {
            Some(key) => key,
            None => format!("{:?} {}", model.describe(), part.lobe.name()),
        };
        let key = match self.economy.sharing {
            true => key,
            // every lobe of every material by itself
            false => format!("{} {name}", self.all.len()),
        };
        let index = match self.found.get(&key) {
            Some(index) => *index,
            None => {
                let purposes = purposes(part);
                let place = if part.specular { ".specular" } else { "" };
                let stem = match (sheet, self.economy.sharing) {
                    (Some((family, masking)), true) => {
                        format!("{}-{}.split-sum{}", family.name(), masking.name(), suffix(part.lobe))
                    }
                    _ => format!("{stem}{place}{}", suffix(part.lobe)),
                };
                self.all.push(Group {
                    stem,
                    model: model.clone(),
                    lobe: part.lobe,
                    is_pair: part.r0.is_some(),
                    materials: Vec::new(),
                    albedo: false,
                    mean: false,
                    purposes,
                });
                self.found.insert(key, self.all.len() - 1);
                self.all.len() - 1
            }
        };
        let group = &mut self.all[index];
        if sheet.is_some() {
            group.model = spanning(&group.model, &model);
        }
        if group.materials.last().map(String::as_str) != Some(name) {
            group.materials.push(name.to_owned());
        }
        group.albedo |= albedo;
        group.mean |= mean;
        (Some(index), albedo)
    }

    /// Ids of rho_hd and rho_hh of each group, all different.
    fn ids(&self) -> Vec<[String; 2]> {
        let mut taken = HashSet::new();
        let unique = |group: &Group| {
            let numbered = (2..).map(|number| format!("{}.{number}", group.stem));
            let mut stems = std::iter::once(group.stem.clone()).chain(numbered);
            let stem = stems.find(|stem| taken.insert(stem.clone())).unwrap_or_default();
            [Quantity::RhoHd, Quantity::RhoHh].map(|quantity| format!("{stem}.{}", quantity.name()))
        };
        self.all.iter().map(unique).collect()
    }
}

fn suffix(lobe: Lobe) -> &'static str {
    match lobe {
        Lobe::Reflection => "",
        Lobe::Transmission => ".transmission",
    }
}

/// What lobes have in common that one sheet may serve.
fn sheet_key(model: &ModelSpec) -> Option<String> {
    let (family, masking) = slope_lobe(model)?;
    let side = match model {
        ModelSpec::BrdfToBtdf(_) => "beyond",
        _ => "above",
    };
    Some(format!("{} {} {side}", family.name(), masking.name()))
}

/// What a person should know the tables for.
fn purposes(part: &Part) -> [&'static str; 2] {
    match (part.r0.is_some(), part.specular, part.lobe) {
        (true, ..) => [
            "directional albedo for any r0 of Schlick's Fresnel term: mix(R, G, r0)",
            "mean albedo for any r0 of Schlick's Fresnel term: mix(R, G, r0)",
        ],
        (_, true, _) => [
            "rho(mu) of eq. 28, specular lobe with ks = 1",
            "rho_bar of the specular lobe with ks = 1",
        ],
        (.., Lobe::Reflection) => ["directional albedo", "mean albedo"],
        (.., Lobe::Transmission) => [
            "share of light from one direction that passes",
            "mean share of light that passes",
        ],
    }
}

/// Whether rho_hh of a closed form is one, too: all but of smooth conductors.
fn has_closed_mean(model: &ModelSpec) -> bool {
    match model {
        ModelSpec::SpecularReflection(mirror) => mirror.fresnel().mean_reflectance().is_some(),
        ModelSpec::BrdfToBtdf(bxdf) => has_closed_mean(bxdf),
        _ => true,
    }
}

/// Family and masking of an isotropic lobe of slopes, GGX or Beckmann: lobes of which engines keep one sheet for all roughnesses.
fn slope_lobe(model: &ModelSpec) -> Option<(Family, Masking)> {
    match model {
        ModelSpec::Microfacet {
            distribution: DistributionSpec::Isotropic { family, .. },
            masking,
            ..
        } => (family.legal().min > 0.0).then_some((*family, *masking)),
        ModelSpec::BrdfToBtdf(bxdf) => slope_lobe(bxdf),
        _ => None,
    }
}

/// `model` with its roughness replaced by what `edit` makes of it.
fn with_roughness(model: &ModelSpec, edit: &dyn Fn(Family, Roughness) -> Roughness) -> ModelSpec {
    let distribution = |distribution: &DistributionSpec| match distribution {
        DistributionSpec::Isotropic { family, roughness } => DistributionSpec::Isotropic {
            family: *family,
            roughness: edit(*family, *roughness),
        },
        other => *other,
    };
    let mut model = model.clone();
    match &mut model {
        ModelSpec::Microfacet { distribution: own, .. } | ModelSpec::FresnelBlend { distribution: own, .. } => {
            *own = distribution(own);
        }
        ModelSpec::RoughDielectric { family, roughness, .. } => *roughness = edit(*family, *roughness),
        ModelSpec::BrdfToBtdf(bxdf) => **bxdf = with_roughness(bxdf, edit),
        _ => {}
    }
    model
}

/// The range of `a`, extended to the roughness of `b`.
fn spanning(a: &ModelSpec, b: &ModelSpec) -> ModelSpec {
    let Some([from, to]) = b.roughness().map(Roughness::ends) else {
        return a.clone();
    };
    with_roughness(a, &|_, own| {
        let [min, max] = own.ends();
        let (min, max) = (min.min(from), max.max(to));
        if min < max {
            Roughness::Range { min, max }
        } else {
            Roughness::Fixed(min)
        }
    })
}

/// Slopes over [1e-6, 1], or what they have where that is more.
fn with_whole_range(model: &ModelSpec) -> ModelSpec {
    with_roughness(model, &|family, own| match family.legal().min {
        0.0 => own,
        min => Roughness::Range {
            min,
            max: own.ends()[1].max(1.0),
        },
    })
}

fn table(
    group: &Group,
    quantity: Quantity,
    id: &str,
    purpose: &'static str,
    request: &Request,
) -> Result<TablePlan, PlanError> {
    let sample: Model = group.model.at(None)?;
    let is_sampled = matches!(request.estimator, Estimator::MonteCarlo { .. }) || sample.is_irregular();
    let plan = TablePlan {
        id: id.to_owned(),
        purpose,
        quantity,
        lobe: group.lobe,
        materials: group.materials.clone(),
        channels: match (request.economy.channels, group.is_pair) {
            (_, true) => Channels::Pair,
            (true, false) => sample.channels(),
            (false, false) => Channels::Rgb,
        },
        alternatives: alternatives(quantity, &group.model, &sample, request)?,
        model: group.model.clone(),
        estimator: request.estimator,
        effort: Effort {
            tolerance: request.tolerance.unwrap_or_else(|| default_tolerance(&sample)),
            // rules draw no samples, and their tables are the same for every seed
            samples: request.samples.filter(|_| is_sampled),
            seed: if is_sampled { request.seed } else { 0 },
        },
    };
    match plan.texels() {
        texels if texels > MAX_TEXELS => Err(PlanError::TooLarge { id: plan.id, texels }),
        _ => Ok(plan),
    }
}
