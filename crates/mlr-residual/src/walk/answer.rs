//! From hypotheses with their evidence to the answer.

use std::collections::BTreeMap;

use mlr_filter::Axes;
use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;

use super::{
    ByAxis, Discrepancy, EvidenceSettings, Nuisance, NuisancePrior, Observation, Reported, Rival,
    StretchErrors, StretchesS, Suspect, TracedEffect, WalkAlternative, WalkCandidate, WalkError,
    WalkExplanation, WalkModel, WalkRecord,
    decomposition::decompose,
    evidence::Fit,
    hypothesis::Walker,
    outcome::{LOCKED_LINKS, Outcome, posterior},
    residual_left::residual_left,
    search::{Beforehand, Search, base::Setting},
    stretch_errors::{Corrected, residual_deg, stretch_errors},
};
use crate::{Posterior, Progress, walk_effects::LIBRARY};

/// Share of the probability that rivals hold together with the answer.
const CREDIBLE: f64 = 0.9;
/// Alternatives that are reported, and the least probability of one.
const ALTERNATIVES: (usize, f64) = (10, 0.005);
/// 95 % quantile, two-sided, of a normal distribution.
const NORMAL_95: f64 = 1.96;

/// Explains a walk: which effects that the model lacks, on which robot, and how probable that is.
///
/// `suspects` are the morphologies in question, the first of them as identified without effects;
/// `known` is what is known of the robot beforehand. `generator` draws the walks that means are taken of.
///
/// # Errors
/// [`WalkError`] when a setting makes no sense, or no suspect's walk can be simulated.
pub fn explain_walk(
    record: &WalkRecord,
    nominal: &WalkModel,
    suspects: &[Suspect],
    known: Beforehand<'_>,
    settings: &EvidenceSettings,
    generator: &ChaCha8Rng,
    progress: &dyn Progress,
) -> Result<WalkExplanation, WalkError> {
    settings.check()?;
    let identified = suspects.first().ok_or(WalkError::Diverged)?;
    let period_s = nominal.gait.period_s;
    let mean = &settings.mean_discrepancy;
    // Evidence by single walks is compared with evidence by their mean: as much of either counts.
    let single = &Discrepancy {
        power: mean.power,
        ..settings.discrepancy.clone()
    };
    let observation = Observation::new(record, single, period_s);
    let of_means = Observation::new(record, mean, period_s);
    let beginning = Observation::of_beginning(record, single, period_s);
    let beginning_of_means = Observation::of_beginning(record, mean, period_s);
    let nuisance = NuisancePrior::new(&settings.nuisance, nominal);
    let of = |observation| Setting {
        observation,
        nuisance: &nuisance,
        nominal,
    };
    let search = Search {
        setting: of(&observation),
        beginning: of(&beginning),
        of_means: &of_means,
        beginning_of_means: &beginning_of_means,
        prior: settings.prior,
        effort: settings.effort,
        kinds: LIBRARY.len(),
        progress,
        known,
        generator,
    };
    let searched = search.run(suspects);
    let posterior = posterior(&settings.prior, searched).ok_or(WalkError::Diverged)?;
    let answer = Answer {
        record,
        settings,
        posterior,
    };
    answer.explanation(identified)
}

struct Answer<'a, 's> {
    record: &'a WalkRecord,
    settings: &'s EvidenceSettings,
    posterior: Posterior<Outcome<'a>>,
}

