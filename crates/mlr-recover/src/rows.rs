//! Joint angles of a plan, row by row.

use mlr_model::{JointTrajectory, LEAST_JERK_PEAK, Leg, Robot, kinematics, least_jerk_share};
use nalgebra::Point3;
use thiserror::Error;

use crate::{
    first_steps::{FirstSteps, seen_from},
    gait_plan::GaitPlan,
    statics::{LIFT_M, Statics},
    support::{Ground, margin_m},
    what_is_left::WhatIsLeft,
};

/// Why the joints of a robot cannot follow a plan. Legs from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NotFollowed {
    /// A foot is out of reach.
    #[error("leg {} does not reach its foothold", .0 + 1)]
    Reach(usize),
    /// A joint turns too far from the leg's posture.
    #[error("a joint of leg {} would turn too far", .0 + 1)]
    Turn(usize),
    /// A servo is too slow.
    #[error("a servo of leg {} is too slow", .0 + 1)]
    Speed(usize),
}

/// A robot whose joints follow plans.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Joints<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) left: &'a WhatIsLeft,
    /// No joint turns further from the posture of its leg.
    pub(crate) most_turn_rad: f64,
}

/// Greatest speed of a joint over that of its servo: what is left follows delays.
const SPEED_SHARE: f64 = 0.9;
/// What is too fast is slowed down by this factor, so many times.
const SLOWED: f64 = 1.08;
const MOST_SLOWED: usize = 16;
/// On the way into the gait, joints may turn so much further.
const ONCE_TURN: f64 = 1.5;
/// The body is moved over its feet so fast at most.
const BODY_M_PER_S: f64 = 0.12;
/// How long a move of the body takes at least, a step, and the folding of a leg.
const MOVE_S: f64 = 0.3;
const STEP_S: f64 = 0.5;
const FOLD_S: f64 = 0.8;
/// Height of a step on the way into the gait.
const STEP_M: f64 = 0.03;

/// The angles of a leg's joints that were commanded to these.
pub(crate) fn reached_rad(leg: &Leg, commanded_rad: &[f64]) -> Vec<f64> {
    let each = commanded_rad.iter().zip(&leg.joint_zeros_rad);
    each.map(|(angle_rad, zero_rad)| angle_rad + zero_rad)
        .collect()
}

/// Rows that grow, leg by leg.
struct Rows<'a> {
    joints: Joints<'a>,
    plan: &'a GaitPlan,
    hold_s: f64,
    /// Motions that are no gait take so many times as long.
    slowness: f64,
    most_turn_rad: f64,
    walking: Vec<usize>,
    /// The last row, leg by leg.
    now_rad: Vec<Vec<f64>>,
    rows_rad: Vec<Vec<f64>>,
}

impl<'a> Joints<'a> {
    /// What standing on these legs needs, with the body at this height.
    pub(crate) fn statics(&self, walking: &[usize], body_height_m: f64) -> Statics {
        Statics::new(
            self.robot,
            self.left,
            walking,
            body_height_m,
            LIFT_M,
            self.most_turn_rad,
        )
    }

    /// The gait alone: from a stand where its cycle begins, over a start in which the cycle runs ever
    /// faster, to the cycle that repeats.
    ///
    /// # Errors
    /// [`NotFollowed`].
    pub(crate) fn of_gait(&self, plan: &GaitPlan) -> Result<JointTrajectory, NotFollowed> {
        let mut rows = Rows::new(*self, plan);
        for leg in 0..rows.now_rad.len() {
            rows.now_rad[leg] = self.left.folded_rad(self.robot, leg, plan.body_height_m);
        }
        rows.gait_at(0.0)?;
        rows.push();
        rows.gait()
    }

    /// The plan with a cycle that takes so long that the servos can follow.
    ///
    /// # Errors
    /// [`NotFollowed`] where that does not help.
    pub(crate) fn slowed(&self, mut plan: GaitPlan) -> Result<GaitPlan, NotFollowed> {
        for _ in 0..MOST_SLOWED {
            match self.of_gait(&plan) {
                Err(NotFollowed::Speed(_)) => plan.period_s *= SLOWED,
                Err(error) => return Err(error),
                Ok(_) => return Ok(plan),
            }
        }
        self.of_gait(&plan).map(|_| plan)
    }

