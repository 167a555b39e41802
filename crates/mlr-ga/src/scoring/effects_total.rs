//! Scores of explanations, added up.

use serde::Serialize;

use super::{
    effects::{EffectsScore, PlaceScore, UnansweredLog, Verdict},
    effects_truth::{LogClass, Origin},
    kind_calibration::KindCalibration,
    kinds::Statement,
    score::mean,
    visibility::Visibility,
};

/// All logs of one origin together.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectsTotal {
    /// Where the logs come from.
    pub origin: Origin,
    /// What became of the logs of each class that occurs.
    pub classes: Vec<ClassTotal>,
    /// Visible logs whose effects stand out of the spread between robots of one make.
    pub standing_out: Share,
    /// Logs with two effects or more of the library, not hidden ones; right: all were found,
    /// whatever else was.
    pub several_effects: Share,
    /// Effects of a leg that are not hidden.
    pub places: PlacesTotal,
    /// The probabilities of kinds; none where no log was answered.
    pub kinds: Option<KindsTotal>,
    /// The damaged legs.
    pub legs: LegsTotal,
    /// How long the answers took; none where no log was answered.
    pub elapsed_s: Option<Elapsed>,
}

/// What became of the logs of one class.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClassTotal {
    /// What there was to find.
    pub class: LogClass,
    /// Logs, those without an answer among them.
    pub logs: usize,
    /// Logs of each verdict, in the order of [`Verdict::ALL`].
    pub verdicts: [usize; Verdict::ALL.len()],
    /// Logs without an answer.
    pub unanswered: usize,
    /// Those marked as unexplained.
    pub unexplained: usize,
    /// Those that would be right without that mark.
    pub right_but_for_mark: usize,
    /// Mean logarithm of the probability of the truth.
    pub mean_ln_probability: Option<f64>,
    /// Median, over the logs, of the error with the effects over the one of the robot as described,
    /// on the unseen stretch.
    pub median_error_ratio: Option<f64>,
    /// The same against the error with the nuisance parameters fitted.
    pub median_calibrated_ratio: Option<f64>,
}

/// How many of some logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// All of them.
    pub logs: usize,
    /// Those that are right.
    pub right: usize,
}

/// Where effects of a leg were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlacesTotal {
    /// Effects of a leg in the robots.
    pub effects: usize,
    /// Of these, the kind was found.
    pub kind_found: usize,
    /// Of these, on the right leg.
    pub leg_right: usize,
    /// Of these, on the right link or joint as well.
    pub place_right: usize,
}

/// How good the probabilities of kinds are.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KindsTotal {
    /// Mean natural logarithm of the probability of the truth; see
    /// [`super::KindsScore::ln_probability`].
    pub mean_ln_probability: f64,
    /// Mean Brier score; see [`super::KindsScore::brier`].
    pub mean_brier: f64,
    /// Logs, and those whose 90 % credible set of kinds holds the truth.
    pub credible: Share,
    /// Median number of kinds in that set.
    pub median_credible_kinds: f64,
    /// Logs with a kind of more than 90 %, and those that have every such kind.
    pub sure: Share,
    /// Of the sure ones, those whose verdict is right.
    pub sure_and_right: usize,
    /// Of the statements of a certain probability, how many are true.
    pub calibration: Vec<KindCalibration>,
}

/// Logs whose damaged legs are right. One without an answer has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LegsTotal {
    /// All logs.
    pub logs: usize,
    /// Right as identified at first.
    pub right_before: usize,
    /// Right with the effects in place.
    pub right_after: usize,
    /// Right before and wrong after.
    pub lost: usize,
    /// Wrong before and right after.
    pub won: usize,
}

/// Times of answers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Elapsed {
    /// Median.
    pub median_s: f64,
    /// Largest.
    pub longest_s: f64,
}

impl EffectsTotal {
    /// Adds up all logs of one origin; `None` where there are none.
    pub fn new(
        origin: Origin,
        scores: &[EffectsScore],
        unanswered: &[UnansweredLog],
    ) -> Option<Self> {
        let scores: Vec<&EffectsScore> = scores.iter().filter(|s| s.origin == origin).collect();
        let unanswered: Vec<&UnansweredLog> =
            unanswered.iter().filter(|u| u.origin == origin).collect();
        if scores.is_empty() && unanswered.is_empty() {
            return None;
        }
        let findable: Vec<&EffectsScore> = scores
            .iter()
            .copied()
            .filter(|s| s.class.is_findable())
            .collect();
        let share = |is_counted: &dyn Fn(&EffectsScore) -> bool,
                     is_right: &dyn Fn(&EffectsScore) -> bool| {
            let logs: Vec<_> = findable.iter().filter(|s| is_counted(s)).collect();
            Share {
                logs: logs.len(),
                right: logs.iter().filter(|s| is_right(s)).count(),
            }
        };
        let classes = LogClass::ALL.into_iter().filter_map(|class| {
            let scores: Vec<_> = scores
                .iter()
                .copied()
                .filter(|s| s.class == class)
                .collect();
            let unanswered = unanswered.iter().filter(|u| u.class == class).count();
            ClassTotal::new(class, &scores, unanswered)
        });
        let elapsed_s: Vec<f64> = scores.iter().map(|s| s.elapsed_s).collect();
        Some(Self {
            origin,
            classes: classes.collect(),
            standing_out: share(&|s| s.visibility == Visibility::StandsOut, &|s| {
                s.verdict == Verdict::Right
            }),
            several_effects: share(&|s| s.truth.len() > 1, &EffectsScore::found_all),
            places: PlacesTotal::new(findable.iter().flat_map(|s| &s.places)),
            kinds: KindsTotal::new(&scores),
            legs: LegsTotal::new(&scores, unanswered.len()),
            elapsed_s: median(elapsed_s.clone()).map(|median_s| Elapsed {
                median_s,
                longest_s: elapsed_s.into_iter().fold(0.0, f64::max),
            }),
        })
    }
}

