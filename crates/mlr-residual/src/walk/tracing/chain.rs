//! Effects found one after the other, each on top of those before.

use std::sync::Arc;

use super::{
    Suspect, Tracing, dedup,
    judging::Judged,
    state::{Hypotheses, State},
};
use crate::walk::{TracedEffect, WalkError};

/// Effects found, and what is known of the robot with them.
pub(super) struct Chain<'a> {
    pub(super) held: Arc<State<'a>>,
    pub(super) effects: Vec<TracedEffect>,
    /// What was tried last: on top of the effects, or, where there are as many as may be,
    /// beside the last of them.
    pub(super) candidates: Vec<Judged<'a>>,
}

impl<'a> Tracing<'a> {
    /// Adds the best effect to the robot as identified, one of the `suspects`, and identifies it
    /// again, until nothing is worth its price. `known` is how this robot may be, the likeliest
    /// first. What nobody could overlook in the rates of the standing robot comes first of all:
    /// looks at the body tell little before it is known.
    pub(super) fn chain(
        &self,
        known: Vec<State<'a>>,
        suspects: &[Suspect],
    ) -> Result<Chain<'a>, WalkError> {
        let most_effects = self.settings.most_effects;
        let mut held = Arc::new(known.first().cloned().ok_or(WalkError::Diverged)?);
        let mut effects: Vec<TracedEffect> = Vec::new();
        let mut candidates = Vec::new();
        while effects.len() < most_effects {
            let obvious = self.obvious(&held);
            let Some((effect, with_it)) = self.best_of(&held, &obvious)? else {
                break;
            };
            effects.push(effect);
            held = Arc::new(with_it);
            candidates = obvious;
        }
        let mut known = match effects.is_empty() {
            true => self
                .weighed(known, suspects, &[])?
                .ok_or(WalkError::Diverged)?,
            false => self.identified_again(&held, suspects)?,
        };
        while effects.len() < most_effects {
            candidates = self.round(&known)?;
            let Some((effect, with_it)) = self.best_of(&known.held, &candidates)? else {
                break;
            };
            effects.push(effect);
            known = self.identified_again(&with_it, suspects)?;
        }
        Ok(Chain {
            held: known.held,
            effects,
            candidates,
        })
    }

    /// The best of these effects that is worth its price, and the robot with it.
    fn best_of(
        &self,
        held: &State<'a>,
        judged: &[Judged<'a>],
    ) -> Result<Option<(TracedEffect, State<'a>)>, WalkError> {
        let contenders = self.contenders(held, judged)?;
        let Some((best, rivals)) = contenders.split_first() else {
            return Ok(None);
        };
        Ok(Some((self.traced(best, rivals), best.state.clone())))
    }

    /// The robot with the effects found, identified again.
    fn identified_again(
        &self,
        held: &State<'a>,
        suspects: &[Suspect],
    ) -> Result<Hypotheses<'a>, WalkError> {
        let mut again = self.search.with_effects(&held.model());
        again.extend_from_slice(suspects);
        again.extend(self.neighbours(&held.morphology));
        dedup(&mut again);
        let found = held.trial.effects.clone();
        self.weighed(vec![held.clone()], &again, &found)?
            .ok_or(WalkError::Diverged)
    }
}
