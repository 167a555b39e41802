//! What a robot, its ground and its sensor may do that the model of a walk does not
//! have. Each effect is one type in its own file; a new one is added by its file and
//! its line in [`LIBRARY`].
//!
//! Lost links that hang on as dead weight (`locked_links`) are no effect here: every
//! model is tried with them and without.

mod backlash;
mod bias_drift;
mod effect;
mod external_force;
mod foot_friction;
mod friction;
mod gait_period;
mod ground_compliance;
mod gyro_bias;
mod gyro_scale;
mod imu_misalignment;
mod joint_friction;
mod joint_offset;
mod payload;
mod reported;
mod sensor_delay;
mod servo_lag;
mod servo_stiffness;
mod short_link;
mod slope;
mod stuck_joint;
mod weak_leg;

pub use crate::EffectParameter;
pub use effect::{Place, WalkEffect};
pub use reported::{apply_reported, apply_reported_surroundings};

/// All effects: those of the body first, then those of the sensor.
pub const LIBRARY: &[&dyn WalkEffect] = &[
    &payload::Payload,
    &slope::Slope,
    &friction::Friction,
    &foot_friction::FootFriction,
    &servo_lag::ServoLag,
    &servo_stiffness::ServoStiffness,
    &joint_friction::JointFriction,
    &backlash::Backlash,
    &weak_leg::WeakLeg,
    &stuck_joint::StuckJoint,
    &joint_offset::JointOffset,
    &short_link::ShortLink,
    &gait_period::GaitPeriod,
    &ground_compliance::GroundCompliance,
    &external_force::ExternalForce,
    &imu_misalignment::ImuMisalignment,
    &gyro_bias::GyroBias,
    &gyro_scale::GyroScale,
    &bias_drift::BiasDrift,
    &sensor_delay::SensorDelay,
];

/// The effect of that kind.
pub fn find(kind: &str) -> Option<&'static dyn WalkEffect> {
    LIBRARY.iter().copied().find(|effect| effect.kind() == kind)
}

#[cfg(test)]
mod tests;
