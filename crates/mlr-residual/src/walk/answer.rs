//! From hypotheses with their evidence to the answer.

use std::collections::BTreeMap;

use mlr_filter::{Axes, SettingError};
use mlr_model::{LostLinks, Morphology};
use serde::{Deserialize, Serialize};

use super::{
    ByAxis, Discrepancy, EffectPrior, Nuisance, NuisanceSettings, Observation, Reported, Rival,
    StretchErrors, StretchesS, Suspect, TracedEffect, WalkAlternative, WalkCandidate, WalkError,
    WalkExplanation, WalkModel, WalkRecord,
    decomposition::decompose,
    evidence::LinearModel,
    hypothesis::Walker,
    residual_left::residual_left,
    search::{Effort, Judged, Search, base::Setting},
};
use crate::{Posterior, Progress};

/// How a walk is explained.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvidenceSettings {
    /// How robots of one make differ.
    pub nuisance: NuisanceSettings,
    /// What the right model gets wrong.
    pub discrepancy: Discrepancy,
    /// How probable effects are before the record is seen.
    pub prior: EffectPrior,
    /// How much is tried.
    pub effort: Effort,
}

impl EvidenceSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        self.nuisance
            .check()
            .map_err(|error| error.under("nuisance"))?;
        self.discrepancy
            .check()
            .map_err(|error| error.under("discrepancy"))?;
        self.prior.check().map_err(|error| error.under("prior"))?;
        self.effort.check().map_err(|error| error.under("effort"))
    }
}

/// Share of the probability that rivals hold together with the answer.
const CREDIBLE: f64 = 0.9;
/// Alternatives that are reported, and the least probability of one.
const ALTERNATIVES: (usize, f64) = (10, 0.005);
/// 95 % quantile, two-sided, of a normal distribution.
const NORMAL_95: f64 = 1.96;
/// Amplitudes of something unknown, degrees, each as probable as the others: from what the model
/// gets wrong of a healthy robot to what throws one over.
const UNKNOWN_DEG: [f64; 6] = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2];
/// The likeliest hypotheses that something unknown may add to.
const WITH_UNKNOWN: usize = 3;
/// Lost links that hang on: an effect by its name.
const LOCKED: &str = "locked_links";

/// One hypothesis of the posterior.
#[derive(Debug, Clone)]
struct Outcome<'a> {
    judged: Judged<'a>,
    /// Whether something that no effect of the library makes adds to it.
    unknown: bool,
}

impl Outcome<'_> {
    fn is_locked(&self) -> bool {
        self.judged.base.lost_links == LostLinks::Locked
            && !self.judged.base.morphology.is_healthy()
    }

    /// The kinds of its effects, in order of their names.
    fn kinds(&self) -> Vec<&'static str> {
        let effects = self.judged.walker.hypothesis.effects.iter();
        let mut kinds: Vec<&'static str> = effects.map(|placed| placed.effect.kind()).collect();
        if self.is_locked() {
            kinds.push(LOCKED);
        }
        if self.unknown {
            kinds.push("unknown");
        }
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }

    fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (
            &self.judged.walker.hypothesis,
            &other.judged.walker.hypothesis,
        );
        let has_all = a.effects.iter().all(|placed| b.effects.contains(placed));
        self.unknown == other.unknown
            && a.morphology == b.morphology
            && a.lost_links == b.lost_links
            && a.effects.len() == b.effects.len()
            && has_all
    }
}

/// Explains a walk: which effects that the model lacks, on which robot, and how probable that is.
///
/// `suspects` are the morphologies in question, the first of them as identified without effects;
/// `ln_prior` is the logarithm of the prior probability of any morphology.
///
/// # Errors
/// [`WalkError`] when a setting makes no sense, or no suspect's walk can be simulated.
pub fn explain_walk(
    record: &WalkRecord,
    nominal: &WalkModel,
    suspects: &[Suspect],
    ln_prior: &(dyn Fn(&Morphology) -> f64 + Sync),
    settings: &EvidenceSettings,
    progress: &dyn Progress,
) -> Result<WalkExplanation, WalkError> {
    settings.check()?;
    let identified = suspects.first().ok_or(WalkError::Diverged)?;
    let observation = Observation::new(record, &settings.discrepancy, nominal.gait.period_s);
    let beginning = Observation::of_beginning(record, &settings.discrepancy, nominal.gait.period_s);
    let of = |observation| Setting {
        observation,
        nuisance: &settings.nuisance,
        nominal,
    };
    let kinds = crate::walk_effects::LIBRARY
        .iter()
        .filter(|effect| record.start_is_told() || !effect.is_a_delay())
        .count();
    let search = Search {
        setting: of(&observation),
        beginning: of(&beginning),
        prior: settings.prior,
        effort: settings.effort,
        kinds,
        progress,
        ln_prior,
    };
    let judged = search.run(suspects);
    let posterior = posterior(&observation, &settings.prior, judged).ok_or(WalkError::Diverged)?;
    let answer = Answer {
        record,
        settings,
        posterior,
    };
    answer.explanation(identified)
}

