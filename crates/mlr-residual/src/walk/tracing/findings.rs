//! What is said of the effects found, and of those that were not.

use std::collections::BTreeMap;

use mlr_model::LostLinks;

use super::{Tracing, contenders::Contender, errors, judging::Judged, state::State};
use crate::{
    statistics::chance_of_gain,
    walk::{
        ByAxis, Placed, Reported, Rival, TracedEffect, Trial, WalkCandidate, WalkError,
        decomposition::decompose,
    },
};

impl<'a> Tracing<'a> {
    /// What is said of an effect when it is added. Intervals come when all are found.
    pub(super) fn traced(&self, best: &Contender<'a>, others: &[Contender<'a>]) -> TracedEffect {
        let limit = best.cost() + self.settings.rival_gain;
        let rivals = others.iter().filter(|other| other.cost() < limit);
        let best = &best.judged;
        let placed = best.placed();
        TracedEffect {
            kind: best.kind().into(),
            parameters: self.report(&best.trial, placed),
            interval_95: BTreeMap::new(),
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            explains: placed.effect.trace().into(),
            gain: best.gain,
            price: best.needed(),
            chance: best.chance,
            error: errors(&best.trial),
            rivals: rivals
                .map(|rival| Rival {
                    kind: rival.judged.kind().into(),
                    parameters: self.report(&rival.judged.trial, rival.judged.placed()),
                })
                .collect(),
        }
    }

    pub(super) fn report(&self, trial: &Trial, placed: &Placed) -> BTreeMap<String, Reported> {
        let values = self.values(trial, placed).into_iter();
        values
            .map(|(name, value)| (name.clone(), Reported::new(&name, value)))
            .collect()
    }

    pub(super) fn values(&self, trial: &Trial, placed: &Placed) -> BTreeMap<String, f64> {
        let before: Vec<Placed> = trial
            .effects
            .iter()
            .take_while(|other| !other.is_same(placed))
            .cloned()
            .collect();
        let mut model = self.nominal.clone();
        for other in before {
            other.effect.apply(other.place, &other.values, &mut model);
        }
        placed.effect.report(placed.place, &placed.values, &model)
    }

    /// Values as fitted together, intervals, and what is wrong with either.
    pub(super) fn finish_effects(&self, state: &State<'a>, effects: &mut [TracedEffect]) {
        let widths = &state.trial.half_width_95;
        for ((placed, widths), traced) in state.trial.effects.iter().zip(widths).zip(effects) {
            traced.parameters = self.report(&state.trial, placed);
            let parameters = placed
                .effect
                .parameters(placed.place, &state.calibration_model);
            let mut moved = placed.clone();
            let mut low = self.values(&state.trial, placed);
            let mut high = low.clone();
            for (index, (parameter, width)) in parameters.iter().zip(widths).enumerate() {
                let value = placed.values[index];
                if parameter.is_at_bound(value) {
                    traced.at_bound.push(parameter.name.clone());
                }
                let range = parameter.upper - parameter.lower;
                if !width.is_finite() || *width > 0.5 * range {
                    traced.undetermined.push(parameter.name.clone());
                    continue;
                }
                for end in [-width, *width] {
                    moved.values[index] = (value + end).clamp(parameter.lower, parameter.upper);
                    for (name, reported) in self.values(&state.trial, &moved) {
                        let range = (low.get_mut(&name), high.get_mut(&name));
                        if let (Some(low), Some(high)) = range {
                            *low = low.min(reported);
                            *high = high.max(reported);
                        }
                    }
                }
                moved.values[index] = value;
            }
            traced.interval_95 = low
                .into_iter()
                .filter_map(|(name, low)| {
                    let high = *high.get(&name)?;
                    (high > low).then_some((name, [low, high]))
                })
                .collect();
        }
    }

    /// Whether lost links hang on as dead weight rather than being gone: an effect of its
    /// own where the walk tells.
    pub(super) fn locked_links(
        &self,
        state: &State<'a>,
    ) -> Result<Option<TracedEffect>, WalkError> {
        if state.lost_links() != LostLinks::Locked || state.morphology.is_healthy() {
            return Ok(None);
        }
        let suspect = state.suspect();
        let effects = &state.trial.effects;
        let Some(gone) = self.calibrated(&suspect, LostLinks::Absent, effects)? else {
            return Ok(None);
        };
        let unseen = |trial: &Trial| state.comparison.cost_of(trial.unseen_deg2);
        let gain = [
            gone.trial.cost - state.trial.cost,
            unseen(&gone.trial) - unseen(&state.trial),
        ];
        let price = self.settings.least_gain / 2.0;
        if gain.iter().any(|gain| *gain < price) {
            return Ok(None);
        }
        let blocks = |trial: &Trial| self.blocks(state, trial);
        let legs = state.morphology.damaged_legs();
        Ok(Some(TracedEffect {
            kind: "locked_links".into(),
            parameters: [("legs".to_string(), Reported::Numbers(legs))].into(),
            interval_95: BTreeMap::new(),
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            explains: "the weight of the lost links is still there".into(),
            gain,
            price,
            chance: chance_of_gain(&blocks(&gone.trial), &blocks(&state.trial)),
            error: errors(&state.trial),
            rivals: Vec::new(),
        }))
    }

    pub(super) fn decomposed(&self, state: &State<'a>) -> ByAxis {
        let period_s = state.model().gait.period_s;
        decompose(self.record, &state.trial.residual_deg, period_s).into()
    }

    /// The best place of each kind that was not added, and the kinds that were not tried.
    pub(super) fn candidates(&self, judged: &[Judged<'_>]) -> Vec<WalkCandidate> {
        let mut candidates: Vec<WalkCandidate> = Vec::new();
        for judged in judged {
            if candidates.iter().any(|known| known.kind == judged.kind()) {
                continue;
            }
            let verdict = if judged.is_usual {
                "fits best where it is absent, or as small as is usual".into()
            } else if judged.is_accepted() {
                "would help, but enough effects are in place".into()
            } else {
                format!(
                    "gains {:.1} on the fitted and {:.1} on the unseen stretch, needed {:.1} on average",
                    judged.gain[0],
                    judged.gain[1],
                    judged.needed()
                )
            };
            candidates.push(WalkCandidate {
                kind: judged.kind().into(),
                parameters: self.report(&judged.trial, judged.placed()),
                validation_deg: Some(errors(&judged.trial).validation_deg),
                gain: Some(judged.gain),
                verdict,
            });
        }
        if !self.record.start_is_told() {
            let kinds = crate::walk_effects::LIBRARY.iter();
            candidates.extend(kinds.filter(|effect| effect.is_a_delay()).map(|effect| {
                WalkCandidate {
                    kind: effect.kind().into(),
                    parameters: BTreeMap::new(),
                    validation_deg: None,
                    gain: None,
                    verdict: "not tried: the log does not tell when the walk was commanded".into(),
                }
            }));
        }
        candidates
    }
}