    /// Least static stability margin of a plan over its cycle.
    ///
    /// # Errors
    /// [`NotFollowed`].
    pub(crate) fn margin_m(&self, plan: &GaitPlan) -> Result<f64, NotFollowed> {
        let mut rows = Rows::new(*self, plan);
        let height_m = plan.body_height_m;
        let resting = self.left.resting_mass(self.robot, &rows.walking, height_m);
        let mut least_m = f64::INFINITY;
        for group in 0..plan.order.len() {
            for phase in plan.swing_phases(group) {
                rows.gait_at(phase)?;
                let (mut mass_kg, mut moment) = resting;
                for leg in &rows.walking {
                    let described = &self.robot.legs()[*leg];
                    let of_leg = kinematics::mass_moment(described, &rows.reached_rad(*leg));
                    mass_kg += of_leg.0;
                    moment += of_leg.1;
                }
                let standing = rows.walking.iter().filter(|leg| plan.stands(**leg, group));
                let standing: Vec<Ground> =
                    standing.map(|leg| plan.foot(*leg, phase).at_m).collect();
                let center_m = [moment.x / mass_kg, moment.y / mass_kg];
                least_m = least_m.min(margin_m(&standing, center_m));
            }
        }
        Ok(least_m)
    }

    /// The gait from the robot's nominal stance on.
    ///
    /// # Errors
    /// [`NotFollowed`].
    pub(crate) fn whole(
        &self,
        stance_rad: &[Vec<f64>],
        plan: &GaitPlan,
        first: &FirstSteps,
    ) -> Result<JointTrajectory, NotFollowed> {
        let mut slowness = 1.0;
        for _ in 0..MOST_SLOWED {
            let rows = self.first_steps(stance_rad, plan, first, slowness)?;
            if rows.check_speed().is_ok() {
                return rows.gait();
            }
            slowness *= SLOWED;
        }
        self.first_steps(stance_rad, plan, first, slowness)?.gait()
    }

    /// The way into the gait, each of whose motions takes so many times as long as it should.
    fn first_steps<'p>(
        &self,
        stance_rad: &[Vec<f64>],
        plan: &'p GaitPlan,
        first: &FirstSteps,
        slowness: f64,
    ) -> Result<Rows<'p>, NotFollowed>
    where
        'a: 'p,
    {
        let mut rows = Rows::new(*self, plan);
        rows.slowness = slowness;
        rows.most_turn_rad *= ONCE_TURN;
        rows.now_rad = stance_rad.to_vec();
        rows.push();
        rows.first_steps(first)?;
        rows.most_turn_rad = self.most_turn_rad;
        Ok(rows)
    }
}

impl<'a> Rows<'a> {
    fn new(joints: Joints<'a>, plan: &'a GaitPlan) -> Self {
        Self {
            joints,
            plan,
            hold_s: joints.robot.servo().command_hold_s,
            slowness: 1.0,
            most_turn_rad: joints.most_turn_rad,
            walking: plan.walking(),
            now_rad: vec![Vec::new(); joints.robot.legs().len()],
            rows_rad: Vec::new(),
        }
    }

    fn push(&mut self) {
        self.rows_rad.push(self.now_rad.concat());
    }

    fn place(&mut self, leg: usize, target: Point3<f64>) -> Result<(), NotFollowed> {
        let described = &self.joints.robot.legs()[leg];
        let angles_rad =
            kinematics::inverse(described, target).map_err(|_| NotFollowed::Reach(leg))?;
        let most_rad = self.most_turn_rad;
        let mut each = described.links.iter().zip(&angles_rad);
        if each.any(|(link, angle_rad)| (angle_rad - link.posture_rad).abs() > most_rad) {
            return Err(NotFollowed::Turn(leg));
        }
        // What is known of a joint's zero is taken out of its command.
        let each = angles_rad.iter().zip(&described.joint_zeros_rad);
        self.now_rad[leg] = each
            .map(|(angle_rad, zero_rad)| angle_rad - zero_rad)
            .collect();
        Ok(())
    }

    /// The angles that a leg has in the last row.
    fn reached_rad(&self, leg: usize) -> Vec<f64> {
        reached_rad(&self.joints.robot.legs()[leg], &self.now_rad[leg])
    }

    fn gait_at(&mut self, phase: f64) -> Result<(), NotFollowed> {
        for index in 0..self.walking.len() {
            let leg = self.walking[index];
            let foot = self.plan.foot(leg, phase);
            let height_m = foot.height_m;
            let target = seen_from([0.0; 2], foot.at_m, height_m, self.plan.body_height_m);
            self.place(leg, target)?;
        }
        Ok(())
    }

