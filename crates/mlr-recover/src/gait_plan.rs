//! A gait by which feet swing when, and by where they stand.

use std::f64::consts::{PI, TAU};

use crate::{support::Ground, swing_order::SwingOrder};

/// A periodic gait of some legs, the body moving steadily but for a sway. All legs that stand push the
/// body along the same path, so that no foot has to slip.
///
/// The cycle has one slot for each group of the order, in which it swings first and then all feet stand.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitPlan {
    /// Which legs swing together. Those of no group do not walk.
    pub order: SwingOrder,
    /// Share of a slot during which its group swings.
    pub swing_share: f64,
    /// Duration of a cycle.
    pub period_s: f64,
    /// How far the body moves forward in a cycle.
    pub advance_m: f64,
    /// By how much it turns to the left in a cycle.
    pub turn_rad: f64,
    /// How high a foot is lifted.
    pub lift_m: f64,
    /// Height of the body's origin over the foot tips.
    pub body_height_m: f64,
    /// Where each foot of the robot stands in the middle of its stance, body frame, for a body that
    /// does not sway.
    pub stance_m: Vec<Ground>,
    /// Where the body is beside its steady path: amplitudes of the cosine and the sine of one and two
    /// cycles, along x and along y.
    pub sway_m: [[f64; 4]; 2],
}

/// Where a foot is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foot {
    /// Seen from above, body frame.
    pub(crate) at_m: Ground,
    /// Over the ground.
    pub(crate) height_m: f64,
}

/// How far a number of a plan may go, and what a step of its search is.
struct Bounded {
    low: f64,
    high: f64,
    step: f64,
}

const SWING_SHARE: Bounded = Bounded {
    low: 0.4,
    high: 0.95,
    step: 0.05,
};
const PERIOD_S: Bounded = Bounded {
    low: 0.6,
    high: 4.0,
    step: 0.1,
};
const LIFT_M: Bounded = Bounded {
    low: 0.02,
    high: 0.05,
    step: 0.004,
};
/// A step of an advance, as a share of it.
const ADVANCE_STEP: f64 = 0.1;
/// A step of a stance, and of an amplitude of the sway.
const STANCE_STEP_M: f64 = 0.01;
const SWAY_STEP_M: f64 = 0.005;

impl GaitPlan {
    /// The slot of the cycle in which a leg swings; `None` of a leg that does not walk.
    fn slot(&self, leg: usize) -> Option<usize> {
        self.order.iter().position(|group| group.contains(&leg))
    }

    /// The legs that walk, in ascending order.
    pub fn walking(&self) -> Vec<usize> {
        let mut legs = self.order.concat();
        legs.sort_unstable();
        legs
    }

    /// Share of the cycle during which a foot swings.
    fn swing_fraction(&self) -> f64 {
        self.swing_share / self.order.len() as f64
    }

    /// Share of the cycle during which a foot stands.
    pub fn duty_factor(&self) -> f64 {
        1.0 - self.swing_fraction()
    }

    /// Mean speed of the body.
    pub fn speed_m_per_s(&self) -> f64 {
        self.advance_m / self.period_s
    }

    /// The body beside its steady path.
    fn sway(&self, phase: f64) -> Ground {
        let (sin, cos) = libm::sincos(TAU * phase);
        let (sin2, cos2) = libm::sincos(2.0 * TAU * phase);
        self.sway_m
            .map(|[a, b, c, d]| a * cos + b * sin + c * cos2 + d * sin2)
    }

    /// Where a leg that walks has its foot; its stance for another one.
    pub(crate) fn foot(&self, leg: usize, phase: f64) -> Foot {
        let Some(slot) = self.slot(leg) else {
            return Foot {
                at_m: self.stance_m[leg],
                height_m: 0.0,
            };
        };
        let lifted = slot as f64 / self.order.len() as f64;
        let swing = self.swing_fraction();
        let since_lifted = phase - lifted - libm::floor(phase - lifted);
        // Cycles since the middle of the stance that the foot comes from.
        let since_middle = since_lifted + (1.0 - swing) / 2.0;
        let (at_m, height_m) = if since_lifted < swing {
            let share = since_lifted / swing;
            // On the ground the foot leaves and arrives at rest, in between no faster than it must.
            let moved = share * share * (3.0 - 2.0 * share);
            let old = self.foothold(leg, since_middle);
            let new = self.foothold(leg, since_middle - 1.0);
            let at_m = [0, 1].map(|axis| (1.0 - moved) * old[axis] + moved * new[axis]);
            let up = libm::sin(PI * share);
            (at_m, self.lift_m * up * up)
        } else {
            (self.foothold(leg, since_middle - 1.0), 0.0)
        };
        let [sway_x, sway_y] = self.sway(phase);
        Foot {
            at_m: [at_m[0] - sway_x, at_m[1] - sway_y],
            height_m,
        }
    }

