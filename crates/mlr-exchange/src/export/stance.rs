//! How the exported robot stands: commands of the gait at its beginning, and how high the body is.

use mlr_model::{ContactShape, Gait, JointCommands, ModelError};
use nalgebra::{Isometry3, Point3, UnitQuaternion};

use super::{BASE, ExportedRobot};

/// The robot before it walks.
pub(crate) struct Stance {
    /// Commanded to each part's joint, whether it obeys or not.
    pub(crate) commands_rad: Vec<f64>,
    /// Of the body's origin over level ground that the robot just touches.
    pub(crate) height_m: f64,
}

impl ExportedRobot<'_> {
    pub(crate) fn stance(&self, gait: &Gait) -> Result<Stance, ModelError> {
        let commands = JointCommands::new(self.robot, gait, 0.0)?;
        let of = self.parts.iter();
        let commands_rad: Vec<f64> = of
            .map(|part| commands.angle_rad(part.leg, part.link, 0.0))
            .collect();
        let mut lowest_m = -self.robot.body().size_m.z / 2.0;
        let mut on = Isometry3::identity();
        for (part, command_rad) in self.parts.iter().zip(&commands_rad) {
            if part.on == BASE {
                on = Isometry3::identity();
            }
            on *= part.frame();
            if !part.is_stuck() {
                let axis = nalgebra::Unit::new_unchecked(part.axis());
                on.rotation *= UnitQuaternion::from_axis_angle(&axis, *command_rad);
            }
            let height_m = |x_m: f64| (on * Point3::new(x_m, 0.0, 0.0)).z;
            let length_m = part.part.length_m;
            let of_part_m = match part.part.contact {
                None => continue,
                Some(ContactShape::Capsule { radius_m }) => {
                    height_m(0.0).min(height_m(length_m)) - radius_m
                }
                Some(ContactShape::Foot { radius_m }) => height_m(length_m - radius_m) - radius_m,
            };
            lowest_m = lowest_m.min(of_part_m);
        }
        Ok(Stance {
            commands_rad,
            height_m: -lowest_m,
        })
    }
}
