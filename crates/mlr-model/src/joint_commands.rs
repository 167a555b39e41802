//! The joint angles that the gait commands, tick by tick, whichever way it says how legs move.

use mlr_filter::SettingError;

use crate::{FootMotion, FootTarget, Gait, Leg, ModelError, Motion, Robot, kinematics};

/// Commanded joint angles of the healthy robot, one set per controller tick.
///
/// A damaged robot keeps executing the full command; commands to lost links go
/// nowhere. The table is therefore the same for every morphology and is computed
/// once.
#[derive(Debug, Clone)]
pub struct JointCommands {
    hold_s: f64,
    /// `ticks[k]` holds from gait time k · hold on: angles of all legs, leg by
    /// leg from the body outward. Tick 0 is the stance.
    ticks: Vec<Vec<f64>>,
    /// Index of each leg's first joint within a tick.
    first_joint: Vec<usize>,
}

impl JointCommands {
    /// The angles at every tick up to `duration_s`: those of a joint trajectory, or the inverse
    /// kinematics of every foot target.
    ///
    /// # Errors
    /// [`ModelError::Setting`] when a number of the gait makes no sense;
    /// [`ModelError::LegCount`], [`ModelError::JointCount`] and [`ModelError::NoFooting`] when
    /// gait and robot do not fit; [`ModelError::Unreachable`] for the first target out of reach.
    pub fn new(robot: &Robot, gait: &Gait, duration_s: f64) -> Result<Self, ModelError> {
        match &gait.motion {
            Motion::Feet(feet) if feet.phase_offsets.len() != robot.legs().len() => {
                return Err(ModelError::LegCount {
                    gait: feet.phase_offsets.len(),
                    robot: robot.legs().len(),
                });
            }
            Motion::Feet(_) => {}
            Motion::Joints(joints) => joints.check_on(robot)?,
        }
        gait.check()?;
        let hold_s = robot.servo().command_hold_s;
        if gait.period_s < 2.0 * hold_s {
            let expected = format!("at least two of the servos' commands, {} s", 2.0 * hold_s);
            return Err(SettingError::new("period_s", gait.period_s, expected).into());
        }
        let last_tick = whole_ticks(duration_s, hold_s) + 1;
        let ticks = (0..=last_tick)
            .map(|tick| tick as f64 * hold_s)
            .map(|time_s| match &gait.motion {
                Motion::Feet(feet) => reaching(robot, feet, gait.period_s, time_s),
                Motion::Joints(joints) => Ok(joints.angles_rad(time_s)),
            })
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(stance) = ticks.first() {
            check_footing(robot, stance)?;
        }
        let first_joint = robot
            .legs()
            .iter()
            .scan(0, |next, leg| {
                let first = *next;
                *next += leg.links.len();
                Some(first)
            })
            .collect();
        Ok(Self {
            hold_s,
            ticks,
            first_joint,
        })
    }

    /// The angle commanded to joint `link` of leg `leg` (both from 0) at gait
    /// time `time_s`: the last one computed before, held. The stance for t ≤ 0.
    pub fn angle_rad(&self, leg: usize, link: usize, time_s: f64) -> f64 {
        self.all_rad(time_s)[self.first_joint[leg] + link]
    }

    /// The angles commanded to all joints at gait time `time_s`, leg by leg from the body outward.
    pub(crate) fn all_rad(&self, time_s: f64) -> &[f64] {
        let tick = whole_ticks(time_s, self.hold_s).min(self.ticks.len() - 1);
        &self.ticks[tick]
    }
}

/// In the stance, whose joint angles are given leg by leg, a leg must reach further down than
/// the body.
fn check_footing(robot: &Robot, stance_rad: &[f64]) -> Result<(), ModelError> {
    let underside_m = -robot.body().size_m.z / 2.0;
    let mut lowest_m = f64::INFINITY;
    let mut rest_rad = stance_rad;
    for leg in robot.legs() {
        let (angles_rad, more_rad) = rest_rad.split_at(leg.links.len().min(rest_rad.len()));
        rest_rad = more_rad;
        let of_leg_m = kinematics::lowest_contact_m(leg, angles_rad);
        lowest_m = lowest_m.min(of_leg_m.unwrap_or(f64::INFINITY));
    }
    if lowest_m < underside_m {
        Ok(())
    } else {
        Err(ModelError::NoFooting {
            underside_m,
            lowest_m,
        })
    }
}

