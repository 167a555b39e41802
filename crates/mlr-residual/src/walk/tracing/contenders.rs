//! The most promising candidates with the model calibrated around them, and which of them
//! comes first.

use super::{Tracing, judging::Judged, state::State};
use crate::walk::{Effort, WalkError};

/// Kinds of effect that are calibrated in full before one is added, and the robots on which
/// each is at most.
const CONTENDERS: usize = 3;
const ROBOTS_EACH: usize = 2;
/// How much more than the best contender a candidate may cost before it is calibrated.
const WITHIN: f64 = 40.0;

/// An effect and the state with it.
pub(super) struct Contender<'a> {
    pub(super) judged: Judged<'a>,
    pub(super) state: State<'a>,
}

impl Contender<'_> {
    /// What all contenders are measured by.
    pub(super) fn cost(&self) -> f64 {
        self.state.total + self.judged.price + self.judged.rarity
    }
}

impl<'a> Tracing<'a> {
    /// Those of the most promising candidates that are worth their price, best first; of a kind
    /// the one on the first robot on which it is.
    pub(super) fn contenders(
        &self,
        held: &State<'a>,
        judged: &[Judged<'a>],
    ) -> Result<Vec<Contender<'a>>, WalkError> {
        let mut contenders: Vec<Contender<'a>> = Vec::new();
        for kind in most_promising(judged) {
            let costs = contenders.iter().map(Contender::cost);
            let most = costs.fold(f64::INFINITY, f64::min) + WITHIN;
            let is_within = |candidate: &&Judged<'a>| self.as_tried(candidate).cost() < most;
            for candidate in kind.into_iter().filter(is_within) {
                let ways = self.accepted_ways(held, candidate)?.into_iter();
                let best = ways.min_by(|a, b| a.cost().total_cmp(&b.cost()));
                if let Some(best) = best {
                    contenders.push(best);
                    break;
                }
            }
        }
        contenders.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        Ok(contenders)
    }

    /// A candidate as it was tried and with the model calibrated around it, lost links gone and
    /// locked, wherever it is worth its price: what an effect gains, and which it is, may look
    /// otherwise then.
    fn accepted_ways(
        &self,
        held: &State<'a>,
        judged: &Judged<'a>,
    ) -> Result<Vec<Contender<'a>>, WalkError> {
        let mut ways = Vec::new();
        if judged.is_accepted() {
            ways.push(self.as_tried(judged));
        }
        let found = &judged.trial.effects;
        for state in self.ranked(std::slice::from_ref(&judged.suspect), found, None)? {
            ways.extend(self.calibrated_contender(held, judged, state)?);
        }
        Ok(ways)
    }

    fn as_tried(&self, judged: &Judged<'a>) -> Contender<'a> {
        Contender {
            state: self.with_trial(&judged.base, &judged.suspect, &judged.trial),
            judged: judged.clone(),
        }
    }

    /// A candidate as it is with the model calibrated around it, if it is worth its price
    /// then. What only this calibration gains, and would without the effect, is none of its
    /// gain.
    fn calibrated_contender(
        &self,
        held: &State<'a>,
        judged: &Judged<'a>,
        state: State<'a>,
    ) -> Result<Option<Contender<'a>>, WalkError> {
        let over = |before: &State<'a>| {
            self.judge(before, &judged.base, &judged.suspect, state.trial.clone())
        };
        let mut calibrated = over(held);
        if calibrated.is_accepted() && !judged.is_accepted() {
            let found = &held.trial.effects;
            let again =
                self.calibrated_from(&state.start(), &held.suspect(), found, Effort::Polls)?;
            if let Some(again) = again.filter(|again| again.total < held.total) {
                calibrated = over(&again);
            }
        }
        let contender = calibrated.is_accepted().then_some(Contender {
            judged: calibrated,
            state,
        });
        Ok(contender)
    }
}

/// The best candidates of the best kinds, each of a kind on another robot: without the effect,
/// none of the robots that it may be on is the likeliest for certain.
fn most_promising<'j, 'a>(judged: &'j [Judged<'a>]) -> Vec<Vec<&'j Judged<'a>>> {
    let mut kinds: Vec<Vec<&Judged<'a>>> = Vec::new();
    for judged in judged.iter().filter(|judged| judged.is_promising()) {
        let of_kind = |known: &Vec<&Judged<'a>>| known[0].kind() == judged.kind();
        match kinds.iter().position(of_kind) {
            Some(kind) => {
                let known = &mut kinds[kind];
                let is_known = known.iter().any(|other| other.suspect == judged.suspect);
                if known.len() < ROBOTS_EACH && !is_known {
                    known.push(judged);
                }
            }
            None if kinds.len() < CONTENDERS => kinds.push(vec![judged]),
            None => {}
        }
    }
    kinds
}
