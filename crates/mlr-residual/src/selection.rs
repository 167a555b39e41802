//! Forward selection: one effect at a time, judged on data that no fit has seen.

mod describe;
mod trial;

use mlr_filter::SettingError;
use trial::Trial;

use crate::{
    Candidate, Effect, SensorError, SensorExplanation, SensorRecord,
    sensor_effects::{Commonness, LIBRARY, SensorEffect},
    statistics::chance_of_gain,
};

/// An error counts as more than noise when it exceeds the noise floor this many times:
/// a random walk that is twice as large as on average is not rare.
const ABOVE_NOISE: f64 = 3.0;

/// How effects are selected.
#[derive(Debug, Clone, PartialEq)]
pub struct SelectionSettings {
    /// Probability of adding any effect by chance, shared by all candidates.
    pub significance: f64,
    /// Share by which the error must fall for each parameter of an effect; twice that
    /// where the effect is rare.
    pub price_per_parameter: f64,
    /// Kinds that are not tried.
    pub without: Vec<String>,
    /// Whether effects that speak of the motion rather than the sensor are tried.
    pub motion_effects: bool,
}

impl Default for SelectionSettings {
    fn default() -> Self {
        Self {
            significance: 0.05,
            price_per_parameter: 0.02,
            without: Vec::new(),
            motion_effects: false,
        }
    }
}

impl SelectionSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("significance", self.significance, 1e-9..=1.0, "")?;
        let price = self.price_per_parameter;
        SettingError::check("price_per_parameter", price, 0.0..=1.0, "")
    }
}

/// The verdict on a candidate in one round.
struct Judged {
    trial: Trial,
    effect: &'static dyn SensorEffect,
    /// Chance of its gain without any effect.
    chance: f64,
    accepted: bool,
    verdict: String,
}

/// Finds what the data sheet's model of a gyroscope lacks.
///
/// The record is divided in the middle. Every candidate is fitted on the first half,
/// together with the effects found before, and judged on the second: the signals of
/// the sensor, but not the reference angle, which serves only to measure the error.
/// Errors are compared in 15 blocks, in two ways: as they are, and within each block
/// less its mean, which drift hardly touches. A candidate is accepted when one of
/// them falls by more than the price of its parameters, the other does not rise, no parameter lies at the
/// bound of what such sensors have, the first half alone tells one of them from where the
/// effect does nothing, and an exact sign-flip test over the blocks says that the gain would come by chance with a
/// probability below `significance / candidates`. Since a drift is one
/// accident rather than fifteen, a smaller drift alone is evidence only while the
/// error is above three times the noise floor, or for effects that observe the drift, such
/// as gravity, and have gained on the first half too. Of the most
/// common among the accepted candidates ([`Commonness`](crate::sensor_effects::Commonness))
/// the one that lowers the errors most for each parameter is added, until none is left; where no single effect
/// that every sensor has is accepted, pairs of them are tried; at last each effect
/// that not every sensor has is taken out again and stays out unless it still earns its price.
///
/// # Errors
/// [`SensorError::UnknownEffect`] for a kind in `without` that is not in the library,
/// [`SensorError::Setting`] for a number that makes no sense.
pub fn explain_sensor(
    record: &SensorRecord,
    settings: &SelectionSettings,
) -> Result<SensorExplanation, SensorError> {
    settings.check()?;
    for kind in &settings.without {
        crate::sensor_effects::find(kind).ok_or_else(|| SensorError::UnknownEffect {
            kind: kind.clone(),
            known: crate::sensor_effects::kinds(),
        })?;
    }
    let fit_half = record.first_half();
    let wanted: Vec<&'static dyn SensorEffect> = LIBRARY
        .iter()
        .copied()
        .filter(|effect| !settings.without.iter().any(|kind| kind == effect.kind()))
        .filter(|effect| settings.motion_effects || !effect.is_about_motion())
        .collect();
    let threshold = settings.significance / wanted.len().max(1) as f64;

    let mut before = Trial::new(record, &fit_half, Vec::new());
    // The noise is that of the sensor, whatever the model lacks: it is read off once
    // more with all that every sensor has.
    let always = LIBRARY
        .iter()
        .copied()
        .filter(|effect| effect.commonness() == Commonness::Always)
        .filter_map(|effect| Some((effect, effect.parameters(&fit_half).ok()?)));
    before.lower_noise(&Trial::new(record, &fit_half, always.collect()));
    let before = before;
    let mut current = before.clone();
    let mut effects: Vec<Effect> = Vec::new();
    let candidates = loop {
        let mut candidates = Vec::new();
        let mut judged: Vec<Judged> = Vec::new();
        for effect in wanted.iter().copied().filter(|e| !current.has(e.kind())) {
            match current.with(record, &fit_half, effect) {
                Ok(trial) => judged.push(judge(&current, trial, effect, settings, threshold)),
                Err(reason) => candidates.push(Candidate {
                    kind: effect.kind().into(),
                    parameters: [].into(),
                    validation_deg: None,
                    verdict: format!("not applicable: {reason}"),
                }),
            }
        }
        let accepted = judged.iter().filter(|judged| judged.accepted);
        let best = accepted.max_by(|a, b| {
            let commonness = b.effect.commonness().cmp(&a.effect.commonness());
            commonness.then_with(|| a.worth(&current).total_cmp(&b.worth(&current)))
        });
        if best.is_none_or(|best| best.effect.commonness() > Commonness::Always)
            && let Some((first, pair)) =
                best_pair(record, &fit_half, &current, &wanted, settings, threshold)
        {
            for effect in [first, pair.effect] {
                effects.push(pair.report(effect, Vec::new()));
            }
            current = pair.trial;
            continue;
        }
        let Some(best) = best else {
            candidates.extend(judged.iter().map(Judged::candidate));
            break candidates;
        };
        let rivals = judged
            .iter()
            .filter(|rival| rival.accepted && rival.is_as_good_as(best))
            .map(|rival| rival.effect.kind().to_string())
            .collect();
        effects.push(best.report(best.effect, rivals));
        current = best.trial.clone();
    };
    let mut explanation = SensorExplanation {
        effects,
        candidates,
        ..describe::description(record, &before, &current)
    };
    let current = prune(
        record,
        &fit_half,
        current,
        settings,
        threshold,
        &mut explanation,
    );
    describe::complete(record, &current, &mut explanation);
    Ok(explanation)
}

