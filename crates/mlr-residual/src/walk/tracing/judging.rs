//! Candidates on trial, and which of them comes first.

use super::{Tracing, round, state::State};
use crate::{
    statistics::chance_of_gain,
    walk::{Placed, Trial, WalkError, WalkRecord, comparison::mean_square},
};

/// Kinds of effect that are calibrated in full before one is added.
const CONTENDERS: usize = 2;

/// An effect on trial.
pub(super) struct Judged {
    pub(super) trial: Trial,
    /// On the fitted and the unseen stretch.
    pub(super) gain: [f64; 2],
    pub(super) price: f64,
    /// See [`WalkEffect::rarity`](crate::walk_effects::WalkEffect::rarity).
    pub(super) rarity: f64,
    pub(super) chance: f64,
    pub(super) at_bound: bool,
}

impl Judged {
    pub(super) fn placed(&self) -> &Placed {
        self.trial
            .effects
            .last()
            .expect("a trial adds an effect to those found")
    }

    pub(super) fn kind(&self) -> &'static str {
        self.placed().effect.kind()
    }

    pub(super) fn total_gain(&self) -> f64 {
        self.gain[0] + self.gain[1] - self.price - self.rarity
    }

    pub(super) fn is_accepted(&self) -> bool {
        self.gain.iter().all(|gain| *gain > self.price) && !self.at_bound
    }
}

impl<'a> Tracing<'a> {
    /// Every effect on top of those found, best first.
    pub(super) fn round(&self, state: &State<'a>) -> Vec<Judged> {
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

    pub(super) fn judge(&self, state: &State<'a>, trial: Trial) -> Judged {
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
    pub(super) fn blocks(&self, state: &State<'a>, trial: &Trial) -> Vec<f64> {
        let unseen = self.record.unseen();
        let period_s = state.calibration_model.gait.period_s;
        let length = ((period_s * WalkRecord::RATE_HZ).round() as usize).max(1);
        let axes = trial.residual_deg.as_ref().into_array();
        let scales = state.trial.unseen_deg2;
        let mut blocks = Vec::new();
        for (axis, scale) in axes.into_iter().zip(scales) {
            for block in axis[unseen.clone()].chunks(length).take(6) {
                blocks.push(mean_square(block) / scale.max(1e-9));
            }
        }
        blocks
    }

    /// The best candidates, each of another kind, calibrated with lost links gone and
    /// locked: which of them it is may look otherwise with an effect in place. Best first.
    pub(super) fn contenders<'j>(
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
}
