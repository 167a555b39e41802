//! Screening: which effects may be worth a fit.

use mlr_model::Morphology;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::base::{Base, Setting};
use crate::{
    Progress,
    walk::hypothesis::{Placement, Walked, Walker},
    walk_effects::{LIBRARY, WalkEffect},
};

/// An effect at a place from where a fit of it may start, and what it adds to the walk of the robot that it was
/// screened on, whitened as errors of that robot.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) placement: Placement,
    /// Coordinates of its parameters.
    pub(crate) coordinates: DVector<f64>,
    /// What it adds to the prediction, whitened.
    pub(crate) change: DVector<f64>,
    /// Change of the prediction per unit of each of its coordinates, whitened.
    pub(crate) jacobian: DMatrix<f64>,
}

/// Times that an effect with several parameters, or of the sensor, is linearised where the last
/// linear model is best.
const RELINEARISATIONS: usize = 1;

/// Standard deviations by which a nuisance parameter usually is off.
const USUAL: f64 = 1.0;

/// Every start of every effect that this record can tell from nothing.
pub(crate) fn starts(base: &Base<'_>, progress: &dyn Progress) -> Vec<Start> {
    let placements = placements_on(base);
    progress.expect_more(placements.len());
    placements
        .into_par_iter()
        .flat_map_iter(|placement| {
            let starts = base.starts_of(placement);
            progress.advance();
            starts
        })
        .collect()
}

/// Those of the sensor's effects, for which no body has to walk.
pub(crate) fn starts_of_sensing(base: &Base<'_>) -> Vec<Start> {
    placements_on(base)
        .into_par_iter()
        .filter(|placement| placement.effect.is_of_sensing())
        .flat_map_iter(|placement| base.starts_of(placement))
        .collect()
}

fn placements_on(base: &Base<'_>) -> Vec<Placement> {
    placements(base.setting, &base.morphology)
}

/// Where effects may be that this record can tell from nothing.
pub(super) fn placements(setting: Setting<'_>, morphology: &Morphology) -> Vec<Placement> {
    let record = setting.observation.record;
    let mut placements = everywhere(setting, morphology);
    placements.retain(|placed| !record.hides(placed.effect));
    placements
}

/// Every effect of the library wherever it may be on such a robot.
pub(super) fn everywhere(setting: Setting<'_>, morphology: &Morphology) -> Vec<Placement> {
    let robot = &setting.nominal.robot;
    let on_it = |effect: &&'static dyn WalkEffect| {
        let effect = *effect;
        let places = effect.places(robot, morphology).into_iter();
        places.map(move |place| Placement { effect, place })
    };
    LIBRARY.iter().flat_map(on_it).collect()
}

/// A point where the prediction is known.
struct Known {
    coordinates: DVector<f64>,
    /// Of the prediction, whitened.
    change: DVector<f64>,
}

impl<'a> Base<'a> {
    fn starts_of(&self, placement: Placement) -> Vec<Start> {
        let walker = self.with(vec![placement]);
        let record = self.setting.observation.record;
        let mut values = placement
            .effect
            .starts(placement.place, &self.reference.model, record);
        values.extend(self.standing_for_nuisances(placement, &walker));
        let count = walker.dimension() - walker.nuisances();
        if count == 1 && !placement.effect.is_of_sensing() {
            return self.by_secants(&walker, placement, values);
        }
        let tangents = values
            .into_iter()
            .filter_map(|values| self.by_tangents(&walker, placement, values));
        tangents.collect()
    }

    /// Values with which an effect does what the nuisance parameters do that it replaces, where the reference has an
    /// unusual one: it was taken for the effect, whose prior is wider.
    fn standing_for_nuisances(
        &self,
        placement: Placement,
        walker: &Walker<'a>,
    ) -> Option<Vec<f64>> {
        let Setting {
            nuisance: prior,
            observation,
            ..
        } = self.setting;
        let (from, to) = (walker.nominal(), &self.reference.model);
        let replaced = placement.effect.replaces(placement.place);
        let is_unusual = replaced.iter().any(|nuisance| {
            let z_score = nuisance.z_score(&prior.settings, observation.record, from, to);
            z_score.abs() > USUAL
        });
        let changes: Vec<f64> = replaced.iter().map(|one| one.change(from, to)).collect();
        is_unusual
            .then(|| placement.effect.standing_for(&changes))
            .flatten()
    }