/// Of each hypothesis the likeliest fit, with and without something unknown.
fn posterior<'a>(
    observation: &Observation<'a>,
    prior: &EffectPrior,
    mut judged: Vec<Judged<'a>>,
) -> Option<Posterior<Outcome<'a>>> {
    judged.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
    let mut outcomes: Vec<(Outcome<'a>, f64)> = Vec::new();
    for judged in judged {
        let ln_weight = judged.ln_weight + (1.0 - prior.unknown).ln();
        let outcome = Outcome {
            judged,
            unknown: false,
        };
        if !outcomes.iter().any(|(known, _)| known.is_same(&outcome)) {
            outcomes.push((outcome, ln_weight));
        }
    }
    let top: Vec<Outcome<'a>> = outcomes
        .iter()
        .take(WITH_UNKNOWN)
        .map(|(one, _)| one.clone())
        .collect();
    let bare = outcomes
        .iter()
        .map(|(one, _)| one)
        .find(|one| one.judged.walker.hypothesis.effects.is_empty());
    let bare = bare
        .filter(|bare| !top.iter().any(|one| one.is_same(bare)))
        .cloned();
    for outcome in top.into_iter().chain(bare) {
        let fit = &outcome.judged.fit;
        let spread = outcome.judged.walker.spread(&fit.jacobian);
        let linear = |unknown_deg: f64| {
            let whitening = observation.whitening_with(spread, unknown_deg)?;
            let linear = LinearModel {
                residual: whitening.apply_to(&fit.walked.residual),
                coordinates: fit.walked.z.clone(),
                jacobian: whitening.apply(&fit.jacobian),
                held: 0,
            };
            Some(linear.ln_evidence(&whitening).0)
        };
        let Some(without) = linear(0.0) else { continue };
        let each: Vec<f64> = UNKNOWN_DEG.iter().copied().filter_map(linear).collect();
        let greatest = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean =
            each.iter().map(|ln| (ln - greatest).exp()).sum::<f64>() / UNKNOWN_DEG.len() as f64;
        let ln_weight =
            outcome.judged.ln_weight + greatest + mean.ln() - without + prior.unknown.ln();
        outcomes.push((
            Outcome {
                unknown: true,
                ..outcome
            },
            ln_weight,
        ));
    }
    let posterior = Posterior::new(outcomes);
    (!posterior.ranked().is_empty()).then_some(posterior)
}

struct Answer<'a, 's> {
    record: &'a WalkRecord,
    settings: &'s EvidenceSettings,
    posterior: Posterior<Outcome<'a>>,
}

