//! The final weights: evidence that no lucky walk decides.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::{Judged, Search, base::Base, kept_bare, race::likeliest, sort_judged};
use crate::walk::{
    mean_walk::{DRAWS, MeanWalks},
    observation::Observation,
};

/// Hypotheses with effects that are weighed so.
const MOST: usize = 8;

/// Walks that are drawn every time as long as hypotheses are looked for.
const DRAWS_AT_FIRST: usize = 48;
/// Robots that are so far behind the likeliest one in the logarithm of the likelihood are in question still, its power
/// being how much of that counts: weighed again on equal terms, robots of one log have changed by up to 45 beside each
/// other.
const IN_QUESTION: f64 = 50.0;
/// Hypotheses on each of these that are weighed again.
const ON_EACH: usize = 4;

/// Hypotheses by the mean of their walks, and others.
pub(super) struct Weighed<'a> {
    robots: Vec<OnRobot<'a>>,
    /// What fell behind before.
    others: Vec<Judged<'a>>,
}

/// Hypotheses on one robot that are weighed together: what their means get wrong is the same.
struct OnRobot<'a> {
    base: Arc<Base<'a>>,
    walks: MeanWalks<'a, 'a>,
    judged: Vec<Judged<'a>>,
}

impl OnRobot<'_> {
    /// That of its most promising hypothesis.
    fn ln_promise(&self) -> f64 {
        let each = self.judged.iter().map(|one| one.ln_promise);
        each.fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Judged<'_> {
    /// The same with so much more weight.
    fn shifted(self, ln_weight: f64) -> Self {
        Self {
            ln_weight: self.ln_weight + ln_weight,
            ln_promise: self.ln_promise + ln_weight,
            ..self
        }
    }
}

impl<'a> Weighed<'a> {
    /// All hypotheses, the most promising first.
    pub(super) fn all(&self) -> Vec<Judged<'a>> {
        let weighed = self.robots.iter().flat_map(|robot| &robot.judged);
        let mut all: Vec<Judged<'a>> = weighed.chain(&self.others).cloned().collect();
        sort_judged(&mut all);
        all
    }

    fn robot(
        &mut self,
        base: &Arc<Base<'a>>,
        of_means: &'a Observation<'a>,
        generator: &ChaCha8Rng,
    ) -> &mut OnRobot<'a> {
        let known = |robot: &OnRobot<'a>| Arc::ptr_eq(&robot.base, base);
        let index = self.robots.iter().position(known).unwrap_or_else(|| {
            self.robots.push(OnRobot {
                walks: base.mean_walks(of_means, generator),
                base: Arc::clone(base),
                judged: Vec::new(),
            });
            self.robots.len() - 1
        });
        &mut self.robots[index]
    }
}