/// Completed ticks at `time_s`. A hair of tolerance keeps a time that is a
/// multiple of the tick, but for rounding, on its own side.
fn whole_ticks(time_s: f64, hold_s: f64) -> usize {
    let ticks = libm::floor(time_s / hold_s + 1e-6);
    if ticks > 0.0 { ticks as usize } else { 0 }
}

/// Joint angles that bring every foot to its target at gait time `time_s`.
pub(crate) fn reaching(
    robot: &Robot,
    feet: &FootMotion,
    period_s: f64,
    time_s: f64,
) -> Result<Vec<f64>, ModelError> {
    reaching_targets(robot, time_s, |index, leg| {
        feet.foot_target(period_s, index, leg, time_s)
    })
}

/// Joint angles that bring every foot to its target in the body frame; `time_s` is for the message.
pub(crate) fn reaching_targets(
    robot: &Robot,
    time_s: f64,
    target: impl Fn(usize, &Leg) -> FootTarget,
) -> Result<Vec<f64>, ModelError> {
    let mut angles_rad = Vec::with_capacity(robot.layout().total_links());
    for (index, leg) in robot.legs().iter().enumerate() {
        let target = target(index, leg);
        angles_rad.extend(kinematics::inverse(leg, target).map_err(|out_of_reach| {
            ModelError::Unreachable {
                leg: index + 1,
                time_s,
                x_m: target.x,
                y_m: target.y,
                z_m: target.z,
                miss_m: out_of_reach.miss_m,
            }
        })?);
    }
    Ok(angles_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_held_between_ticks() {
        let robot = Robot::jethexa();
        let commands = JointCommands::new(&robot, &Gait::tripod(), 2.0).unwrap();
        let at = |time_s| commands.angle_rad(0, 0, time_s);
        assert_eq!(at(-3.0), at(0.0));
        assert_eq!(at(1.10), at(1.119));
        assert_ne!(at(1.10), at(1.12));
    }

    /// The tripod with another motion of the feet.
    fn tripod_with(change: impl FnOnce(&mut FootMotion)) -> Gait {
        let mut gait = Gait::tripod();
        change(gait.feet_mut().unwrap());
        gait
    }

    #[test]
    fn a_stride_too_long_names_leg_time_and_target() {
        let gait = tripod_with(|feet| feet.stride_m = 0.5);
        let message = JointCommands::new(&Robot::jethexa(), &gait, 2.0)
            .unwrap_err()
            .to_string();
        assert!(message.starts_with("leg "), "{message}");
        assert!(message.contains("gait time"), "{message}");
    }

    #[test]
    fn a_stance_in_which_no_leg_reaches_the_ground_is_refused() {
        let commands = |robot: &str, gait: &Gait| {
            JointCommands::new(&Robot::from_toml(robot).unwrap(), gait, 1.0)
        };
        // The feet are level with the middle of the body.
        let lying = tripod_with(|feet| (feet.body_height_m, feet.lift_m) = (0.001, 0.0));
        let error = commands(Robot::JETHEXA_TOML, &lying).unwrap_err();
        assert!(matches!(error, ModelError::NoFooting { .. }), "{error}");
        // The tibias cannot touch the ground, and the femurs stay above the body's underside.
        let foot = "contact = { shape = \"foot\", radius_m = 0.012 }";
        let footless = Robot::JETHEXA_TOML.replace(foot, "");
        let error = commands(&footless, &Gait::tripod()).unwrap_err();
        assert!(matches!(error, ModelError::NoFooting { .. }), "{error}");
        // The controls: the robot as it is, and one that has lost the femurs' contacts only.
        assert!(commands(Robot::JETHEXA_TOML, &Gait::tripod()).is_ok());
        let capsule = "contact = { shape = \"capsule\", radius_m = 0.012 }";
        let only_feet = Robot::JETHEXA_TOML.replace(capsule, "");
        assert!(commands(&only_feet, &Gait::tripod()).is_ok());
    }

    #[test]
    fn a_gait_for_another_number_of_legs_is_refused() {
        let gait = tripod_with(|feet| _ = feet.phase_offsets.pop());
        assert!(matches!(
            JointCommands::new(&Robot::jethexa(), &gait, 1.0),
            Err(ModelError::LegCount { gait: 5, robot: 6 })
        ));
    }
}
