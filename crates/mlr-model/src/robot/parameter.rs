//! What one robot differs by from another of its make, for as long as it lives.

use std::{fmt, str::FromStr};

use super::Robot;

/// A number of a robot that its description gives as the make has it, and that each robot has its
/// own value of. Legs, joints and axes are counted from 0.
///
/// Its [coordinate](Self::coordinate) is what deviations are normal in: a logarithm where the value
/// is positive by nature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RobotParameter {
    /// Stiffness of the servos.
    ServoStiffness,
    /// Damping of the servos.
    ServoDamping,
    /// Mass of the body, its inertia in proportion.
    BodyMass,
    /// Centre of mass of the body along x, y or z.
    CenterOfMass(usize),
    /// Zero of a joint: true angle less commanded angle.
    JointZero {
        /// Leg.
        leg: usize,
        /// Joint, from the body outward.
        joint: usize,
    },
    /// Roll, pitch or yaw at which the IMU is mounted on the body.
    ImuMounting(usize),
    /// True rate over the rate that the gyroscope reports.
    GyroScale,
    /// Duration of the controller's gait over the nominal one.
    Clock,
}

/// Axes of bodies, and of rotations.
const AXES: [&str; 3] = ["x", "y", "z"];
const ROTATIONS: [&str; 3] = ["roll", "pitch", "yaw"];

impl RobotParameter {
    /// Every parameter of this robot.
    pub fn all(robot: &Robot) -> Vec<Self> {
        let joints = robot
            .legs()
            .iter()
            .enumerate()
            .flat_map(|(leg, described)| {
                (0..described.links.len()).map(move |joint| Self::JointZero { leg, joint })
            });
        [Self::ServoStiffness, Self::ServoDamping, Self::BodyMass]
            .into_iter()
            .chain((0..3).map(Self::CenterOfMass))
            .chain(joints)
            .chain((0..3).map(Self::ImuMounting))
            .chain([Self::GyroScale, Self::Clock])
            .collect()
    }

    /// Whether this robot has it.
    pub fn is_of(self, robot: &Robot) -> bool {
        match self {
            Self::JointZero { leg, joint } => {
                let legs = robot.legs().get(leg);
                legs.is_some_and(|leg| joint < leg.links.len())
            }
            Self::CenterOfMass(axis) | Self::ImuMounting(axis) => axis < 3,
            _ => true,
        }
    }

    /// What the coordinate is in: `ln` for the logarithm of a positive number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::ServoStiffness
            | Self::ServoDamping
            | Self::BodyMass
            | Self::GyroScale
            | Self::Clock => "ln",
            Self::CenterOfMass(_) => "m",
            Self::JointZero { .. } => "rad",
            Self::ImuMounting(_) => "deg",
        }
    }

    /// Whether its coordinate is the logarithm of its value.
    pub(crate) fn is_logarithmic(self) -> bool {
        self.unit() == "ln"
    }

    /// Its coordinate in the description of a robot; 0 for a parameter that the robot lacks.
    pub fn coordinate(self, robot: &Robot) -> f64 {
        match self {
            Self::ServoStiffness => robot.servo.stiffness_nm_per_rad.ln(),
            Self::ServoDamping => robot.servo.damping_nm_s_per_rad.max(f64::MIN_POSITIVE).ln(),
            Self::BodyMass => robot.body.mass_kg.ln(),
            Self::CenterOfMass(axis) => robot
                .body
                .center_of_mass_m
                .coords
                .get(axis)
                .copied()
                .unwrap_or(0.0),
            Self::JointZero { leg, joint } => {
                let zeros = robot.legs.get(leg).map(|leg| &leg.joint_zeros_rad);
                zeros
                    .and_then(|zeros| zeros.get(joint))
                    .copied()
                    .unwrap_or(0.0)
            }
            Self::ImuMounting(axis) => robot.imu.mounting_deg.get(axis).copied().unwrap_or(0.0),
            Self::GyroScale => robot.imu.gyro_scale.ln(),
            Self::Clock => robot.clock.ln(),
        }
    }

    /// Adds so much to its coordinate; nothing happens to a robot that lacks it.
    pub(crate) fn add(self, robot: &mut Robot, more: f64) {
        let scale = more.exp();
        match self {
            Self::ServoStiffness => robot.servo.stiffness_nm_per_rad *= scale,
            Self::ServoDamping => robot.servo.damping_nm_s_per_rad *= scale,
            Self::BodyMass => robot.body.scale_mass(scale),
            Self::CenterOfMass(axis) => {
                if let Some(center_m) = robot.body.center_of_mass_m.coords.get_mut(axis) {
                    *center_m += more;
                }
            }
            Self::JointZero { leg, joint } => {
                let leg = robot.legs.get_mut(leg);
                if let Some(zero) = leg.and_then(|leg| leg.joint_zeros_rad.get_mut(joint)) {
                    *zero += more;
                }
            }
            Self::ImuMounting(axis) => {
                if let Some(angle_deg) = robot.imu.mounting_deg.get_mut(axis) {
                    *angle_deg += more;
                }
            }
            Self::GyroScale => robot.imu.gyro_scale *= scale,
            Self::Clock => robot.clock *= scale,
        }
    }
}

