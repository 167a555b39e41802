//! How far a plan is from tipping, and whether its legs can do it.

use mlr_model::Robot;

use crate::{
    footholds::Footholds,
    gait_plan::{GaitPlan, SAMPLES},
    support::{Ground, distance_m, margin_m},
    what_is_left::WhatIsLeft,
};

/// What standing needs of a robot at one height of its body: masses, and where feet reach.
#[derive(Debug)]
pub(crate) struct Statics {
    legs: Vec<Footholds>,
    walking: Vec<usize>,
    /// Of the body with the legs that do not walk.
    resting_kg: f64,
    resting_moment: Ground,
    /// How fast a foot may turn about its hip.
    most_rad_per_s: f64,
}

/// A plan as statics see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Standing {
    /// Least static stability margin over the cycle.
    pub(crate) margin_m: f64,
    /// Share of the looked-at places of feet that are out of reach, too near to another leg's, or
    /// passed too fast.
    pub(crate) amiss: f64,
}

/// How high feet are lifted at first.
pub(crate) const LIFT_M: f64 = 0.035;
/// Distance of the lines from hip to foot of two legs, seen from above: twice the radius of a link, and
/// as much again.
const APART_M: f64 = 0.045;
/// Share of the servos' speed that swings may need of the first joint: others add to it.
const SPEED_SHARE: f64 = 0.75;
/// Over so much of the cycle is the speed of a foot taken.
const MOMENT: f64 = 0.005;

impl Statics {
    /// Of these legs that walk, with the body at this height.
    pub(crate) fn new(
        robot: &Robot,
        left: &WhatIsLeft,
        walking: &[usize],
        body_height_m: f64,
        lift_m: f64,
        most_turn_rad: f64,
    ) -> Self {
        let legs = robot.legs().iter();
        let (resting_kg, moment) = left.resting_mass(robot, walking, body_height_m);
        Self {
            legs: legs
                .map(|leg| Footholds::of(leg, body_height_m, lift_m, most_turn_rad))
                .collect(),
            walking: walking.to_vec(),
            resting_kg,
            resting_moment: [moment.x, moment.y],
            most_rad_per_s: SPEED_SHARE * robot.servo().speed_limit_rad_per_s,
        }
    }

    /// The legs that walk.
    pub(crate) fn walking(&self) -> &[usize] {
        &self.walking
    }

    /// The centre of mass with the feet of the walking legs at these places (body frame, in their
    /// order), and how many of them are out of reach. Those count as where they were meant to be.
    pub(crate) fn center_m(&self, feet_m: &[Ground]) -> (Ground, usize) {
        let mut out_of_reach = 0;
        let mut mass_kg = self.resting_kg;
        let mut moment = self.resting_moment;
        for (leg, at_m) in self.walking.iter().zip(feet_m) {
            let table = &self.legs[*leg];
            let of_leg = table.moment(*at_m).unwrap_or_else(|| {
                out_of_reach += 1;
                [0, 1].map(|axis| table.mass_kg * 0.5 * (table.hip_m[axis] + at_m[axis]))
            });
            mass_kg += table.mass_kg;
            moment = [moment[0] + of_leg[0], moment[1] + of_leg[1]];
        }
        (moment.map(|m| m / mass_kg), out_of_reach)
    }

    /// How many pairs of walking legs come too near to each other.
    pub(crate) fn too_near(&self, feet_m: &[Ground]) -> usize {
        let line = |index: usize| [self.legs[self.walking[index]].hip_m, feet_m[index]];
        let n = self.walking.len();
        let pairs = (0..n).flat_map(|one| (one + 1..n).map(move |other| (one, other)));
        pairs
            .filter(|(one, other)| distance_m(line(*one), line(*other)) < APART_M)
            .count()
    }

    /// How many feet of a group are too fast in the middle of their swing.
    fn too_fast(&self, plan: &GaitPlan, group: usize) -> usize {
        let Some(middle) = plan.swing_phases(group).nth(SAMPLES / 2) else {
            return 0;
        };
        let is_too_fast = |leg: &&usize| {
            let [before, after] =
                [middle - MOMENT, middle + MOMENT].map(|phase| plan.foot(**leg, phase).at_m);
            let hip_m = self.legs[**leg].hip_m;
            let moved_m = libm::hypot(after[0] - before[0], after[1] - before[1]);
            let lever_m = libm::hypot(before[0] - hip_m[0], before[1] - hip_m[1]);
            let rad_per_s = moved_m / lever_m.max(1e-6) / (2.0 * MOMENT * plan.period_s);
            rad_per_s > self.most_rad_per_s
        };
        plan.order[group].iter().filter(is_too_fast).count()
    }

    /// A plan over its cycle: while some legs swing it stands on the fewest.
    pub(crate) fn assess(&self, plan: &GaitPlan) -> Standing {
        let mut least_m = f64::INFINITY;
        let (mut amiss, mut looked_at) = (0, 0);
        let mut feet_m = Vec::with_capacity(self.walking.len());
        let mut standing_m = Vec::with_capacity(self.walking.len());
        for group in 0..plan.order.len() {
            amiss += self.too_fast(plan, group);
            for phase in plan.swing_phases(group) {
                feet_m.clear();
                standing_m.clear();
                for leg in &self.walking {
                    let at_m = plan.foot(*leg, phase).at_m;
                    feet_m.push(at_m);
                    if plan.stands(*leg, group) {
                        standing_m.push(at_m);
                    }
                }
                let (center_m, out_of_reach) = self.center_m(&feet_m);
                amiss += out_of_reach + self.too_near(&feet_m);
                looked_at += feet_m.len();
                least_m = least_m.min(margin_m(&standing_m, center_m));
            }
        }
        Standing {
            margin_m: least_m,
            amiss: amiss as f64 / looked_at.max(1) as f64,
        }
    }
}