/// Two effects that every sensor has can hide each other, so that neither helps alone:
/// the best pair of those not added yet that is accepted together.
fn best_pair(
    record: &SensorRecord,
    fit_half: &SensorRecord,
    current: &Trial,
    wanted: &[&'static dyn SensorEffect],
    settings: &SelectionSettings,
    threshold: f64,
) -> Option<(&'static dyn SensorEffect, Judged)> {
    let missing: Vec<_> = wanted
        .iter()
        .copied()
        .filter(|effect| effect.commonness() == Commonness::Always && !current.has(effect.kind()))
        .collect();
    let mut best: Option<(&'static dyn SensorEffect, Judged)> = None;
    for (k, first) in missing.iter().enumerate() {
        for second in &missing[k + 1..] {
            let with_first = current.with(record, fit_half, *first).ok();
            let with_both = with_first.and_then(|t| t.with(record, fit_half, *second).ok());
            let Some(trial) = with_both.filter(|trial| !trial.is_at_bound(first.kind())) else {
                continue;
            };
            let judged = judge(current, trial, *second, settings, threshold);
            let better = best
                .as_ref()
                .is_none_or(|(_, best)| judged.worth(current) > best.worth(current));
            if judged.accepted && better {
                best = Some((*first, judged));
            }
        }
    }
    best
}

fn judge(
    current: &Trial,
    trial: Trial,
    effect: &'static dyn SensorEffect,
    settings: &SelectionSettings,
    threshold: f64,
) -> Judged {
    let added = trial.parameter_count() - current.parameter_count();
    let rarity = if effect.commonness() == Commonness::Rare {
        2.0
    } else {
        1.0
    };
    let price = 1.0 - settings.price_per_parameter * rarity * added.max(1) as f64;
    let (old, new) = (current.error(), trial.error());
    let within_falls = new.within_blocks_deg <= price * old.within_blocks_deg;
    let level_falls = new.validation_deg <= price * old.validation_deg;
    let within_chance = chance_of_gain(&current.blocks.within, &trial.blocks.within);
    let level_chance = chance_of_gain(&current.blocks.level, &trial.blocks.level);
    let drift_is_evidence = if effect.observes_drift() {
        new.fit_deg <= price * old.fit_deg
    } else {
        old.validation_deg > ABOVE_NOISE * current.noise_floor_deg()
    };
    let by_within =
        within_falls && within_chance < threshold && new.validation_deg <= old.validation_deg;
    let by_level = level_falls && level_chance < threshold && drift_is_evidence;
    let chance = match (by_within, by_level) {
        (true, _) => within_chance,
        (false, true) => level_chance,
        (false, false) => within_chance.min(level_chance),
    };
    let at_bound = trial.is_at_bound(effect.kind());
    let absent = trial.is_absent(effect.kind());
    let accepted = (by_within || by_level) && !at_bound && !absent;
    let verdict = if at_bound {
        "helps only beyond what such sensors have".into()
    } else if absent {
        "may as well not be there, by the half that it was fitted on".into()
    } else if accepted {
        "within noise of what was added".into()
    } else if new.validation_deg > old.validation_deg {
        "worse on the unseen half".into()
    } else if !(within_falls || level_falls) {
        "gains less than its parameters cost".into()
    } else if level_falls && level_chance < threshold {
        "a smaller drift, as noise alone could leave".into()
    } else {
        format!("no better than chance (p = {chance:.4}, needed {threshold:.4})")
    };
    Judged {
        trial,
        effect,
        chance,
        accepted,
        verdict,
    }
}

impl Judged {
    fn report(&self, effect: &dyn SensorEffect, rivals: Vec<String>) -> Effect {
        Effect {
            kind: effect.kind().into(),
            parameters: self.trial.parameters_of(effect.kind()),
            interval_95: [].into(),
            error_deg: Some(self.trial.error()),
            explains: effect.trace().into(),
            chance: Some(self.chance),
            rivals,
        }
    }

    fn candidate(&self) -> Candidate {
        Candidate {
            kind: self.effect.kind().into(),
            parameters: self.trial.parameters_of(self.effect.kind()),
            validation_deg: Some(self.trial.error().validation_deg),
            verdict: self.verdict.clone(),
        }
    }

    /// By how much the errors have fallen for each parameter, in powers of e. An effect
    /// with many parameters can stand in for a simpler one, and must not be preferred
    /// for that.
    fn worth(&self, current: &Trial) -> f64 {
        let added = self.trial.parameter_count() - current.parameter_count();
        (current.score() - self.trial.score()) / added.max(1) as f64
    }

    /// Whether another candidate's error does not differ from the best one's by more
    /// than one block in twenty would by chance.
    fn is_as_good_as(&self, best: &Self) -> bool {
        !std::ptr::addr_eq(self.effect, best.effect)
            && self.effect.kind() != best.effect.kind()
            && chance_of_gain(&self.trial.blocks.level, &best.trial.blocks.level) > 0.05
    }
}

/// Takes out what later effects have made superfluous, unless every sensor has it: a
/// rarer effect may then be standing in for it.
fn prune(
    record: &SensorRecord,
    fit_half: &SensorRecord,
    mut current: Trial,
    settings: &SelectionSettings,
    threshold: f64,
    explanation: &mut SensorExplanation,
) -> Trial {
    let mut index = 0;
    while explanation.effects.len() > 1 && index < explanation.effects.len() {
        let kind = explanation.effects[index].kind.clone();
        let Some(effect) = crate::sensor_effects::find(&kind) else {
            break;
        };
        if effect.commonness() == Commonness::Always {
            index += 1;
            continue;
        }
        let without = current.without(record, fit_half, &kind);
        let judged = judge(&without, current.clone(), effect, settings, threshold);
        if judged.accepted {
            index += 1;
            continue;
        }
        explanation.effects.remove(index);
        explanation.candidates.push(Candidate {
            verdict: "superfluous beside the effects added after it".into(),
            ..judged.candidate()
        });
        current = without;
    }
    current
}
