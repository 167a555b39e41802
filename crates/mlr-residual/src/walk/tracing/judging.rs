//! Candidates on trial, and what they gain.

use std::sync::Arc;

use super::{
    Suspect, Tracing,
    round::{Footing, OBVIOUS_GAIN, Round, Scope, Screening},
    state::{Hypotheses, State},
};
use crate::{
    statistics::chance_of_gain,
    walk::{
        Placed, Trial, WalkError, WalkRecord,
        comparison::{is_wild, mean_square},
    },
};

/// What an effect must gain on either stretch, over its price. Twice the price on both together
/// may come from one of them for the most part: robots that turn, and faults that come and go,
/// show an effect in one half of a walk more than in the other.
const LEAST_SHARE: f64 = 0.5;

/// An effect on trial.
#[derive(Clone)]
pub(super) struct Judged<'a> {
    /// What walks with it.
    pub(super) suspect: Suspect,
    /// What it was tried on.
    pub(super) base: Arc<State<'a>>,
    pub(super) trial: Trial,
    /// On the fitted and the unseen stretch.
    pub(super) gain: [f64; 2],
    pub(super) price: f64,
    /// See [`WalkEffect::rarity`](crate::walk_effects::WalkEffect::rarity).
    pub(super) rarity: f64,
    pub(super) chance: f64,
    /// Whether it is no more than what robots of one make differ by anyhow.
    pub(super) is_usual: bool,
}

impl Judged<'_> {
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

    /// The lesser of its gains on the two stretches.
    fn least_gain(&self) -> f64 {
        self.gain[0].min(self.gain[1])
    }

    /// What its gains on the two stretches must exceed on average.
    pub(super) fn needed(&self) -> f64 {
        self.price + self.rarity / 2.0
    }

    /// Whether it gains what is needed on both stretches together, and enough on either.
    pub(super) fn is_accepted(&self) -> bool {
        let [fit, unseen] = self.gain;
        let on_either = self.least_gain() > LEAST_SHARE * self.price;
        on_either && fit + unseen > 2.0 * self.needed() && !self.is_usual
    }

    /// Whether it may turn out to be worth its price with the model calibrated around it: it
    /// gains that on the fitted stretch, or something on either and that on both together.
    /// What is usual has been fitted without it, and stands in for some of it.
    pub(super) fn is_promising(&self) -> bool {
        let [fit, unseen] = self.gain;
        let gains = fit > self.price || (self.least_gain() > 0.0 && fit + unseen > self.price);
        self.is_accepted() || (gains && !self.is_usual)
    }
}

