//! Tracing a residual to effects that the model lacks.

use std::collections::BTreeMap;

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    Calibration, ComparisonSettings, Placed, Reported, Rival, StretchErrors, TracedEffect, Trial,
    UsualRemainder, WalkCandidate, WalkError, WalkExplanation, WalkModel, WalkRecord, Walker,
    decomposition::decompose, remainder::remainder, round, usual::Difference,
};
use crate::{Progress, statistics::chance_of_gain, walk_effects::Place};

/// How effects are traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TracingSettings {
    /// How models are compared with the record.
    pub comparison: ComparisonSettings,
    /// What an effect must gain on either stretch before it is added, besides the price
    /// of its parameters and places. The usual gain by chance, measured on logs of
    /// undisturbed robots (`docs/explain.md`), stays below it.
    pub least_gain: f64,
    /// Price of each parameter.
    pub price_per_parameter: f64,
    /// Effects that are added at most.
    pub most_effects: usize,
    /// Candidates this close to the best in their gains on both stretches together are
    /// its rivals.
    pub rival_gain: f64,
    /// What another morphology must gain on both stretches together before it takes the
    /// place of the one identified.
    pub switch_gain: f64,
    /// What the model leaves of robots that lack nothing.
    pub remainder: UsualRemainder,
}

impl Default for TracingSettings {
    fn default() -> Self {
        Self {
            comparison: ComparisonSettings::default(),
            least_gain: 6.0,
            price_per_parameter: 1.0,
            most_effects: 3,
            rival_gain: 6.0,
            switch_gain: 8.0,
            remainder: UsualRemainder::default(),
        }
    }
}

/// A morphology that the robot may have.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Which links are left.
    pub morphology: Morphology,
    /// Logarithm of its probability before the record is compared with its walk.
    pub ln_prior: f64,
}

/// Names the morphologies that come into question when the model has effects.
pub type IdentifyAgain<'a> = dyn Fn(&WalkModel) -> Vec<Suspect> + 'a;

/// Morphologies that are calibrated in full after a first look at all.
const FINALISTS: usize = 2;
/// Turns of calibration and fit, and the gain below which they have settled.
const TURNS: usize = 2;
const SETTLED: f64 = 0.5;
/// How much less probable a morphology may be after the first look, in the units of cost.
const WITHIN: f64 = 25.0;

/// Kinds of effect that are calibrated in full before one is added.
const CONTENDERS: usize = 2;

/// Finds what the model of a walk lacks.
///
/// Of the `suspects`, the first of which is the morphology as identified, the one is
/// taken that leaves least with the usual differences between robots fitted. Then every
/// effect of the library is fitted on the first stretch of the record, on top of those
/// found before, and measured on the second, which it never saw. Its gain is the fall of
/// n · ln(error²), summed over the axes, and of the price of the usual differences that
/// it makes unnecessary. The best one is added if its gain exceeds its price on both
/// stretches: the least gain that chance could give, something for each parameter, and
/// the logarithm of the number of places where it was tried. With the effect in place
/// the morphology is identified again. Effects are added until none is worth its price.
///
/// # Errors
/// [`WalkError`] when no suspect's walk can be simulated.
pub fn explain_walk(
    record: &WalkRecord,
    nominal: &WalkModel,
    suspects: &[Suspect],
    identify_again: &IdentifyAgain<'_>,
    settings: &TracingSettings,
    progress: &dyn Progress,
) -> Result<WalkExplanation, WalkError> {
    let tracing = Tracing {
        record,
        nominal,
        settings,
        progress,
    };
    let identified = suspects.first().ok_or(WalkError::Diverged)?;
    let first = tracing
        .likeliest(std::slice::from_ref(identified), &[])?
        .ok_or(WalkError::Diverged)?;
    let error_before = tracing.as_described(&identified.morphology, first.lost_links())?;
    let mut state = tracing.likeliest_beside(&first, suspects, &[])?;
    let error_calibrated = errors(&first.trial);
    let residual_before = tracing.decomposed(&first);
    let mut effects = Vec::new();
    let mut candidates = loop {
        let judged = tracing.round(&state);
        if effects.len() >= settings.most_effects {
            break judged;
        }
        let contenders = tracing.contenders(&state, &judged)?;
        let Some((best, with_best)) = contenders.first() else {
            break judged;
        };
        effects.push(tracing.traced(best, &contenders));
        let found = with_best.trial.effects.clone();
        let mut again = identify_again(&with_best.walker().with(&found));
        again.insert(0, with_best.suspect());
        again.extend_from_slice(suspects);
        dedup(&mut again);
        state = tracing.likeliest_beside(with_best, &again, &found)?;
    };
    tracing.finish_effects(&state, &mut effects);
    if let Some(locked) = tracing.locked_links(&state)? {
        effects.push(locked);
    }
    let residual_after = tracing.decomposed(&state);
    let model = Walker {
        model: &state.calibration_model,
        morphology: &state.morphology,
    }
    .with(&state.trial.effects);
    let left = remainder(record, &model, &residual_after, &settings.remainder);
    candidates.retain(|judged| !effects.iter().any(|effect| effect.kind == judged.kind()));
    let mut warnings = Vec::new();
    if record.standing().is_empty() {
        warnings
            .push("the log does not show the robot standing: offsets at rest are not known".into());
    }
    Ok(WalkExplanation {
        morphology_before: identified.morphology.to_rows(),
        morphology: state.morphology.to_rows(),
        damaged_legs: state.morphology.damaged_legs(),
        effects,
        unexplained: left.unexplained,
        error_before,
        error_calibrated,
        error_after: errors(&state.trial),
        noise_floor_deg: left.floor_deg,
        usual_differences: state.usual_differences(),
        candidates: tracing.candidates(&candidates),
        residual: left.residual,
        residual_before,
        residual_after,
        stretch_s: record.fit().len() as f64 * WalkRecord::PERIOD_S,
        warnings,
    })
}