impl ClassTotal {
    fn new(class: LogClass, scores: &[&EffectsScore], unanswered: usize) -> Option<Self> {
        let logs = scores.len() + unanswered;
        let count = |is: &dyn Fn(&EffectsScore) -> bool| scores.iter().filter(|s| is(s)).count();
        let ratio = |before: &dyn Fn(&EffectsScore) -> f64| {
            let ratios = scores
                .iter()
                .map(|s| s.error_after.validation_deg / before(s));
            median(ratios.filter(|ratio| ratio.is_finite()).collect())
        };
        (logs > 0).then(|| Self {
            class,
            logs,
            verdicts: Verdict::ALL.map(|verdict| count(&|s| s.verdict == verdict)),
            unanswered,
            unexplained: count(&|s| s.unexplained),
            right_but_for_mark: count(&|s| {
                s.verdict != Verdict::Right && s.verdict_but_for_mark == Verdict::Right
            }),
            mean_ln_probability: (!scores.is_empty())
                .then(|| mean(scores.iter().map(|s| s.kinds.ln_probability))),
            median_error_ratio: ratio(&|s| s.error_before.validation_deg),
            median_calibrated_ratio: ratio(&|s| s.error_calibrated.validation_deg),
        })
    }
}

impl PlacesTotal {
    fn new<'a>(places: impl Iterator<Item = &'a PlaceScore>) -> Self {
        let mut total = Self {
            effects: 0,
            kind_found: 0,
            leg_right: 0,
            place_right: 0,
        };
        for place in places {
            total.effects += 1;
            total.kind_found += usize::from(place.kind_found);
            total.leg_right += usize::from(place.leg_right);
            total.place_right += usize::from(place.place_right);
        }
        total
    }
}

impl KindsTotal {
    fn new(scores: &[&EffectsScore]) -> Option<Self> {
        let count = |is: &dyn Fn(&EffectsScore) -> bool| scores.iter().filter(|s| is(s)).count();
        let is_sure = |s: &EffectsScore| !s.kinds.sure.is_empty();
        let statements: Vec<&Statement> = scores.iter().flat_map(|s| &s.kinds.statements).collect();
        let sizes = scores.iter().map(|s| s.kinds.credible.len() as f64);
        Some(Self {
            median_credible_kinds: median(sizes.collect())?,
            mean_ln_probability: mean(scores.iter().map(|s| s.kinds.ln_probability)),
            mean_brier: mean(scores.iter().map(|s| s.kinds.brier)),
            credible: Share {
                logs: scores.len(),
                right: count(&|s| s.kinds.credible_holds_truth),
            },
            sure: Share {
                logs: count(&is_sure),
                right: count(&|s| is_sure(s) && s.kinds.sure_is_true),
            },
            sure_and_right: count(&|s| is_sure(s) && s.verdict == Verdict::Right),
            calibration: KindCalibration::table(&statements),
        })
    }
}

impl LegsTotal {
    fn new(scores: &[&EffectsScore], unanswered: usize) -> Self {
        let count = |before: bool, after: bool| {
            let is = |s: &&&EffectsScore| (s.legs_right_before, s.legs_right) == (before, after);
            scores.iter().filter(is).count()
        };
        let (kept, lost, won) = (count(true, true), count(true, false), count(false, true));
        Self {
            logs: scores.len() + unanswered,
            right_before: kept + lost,
            right_after: kept + won,
            lost,
            won,
        }
    }
}

