//! One joint's position servo while it runs.

use rapier3d::prelude::MultibodyLink;

use crate::Servo;

/// Index of the angular x axis in rapier's spatial layout: every joint turns
/// about the x axis of its own frame.
const HINGE_AXIS: usize = 3;

/// The moving set point of one servo.
///
/// The servo's spring acts through rapier's implicit joint spring, which is
/// stable at any time step; its damper through the multibody's joint damping.
/// Each step moves the spring's rest angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct ServoState {
    set_point_rad: f64,
    torque_nm: f64,
}

impl ServoState {
    /// At rest at `angle_rad`.
    pub(super) fn at(angle_rad: f64) -> Self {
        Self {
            set_point_rad: angle_rad,
            torque_nm: 0.0,
        }
    }

    /// Torque of the last step as predicted at its start, before the implicit
    /// correction within the step.
    pub(super) fn torque_nm(&self) -> f64 {
        self.torque_nm
    }

    /// Moves the set point towards `command_rad`, no faster than the servo can,
    /// and hangs the joint's spring so that spring and damper together stay
    /// within the torque limit.
    pub(super) fn drive(
        &mut self,
        servo: &Servo,
        command_rad: f64,
        joint_speed_rad_per_s: f32,
        time_step_s: f64,
        link: &mut MultibodyLink,
    ) {
        let reach_rad = servo.speed_limit_rad_per_s * time_step_s;
        self.set_point_rad += (command_rad - self.set_point_rad).clamp(-reach_rad, reach_rad);

        let angle_rad = f64::from(link.joint.coords()[HINGE_AXIS]);
        let damping_nm = servo.damping_nm_s_per_rad * f64::from(joint_speed_rad_per_s);
        let wanted_nm = servo.stiffness_nm_per_rad * (self.set_point_rad - angle_rad) - damping_nm;
        self.torque_nm = wanted_nm.clamp(-servo.torque_limit_nm, servo.torque_limit_nm);
        let rest_rad = angle_rad + (self.torque_nm + damping_nm) / servo.stiffness_nm_per_rad;
        link.joint.set_spring(
            HINGE_AXIS,
            servo.stiffness_nm_per_rad as f32,
            rest_rad as f32,
        );
    }
}
