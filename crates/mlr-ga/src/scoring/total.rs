use std::collections::BTreeMap;

use mlr_model::Gait;
use serde::Serialize;

use super::{LogScore, score::mean};

/// Many answers against the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TotalScore {
    /// Logs that were answered.
    pub answered: usize,
    /// Logs that could not be.
    pub unanswered: usize,
    /// Answers that name exactly the damaged legs.
    pub legs_right: usize,
    /// Answers that are right in every link.
    pub links_right: usize,
    /// Answers whose truth is listed.
    pub covered: usize,
    /// Median number of morphologies listed.
    pub median_listed: usize,
    /// Mean Brier score of the legs' probabilities.
    pub brier: f64,
    /// Of the answers given with a certain confidence, how many are right.
    pub calibration: Vec<Calibration>,
    /// Which leg groups were taken for which.
    pub confusion: Vec<Confusion>,
    /// Mean time of an answer.
    pub mean_elapsed_s: f64,
    /// Longest time of an answer.
    pub longest_elapsed_s: f64,
}

/// Answers whose confidence lies in one interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Calibration {
    /// Confidence at least, and below.
    pub confidence: [f64; 2],
    /// Answers.
    pub answers: usize,
    /// Mean confidence.
    pub mean_confidence: f64,
    /// Share of them whose legs are right.
    pub legs_right_share: f64,
}

/// How often damage to some leg groups was taken for damage to others. A group's
/// legs swing together.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Confusion {
    /// Damaged legs per group, as in "A2 B1"; "healthy" without any. Their number alone where
    /// the gait is a joint trajectory, which knows no groups.
    pub truth: String,
    /// The same of the answer.
    pub answer: String,
    /// Answers of this kind.
    pub count: usize,
    /// Those of them whose legs are right.
    pub legs_right: usize,
}

/// Bounds of the confidence intervals.
const CONFIDENCE: [f64; 6] = [0.0, 0.5, 0.7, 0.9, 0.99, 1.000_001];

impl TotalScore {
    /// The sum of some scores; `unanswered` logs had no answer.
    pub fn new(scores: &[LogScore], unanswered: usize, gait: &Gait) -> Self {
        let count = |is: fn(&LogScore) -> bool| scores.iter().filter(|score| is(score)).count();
        let mut listed: Vec<usize> = scores.iter().map(|score| score.listed).collect();
        listed.sort_unstable();
        Self {
            answered: scores.len(),
            unanswered,
            legs_right: count(|score| score.legs_right),
            links_right: count(|score| score.links_right),
            covered: count(|score| score.covered),
            median_listed: listed.get(listed.len() / 2).copied().unwrap_or(0),
            brier: mean(scores.iter().map(|score| score.brier)),
            calibration: calibration(scores),
            confusion: confusion(scores, gait),
            mean_elapsed_s: mean(scores.iter().map(|score| score.elapsed_s)),
            longest_elapsed_s: scores.iter().map(|s| s.elapsed_s).fold(0.0, f64::max),
        }
    }
}

fn calibration(scores: &[LogScore]) -> Vec<Calibration> {
    CONFIDENCE
        .windows(2)
        .filter_map(|bounds| {
            let within: Vec<&LogScore> = scores
                .iter()
                .filter(|score| (bounds[0]..bounds[1]).contains(&score.confidence))
                .collect();
            (!within.is_empty()).then(|| Calibration {
                confidence: [bounds[0], bounds[1].min(1.0)],
                answers: within.len(),
                mean_confidence: mean(within.iter().map(|score| score.confidence)),
                legs_right_share: mean(
                    within
                        .iter()
                        .map(|score| f64::from(u8::from(score.legs_right))),
                ),
            })
        })
        .collect()
}

fn confusion(scores: &[LogScore], gait: &Gait) -> Vec<Confusion> {
    let mut pairs: BTreeMap<(String, String), (usize, usize)> = BTreeMap::new();
    for score in scores {
        let pair = (
            per_group(&score.true_damaged_legs, gait),
            per_group(&score.damaged_legs, gait),
        );
        let entry = pairs.entry(pair).or_default();
        entry.0 += 1;
        entry.1 += usize::from(score.legs_right);
    }
    pairs
        .into_iter()
        .map(|((truth, answer), (count, legs_right))| Confusion {
            truth,
            answer,
            count,
            legs_right,
        })
        .collect()
}

/// Damaged legs by group; groups are named in the order in which they swing.
fn per_group(damaged_legs: &[usize], gait: &Gait) -> String {
    if damaged_legs.is_empty() {
        return "healthy".into();
    }
    let Some(feet) = gait.feet() else {
        return damaged_legs.len().to_string();
    };
    let mut phases: Vec<f64> = feet.phase_offsets.clone();
    phases.sort_by(f64::total_cmp);
    phases.dedup();
    let groups: Vec<String> = ('A'..='Z')
        .zip(&phases)
        .filter_map(|(name, phase)| {
            let damaged = damaged_legs
                .iter()
                .filter(|&&leg| feet.phase_offsets.get(leg - 1) == Some(phase))
                .count();
            (damaged > 0).then(|| format!("{name}{damaged}"))
        })
        .collect();
    groups.join(" ")
}

#[cfg(test)]
mod tests {
    use mlr_model::{JointTrajectory, Morphology, Motion, Robot};

    use super::*;

    fn without(legs: &[usize]) -> Morphology {
        let healthy = Morphology::healthy(&Robot::jethexa().layout());
        let lose = |morphology: Morphology, leg: &usize| morphology.without_leg(leg - 1);
        legs.iter().fold(healthy, lose)
    }

    fn score(truth: &[usize], answer: &[usize], confidence: f64) -> LogScore {
        LogScore {
            log: String::new(),
            true_damaged_legs: truth.into(),
            damaged_legs: answer.into(),
            true_morphology: without(truth),
            morphology: without(answer),
            legs_right: truth == answer,
            links_right: false,
            covered: true,
            listed: 3,
            leg_damage_probability: Vec::new(),
            brier: 0.1,
            confidence,
            something_else_probability: Some(0.0),
            error_deg: [0.0; 3],
            mean_error_deg: 0.0,
            motion_deg: [0.0; 3],
            elapsed_s: 1.0,
        }
    }

    #[test]
    fn groups_are_those_that_swing_together() {
        let tripod = Gait::tripod();
        assert_eq!(per_group(&[1, 4, 5], &tripod), "A3");
        assert_eq!(per_group(&[1, 2, 3], &tripod), "A1 B2");
        assert_eq!(per_group(&[], &tripod), "healthy");
        // A joint trajectory says nothing about groups.
        let joints = JointTrajectory::commanded(&Robot::jethexa(), &tripod, 3.0).unwrap();
        let rows = Gait {
            motion: Motion::Joints(joints),
            ..tripod
        };
        assert_eq!(per_group(&[1, 2, 3], &rows), "3");
        assert_eq!(per_group(&[], &rows), "healthy");
    }

    #[test]
    fn counts_and_calibration() {
        let scores = [
            score(&[3], &[3], 0.95),
            score(&[3], &[2], 0.92),
            score(&[1, 4], &[1, 4], 0.999),
        ];
        let total = TotalScore::new(&scores, 1, &Gait::tripod());
        assert_eq!(
            (total.answered, total.unanswered, total.legs_right),
            (3, 1, 2)
        );
        assert_eq!(total.calibration.len(), 2);
        assert_eq!(total.calibration[0].legs_right_share, 0.5);
        let mistaken = total.confusion.iter().find(|c| c.truth == "B1").unwrap();
        assert_eq!((mistaken.count, mistaken.legs_right), (2, 1));
    }
}