impl<'a> Answer<'a, '_> {
    fn explanation(&self, identified: &Suspect) -> Result<WalkExplanation, WalkError> {
        let fitted = self.fitted();
        let (best, fit) = *fitted.first().ok_or(WalkError::Diverged)?;
        let is_bare = |(one, _): &&(&Outcome<'a>, &Fit)| one.walker.hypothesis.is_bare();
        let (bare, _) = *fitted.iter().find(is_bare).unwrap_or(&(best, fit));
        let error_before = self.errors_as_described(bare)?;
        let (error_calibrated, residual_before) = self.errors_of(bare)?;
        let (error_after, residual_after) = self.errors_of(best)?;
        let period_s = fit.walked.model.gait.period_s;
        let split = |residual_deg: &Axes<Vec<f64>>| -> ByAxis {
            decompose(self.record, residual_deg, period_s).into()
        };
        let residual_after = split(&residual_after);
        let unknown = self.posterior.sum(|one| one.unknown);
        let left = residual_left(
            self.record,
            &fit.walked.model,
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
            morphology: best.walker.hypothesis.morphology.clone(),
            damaged_legs: best.walker.hypothesis.morphology.damaged_legs(),
            effect_probability: self.effect_probability(),
            effects: self.effects(best, fit),
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

    /// Hypotheses that were fitted, the most probable first: whether something unknown acts as well is another
    /// question.
    fn fitted(&self) -> Vec<(&Outcome<'a>, &Fit)> {
        let ranked = self.posterior.ranked().iter().map(|(one, _)| one);
        let known = ranked.filter(|one| !one.unknown);
        let mut fitted: Vec<(&Outcome<'a>, &Fit, f64)> = known
            .filter_map(|one| {
                let hypothesis = &one.walker.hypothesis;
                let is_same = |other: &Outcome<'a>| other.walker.hypothesis.is_same(hypothesis);
                Some((one, one.fit()?, self.posterior.sum(is_same)))
            })
            .collect();
        fitted.sort_by(|(.., a), (.., b)| b.total_cmp(a));
        fitted.into_iter().map(|(one, fit, _)| (one, fit)).collect()
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
        let walker = &outcome.walker;
        let values = walker.values(outcome.coordinates());
        let placed = walker.hypothesis.effects[index];
        // As if it were alone on the robot as calibrated.
        let bare = walker.without_effects_model(outcome.coordinates());
        placed
            .effect
            .report(placed.place, &values[index], &bare)
            .into_iter()
            .map(|(name, value)| (name.clone(), Reported::new(&name, value)))
            .collect()
    }

    fn effects(&self, best: &Outcome<'a>, fit: &Fit) -> Vec<TracedEffect> {
        let walker = &best.walker;
        let rivals = self.rivals(best);
        let mut effects: Vec<TracedEffect> = (0..walker.hypothesis.effects.len())
            .map(|index| {
                let placed = walker.hypothesis.effects[index];
                let (interval_95, at_bound, undetermined) = intervals(walker, fit, index);
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
            let legs = best.walker.hypothesis.morphology.damaged_legs();
            effects.push(TracedEffect {
                kind: LOCKED_LINKS.into(),
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
            for (index, placed) in outcome.walker.hypothesis.effects.iter().enumerate() {
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

    fn alternatives(&self) -> Vec<WalkAlternative> {
        let (most, least) = ALTERNATIVES;
        let ranked = self.posterior.ranked().iter();
        ranked
            .take(most)
            .filter(|(_, probability)| *probability >= least)
            .map(|(outcome, probability)| {
                let effects = outcome.walker.hypothesis.effects.iter().enumerate();
                WalkAlternative {
                    morphology: outcome.walker.hypothesis.morphology.clone(),
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
            for (index, placed) in outcome.walker.hypothesis.effects.iter().enumerate() {
                let kind = placed.effect.kind();
                if own.contains(&kind)
                    || candidates.iter().any(|known| known.kind == kind)
                    || self.record.hides(placed.effect)
                {
                    continue;
                }
                let probability = self.probability_of_kind(kind);
                let errors = self.errors_of(outcome).ok();
                candidates.push(WalkCandidate {
                    kind: kind.into(),
                    parameters: self.report(outcome, index),
                    validation_deg: errors.map(|(errors, _)| errors.validation_deg),
                    probability,
                    verdict: format!("{:.1} % probable", 100.0 * probability),
                });
            }
        }
        let hidden = LIBRARY.iter().filter(|effect| self.record.hides(**effect));
        candidates.extend(hidden.map(|effect| {
            let probability = self.probability_of_kind(effect.kind());
            WalkCandidate {
                kind: effect.kind().into(),
                parameters: BTreeMap::new(),
                validation_deg: None,
                probability,
                verdict: format!(
                    "{:.1} % probable, by the prior: the log does not tell when the walk was commanded",
                    100.0 * probability
                ),
            }
        }));
        candidates
    }

    fn nuisance(&self, best: &Outcome<'a>) -> BTreeMap<String, f64> {
        let names = Nuisance::of(&best.walker.hypothesis.morphology, self.record).into_iter();
        let deviations = best.walker.deviations(best.coordinates());
        names
            .map(Nuisance::name)
            .zip(deviations.iter().copied())
            .collect()
    }

    /// The errors of the robot as described, without effects.
    fn errors_as_described(&self, bare: &Outcome<'a>) -> Result<StretchErrors, WalkError> {
        let walker = bare.walker.without_effects();
        let mut z = walker.described(&[]);
        // Time has no zero: the start of the walk is part of the comparison.
        z[0] = bare.coordinates()[0];
        let residual_deg = self.residual_deg(&walker, &z)?;
        Ok(stretch_errors(self.record, &residual_deg, Corrected::Heading).0)
    }

    fn errors_of(
        &self,
        outcome: &Outcome<'a>,
    ) -> Result<(StretchErrors, Axes<Vec<f64>>), WalkError> {
        let residual_deg = self.residual_deg(&outcome.walker, outcome.coordinates())?;
        Ok(stretch_errors(self.record, &residual_deg, Corrected::Drift))
    }

    /// What a walk leaves of the whole record.
    fn residual_deg(
        &self,
        walker: &Walker<'a>,
        z: &DVector<f64>,
    ) -> Result<Axes<Vec<f64>>, WalkError> {
        let model = walker.model(z);
        let samples = self.record.times_s().len();
        let body = model
            .walk(&walker.hypothesis.morphology, self.record, samples)?
            .ok_or(WalkError::Diverged)?;
        Ok(residual_deg(
            self.record,
            &model.observe(&body, self.record, samples),
        ))
    }
}

/// A parameter whose posterior has this share of its prior's deviation is not determined.
const UNDETERMINED: f64 = 0.8;

/// Intervals of what is reported, parameters at a bound, and those that the log does not tell:
/// their posterior is as wide as their prior.
fn intervals(
    walker: &Walker<'_>,
    fit: &Fit,
    index: usize,
) -> (BTreeMap<String, [f64; 2]>, Vec<String>, Vec<String>) {
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