impl<'a> Search<'a, '_> {
    /// The likeliest hypotheses, each once, by the mean of their walks. The others, which have fallen
    /// behind, change as much as these do in the mean.
    pub(super) fn weighed(&self, fitted: Vec<Judged<'a>>) -> Weighed<'a> {
        let (chosen, others) = self.likeliest_and_others(each_once(fitted));
        self.progress.expect_more(chosen.len());
        let mut weighed = Weighed {
            robots: Vec::new(),
            others,
        };
        for one in chosen {
            let robot = weighed.robot(&one.base, self.of_means, self.generator);
            robot.judged.push(one);
        }
        let before = weighed.robots.iter().flat_map(|robot| &robot.judged);
        let before: Vec<f64> = before.map(|one| one.ln_weight).collect();
        for robot in &mut weighed.robots {
            let on_it = std::mem::take(&mut robot.judged);
            self.weigh_on(robot, on_it, &[], DRAWS_AT_FIRST);
        }
        let now = weighed.robots.iter().flat_map(|robot| &robot.judged);
        let change = mean_change(now, &before);
        let others = std::mem::take(&mut weighed.others).into_iter();
        weighed.others = others.map(|one| one.shifted(change)).collect();
        weighed
    }

    /// Weighs further hypotheses on one robot, and again those that were weighed on it before and are
    /// `compared_with` them.
    pub(super) fn weigh_too(
        &self,
        weighed: &mut Weighed<'a>,
        on_one_robot: Vec<Judged<'a>>,
        compared_with: &[Judged<'a>],
    ) {
        let Some(first) = on_one_robot.first() else {
            return;
        };
        let is_new = |other: &Judged<'a>| !on_one_robot.iter().any(|one| one.is_same(other));
        weighed.others.retain(is_new);
        let robot = weighed.robot(&first.base, self.of_means, self.generator);
        self.weigh_on(robot, on_one_robot, compared_with, DRAWS_AT_FIRST);
    }

    /// Robots whose logarithm of the weight is less far behind the likeliest one's are in question.
    pub(super) fn in_question(&self) -> f64 {
        IN_QUESTION * self.of_means.power()
    }

    /// Weighs the robots that are in question, if there are several, again, by as many walks each, about the parameters that
    /// were found.
    ///
    /// What was looked at longer has more walks, and nearer to where they matter: it seems likelier for that alone.
    pub(super) fn on_equal_terms(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let best = weighed.robots.iter().map(OnRobot::ln_promise);
        let least = best.fold(f64::NEG_INFINITY, f64::max) - self.in_question();
        let robots = weighed.robots.iter_mut();
        let in_question: Vec<&mut OnRobot<'a>> =
            robots.filter(|robot| robot.ln_promise() > least).collect();
        if in_question.len() < 2 {
            return weighed;
        }
        for robot in in_question {
            let mut known = std::mem::take(&mut robot.judged);
            sort_judged(&mut known);
            let fallen_behind = known.split_off(ON_EACH.min(known.len()));
            let before: Vec<f64> = known.iter().map(|one| one.ln_weight).collect();
            self.progress.expect_more(known.len());
            robot.walks = robot.base.mean_walks(self.of_means, self.generator);
            self.weigh_on(robot, known, &[], DRAWS);
            let change = mean_change(&robot.judged, &before);
            weighed
                .others
                .extend(fallen_behind.into_iter().map(|one| one.shifted(change)));
        }
        weighed
    }

    /// Weighs further hypotheses on a robot by what the walks of the others on it tell too, and those others again: by
    /// new walks where the further ones are compared with them. About `draws` walks are drawn every time.
    fn weigh_on(
        &self,
        robot: &mut OnRobot<'a>,
        further: Vec<Judged<'a>>,
        compared_with: &[Judged<'a>],
        draws: usize,
    ) {
        let fitted = further.iter().map(|one| (&one.walker, &one.fit));
        let is_compared = |index: &usize| {
            let known = &robot.judged[*index];
            compared_with.iter().any(|one| one.is_same(known))
        };
        let anew: Vec<usize> = (0..robot.judged.len()).filter(is_compared).collect();
        robot.walks.average(fitted, &anew, draws, &());
        further.iter().for_each(|_| self.progress.advance());
        robot.judged.extend(further);
        self.judge_by_means(robot);
    }

    /// Those that are weighed, of hypotheses in order of their likelihood, and the rest.
    fn likeliest_and_others(&self, fitted: Vec<Judged<'a>>) -> (Vec<Judged<'a>>, Vec<Judged<'a>>) {
        let least = self.least_ln_promise(&fitted);
        let mut chosen = likeliest(&fitted, MOST);
        chosen.extend(kept_bare(fitted.iter().map(Judged::hypothesis)));
        let each = fitted.into_iter().enumerate();
        let (chosen, others): (Vec<_>, Vec<_>) =
            each.partition(|(k, one)| chosen.contains(k) && one.ln_promise > least);
        let without_index = |(_, one)| one;
        (
            chosen.into_iter().map(without_index).collect(),
            others.into_iter().map(without_index).collect(),
        )
    }

    fn judge_by_means(&self, robot: &mut OnRobot<'a>) {
        let usual = robot.walks.whitening();
        let with_unknown = self.of_means.with_unknown(usual);
        let missed_share = self.of_means.missed_share(robot.base.spread());
        for (one, fit) in robot.judged.iter_mut().zip(robot.walks.fits()) {
            match fit {
                Some(fit) => {
                    let ln_gain = fit.ln_gain_of_unknown(usual, &with_unknown);
                    let by_unknown = self
                        .prior
                        .ln_without_and_with_unknown(ln_gain, missed_share);
                    let (base, walker) = (&robot.base, one.walker.clone());
                    *one = self.judged(base, walker, fit.clone(), Some(by_unknown));
                }
                // Most of its neighbours do not walk.
                None => {
                    one.ln_weight = f64::NEG_INFINITY;
                    one.ln_promise = f64::NEG_INFINITY;
                }
            }
        }
    }
}

/// By how much the weights of hypotheses have changed in the mean, those left out that have none any more.
fn mean_change<'j, 'a: 'j>(
    now: impl IntoIterator<Item = &'j Judged<'a>>,
    ln_weights_before: &[f64],
) -> f64 {
    let each = now.into_iter().zip(ln_weights_before);
    let changes = each.map(|(one, before)| one.ln_weight - before);
    let changes: Vec<f64> = changes.filter(|change| change.is_finite()).collect();
    changes.iter().sum::<f64>() / changes.len().max(1) as f64
}

/// The likeliest fit of each hypothesis, the likeliest hypothesis first.
fn each_once(mut fitted: Vec<Judged<'_>>) -> Vec<Judged<'_>> {
    sort_judged(&mut fitted);
    let mut once: Vec<Judged<'_>> = Vec::new();
    for one in fitted {
        if !once.iter().any(|other| other.is_same(&one)) {
            once.push(one);
        }
    }
    once
}