    /// From the pose in which the cycle begins to its end.
    fn gait(mut self) -> Result<JointTrajectory, NotFollowed> {
        let cycle = self.cycle_rows();
        // The phase runs ever faster over the time of a cycle, in which half a cycle passes.
        for row in 1..=cycle {
            let t = row as f64 / cycle as f64;
            self.gait_at(t * t * t * (1.0 - t / 2.0))?;
            self.push();
        }
        self.check_speed()?;
        let first = self.rows_rad.len();
        for row in 1..=cycle {
            self.gait_at(0.5 + row as f64 / cycle as f64)?;
            self.push();
        }
        let end = self.rows_rad.len();
        self.check_speed()?;
        // Angles of inverse kinematics within the joints' range, a row each for one command.
        JointTrajectory::new(self.hold_s, self.rows_rad, Some(first..end))
            .map_err(|_| NotFollowed::Turn(self.walking.first().copied().unwrap_or(0)))
    }

    fn cycle_rows(&self) -> usize {
        libm::round(self.plan.period_s / self.hold_s).max(2.0) as usize
    }

    /// No servo is asked for more than its speed.
    fn check_speed(&self) -> Result<(), NotFollowed> {
        let most_rad = SPEED_SHARE * self.joints.robot.servo().speed_limit_rad_per_s * self.hold_s;
        for pair in self.rows_rad.windows(2) {
            let [from, to] = pair else { continue };
            let mut joint = 0;
            for (leg, described) in self.joints.robot.legs().iter().enumerate() {
                for _ in &described.links {
                    if (to[joint] - from[joint]).abs() > most_rad {
                        return Err(NotFollowed::Speed(leg));
                    }
                    joint += 1;
                }
            }
        }
        Ok(())
    }

    /// Folds the legs that do not walk and steps to where the gait begins.
    fn first_steps(&mut self, first: &FirstSteps) -> Result<(), NotFollowed> {
        let legs = self.joints.robot.legs();
        let stood: Vec<Point3<f64>> = legs
            .iter()
            .zip(&self.now_rad)
            .map(|(leg, angles_rad)| kinematics::foot_tip(leg, &reached_rad(leg, angles_rad)))
            .collect();
        let mut feet: Vec<Ground> = stood.iter().map(|tip| [tip.x, tip.y]).collect();
        let before_m = self.walking.iter().map(|leg| -stood[*leg].z);
        let before_m = before_m.fold(0.0, f64::max);
        let folding: Vec<usize> = (0..legs.len())
            .filter(|leg| !self.walking.contains(leg))
            .collect();
        // Legs that have lost links carry nothing: they are folded while the body moves.
        let morphology = &self.joints.left.morphology;
        let (whole, lost): (Vec<usize>, Vec<usize>) = folding
            .into_iter()
            .partition(|leg| morphology.remaining(*leg) == morphology.links(*leg));
        let height_m = self.plan.body_height_m;
        self.fold(&lost, |rows, share| {
            let body_m = first.begin_m.map(|way| share * way);
            let height_m = before_m + share * (height_m - before_m);
            for leg in rows.walking.clone() {
                rows.place(leg, seen_from(body_m, feet[leg], 0.0, height_m))?;
            }
            for leg in &whole {
                // One that does not reach is dragged along.
                let _ = rows.place(*leg, seen_from(body_m, feet[*leg], 0.0, height_m));
            }
            Ok(())
        })?;
        for leg in whole {
            self.fold(&[leg], |_, _| Ok(()))?;
        }
        let mut body_m = first.begin_m;
        for step in &first.steps {
            self.move_body(&feet, body_m, step.body_m)?;
            body_m = step.body_m;
            let rows = self.rows_in(STEP_S);
            for row in 1..=rows {
                let t = row as f64 / rows as f64;
                let share = least_jerk_share(t);
                let at_m = [0, 1]
                    .map(|axis| step.from_m[axis] + share * (step.to_m[axis] - step.from_m[axis]));
                let up = libm::sin(std::f64::consts::PI * t);
                self.place(
                    step.leg,
                    seen_from(body_m, at_m, STEP_M * up * up, height_m),
                )?;
                self.push();
            }
            feet[step.leg] = step.to_m;
        }
        self.move_body(&feet, body_m, first.end_m)
    }

