use crate::what_is_left::WhatIsLeft;

/// What may be left of a robot, each case with its probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    most_probable: WhatIsLeft,
    /// That one included. The probabilities are positive and sum to 1.
    cases: Vec<(WhatIsLeft, f64)>,
}

/// A leg that can walk with a probability between these may as well not.
const DOUBTFUL: std::ops::Range<f64> = 0.05..0.95;

impl Diagnosis {
    /// What is left is known.
    pub fn certain(left: WhatIsLeft) -> Self {
        Self {
            most_probable: left.clone(),
            cases: vec![(left, 1.0)],
        }
    }

    /// Cases with their weights, the first of which is taken where no other weighs more. Cases without
    /// weight are left out.
    pub fn new(first: WhatIsLeft, weight: f64, others: Vec<(WhatIsLeft, f64)>) -> Self {
        let weighs = |(_, weight): &(WhatIsLeft, f64)| *weight > 0.0 && weight.is_finite();
        let all = std::iter::once((first.clone(), weight)).chain(others);
        let mut cases: Vec<(WhatIsLeft, f64)> = all.filter(weighs).collect();
        cases.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let total: f64 = cases.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut cases {
            *weight /= total;
        }
        match cases.first() {
            Some((most_probable, _)) => Self {
                most_probable: most_probable.clone(),
                cases,
            },
            None => Self::certain(first),
        }
    }

    /// What is left most probably.
    pub fn most_probable(&self) -> &WhatIsLeft {
        &self.most_probable
    }

    /// How many cases there are.
    pub fn cases(&self) -> usize {
        self.cases.len()
    }

    /// The case that a share of all probability, from 0 to 1, falls into.
    pub fn at(&self, share: f64) -> &WhatIsLeft {
        let mut left = share;
        for (case, probability) in &self.cases {
            left -= probability;
            if left <= 0.0 {
                return case;
            }
        }
        &self.most_probable
    }

    /// Sets of legs that may walk, of so many: all that probably can, the same without those that may
    /// not be able to, and without those that are weak.
    pub(crate) fn walking_sets(&self, legs: usize) -> Vec<Vec<usize>> {
        let probability = |leg: usize| -> f64 {
            let able = self.cases.iter().filter(|(case, _)| case.can_walk(leg));
            able.map(|(_, probability)| probability).sum()
        };
        let weak = |leg: usize| self.cases.iter().any(|(case, _)| case.is_weak(leg));
        let able: Vec<usize> = (0..legs).filter(|leg| probability(*leg) >= 0.5).collect();
        let without = |left_out: &dyn Fn(usize) -> bool| -> Vec<usize> {
            able.iter().copied().filter(|leg| !left_out(*leg)).collect()
        };
        let sets = [
            able.clone(),
            without(&|leg| DOUBTFUL.contains(&probability(leg))),
            without(&weak),
        ];
        let mut different: Vec<Vec<usize>> = Vec::new();
        for set in sets {
            if !different.contains(&set) {
                different.push(set);
            }
        }
        different
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Fault, Morphology, Robot};

    use super::*;

    fn lost(legs: &str) -> WhatIsLeft {
        let layout = Robot::jethexa().layout();
        WhatIsLeft::of(Morphology::parse_legs_lost(legs, &layout).unwrap())
    }

    #[test]
    fn cases_are_drawn_by_their_probabilities() {
        let diagnosis = Diagnosis::new(lost("3"), 1.0, vec![(lost("4"), 3.0), (lost("5"), 0.0)]);
        assert_eq!(diagnosis.most_probable(), &lost("4"));
        assert_eq!(diagnosis.cases(), 2);
        assert_eq!(diagnosis.at(0.7), &lost("4"));
        assert_eq!(diagnosis.at(0.8), &lost("3"));
        // Without any weight the first is as good as any.
        let nothing = Diagnosis::new(lost("3"), 0.0, vec![(lost("4"), f64::NAN)]);
        assert_eq!(nothing, Diagnosis::certain(lost("3")));
    }

    #[test]
    fn doubtful_and_weak_legs_walk_or_do_not() {
        let certain = Diagnosis::certain(lost("3"));
        assert_eq!(certain.walking_sets(6), [vec![0, 1, 3, 4, 5]]);
        let doubtful = Diagnosis::new(lost("3"), 0.7, vec![(lost("3,4"), 0.3)]);
        assert_eq!(
            doubtful.walking_sets(6),
            [vec![0, 1, 3, 4, 5], vec![0, 1, 4, 5]]
        );
        let weak = WhatIsLeft {
            faults: vec![Fault::WeakLeg { leg: 2, gain: 0.3 }],
            ..lost("")
        };
        let weak = Diagnosis::certain(weak).walking_sets(6);
        assert_eq!(weak, [vec![0, 1, 2, 3, 4, 5], vec![0, 2, 3, 4, 5]]);
        let stuck = WhatIsLeft {
            faults: vec![Fault::StuckJoint {
                leg: 1,
                joint: 2,
                angle_rad: 0.5,
            }],
            ..lost("")
        };
        let stuck = Diagnosis::certain(stuck).walking_sets(6);
        assert_eq!(stuck, [vec![1, 2, 3, 4, 5]]);
    }
}