/// Its name in files: `servo_stiffness`, `center_of_mass_x`, `joint_zero_leg1_2`, `imu_roll`.
impl fmt::Display for RobotParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |names: [&'static str; 3], axis: usize| names.get(axis).copied().unwrap_or("?");
        match *self {
            Self::ServoStiffness => f.write_str("servo_stiffness"),
            Self::ServoDamping => f.write_str("servo_damping"),
            Self::BodyMass => f.write_str("body_mass"),
            Self::CenterOfMass(axis) => write!(f, "center_of_mass_{}", of(AXES, axis)),
            Self::JointZero { leg, joint } => {
                write!(f, "joint_zero_leg{}_{}", leg + 1, joint + 1)
            }
            Self::ImuMounting(axis) => write!(f, "imu_{}", of(ROTATIONS, axis)),
            Self::GyroScale => f.write_str("gyro_scale"),
            Self::Clock => f.write_str("clock"),
        }
    }
}

/// A name that no parameter has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownParameter;

impl FromStr for RobotParameter {
    type Err = UnknownParameter;

    fn from_str(name: &str) -> Result<Self, UnknownParameter> {
        let axis = |names: [&str; 3], axis: &str| names.iter().position(|one| *one == axis);
        let number = |text: &str| text.parse::<usize>().ok()?.checked_sub(1);
        let found = match name {
            "servo_stiffness" => Some(Self::ServoStiffness),
            "servo_damping" => Some(Self::ServoDamping),
            "body_mass" => Some(Self::BodyMass),
            "gyro_scale" => Some(Self::GyroScale),
            "clock" => Some(Self::Clock),
            _ => None,
        };
        found
            .or_else(|| axis(AXES, name.strip_prefix("center_of_mass_")?).map(Self::CenterOfMass))
            .or_else(|| axis(ROTATIONS, name.strip_prefix("imu_")?).map(Self::ImuMounting))
            .or_else(|| {
                let (leg, joint) = name.strip_prefix("joint_zero_leg")?.split_once('_')?;
                Some(Self::JointZero {
                    leg: number(leg)?,
                    joint: number(joint)?,
                })
            })
            .ok_or(UnknownParameter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_name_of_its_own() {
        let robot = Robot::jethexa();
        let all = RobotParameter::all(&robot);
        assert_eq!(all.len(), 3 + 3 + 18 + 3 + 2);
        for parameter in &all {
            assert_eq!(parameter.to_string().parse(), Ok(*parameter));
            assert!(parameter.is_of(&robot));
        }
        for name in [
            "",
            "joint_zero_leg0_1",
            "joint_zero_leg1",
            "imu_x",
            "center_of_mass_roll",
        ] {
            assert_eq!(
                name.parse::<RobotParameter>(),
                Err(UnknownParameter),
                "{name}"
            );
        }
        assert!(!RobotParameter::JointZero { leg: 6, joint: 0 }.is_of(&robot));
    }

    #[test]
    fn what_is_added_shows_in_its_own_coordinate_alone() {
        let robot = Robot::jethexa();
        for parameter in RobotParameter::all(&robot) {
            let changed = robot.clone().with_added(parameter, 0.01);
            for other in RobotParameter::all(&robot) {
                let added = other.coordinate(&changed) - other.coordinate(&robot);
                let expected = if other == parameter { 0.01 } else { 0.0 };
                assert!(
                    (added - expected).abs() < 1e-12,
                    "{parameter} {other}: {added}"
                );
            }
        }
    }
}