/// Those worth their price first, each part by what it gains.
fn sort(judged: &mut [Judged<'_>]) {
    judged.sort_by(|a, b| {
        let accepted = b.is_accepted().cmp(&a.is_accepted());
        accepted.then(b.total_gain().total_cmp(&a.total_gain()))
    });
}

impl<'a> Tracing<'a> {
    /// Every effect on top of those found, best first: on the robot as it is held to be, and on
    /// those that it may be as well; where these miss links of the same legs, calibrated and as
    /// described, because what is usual can stand in for an effect; and on each damaged leg of
    /// all of them as if that leg were whole, because a leg that does not do its part passes for
    /// a lost one. Where the best is a fault of a leg, all that may be wrong with that leg is
    /// fitted in earnest.
    pub(super) fn round(&self, known: &Hypotheses<'a>) -> Result<Vec<Judged<'a>>, WalkError> {
        let held = &known.held;
        let Some(round) = Round::new(held, self.brief, self.progress) else {
            return Ok(Vec::new());
        };
        let on_held = self.footings(held, held)?;
        let mut beside = Vec::new();
        for other in &known.beside {
            beside.extend(self.footings(held, other)?);
        }
        let restored = self.with_a_leg_restored(known);
        let mut judged = self.try_on(&round, &on_held, Screening::BROAD);
        judged.extend(self.try_on(&round, &beside, Screening::BESIDE));
        judged.extend(self.try_on(&round, &restored, Screening::RESTORED));
        sort(&mut judged);
        let more = self.rest_of_leg_at_fault(&round, &judged);
        judged.extend(more);
        sort(&mut judged);
        Ok(judged)
    }

    /// What nobody could overlook in the rates of the standing robot, best first. Everything else
    /// that a standing robot shows, a slope does as well as a tilted sensor.
    pub(super) fn obvious(&self, held: &Arc<State<'a>>) -> Vec<Judged<'a>> {
        if self.record.rest_rate_dps().is_none() {
            return Vec::new();
        }
        let Some(round) = Round::new(held, self.brief, self.progress) else {
            return Vec::new();
        };
        let at_rest = Footing {
            scope: Scope::AtRest,
            ..Footing::new(Arc::clone(held))
        };
        let mut judged = self.try_on(&round, &[at_rest], Screening::OBVIOUS);
        judged.retain(|judged| judged.is_accepted() && judged.least_gain() > OBVIOUS_GAIN);
        sort(&mut judged);
        judged
    }

    /// A robot as it is calibrated and, where the same legs are damaged as of the one held, as
    /// it is described.
    fn footings(
        &self,
        held: &State<'a>,
        base: &Arc<State<'a>>,
    ) -> Result<Vec<Footing<'a>>, WalkError> {
        let mut footings = vec![Footing::new(Arc::clone(base))];
        if base.has_same_legs(held) {
            let described = self.uncalibrated(base)?.map(Arc::new);
            footings.extend(described.map(Footing::new));
        }
        Ok(footings)
    }

    /// Each damaged leg of each robot that comes into question, as if this leg were whole.
    fn with_a_leg_restored(&self, known: &Hypotheses<'a>) -> Vec<Footing<'a>> {
        let mut all: Vec<Footing<'a>> = Vec::new();
        for base in std::iter::once(&known.held).chain(&known.beside) {
            let morphology = &base.morphology;
            for leg in 0..morphology.legs() {
                let links = morphology.links(leg);
                let restored = self.suspect(morphology.clone().with_remaining(leg, links));
                let is_known = all.iter().any(|other| {
                    other.suspect == restored && other.base.lost_links() == base.lost_links()
                });
                if morphology.remaining(leg) < links && !is_known {
                    all.push(Footing {
                        base: Arc::clone(base),
                        suspect: restored,
                        scope: Scope::Leg(leg + 1),
                        tried: Vec::new(),
                    });
                }
            }
        }
        all
    }

    /// What has not been tried of the leg that the best of those judged puts at fault.
    fn rest_of_leg_at_fault(
        &self,
        round: &Round<'_, 'a>,
        judged: &[Judged<'a>],
    ) -> Vec<Judged<'a>> {
        let Some(first) = judged.first().filter(|first| first.is_accepted()) else {
            return Vec::new();
        };
        let leg = first.placed().place.leg();
        if leg == 0 {
            return Vec::new();
        }
        let on_it = judged
            .iter()
            .filter(|judged| judged.suspect == first.suspect);
        let footing = Footing {
            base: Arc::clone(&first.base),
            suspect: first.suspect.clone(),
            scope: Scope::Leg(leg),
            tried: on_it.map(|judged| judged.placed().clone()).collect(),
        };
        self.try_on(round, &[footing], Screening::ONE_LEG)
    }

    /// The effects that may be on these robots and look best on them.
    fn try_on(
        &self,
        round: &Round<'_, 'a>,
        footings: &[Footing<'a>],
        screening: Screening,
    ) -> Vec<Judged<'a>> {
        let held = round.held;
        round.try_on(
            footings,
            screening,
            |suspect, leg| self.switching(held, suspect, leg),
            |on, trial| self.judge(held, &on.base, &on.suspect, trial),
        )
    }

    pub(super) fn judge(
        &self,
        held: &State<'a>,
        base: &Arc<State<'a>>,
        suspect: &Suspect,
        trial: Trial,
    ) -> Judged<'a> {
        let placed = trial.effects.last().expect("a trial has an effect");
        let parameters = placed
            .effect
            .parameters(placed.place, &base.calibration_model);
        let places = placed
            .effect
            .places(&base.model().robot, &suspect.morphology);
        let of_effect = placed.effect.chance_share() * self.settings.least_gain
            + self.settings.price_per_parameter * parameters.len() as f64
            + (places.len() as f64).ln();
        let times = match is_wild(held.trial.fit_deg2) {
            true => self.settings.wild_price,
            false => 1.0,
        };
        Judged {
            price: times * of_effect + self.switching(held, suspect, placed.place.leg()),
            rarity: placed.effect.rarity(&placed.values),
            chance: self.chance(held, &trial),
            is_usual: placed.is_usual(&base.calibration_model),
            gain: gains(self.without(held, base, suspect), &trial),
            suspect: suspect.clone(),
            base: Arc::clone(base),
            trial,
        }
    }

    /// What an effect is measured by: the robot held, or the one that it was tried on where
    /// that is likelier already.
    fn without<'s>(
        &self,
        held: &'s State<'a>,
        base: &'s State<'a>,
        suspect: &Suspect,
    ) -> &'s State<'a> {
        let is_of_base = base.morphology == suspect.morphology;
        if is_of_base && base.total < held.total {
            base
        } else {
            held
        }
    }

    /// What an effect on `leg`, from 1 (0: on none), of another robot than the one held must gain
    /// more on either stretch: other damaged legs must be far better, half of it on each, and
    /// what is less probable beforehand by so much more. A damaged leg that is whole but for
    /// the effect is no other leg, but another account of it: half of that will do.
    fn switching(&self, held: &State<'a>, suspect: &Suspect, leg: usize) -> f64 {
        let less_probable = held.ln_prior - suspect.ln_prior;
        let legs = held.morphology.damaged_legs();
        let damaged = suspect.morphology.damaged_legs();
        let mut at_fault = damaged.clone();
        if !at_fault.contains(&leg) {
            at_fault.push(leg);
            at_fault.sort_unstable();
        }
        let far_better = if damaged == legs {
            0.0
        } else if at_fault == legs {
            self.settings.switch_gain / 4.0
        } else {
            self.settings.switch_gain / 2.0
        };
        (far_better + less_probable).max(0.0)
    }

    /// The probability that so many cycles gain by chance.
    fn chance(&self, state: &State<'a>, trial: &Trial) -> f64 {
        let blocks = |trial: &Trial| self.blocks(state, trial);
        chance_of_gain(&blocks(&state.trial), &blocks(trial))
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
}

/// What a trial gains on the fitted and on the unseen stretch. What the usual differences
/// cost counts on either: an effect that makes an unusual one unnecessary has gained as much.
fn gains(before: &State<'_>, after: &Trial) -> [f64; 2] {
    let comparison = &before.comparison;
    let prior = |trial: &Trial| trial.cost - comparison.cost_of(trial.fit_deg2);
    let unseen = |trial: &Trial| comparison.cost_of(trial.unseen_deg2) + prior(trial);
    [
        before.trial.cost - after.cost,
        unseen(&before.trial) - unseen(after),
    ]
}