/// The mean of both middle ones where their number is even; `None` without any.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    let lower = *values.get(values.len().checked_sub(1)? / 2)?;
    Some(0.5 * (lower + upper))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoring::{
        effects::{Errors, FoundEffect},
        effects_truth::{TrueEffect, TrueKinds},
        kinds::KindsScore,
    };

    fn score(class: LogClass, verdict: Verdict) -> EffectsScore {
        let errors = |validation_deg| Errors {
            fit_deg: 1.0,
            validation_deg,
        };
        let truth = TrueKinds {
            effects: ["payload".to_string()].into(),
            locked: false,
        };
        let probabilities = [("payload".to_string(), 0.95), ("slope".to_string(), 0.05)];
        EffectsScore {
            log: "log".into(),
            origin: Origin::Drawn,
            class,
            truth: vec![TrueEffect {
                kind: "payload".into(),
                parameters: [].into(),
            }],
            visibility: Visibility::StandsOut,
            found: vec![FoundEffect {
                kind: "payload".into(),
                parameters: [].into(),
                probability: 0.95,
            }],
            unexplained: false,
            verdict,
            verdict_but_for_mark: verdict,
            places: Vec::new(),
            kinds: KindsScore::new(&probabilities.into(), &truth, false),
            error_before: errors(4.0),
            error_calibrated: errors(2.0),
            error_after: errors(1.0),
            legs_right_before: true,
            legs_right: verdict != Verdict::WrongLegs,
            links_right: true,
            elapsed_s: 10.0,
        }
    }

    fn drawn(scores: &[EffectsScore], unanswered: &[UnansweredLog]) -> EffectsTotal {
        EffectsTotal::new(Origin::Drawn, scores, unanswered).unwrap()
    }

    #[test]
    fn every_log_is_counted_once() {
        let unanswered = UnansweredLog {
            log: "short".into(),
            origin: Origin::Drawn,
            class: LogClass::Hidden,
            truth: Vec::new(),
            reason: "too short".into(),
        };
        let mut stand_in = score(LogClass::NotRecorded, Verdict::Right);
        stand_in.origin = Origin::StandIn;
        let scores = [
            score(LogClass::Visible, Verdict::Right),
            score(LogClass::Visible, Verdict::Missed),
            score(LogClass::Hidden, Verdict::Missed),
            score(LogClass::OutsideHidden, Verdict::Wrong),
            stand_in,
        ];
        let total = drawn(&scores, &[unanswered]);
        let logs = |class| {
            let of_class = total.classes.iter().find(|total| total.class == class);
            of_class.map_or([0, 0, 0], |c| [c.logs, c.verdicts[0], c.unanswered])
        };
        assert_eq!(logs(LogClass::Visible), [2, 1, 0]);
        assert_eq!(logs(LogClass::Hidden), [2, 0, 1]);
        assert_eq!(logs(LogClass::OutsideHidden), [1, 0, 0]);
        assert_eq!(logs(LogClass::NotRecorded), [0, 0, 0]);
        assert_eq!(total.classes.iter().map(|c| c.logs).sum::<usize>(), 5);
        for class in &total.classes {
            let judged: usize = class.verdicts.iter().sum();
            assert_eq!(judged + class.unanswered, class.logs);
        }
        let stand_ins = EffectsTotal::new(Origin::StandIn, &scores, &[]).unwrap();
        assert_eq!(stand_ins.classes.len(), 1);
        assert_eq!(EffectsTotal::new(Origin::StandIn, &scores[..4], &[]), None);
    }

    #[test]
    fn legs_are_lost_and_won() {
        let mut won = score(LogClass::Visible, Verdict::Right);
        won.legs_right_before = false;
        let kept = score(LogClass::Visible, Verdict::Right);
        let lost = score(LogClass::Visible, Verdict::WrongLegs);
        let legs = drawn(&[won, kept.clone(), kept, lost], &[]).legs;
        assert_eq!([legs.logs, legs.right_before, legs.right_after], [4, 3, 3]);
        assert_eq!([legs.lost, legs.won], [1, 1]);
    }

    #[test]
    fn medians_and_means_are_those_of_the_logs() {
        let mut slow = score(LogClass::Visible, Verdict::Right);
        slow.elapsed_s = 40.0;
        slow.error_after.validation_deg = 3.0;
        // Nothing was wrong with this one: no ratio.
        let mut perfect = score(LogClass::Visible, Verdict::Right);
        perfect.error_before.validation_deg = 0.0;
        let total = drawn(
            &[score(LogClass::Visible, Verdict::Right), slow, perfect],
            &[],
        );
        let elapsed_s = total.elapsed_s.unwrap();
        assert_eq!([elapsed_s.median_s, elapsed_s.longest_s], [10.0, 40.0]);
        assert_eq!(total.classes[0].median_error_ratio, Some(0.5));
        assert_eq!(total.classes[0].median_calibrated_ratio, Some(0.5));
        let kinds = total.kinds.unwrap();
        assert!((kinds.mean_ln_probability - 0.95_f64.ln()).abs() < 1e-12);
        assert!((kinds.median_credible_kinds - 1.0).abs() < 1e-12);
        assert_eq!([kinds.sure.logs, kinds.sure.right], [3, 3]);
    }

    #[test]
    fn a_mark_that_should_not_be_there_is_told_apart() {
        let mut marked = score(LogClass::Visible, Verdict::Partly);
        marked.unexplained = true;
        marked.verdict_but_for_mark = Verdict::Right;
        let right = score(LogClass::Visible, Verdict::Right);
        let class = &drawn(&[marked, right], &[]).classes[0];
        assert_eq!([class.unexplained, class.right_but_for_mark], [1, 1]);
        assert_eq!(class.verdicts[0], 1);
    }
}
