//! Forward selection: which effects are added, in which order.

use super::{
    SelectionSettings,
    comparison::Comparison,
    trial::{SelectionRecord, Trial},
};
use crate::{
    SensorRecord,
    fitted_model::{ChosenEffect, FittedModel},
    sensor_effects::{Commonness, LIBRARY, SensorEffect},
};

/// A forward-selection step: an effect that was added.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) effect: &'static dyn SensorEffect,
    /// With this effect and all before it, fitted on the fit stretch.
    pub(super) model: FittedModel,
    pub(super) p_value: f64,
    /// Kinds that did not differ from it significantly.
    pub(super) rivals: Vec<String>,
}

/// An effect that was not added, or removed again.
#[derive(Debug)]
pub(super) struct Rejected {
    pub(super) effect: &'static dyn SensorEffect,
    /// On top of what was found; None where the effect could not be tried.
    pub(super) model: Option<FittedModel>,
    pub(super) verdict: String,
}

/// What the search has found.
#[derive(Debug)]
pub(super) struct Selected {
    /// With all effects, fitted on the fit stretch.
    pub(super) trial: Trial,
    pub(super) steps: Vec<Step>,
    pub(super) rejected: Vec<Rejected>,
}

/// A search over the library. It holds no sample of the test stretch.
#[derive(Debug)]
pub(super) struct Search<'a> {
    seen: SelectionRecord,
    wanted: Vec<&'static dyn SensorEffect>,
    settings: &'a SelectionSettings,
    /// Largest p-value of an effect that is added.
    threshold: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(record: &SensorRecord, settings: &'a SelectionSettings) -> Self {
        let wanted: Vec<&'static dyn SensorEffect> = LIBRARY
            .iter()
            .copied()
            .filter(|effect| !settings.without.iter().any(|kind| kind == effect.kind()))
            .filter(|effect| settings.motion_effects || !effect.is_about_motion())
            .collect();
        Self {
            seen: SelectionRecord::of(record),
            threshold: settings.significance / wanted.len().max(1) as f64,
            wanted,
            settings,
        }
    }

    /// Fit and selection stretch.
    pub(super) fn record(&self) -> &SensorRecord {
        &self.seen.whole
    }

    /// Adds effects until none is accepted, then removes those that later ones replace.
    pub(super) fn run(&self) -> Selected {
        let mut selected = Selected {
            trial: self.data_sheet(),
            steps: Vec::new(),
            rejected: Vec::new(),
        };
        loop {
            let (compared, inapplicable) = self.candidates(&selected.trial);
            let best = self.best(&compared, &selected.trial);
            if best.is_none_or(|best| best.effect.commonness() > Commonness::Always)
                && let Some((first, pair)) = self.best_pair(&selected.trial)
            {
                let model = &pair.trial.model;
                let step = |effect| Step {
                    effect,
                    model: model.clone(),
                    p_value: pair.p_value,
                    rivals: Vec::new(),
                };
                selected.steps.extend([first, pair.effect].map(step));
                selected.trial = pair.trial;
                continue;
            }
            let Some(best) = best else {
                selected.rejected = inapplicable;
                let rejected = compared.into_iter().map(Comparison::rejected);
                selected.rejected.extend(rejected);
                break;
            };
            let rivals = compared.iter().filter(|rival| rival.accepted);
            let rivals = rivals.filter(|rival| rival.is_rival_of(best));
            selected.steps.push(Step {
                effect: best.effect,
                model: best.trial.model.clone(),
                p_value: best.p_value,
                rivals: rivals.map(|rival| rival.effect.kind().into()).collect(),
            });
            selected.trial = best.trial.clone();
        }
        self.prune(&mut selected);
        selected
    }

    /// The model without effects. Its noise is that of the sensor, whatever the model lacks: it
    /// is also read off a model with all that every sensor has.
    fn data_sheet(&self) -> Trial {
        let mut data_sheet = Trial::new(&self.seen, Vec::new());
        data_sheet.lower_noise(&Trial::new(
            &self.seen,
            what_every_sensor_has(&self.seen.fit),
        ));
        data_sheet
    }

    /// Every effect not added yet, compared with the current model, and those that cannot be.
    fn candidates(&self, current: &Trial) -> (Vec<Comparison>, Vec<Rejected>) {
        let (mut compared, mut inapplicable) = (Vec::new(), Vec::new());
        for effect in self.missing(current) {
            match current.with(&self.seen, effect) {
                Ok(trial) => compared.push(self.compare(current, trial, effect)),
                Err(reason) => inapplicable.push(Rejected {
                    effect,
                    model: None,
                    verdict: format!("not applicable: {reason}"),
                }),
            }
        }
        (compared, inapplicable)
    }

    fn missing(&self, current: &Trial) -> impl Iterator<Item = &'static dyn SensorEffect> {
        let wanted = self.wanted.iter().copied();
        wanted.filter(|effect| !current.model.has(effect.kind()))
    }

    fn compare(
        &self,
        current: &Trial,
        trial: Trial,
        effect: &'static dyn SensorEffect,
    ) -> Comparison {
        Comparison::new(current, trial, effect, self.settings, self.threshold)
    }

    /// Of the most common among the accepted candidates, the one that gains most for each
    /// parameter.
    fn best<'c>(&self, compared: &'c [Comparison], current: &Trial) -> Option<&'c Comparison> {
        let accepted = compared.iter().filter(|candidate| candidate.accepted);
        let gain = |candidate: &Comparison| candidate.gain_per_parameter(current);
        accepted.max_by(|a, b| {
            let commonness = b.effect.commonness().cmp(&a.effect.commonness());
            commonness.then_with(|| gain(a).total_cmp(&gain(b)))
        })
    }

    /// Two effects that every sensor has can hide each other, so that neither helps alone:
    /// the best pair of those not added yet that is accepted together.
    fn best_pair(&self, current: &Trial) -> Option<(&'static dyn SensorEffect, Comparison)> {
        let missing: Vec<_> = self
            .missing(current)
            .filter(|effect| effect.commonness() == Commonness::Always)
            .collect();
        let mut best: Option<(&'static dyn SensorEffect, Comparison)> = None;
        for (k, first) in missing.iter().enumerate() {
            for second in &missing[k + 1..] {
                let with_first = current.with(&self.seen, *first).ok();
                let with_both = with_first.and_then(|t| t.with(&self.seen, *second).ok());
                let Some(trial) = with_both.filter(|t| !t.model.is_at_bound(first.kind())) else {
                    continue;
                };
                let pair = self.compare(current, trial, *second);
                let gain = |pair: &Comparison| pair.gain_per_parameter(current);
                let better = best
                    .as_ref()
                    .is_none_or(|(_, best)| gain(&pair) > gain(best));
                if pair.accepted && better {
                    best = Some((*first, pair));
                }
            }
        }
        best
    }

    /// Removes what later effects have made superfluous, unless every sensor has it: a rarer
    /// effect may then be imitating it.
    fn prune(&self, selected: &mut Selected) {
        let mut index = 0;
        while selected.steps.len() > 1
            && let Some(step) = selected.steps.get(index)
        {
            let effect = step.effect;
            if effect.commonness() == Commonness::Always {
                index += 1;
                continue;
            }
            let without = selected.trial.without(&self.seen, effect.kind());
            let comparison = self.compare(&without, selected.trial.clone(), effect);
            if comparison.accepted {
                index += 1;
                continue;
            }
            selected.steps.remove(index);
            selected.rejected.push(Rejected {
                verdict: "superfluous beside the effects added after it".into(),
                ..comparison.rejected()
            });
            selected.trial = without;
        }
    }
}

/// The effects that every sensor has, with the parameters for a fit on a record.
pub(super) fn what_every_sensor_has(record: &SensorRecord) -> Vec<ChosenEffect> {
    let effects = LIBRARY.iter().copied();
    effects
        .filter(|effect| effect.commonness() == Commonness::Always)
        .filter_map(|effect| Some((effect, effect.parameters(record).ok()?)))
        .collect()
}

impl Comparison {
    fn rejected(self) -> Rejected {
        Rejected {
            effect: self.effect,
            model: Some(self.trial.model),
            verdict: self.verdict,
        }
    }
}