impl<'a> Answer<'a, '_> {
    fn explanation(&self, identified: &Suspect) -> Result<WalkExplanation, WalkError> {
        let ranked = self.posterior.ranked();
        let best = ranked.iter().map(|(one, _)| one).find(|one| !one.unknown);
        let best = best.ok_or(WalkError::Diverged)?;
        let bare = ranked.iter().map(|(one, _)| one);
        let bare = bare
            .filter(|one| one.judged.walker.hypothesis.effects.is_empty())
            .find(|one| !one.unknown)
            .unwrap_or(best);
        let before = self.described(&bare.judged)?;
        let (error_before, _) = self.errors(&before, Corrected::Heading);
        let (error_calibrated, residual_before) = self.errors_of(&bare.judged)?;
        let (error_after, residual_after) = self.errors_of(&best.judged)?;
        let period_s = best.judged.fit.walked.model.gait.period_s;
        let split = |residual_deg: &Axes<Vec<f64>>| -> ByAxis {
            decompose(self.record, residual_deg, period_s).into()
        };
        let residual_after = split(&residual_after);
        let unknown = self.posterior.sum(|one| one.unknown);
        let left = residual_left(
            self.record,
            &best.judged.fit.walked.model,
            &residual_after,
            &self.settings.discrepancy,
            unknown > 0.5,
        );
        let mut warnings = Vec::new();
        if self.record.standing().is_empty() {
            warnings.push(
                "the log does not show the robot standing: offsets at rest are not known".into(),
            );
        }
        let times_s = self.record.times_s();
        let stretch = |range: std::ops::Range<usize>| {
            [times_s[range.start], times_s[range.end.saturating_sub(1)]]
        };
        Ok(WalkExplanation {
            morphology_before: identified.morphology.clone(),
            morphology: best.judged.base.morphology.clone(),
            damaged_legs: best.judged.base.morphology.damaged_legs(),
            effect_probability: self.effect_probability(),
            effects: self.effects(best),
            alternatives: self.alternatives(),
            unexplained: unknown > 0.5,
            error_before,
            error_calibrated,
            error_after,
            noise_floor_deg: left.floor_deg,
            nuisance: self.nuisance(best),
            candidates: self.candidates(best),
            residual: left.residual,
            residual_before: split(&residual_before),
            residual_after,
            stretches_s: StretchesS {
                fit: stretch(self.record.fit()),
                validation: stretch(self.record.unseen()),
            },
            warnings,
        })
    }

    /// Probability of each kind to be in the robot, of none, and of something unknown.
    fn effect_probability(&self) -> BTreeMap<String, f64> {
        let mut probability: BTreeMap<String, f64> = BTreeMap::new();
        for (outcome, share) in self.posterior.ranked() {
            let mut kinds = outcome.kinds();
            if kinds.is_empty() {
                kinds.push("none");
            }
            for kind in kinds {
                *probability.entry(kind.to_string()).or_default() += share;
            }
        }
        for kind in ["none", "unknown"] {
            probability.entry(kind.into()).or_default();
        }
        probability
    }

    fn report(&self, outcome: &Outcome<'a>, index: usize) -> BTreeMap<String, Reported> {
        let walker = &outcome.judged.walker;
        let values = walker.values(&outcome.judged.fit.walked.z);
        let placed = walker.hypothesis.effects[index];
        // As if it were alone on the robot as calibrated.
        let bare = walker.without_effects_model(&outcome.judged.fit.walked.z);
        placed
            .effect
            .report(placed.place, &values[index], &bare)
            .into_iter()
            .map(|(name, value)| (name.clone(), Reported::new(&name, value)))
            .collect()
    }

    fn effects(&self, best: &Outcome<'a>) -> Vec<TracedEffect> {
        let walker = &best.judged.walker;
        let rivals = self.rivals(best);
        let mut effects: Vec<TracedEffect> = (0..walker.hypothesis.effects.len())
            .map(|index| {
                let placed = walker.hypothesis.effects[index];
                let (interval_95, at_bound, undetermined) = self.intervals(best, index);
                TracedEffect {
                    kind: placed.effect.kind().into(),
                    parameters: self.report(best, index),
                    interval_95,
                    at_bound,
                    undetermined,
                    explains: placed.effect.signature().into(),
                    probability: self.probability_of_kind(placed.effect.kind()),
                    rivals: rivals.clone(),
                }
            })
            .collect();
        if best.is_locked() {
            let legs = best.judged.base.morphology.damaged_legs();
            effects.push(TracedEffect {
                kind: LOCKED.into(),
                parameters: [("legs".to_string(), Reported::Numbers(legs))].into(),
                interval_95: BTreeMap::new(),
                at_bound: Vec::new(),
                undetermined: Vec::new(),
                explains: "the weight of the lost links is still there".into(),
                probability: self.posterior.sum(Outcome::is_locked),
                rivals: Vec::new(),
            });
        }
        effects
    }

    fn probability_of_kind(&self, kind: &str) -> f64 {
        self.posterior.sum(|one| one.kinds().contains(&kind))
    }

    /// Effects of other sets in the credible set, of kinds that the answer does not have.
    fn rivals(&self, best: &Outcome<'a>) -> Vec<Rival> {
        let own = best.kinds();
        let sets = self.posterior.classes(Outcome::kinds);
        let mut rivals: Vec<Rival> = Vec::new();
        for set in sets.credible(CREDIBLE) {
            let of_set = self
                .posterior
                .ranked()
                .iter()
                .map(|(one, _)| one)
                .find(|one| one.kinds() == *set);
            let Some(outcome) = of_set else { continue };
            for (index, placed) in outcome.judged.walker.hypothesis.effects.iter().enumerate() {
                let kind = placed.effect.kind();
                if !own.contains(&kind) && !rivals.iter().any(|rival| rival.kind == kind) {
                    rivals.push(Rival {
                        kind: kind.into(),
                        parameters: self.report(outcome, index),
                    });
                }
            }
        }
        rivals
    }

    /// Intervals of what is reported, parameters at a bound, and those that the log does not tell:
    /// their posterior is as wide as their prior.
    fn intervals(
        &self,
        best: &Outcome<'a>,
        index: usize,
    ) -> (BTreeMap<String, [f64; 2]>, Vec<String>, Vec<String>) {
        let walker = &best.judged.walker;
        let fit = &best.judged.fit;
        let covariance = fit.covariance();
        let placed = walker.hypothesis.effects[index];
        let bare = walker.without_effects_model(&fit.walked.z);
        let parameters = placed.effect.parameters(placed.place, &bare);
        let first = walker.nuisances()
            + walker.values(&fit.walked.z)[..index]
                .iter()
                .map(Vec::len)
                .sum::<usize>();
        let reported = |z: &nalgebra::DVector<f64>| {
            placed
                .effect
                .report(placed.place, &walker.values(z)[index], &bare)
        };
        let (mut low, mut at_bound, mut undetermined) =
            (reported(&fit.walked.z), Vec::new(), Vec::new());
        let mut high = low.clone();
        for (k, parameter) in parameters.iter().enumerate() {
            let value = walker.values(&fit.walked.z)[index][k];
            if parameter.is_at_bound(value) {
                at_bound.push(parameter.name.into());
            }
            let deviation = covariance[(first + k, first + k)].max(0.0).sqrt();
            if deviation > UNDETERMINED {
                undetermined.push(parameter.name.into());
                continue;
            }
            for end in [-NORMAL_95, NORMAL_95] {
                let mut z = fit.walked.z.clone();
                z[first + k] += end * deviation;
                for (name, value) in reported(&z) {
                    if let (Some(low), Some(high)) = (low.get_mut(&name), high.get_mut(&name)) {
                        *low = low.min(value);
                        *high = high.max(value);
                    }
                }
            }
        }
        let interval_95 = low
            .into_iter()
            .filter_map(|(name, low)| {
                let high = *high.get(&name)?;
                (high > low).then_some((name, [low, high]))
            })
            .collect();
        (interval_95, at_bound, undetermined)
    }

    fn alternatives(&self) -> Vec<WalkAlternative> {
        let (most, least) = ALTERNATIVES;
        let ranked = self.posterior.ranked().iter();
        ranked
            .take(most)
            .filter(|(_, probability)| *probability >= least)
            .map(|(outcome, probability)| {
                let effects = outcome.judged.walker.hypothesis.effects.iter().enumerate();
                WalkAlternative {
                    morphology: outcome.judged.base.morphology.clone(),
                    locked_links: outcome.is_locked(),
                    effects: effects
                        .map(|(index, placed)| Rival {
                            kind: placed.effect.kind().into(),
                            parameters: self.report(outcome, index),
                        })
                        .collect(),
                    unknown: outcome.unknown,
                    probability: *probability,
                }
            })
            .collect()
    }

    /// The likeliest hypothesis with each kind that the answer does not have.
    fn candidates(&self, best: &Outcome<'a>) -> Vec<WalkCandidate> {
        let own = best.kinds();
        let mut candidates: Vec<WalkCandidate> = Vec::new();
        for (outcome, _) in self.posterior.ranked() {
            for (index, placed) in outcome.judged.walker.hypothesis.effects.iter().enumerate() {
                let kind = placed.effect.kind();
                if own.contains(&kind) || candidates.iter().any(|known| known.kind == kind) {
                    continue;
                }
                let probability = self.probability_of_kind(kind);
                let errors = self.errors_of(&outcome.judged).ok();
                candidates.push(WalkCandidate {
                    kind: kind.into(),
                    parameters: self.report(outcome, index),
                    validation_deg: errors.map(|(errors, _)| errors.validation_deg),
                    probability: Some(probability),
                    verdict: format!("{:.1} % probable", 100.0 * probability),
                });
            }
        }
        if !self.record.start_is_told() {
            let kinds = crate::walk_effects::LIBRARY.iter();
            candidates.extend(kinds.filter(|effect| effect.is_a_delay()).map(|effect| {
                WalkCandidate {
                    kind: effect.kind().into(),
                    parameters: BTreeMap::new(),
                    validation_deg: None,
                    probability: None,
                    verdict: "not tried: the log does not tell when the walk was commanded".into(),
                }
            }));
        }
        candidates
    }

    fn nuisance(&self, best: &Outcome<'a>) -> BTreeMap<String, f64> {
        let names = Nuisance::of(&best.judged.base.morphology, self.record).into_iter();
        names
            .map(Nuisance::name)
            .zip(best.judged.fit.walked.z.iter().copied())
            .collect()
    }

    fn described(&self, judged: &Judged<'a>) -> Result<WholeWalk, WalkError> {
        let mut z = judged.base.with(Vec::new()).described(&[]);
        // Time has no zero: the start of the walk is part of the comparison.
        z[0] = judged.fit.walked.z[0];
        self.whole(&judged.base.with(Vec::new()), &z)
    }

    fn errors_of(&self, judged: &Judged<'a>) -> Result<(StretchErrors, Axes<Vec<f64>>), WalkError> {
        let whole = self.whole(&judged.walker, &judged.fit.walked.z)?;
        Ok(self.errors(&whole, Corrected::Drift))
    }

    /// The walk over the whole record.
    fn whole(
        &self,
        walker: &Walker<'a>,
        z: &nalgebra::DVector<f64>,
    ) -> Result<WholeWalk, WalkError> {
        let model = walker.model(z);
        let samples = self.record.times_s().len();
        let body = model
            .walk(&walker.hypothesis.morphology, self.record, samples)?
            .ok_or(WalkError::Diverged)?;
        Ok(WholeWalk {
            residual_deg: residual(self.record, &model.observe(&body, self.record, samples)),
        })
    }

    /// Errors of a walk on the stretch that decided, and on the one that nothing has seen.
    fn errors(&self, walk: &WholeWalk, corrected: Corrected) -> (StretchErrors, Axes<Vec<f64>>) {
        let record = self.record;
        let residual_deg = walk.residual_deg.as_ref().map(|axis, residual| {
            without_zeros(record, residual, corrected, axis == mlr_filter::Axis::Yaw)
        });
        let square = |range: std::ops::Range<usize>| {
            let axes = residual_deg.as_ref().into_array();
            axes.map(|axis| {
                let axis = &axis[range.clone()];
                axis.iter().map(|x| x * x).sum::<f64>() / axis.len().max(1) as f64
            })
        };
        let errors = StretchErrors::new(square(record.fit()), square(record.unseen()));
        (errors, residual_deg)
    }
}

