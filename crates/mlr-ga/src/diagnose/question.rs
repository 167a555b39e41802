//! What a log leaves open.

use mlr_model::{LostLinks, Morphology};
use serde::Serialize;

use crate::Identification;

/// What a log leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenQuestion {
    /// The morphologies in question, most probable first.
    pub morphologies: Vec<OpenMorphology>,
}

/// One of the morphologies in question.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OpenMorphology {
    /// Which links are left.
    pub morphology: Morphology,
    /// Its probability among those in question.
    pub probability: f64,
    /// Probability that its lost links are locked and not gone; 0 where it lost none.
    pub locked_probability: f64,
}

/// A morphology whose lost links are gone or locked.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis<'q> {
    /// Which links are left.
    pub morphology: &'q Morphology,
    /// What the others have become.
    pub lost_links: LostLinks,
    /// All hypotheses sum to one.
    pub probability: f64,
}

/// A log whose morphology is known better than this leaves nothing to tell apart.
const SURE_NATS: f64 = 0.05;
/// Less probable morphologies are not asked about.
const LEAST_PROBABILITY: f64 = 0.01;

impl OpenQuestion {
    /// What an answer leaves open: the morphologies of at least one percent.
    pub fn of(answer: &Identification) -> Self {
        let best = OpenMorphology {
            morphology: answer.morphology.clone(),
            probability: answer.probability.max(f64::MIN_POSITIVE),
            locked_probability: answer.locked_probability.unwrap_or(0.0),
        };
        let others = answer.alternatives.iter().map(|other| OpenMorphology {
            morphology: other.morphology.clone(),
            probability: other.probability,
            locked_probability: other.locked_probability.unwrap_or(0.0),
        });
        let others = others.filter(|other| other.probability >= LEAST_PROBABILITY);
        let mut morphologies: Vec<_> = std::iter::once(best).chain(others).collect();
        morphologies.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let sum: f64 = morphologies.iter().map(|one| one.probability).sum();
        for one in &mut morphologies {
            one.probability /= sum;
        }
        Self { morphologies }
    }

    /// Entropy of the morphology and of what its lost links have become.
    pub fn entropy_nats(&self) -> f64 {
        entropy_nats(self.hypotheses().iter().map(|one| one.probability))
    }

    /// The morphologies with what their lost links may be, as far as that has at least one percent.
    pub fn hypotheses(&self) -> Vec<Hypothesis<'_>> {
        let each = self.morphologies.iter().flat_map(|one| {
            let gone = (LostLinks::Absent, 1.0 - one.locked_probability);
            let locked = (LostLinks::Locked, one.locked_probability);
            [gone, locked].map(|(lost_links, share)| Hypothesis {
                morphology: &one.morphology,
                lost_links,
                probability: share * one.probability,
            })
        });
        let mut kept: Vec<_> = each
            .filter(|one| one.probability >= LEAST_PROBABILITY)
            .collect();
        let sum: f64 = kept.iter().map(|one| one.probability).sum();
        for one in &mut kept {
            one.probability /= sum;
        }
        kept
    }

    /// Whether the morphology is known: what its lost links have become is not asked for its own sake.
    pub fn is_sure(&self) -> bool {
        let of_morphologies = self.morphologies.iter().map(|one| one.probability);
        self.hypotheses().len() < 2 || entropy_nats(of_morphologies) < SURE_NATS
    }

    /// The legs, from 0, of which not the same links are left by all morphologies.
    pub fn legs_in_doubt(&self) -> Vec<usize> {
        let Some(best) = self.morphologies.first() else {
            return Vec::new();
        };
        let legs = 0..best.morphology.legs();
        let in_doubt = |leg: &usize| {
            let mut others = self.morphologies.iter();
            let remaining = best.morphology.remaining(*leg);
            others.any(|other| other.morphology.remaining(*leg) != remaining)
        };
        legs.filter(in_doubt).collect()
    }
}

pub(super) fn entropy_nats(probabilities: impl Iterator<Item = f64>) -> f64 {
    let positive = probabilities.filter(|p| *p > 0.0);
    0.0 - positive.map(|p| p * p.ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use mlr_model::Robot;

    use super::*;

    fn question(each: &[(&str, f64, f64)]) -> OpenQuestion {
        let layout = Robot::jethexa().layout();
        let open = each
            .iter()
            .map(|(text, probability, locked)| OpenMorphology {
                morphology: Morphology::parse(text, &layout).unwrap(),
                probability: *probability,
                locked_probability: *locked,
            });
        OpenQuestion {
            morphologies: open.collect(),
        }
    }

    #[test]
    fn legs_in_doubt_are_those_that_morphologies_differ_by() {
        let open = question(&[
            ("111 111 110 000 111 111", 0.5, 0.0),
            ("111 111 100 000 111 111", 0.3, 0.0),
            ("111 111 100 000 111 110", 0.2, 0.0),
        ]);
        assert_eq!(open.legs_in_doubt(), [2, 5]);
        assert!(!open.is_sure());
    }

    #[test]
    fn lost_links_are_gone_or_locked_as_far_as_that_is_in_question() {
        let open = question(&[
            ("111 111 110 111 111 111", 0.7, 0.5),
            ("111 111 100 111 111 111", 0.3, 0.001),
        ]);
        let hypotheses = open.hypotheses();
        let kinds: Vec<_> = hypotheses.iter().map(|one| one.lost_links).collect();
        assert_eq!(
            kinds,
            [LostLinks::Absent, LostLinks::Locked, LostLinks::Absent]
        );
        let sum: f64 = hypotheses.iter().map(|one| one.probability).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        // What they have become is one more thing not to know, but no reason to ask by itself.
        let known = question(&[("111 111 110 111 111 111", 1.0, 0.5)]);
        assert!((known.entropy_nats() - 2.0_f64.ln()).abs() < 1e-12);
        assert!(known.is_sure());
    }
}
