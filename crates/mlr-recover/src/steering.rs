//! A gait that walked, steered by how the robot turned.

use mlr_model::{Gait, Robot};

use crate::{
    GaitPlan, RecoverError, RecoverSettings, WhatIsLeft, nominal_stance::NominalStance,
    rows::Joints, whole_gait::WholeGait,
};

/// The plan of a recovery gait that a robot walked.
#[derive(Debug, Clone, Copy)]
pub struct WalkedPlan<'a> {
    /// The robot in full health, as it is described.
    pub robot: &'a Robot,
    /// Its nominal gait, from whose stance the gait begins.
    pub nominal: &'a Gait,
    /// What is left of the robot.
    pub left: &'a WhatIsLeft,
    /// The gait that it walked.
    pub plan: &'a GaitPlan,
}

/// A recovery gait that turns as far the other way as the robot was seen to turn.
#[derive(Debug, Clone)]
pub struct Steered {
    /// The gait: from the nominal stance into a cycle that repeats.
    pub gait: Gait,
    /// What it is made of.
    pub plan: GaitPlan,
    /// Least static stability margin over its cycle, of the robot as described.
    pub margin_m: f64,
    /// The same on the way into it.
    pub first_steps_margin_m: f64,
}

/// Joints may turn so much further than in a gait that is searched, which often uses all that it may: a little
/// more keeps far from what a servo can.
const FURTHER: f64 = 1.1;

impl WalkedPlan<'_> {
    /// The same gait for a robot that turned by `turned_rad` to the left in a cycle of it.
    ///
    /// # Errors
    /// [`RecoverError`] where robot, gait and settings do not fit, or the joints cannot follow a gait
    /// that turns so far.
    pub fn steered(
        self,
        turned_rad: f64,
        settings: &RecoverSettings,
    ) -> Result<Steered, RecoverError> {
        settings.check()?;
        let joints = Joints {
            robot: self.robot,
            left: self.left,
            most_turn_rad: FURTHER * settings.most_turn_deg.to_radians(),
        };
        let stance = NominalStance::of(self.robot, self.nominal)?;
        let plan = joints.slowed(GaitPlan {
            turn_rad: self.plan.turn_rad - turned_rad,
            ..self.plan.clone()
        })?;
        let whole = WholeGait::of(&plan, joints, &stance)?;
        Ok(Steered {
            margin_m: joints.margin_m(&plan)?,
            gait: whole.gait,
            plan,
            first_steps_margin_m: whole.first_steps_margin_m,
        })
    }
}