/// A parameter whose posterior has this share of its prior's deviation is not determined.
const UNDETERMINED: f64 = 0.8;

struct WholeWalk {
    residual_deg: Axes<Vec<f64>>,
}

/// What of a residual is no error of the robot.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Corrected {
    /// Where yaw has its zero.
    Heading,
    /// The zero of yaw, the rate of turning and the lean of the walking body, which no contact model
    /// gets right: as found on the stretch that decides.
    Drift,
}

fn residual(record: &WalkRecord, predicted: &Axes<Vec<f64>>) -> Axes<Vec<f64>> {
    let measured = record.measured_deg();
    let of = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    Axes {
        roll: of(&measured.roll, &predicted.roll),
        pitch: of(&measured.pitch, &predicted.pitch),
        yaw: of(&measured.yaw, &predicted.yaw),
    }
}

fn without_zeros(
    record: &WalkRecord,
    residual: &[f64],
    corrected: Corrected,
    is_yaw: bool,
) -> Vec<f64> {
    let fit = record.fit();
    let of_fit = &residual[fit.clone()];
    let n = of_fit.len() as f64;
    let mean = of_fit.iter().sum::<f64>() / n.max(1.0);
    if !is_yaw && corrected == Corrected::Heading {
        return residual.to_vec();
    }
    let walks = |index: usize| record.times_s()[index] > record.start_s();
    if !is_yaw {
        let lean = |(k, x): (usize, &f64)| if walks(k) { x - mean } else { *x };
        return residual.iter().enumerate().map(lean).collect();
    }
    let times_s = record.times_s();
    let middle_s = of_fit.len() as f64 / 2.0 * WalkRecord::PERIOD_S + times_s[fit.start];
    let lever: f64 = fit.clone().map(|k| (times_s[k] - middle_s).powi(2)).sum();
    let along: f64 = fit
        .clone()
        .map(|k| (times_s[k] - middle_s) * residual[k])
        .sum();
    let slope_dps = match corrected {
        Corrected::Heading => 0.0,
        Corrected::Drift => along / lever.max(1e-9),
    };
    residual
        .iter()
        .enumerate()
        .map(|(k, x)| x - mean - slope_dps * (times_s[k] - middle_s))
        .collect()
}