    /// Folds legs while something else happens.
    fn fold(
        &mut self,
        legs: &[usize],
        mut meanwhile: impl FnMut(&mut Self, f64) -> Result<(), NotFollowed>,
    ) -> Result<(), NotFollowed> {
        let Joints { robot, left, .. } = self.joints;
        let height_m = self.plan.body_height_m;
        let from_rad: Vec<Vec<f64>> = legs.iter().map(|leg| self.now_rad[*leg].clone()).collect();
        let to_rad: Vec<Vec<f64>> = legs
            .iter()
            .map(|leg| left.folded_rad(robot, *leg, height_m))
            .collect();
        let ways = from_rad.iter().flatten().zip(to_rad.iter().flatten());
        let furthest_rad = ways.fold(0.0, |most: f64, (from, to)| most.max((to - from).abs()));
        let speed = SPEED_SHARE * robot.servo().speed_limit_rad_per_s;
        let rows = self.rows_in(FOLD_S.max(LEAST_JERK_PEAK * furthest_rad / speed));
        for row in 1..=rows {
            let share = least_jerk_share(row as f64 / rows as f64);
            meanwhile(self, share)?;
            for (index, leg) in legs.iter().enumerate() {
                let ways = from_rad[index].iter().zip(&to_rad[index]);
                self.now_rad[*leg] = ways.map(|(from, to)| from + share * (to - from)).collect();
            }
            self.push();
        }
        Ok(())
    }

    fn move_body(&mut self, feet: &[Ground], from: Ground, to: Ground) -> Result<(), NotFollowed> {
        let way_m = libm::hypot(to[0] - from[0], to[1] - from[1]);
        if way_m < 1e-6 {
            return Ok(());
        }
        let rows = self.rows_in(MOVE_S.max(LEAST_JERK_PEAK * way_m / BODY_M_PER_S));
        for row in 1..=rows {
            let share = least_jerk_share(row as f64 / rows as f64);
            let body_m = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            for leg in self.walking.clone() {
                let target = seen_from(body_m, feet[leg], 0.0, self.plan.body_height_m);
                self.place(leg, target)?;
            }
            self.push();
        }
        Ok(())
    }

    fn rows_in(&self, duration_s: f64) -> usize {
        libm::ceil(self.slowness * duration_s / self.hold_s - 1e-6).max(1.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Morphology, RobotParameter};

    use super::*;
    use crate::gait_plan::tests::plan;

    /// One that the servos follow.
    fn easy() -> GaitPlan {
        GaitPlan {
            advance_m: 0.05,
            period_s: 3.0,
            ..plan()
        }
    }

    #[test]
    fn feet_go_where_they_are_planned_on_a_robot_whose_joint_zeros_are_known() {
        let plain = Robot::jethexa();
        let zero = RobotParameter::JointZero { leg: 1, joint: 2 };
        let calibrated = plain.clone().with_added(zero, 0.03);
        let left = WhatIsLeft::of(Morphology::healthy(&plain.layout()));
        let of = |robot: &Robot| {
            let joints = Joints {
                robot,
                left: &left,
                most_turn_rad: 1.2,
            };
            joints.of_gait(&easy()).unwrap()
        };
        let (of_plain, of_calibrated) = (of(&plain), of(&calibrated));
        let rows = of_plain.rows_rad().iter().zip(of_calibrated.rows_rad());
        for (plain_rad, calibrated_rad) in rows {
            for (joint, (a, b)) in plain_rad.iter().zip(calibrated_rad).enumerate() {
                let expected = if joint == 5 { a - 0.03 } else { *a };
                assert!((b - expected).abs() < 1e-9, "joint {joint}");
            }
        }
    }

    #[test]
    fn what_is_too_fast_is_slowed_down() {
        let robot = Robot::jethexa();
        let left = WhatIsLeft::of(Morphology::healthy(&robot.layout()));
        let joints = Joints {
            robot: &robot,
            left: &left,
            most_turn_rad: 1.2,
        };
        let hasty = GaitPlan {
            period_s: 1.0,
            ..easy()
        };
        assert!(matches!(joints.of_gait(&hasty), Err(NotFollowed::Speed(_))));
        let slowed = joints.slowed(hasty.clone()).unwrap();
        assert!(slowed.period_s > hasty.period_s);
        assert_eq!(slowed.advance_m, hasty.advance_m);
        // What is out of reach stays so.
        let far = GaitPlan {
            advance_m: 0.5,
            ..easy()
        };
        assert!(joints.slowed(far).is_err());
    }
}