/// Keeps the first of each morphology.
fn dedup(suspects: &mut Vec<Suspect>) {
    let mut seen: Vec<Morphology> = Vec::new();
    suspects.retain(|suspect| {
        let new = !seen.contains(&suspect.morphology);
        if new {
            seen.push(suspect.morphology.clone());
        }
        new
    });
}

fn errors(trial: &Trial) -> StretchErrors {
    StretchErrors::new(trial.fit_deg2, trial.unseen_deg2)
}

struct Tracing<'a> {
    record: &'a WalkRecord,
    nominal: &'a WalkModel,
    settings: &'a TracingSettings,
    progress: &'a dyn Progress,
}

/// Where the tracing has come to: a morphology, its calibrated model, and the effects
/// found.
#[derive(Clone)]
struct State<'a> {
    morphology: Morphology,
    calibration_model: WalkModel,
    comparison: super::Comparison<'a>,
    trial: Trial,
    ln_prior: f64,
    /// Cost on both stretches, with prior.
    total: f64,
}

/// An effect on trial.
struct Judged {
    trial: Trial,
    /// On the fitted and the unseen stretch.
    gain: [f64; 2],
    price: f64,
    /// See [`WalkEffect::rarity`](crate::walk_effects::WalkEffect::rarity).
    rarity: f64,
    chance: f64,
    at_bound: bool,
}

impl State<'_> {
    fn lost_links(&self) -> LostLinks {
        self.calibration_model.simulation.lost_links
    }

    fn walker(&self) -> Walker<'_> {
        Walker {
            model: &self.calibration_model,
            morphology: &self.morphology,
        }
    }

    fn suspect(&self) -> Suspect {
        Suspect {
            morphology: self.morphology.clone(),
            ln_prior: self.ln_prior,
        }
    }

    fn usual_differences(&self) -> BTreeMap<String, f64> {
        let there = self.comparison.there.iter().zip(&self.trial.usual);
        Difference::ALL
            .into_iter()
            .zip(there)
            .filter(|(difference, _)| !difference.is_of_zeros())
            .map(|(difference, (there, more))| (difference.name().to_string(), there + more))
            .collect()
    }
}

impl Judged {
    fn placed(&self) -> &Placed {
        self.trial
            .effects
            .last()
            .expect("a trial adds an effect to those found")
    }

    fn kind(&self) -> &'static str {
        self.placed().effect.kind()
    }

    fn total_gain(&self) -> f64 {
        self.gain[0] + self.gain[1] - self.price - self.rarity
    }

    fn is_accepted(&self) -> bool {
        self.gain.iter().all(|gain| *gain > self.price) && !self.at_bound
    }
}

