use mlr_model::{Gait, JointCommands, ModelError, Robot, kinematics};

use crate::{rows::reached_rad, support::Ground};

/// How a robot stands before its nominal gait, from where every way into another gait begins.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NominalStance {
    /// Commanded angles, leg by leg.
    pub(crate) angles_rad: Vec<Vec<f64>>,
    /// Where the feet are seen from above, body frame.
    pub(crate) feet_m: Vec<Ground>,
    /// Height of the body's origin over the lowest foot.
    pub(crate) body_height_m: f64,
}

impl NominalStance {
    /// The stance from which a robot begins a gait.
    ///
    /// # Errors
    /// [`ModelError`] where robot and gait do not fit.
    pub(crate) fn of(robot: &Robot, nominal: &Gait) -> Result<Self, ModelError> {
        let commands = JointCommands::new(robot, nominal, 0.0)?;
        let legs = robot.legs().iter().enumerate();
        let angles_rad: Vec<Vec<f64>> = legs
            .map(|(leg, described)| {
                let joints = 0..described.links.len();
                joints
                    .map(|joint| commands.angle_rad(leg, joint, 0.0))
                    .collect()
            })
            .collect();
        let tips = robot.legs().iter().zip(&angles_rad);
        let tips: Vec<_> = tips
            .map(|(leg, angles_rad)| kinematics::foot_tip(leg, &reached_rad(leg, angles_rad)))
            .collect();
        let lowest_m = tips.iter().map(|tip| tip.z).fold(f64::INFINITY, f64::min);
        Ok(Self {
            angles_rad,
            feet_m: tips.iter().map(|tip| [tip.x, tip.y]).collect(),
            body_height_m: -lowest_m,
        })
    }
}
