//! One joint's position servo while it runs.

use rapier3d::prelude::MultibodyLink;

use crate::Servo;

/// Index of the angular x axis in rapier's spatial layout: every joint turns
/// about the x axis of its own frame.
pub(crate) const HINGE_AXIS: usize = 3;
/// Stiffness of a spring whose torque does not change with the angle, N m/rad: enough for a torque
/// to be given as the spring's rest angle, and too little to be felt.
const LIMP: f64 = 1e-3;

/// The moving set point of one servo.
///
/// The servo's spring acts through rapier's implicit joint spring, which is
/// stable at any time step; its damper and viscous friction through the
/// multibody's joint damping, dry friction through its friction rows. Each step
/// moves the spring's rest angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ServoState {
    set_point_rad: f64,
    torque_nm: f64,
}

impl ServoState {
    /// At rest at `angle_rad`.
    pub(crate) fn at(angle_rad: f64) -> Self {
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
    /// and hangs the joint's spring so that its torque stays within the limit.
    /// Returns the most that dry friction may hold against, in N m: with the load on the joint, or
    /// where it is not known with the one that the motor would hold at rest.
    pub(crate) fn drive(
        &mut self,
        servo: &Servo,
        command_rad: f64,
        joint_speed_rad_per_s: f32,
        load_nm: Option<f64>,
        time_step_s: f64,
        link: &mut MultibodyLink,
    ) -> f64 {
        let reach_rad = servo.speed_limit_rad_per_s * time_step_s;
        self.set_point_rad += (command_rad - self.set_point_rad).clamp(-reach_rad, reach_rad);

        let angle_rad = f64::from(link.joint.coords()[HINGE_AXIS]);
        let speed_rad_per_s = f64::from(joint_speed_rad_per_s);
        let error_rad = self.set_point_rad - angle_rad;
        let (motor_nm, growth) = servo.motor(error_rad, speed_rad_per_s);
        self.torque_nm = motor_nm;
        // The joint's own damping takes off what is added here.
        let spring_nm = motor_nm + servo.damping_nm_s_per_rad * speed_rad_per_s;
        let stiffness = if growth > 0.0 { growth } else { LIMP };
        let rest_rad = angle_rad + spring_nm / stiffness;
        link.joint
            .set_spring(HINGE_AXIS, stiffness as f32, rest_rad as f32);
        let load_nm = load_nm.unwrap_or(-spring_nm);
        servo
            .drive
            .dry_friction_nm(speed_rad_per_s, motor_nm, load_nm)
    }

    /// Lets go of the joint: the motor has no current. Returns the most that dry friction may hold
    /// against, in N m.
    pub(crate) fn release(
        &mut self,
        servo: &Servo,
        joint_speed_rad_per_s: f32,
        load_nm: f64,
        link: &mut MultibodyLink,
    ) -> f64 {
        self.set_point_rad = f64::from(link.joint.coords()[HINGE_AXIS]);
        self.torque_nm = 0.0;
        link.joint.set_spring(HINGE_AXIS, 0.0, 0.0);
        let speed_rad_per_s = f64::from(joint_speed_rad_per_s);
        servo.drive.dry_friction_nm(speed_rad_per_s, 0.0, load_nm)
    }
}