    /// A place on the ground where a leg stands, so many cycles after the middle of its stance, for a
    /// body that does not sway.
    fn foothold(&self, leg: usize, cycles: f64) -> Ground {
        let path = self.path_m(cycles);
        let [x, y] = [0, 1].map(|axis| self.stance_m[leg][axis] - path[axis]);
        let (sin, cos) = libm::sincos(-cycles * self.turn_rad);
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Where a body that does not sway is after so many cycles: on an arc.
    fn path_m(&self, cycles: f64) -> Ground {
        let half_rad = cycles * self.turn_rad / 2.0;
        let (sin, cos) = libm::sincos(half_rad);
        let chord = match half_rad.abs() < 1e-9 {
            true => 1.0,
            false => sin / half_rad,
        };
        [cos, sin].map(|along| cycles * self.advance_m * chord * along)
    }

    /// Whether a leg stands, in the middle of whose group's swing the phase may be.
    pub(crate) fn stands(&self, leg: usize, swinging: usize) -> bool {
        self.slot(leg).is_some_and(|slot| slot != swinging)
    }

    /// Phases within the swing of a group, from its first to its last moment.
    pub(crate) fn swing_phases(&self, group: usize) -> impl Iterator<Item = f64> {
        let first = group as f64 / self.order.len() as f64;
        let swing = self.swing_fraction();
        (0..SAMPLES).map(move |k| first + swing * k as f64 / (SAMPLES - 1) as f64)
    }

    /// How many numbers a search changes.
    pub(crate) fn dimension(&self) -> usize {
        2 * self.walking().len() + 8 + 5
    }

    /// The same plan with each number moved by so many steps, within its bounds.
    pub(crate) fn moved(&self, steps: &[f64]) -> Self {
        let mut plan = self.moved_in_place(steps);
        let rest = &steps[(2 * self.walking().len() + 8).min(steps.len())..];
        let step = |index: usize| rest.get(index).copied().unwrap_or(0.0);
        plan.advance_m *= libm::exp(ADVANCE_STEP * step(0));
        plan.period_s = PERIOD_S.scaled(plan.period_s, step(1));
        plan.swing_share = SWING_SHARE.moved(plan.swing_share, step(2));
        plan.lift_m = LIFT_M.moved(plan.lift_m, step(3));
        plan.body_height_m *= libm::exp(0.05 * step(4));
        plan
    }

    /// The same where only stances and sway change.
    pub(crate) fn moved_in_place(&self, steps: &[f64]) -> Self {
        let mut plan = self.clone();
        let mut steps = steps.iter().copied();
        let mut next = || steps.next().unwrap_or(0.0);
        for leg in self.walking() {
            for axis in &mut plan.stance_m[leg] {
                *axis += STANCE_STEP_M * next();
            }
        }
        for amplitude in plan.sway_m.iter_mut().flatten() {
            *amplitude += SWAY_STEP_M * next();
        }
        plan
    }
}

/// Phases looked at within a swing.
pub(crate) const SAMPLES: usize = 5;

impl Bounded {
    fn moved(&self, value: f64, steps: f64) -> f64 {
        (value + self.step * steps).clamp(self.low, self.high)
    }

    fn scaled(&self, value: f64, steps: f64) -> f64 {
        (value * libm::exp(self.step * steps)).clamp(self.low, self.high)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    pub(crate) fn plan() -> GaitPlan {
        GaitPlan {
            order: vec![vec![0], vec![4], vec![1, 5], vec![3]],
            swing_share: 0.7,
            period_s: 1.4,
            advance_m: 0.09,
            turn_rad: 0.1,
            lift_m: 0.03,
            body_height_m: 0.09,
            stance_m: vec![
                [0.16, 0.15],
                [0.16, -0.15],
                [0.0, 0.19],
                [0.0, -0.19],
                [-0.16, 0.15],
                [-0.16, -0.15],
            ],
            sway_m: [[0.01, -0.01, 0.002, 0.0], [0.0, 0.02, 0.0, -0.004]],
        }
    }

    /// Where a foot is on the ground, for a body that moves as planned.
    fn on_ground(plan: &GaitPlan, leg: usize, phase: f64) -> Ground {
        let foot = plan.foot(leg, phase);
        let sway = plan.sway(phase);
        let [x, y] = [foot.at_m[0] + sway[0], foot.at_m[1] + sway[1]];
        let path = plan.path_m(phase);
        let (sin, cos) = libm::sincos(phase * plan.turn_rad);
        [cos * x - sin * y + path[0], sin * x + cos * y + path[1]]
    }

    proptest! {
        #[test]
        fn feet_are_continuous_and_periodic(leg in 0_usize..6, phase in 0.0..2.0_f64) {
            let plan = plan();
            let (foot, next) = (plan.foot(leg, phase), plan.foot(leg, phase + 1e-6));
            for axis in 0..2 {
                prop_assert!((foot.at_m[axis] - next.at_m[axis]).abs() < 1e-5);
                let later = plan.foot(leg, phase + 1.0);
                prop_assert!((foot.at_m[axis] - later.at_m[axis]).abs() < 1e-9);
            }
            prop_assert!((foot.height_m - next.height_m).abs() < 1e-5);
        }

        #[test]
        fn feet_that_stand_do_not_slip(group in 0_usize..4, share in 0.0..1.0_f64) {
            let plan = plan();
            let first = group as f64 / 4.0;
            let (early, late) = (first + 0.01 * share, first + share * 0.25);
            for leg in plan.walking().into_iter().filter(|leg| plan.stands(*leg, group)) {
                let (before, after) = (on_ground(&plan, leg, early), on_ground(&plan, leg, late));
                for axis in 0..2 {
                    prop_assert!((before[axis] - after[axis]).abs() < 1e-9);
                }
                prop_assert_eq!(plan.foot(leg, late).height_m, 0.0);
            }
        }
    }

    #[test]
    fn the_body_advances_by_what_is_planned() {
        let mut plan = plan();
        plan.turn_rad = 0.0;
        for leg in plan.walking() {
            let step = on_ground(&plan, leg, 1.0)[0] - on_ground(&plan, leg, 0.0)[0];
            assert!((step - plan.advance_m).abs() < 1e-9);
        }
        assert_eq!(plan.foot(2, 0.3), plan.foot(2, 0.8));
    }
}