    /// One walk for each start; slopes lead to the nearest other one, or to where the effect is
    /// absent.
    fn by_secants(
        &self,
        walker: &Walker<'a>,
        placement: Placement,
        values: Vec<Vec<f64>>,
    ) -> Vec<Start> {
        let mut known: Vec<Known> = values
            .into_iter()
            .filter_map(|values| {
                let walked = walker.walk(self.beside_reference(walker, &[values]))?;
                Some(self.known(walker, &walked))
            })
            .collect();
        let walked = known.len();
        let neutral = placement
            .effect
            .parameters(placement.place, &self.reference.model);
        let neutral = neutral.first().and_then(|parameter| parameter.neutral);
        // Where the effect replaces parameters of the reference, its absence changes these.
        let changes_nothing = placement.effect.replaces(placement.place).is_empty();
        if let Some(value) = neutral.filter(|_| changes_nothing || walked < 2) {
            let z = walker.described(&[vec![value]]);
            known.push(Known {
                coordinates: z.rows(walker.nuisances(), 1).clone_owned(),
                change: DVector::zeros(self.reference.residual.len()),
            });
        }
        (0..walked)
            .filter_map(|index| {
                let here = &known[index];
                let distance = |other: &Known| (other.coordinates[0] - here.coordinates[0]).abs();
                let others = known.iter().enumerate().filter(|(k, _)| *k != index);
                let (_, nearest) =
                    others.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))?;
                let between = here.coordinates[0] - nearest.coordinates[0];
                if between.abs() < 1e-9 {
                    return None;
                }
                let slope = (&here.change - &nearest.change) / between;
                Some(Start {
                    placement,
                    coordinates: here.coordinates.clone(),
                    change: here.change.clone(),
                    jacobian: DMatrix::from_columns(&[slope]),
                })
            })
            .collect()
    }

    /// Slopes of every parameter, taken again where the linear model is best.
    fn by_tangents(
        &self,
        walker: &Walker<'a>,
        placement: Placement,
        values: Vec<f64>,
    ) -> Option<Start> {
        let mut best: Option<(f64, Start)> = None;
        let mut z = self.beside_reference(walker, &[values]);
        for _ in 0..=RELINEARISATIONS {
            let walked = match placement.effect.is_of_sensing() {
                true => walker.walk_like(z.clone(), &self.reference.body),
                false => walker.walk(z.clone())?,
            };
            let Known {
                coordinates,
                change,
            } = self.known(walker, &walked);
            let start = Start {
                placement,
                coordinates,
                change,
                jacobian: self.whitening.apply(&walker.jacobian_of_effects(&walked)),
            };
            let linear = self.simulated.with(&[&start], walker, true);
            let (ln_evidence, to) = linear.ln_evidence(&self.whitening);
            if best.as_ref().is_none_or(|(known, _)| ln_evidence > *known) {
                best = Some((ln_evidence, start));
            }
            let own = walker.nuisances()..walker.dimension();
            for k in own {
                z[k] = to[k];
            }
            walker.clamp(&mut z);
        }
        best.map(|(_, start)| start)
    }

    /// Coordinates of the reference with these values of effects' parameters.
    pub(crate) fn beside_reference(
        &self,
        walker: &Walker<'a>,
        values: &[Vec<f64>],
    ) -> DVector<f64> {
        let p = walker.nuisances();
        let z = self
            .reference
            .z
            .clone()
            .insert_rows(p, walker.dimension() - p, 0.0);
        let mut z = walker.with_values(z, values);
        walker.clamp(&mut z);
        z
    }

    fn known(&self, walker: &Walker<'a>, walked: &Walked) -> Known {
        let own = walker.dimension() - walker.nuisances();
        Known {
            coordinates: walked.z.rows(walker.nuisances(), own).clone_owned(),
            change: self
                .whitening
                .apply_to(&(&self.reference.residual - &walked.residual)),
        }
    }
}