impl<'a> Tracing<'a> {
    /// The suspect whose walk with these effects leaves least: all are looked at, the
    /// best few calibrated in full.
    fn likeliest(
        &self,
        suspects: &[Suspect],
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
        let cases: Vec<(&Suspect, LostLinks)> = suspects
            .iter()
            .flat_map(|suspect| {
                let cases: &[LostLinks] = if suspect.morphology.is_healthy() {
                    &[LostLinks::Absent]
                } else {
                    &[LostLinks::Absent, LostLinks::Locked]
                };
                cases.iter().map(move |lost_links| (suspect, *lost_links))
            })
            .collect();
        let finalists = if suspects.len() == 1 {
            cases
        } else {
            self.finalists(cases, effects)?
        };
        self.progress.expect_more(finalists.len());
        let states = finalists
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let state = self.calibrated(suspect, lost_links, effects);
                self.progress.advance();
                state
            })
            .collect::<Result<Vec<_>, WalkError>>()?;
        let states = states.into_iter().flatten();
        Ok(states.min_by(|a, b| a.total.total_cmp(&b.total)))
    }

    /// Looks at all cases and chooses the best few.
    fn finalists<'s>(
        &self,
        cases: Vec<(&'s Suspect, LostLinks)>,
        effects: &[Placed],
    ) -> Result<Vec<(&'s Suspect, LostLinks)>, WalkError> {
        self.progress.expect_more(cases.len());
        let mut glances = cases
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let cost = Calibration::glance(
                    &self.settings.comparison,
                    &self.with_lost(lost_links),
                    effects,
                    &suspect.morphology,
                    self.record,
                )?;
                self.progress.advance();
                Ok(cost.map(|cost| (cost - 2.0 * suspect.ln_prior, suspect, lost_links)))
            })
            .collect::<Result<Vec<_>, WalkError>>()?
            .into_iter()
            .flatten()
            .collect::<Vec<_>>();
        glances.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let best = glances.first().map_or(0.0, |(cost, ..)| *cost);
        glances.retain(|(cost, ..)| *cost <= best + WITHIN);
        let chosen = glances.into_iter().take(FINALISTS);
        Ok(chosen
            .map(|(_, suspect, lost_links)| (suspect, lost_links))
            .collect())
    }

    /// The likeliest of the suspects, unless it is hardly likelier than the morphology held
    /// so far.
    fn likeliest_beside(
        &self,
        so_far: &State<'a>,
        suspects: &[Suspect],
        effects: &[Placed],
    ) -> Result<State<'a>, WalkError> {
        let others: Vec<Suspect> = suspects
            .iter()
            .filter(|suspect| suspect.morphology != so_far.morphology)
            .cloned()
            .collect();
        if others.is_empty() {
            return Ok(so_far.clone());
        }
        let other = self.likeliest(&others, effects)?;
        let other = other.filter(|other| other.total < so_far.total - self.settings.switch_gain);
        Ok(other.unwrap_or_else(|| so_far.clone()))
    }

    /// The state that a trial stands for.
    fn with_trial(&self, state: &State<'a>, trial: &Trial) -> State<'a> {
        let unseen = state.comparison.cost_of(trial.unseen_deg2);
        State {
            total: trial.cost + unseen - 2.0 * state.ln_prior,
            trial: trial.clone(),
            ..state.clone()
        }
    }

    fn with_lost(&self, lost_links: LostLinks) -> WalkModel {
        let mut model = self.nominal.clone();
        model.simulation.lost_links = lost_links;
        model
    }

    /// Calibrates a suspect's model and fits its effects in turn, because either depends
    /// on the other.
    fn calibrated(
        &self,
        suspect: &Suspect,
        lost_links: LostLinks,
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
        let turns = if effects.is_empty() { 1 } else { TURNS };
        let mut best: Option<State<'a>> = None;
        for _ in 0..turns {
            let effects = best.as_ref().map_or(effects, |best| &best.trial.effects);
            let Some(next) = self.calibrated_once(suspect, lost_links, effects)? else {
                break;
            };
            if best
                .as_ref()
                .is_some_and(|best| next.total > best.total - SETTLED)
            {
                break;
            }
            best = Some(next);
        }
        Ok(best)
    }

    fn calibrated_once(
        &self,
        suspect: &Suspect,
        lost_links: LostLinks,
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
        let model = self.with_lost(lost_links);
        let comparison = &self.settings.comparison;
        let morphology = &suspect.morphology;
        let Some(calibration) =
            Calibration::new(comparison, &model, effects, morphology, self.record)?
        else {
            return Ok(None);
        };
        let walker = Walker {
            model: &calibration.model,
            morphology,
        };
        let Some(trial) = walker.fit(&calibration.comparison, effects.to_vec(), 0) else {
            return Ok(None);
        };
        let unseen = calibration.comparison.cost_of(trial.unseen_deg2);
        Ok(Some(State {
            morphology: morphology.clone(),
            ln_prior: suspect.ln_prior,
            total: trial.cost + unseen - 2.0 * suspect.ln_prior,
            calibration_model: calibration.model,
            comparison: calibration.comparison,
            trial,
        }))
    }

    /// The errors of the robot as described.
    fn as_described(
        &self,
        morphology: &Morphology,
        lost_links: LostLinks,
    ) -> Result<StretchErrors, WalkError> {
        let model = self.with_lost(lost_links);
        let settings = &self.settings.comparison;
        let comparison = Calibration::uncalibrated(settings, &model, morphology, self.record)?
            .ok_or(WalkError::Diverged)?;
        let walker = Walker {
            model: &model,
            morphology,
        };
        let trial = walker.fit(&comparison.as_described(), Vec::new(), 0);
        trial.as_ref().map(errors).ok_or(WalkError::Diverged)
    }

    /// Every effect on top of those found, best first.
    fn round(&self, state: &State<'a>) -> Vec<Judged> {
        let kinds = round::kinds_for(&state.comparison);
        let walker = state.walker();
        let found = &state.trial.effects;
        let trials = round::try_all(&walker, &state.comparison, found, &kinds, self.progress);
        let mut judged: Vec<Judged> = trials
            .into_iter()
            .map(|trial| self.judge(state, trial))
            .collect();
        judged.sort_by(|a, b| {
            let accepted = b.is_accepted().cmp(&a.is_accepted());
            accepted.then(b.total_gain().total_cmp(&a.total_gain()))
        });
        judged
    }

    fn judge(&self, state: &State<'a>, trial: Trial) -> Judged {
        let comparison = &state.comparison;
        // What the usual differences cost counts on either stretch: an effect that makes
        // an unusual one unnecessary has gained as much.
        let prior = |trial: &Trial| trial.cost - comparison.cost_of(trial.fit_deg2);
        let unseen = |trial: &Trial| comparison.cost_of(trial.unseen_deg2) + prior(trial);
        let gain = [
            state.trial.cost - trial.cost,
            unseen(&state.trial) - unseen(&trial),
        ];
        let placed = trial.effects.last().expect("a trial has an effect");
        let parameters = placed
            .effect
            .parameters(placed.place, &state.calibration_model);
        let model = state.walker().with(&state.trial.effects);
        let places = placed.effect.places(&model.robot, &state.morphology).len();
        let blocks = |trial: &Trial| self.blocks(state, trial);
        Judged {
            price: self.settings.least_gain
                + self.settings.price_per_parameter * parameters.len() as f64
                + (places as f64).ln(),
            rarity: placed.effect.rarity(&placed.values),
            chance: chance_of_gain(&blocks(&state.trial), &blocks(&trial)),
            at_bound: parameters
                .iter()
                .zip(&placed.values)
                .any(|(parameter, value)| {
                    parameter.is_at_bound(*value) && parameter.neutral == Some(*value)
                }),
            gain,
            trial,
        }
    }

    /// Mean squares of the unseen errors, cycle by cycle and axis by axis, over what is
    /// left of the axis now.
    fn blocks(&self, state: &State<'a>, trial: &Trial) -> Vec<f64> {
        let unseen = self.record.unseen();
        let period_s = state.calibration_model.gait.period_s;
        let length = ((period_s * WalkRecord::RATE_HZ).round() as usize).max(1);
        let axes = trial.residual_deg.as_ref().into_array();
        let scales = state.trial.unseen_deg2;
        let mut blocks = Vec::new();
        for (axis, scale) in axes.into_iter().zip(scales) {
            for block in axis[unseen.clone()].chunks(length).take(6) {
                blocks.push(super::comparison::mean_square(block) / scale.max(1e-9));
            }
        }
        blocks
    }

    /// The best candidates, each of another kind, calibrated with lost links gone and
    /// locked: which of them it is may look otherwise with an effect in place. Best first.
    fn contenders<'j>(
        &self,
        state: &State<'a>,
        judged: &'j [Judged],
    ) -> Result<Vec<(&'j Judged, State<'a>)>, WalkError> {
        let mut kinds: Vec<&Judged> = Vec::new();
        for judged in judged.iter().filter(|judged| judged.is_accepted()) {
            if kinds.len() < CONTENDERS && !kinds.iter().any(|k| k.kind() == judged.kind()) {
                kinds.push(judged);
            }
        }
        let mut contenders = Vec::new();
        for judged in kinds {
            let as_tried = self.with_trial(state, &judged.trial);
            let found = &judged.trial.effects;
            let suited = self.likeliest(&[state.suspect()], found)?;
            let suited = suited.filter(|suited| suited.total < as_tried.total);
            contenders.push((judged, suited.unwrap_or(as_tried)));
        }
        let cost =
            |(judged, state): &(&Judged, State<'_>)| state.total + judged.price + judged.rarity;
        contenders.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        Ok(contenders)
    }

    /// What is said of an effect when it is added. Intervals come when all are found.
    fn traced(&self, best: &Judged, contenders: &[(&Judged, State<'a>)]) -> TracedEffect {
        let placed = best.placed();
        let cost =
            |(judged, state): &(&Judged, State<'_>)| state.total + judged.price + judged.rarity;
        let least = contenders.first().map_or(0.0, cost);
        let rivals = contenders
            .iter()
            .skip(1)
            .filter(|rival| cost(rival) < least + self.settings.rival_gain);
        TracedEffect {
            kind: best.kind().into(),
            parameters: self.report(&best.trial, placed),
            interval_95: BTreeMap::new(),
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            explains: placed.effect.trace().into(),
            gain: best.gain,
            price: best.price,
            chance: best.chance,
            error: errors(&best.trial),
            rivals: rivals
                .map(|(rival, state)| Rival {
                    kind: rival.kind().into(),
                    parameters: state
                        .trial
                        .effects
                        .last()
                        .map_or_else(BTreeMap::new, |last| self.report(&state.trial, last)),
                })
                .collect(),
        }
    }

    fn report(&self, trial: &Trial, placed: &Placed) -> BTreeMap<String, Reported> {
        let values = self.values(trial, placed).into_iter();
        values
            .map(|(name, value)| (name.clone(), Reported::new(&name, value)))
            .collect()
    }

    fn values(&self, trial: &Trial, placed: &Placed) -> BTreeMap<String, f64> {
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
    fn finish_effects(&self, state: &State<'a>, effects: &mut [TracedEffect]) {
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
    fn locked_links(&self, state: &State<'a>) -> Result<Option<TracedEffect>, WalkError> {
        if state.lost_links() != LostLinks::Locked || state.morphology.is_healthy() {
            return Ok(None);
        }
        let suspect = Suspect {
            morphology: state.morphology.clone(),
            ln_prior: 0.0,
        };
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

    fn decomposed(&self, state: &State<'a>) -> super::ByAxis {
        let period_s = state.walker().with(&state.trial.effects).gait.period_s;
        decompose(self.record, &state.trial.residual_deg, period_s).into()
    }

    /// The best place of each kind that was not added, and the kinds that were not tried.
    fn candidates(&self, judged: &[Judged]) -> Vec<WalkCandidate> {
        let mut candidates: Vec<WalkCandidate> = Vec::new();
        for judged in judged {
            if candidates.iter().any(|known| known.kind == judged.kind()) {
                continue;
            }
            let verdict = if judged.at_bound {
                "fits best where it is absent".into()
            } else if judged.is_accepted() {
                "would help, but enough effects are in place".into()
            } else {
                format!(
                    "gains {:.1} on the fitted and {:.1} on the unseen stretch, needed {:.1}",
                    judged.gain[0], judged.gain[1], judged.price
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

impl Placed {
    fn is_same(&self, other: &Self) -> bool {
        self.effect.kind() == other.effect.kind() && self.place == other.place
    }
}

/// Where an effect sits, for messages.
impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Robot => write!(f, "robot"),
            Self::Leg(leg) => write!(f, "leg {}", leg + 1),
            Self::Link(leg, link) => write!(f, "leg {}, link {}", leg + 1, link + 1),
        }
    }
}
