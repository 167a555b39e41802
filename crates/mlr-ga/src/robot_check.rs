//! Whether the description of a robot and a gait make a robot that stands and walks.

use mlr_filter::DetectorSettings;
use mlr_model::{
    Gait, JointCommands, ModelError, Morphology, Outcome, Record, Robot, SimulationSettings,
    Simulator, Trajectory,
    kinematics::{foot_tip, inverse, mass_moment},
};
use mlr_recover::{PossibleRobot, Walking, margin_m};
use serde::Serialize;
use thiserror::Error;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.robot_check/1";
/// For how long it stands.
const STAND_S: f64 = 2.0;
/// At the end of which so much is looked at.
const LOOKED_AT_S: f64 = 0.5;
/// For how long it walks.
const WALK_S: f64 = 5.0;
/// A body that leans by more has fallen.
const FALLEN_DEG: f64 = 30.0;
/// A foot that carries less of the weight does not touch the ground.
const TOUCHING: f64 = 0.002;
/// Places of a cycle at which feet must be within reach.
const LOOKS: usize = 100;
/// Share of the time with a servo at its limit that is worth a word.
const OFTEN: f64 = 0.05;
/// A robot that walks slower than this share of the commanded speed slips or stumbles.
const SLOW: f64 = 0.5;

/// What was found about a robot with a gait.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RobotCheck {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Name of the robot.
    pub robot: String,
    /// Name of the gait.
    pub gait: String,
    /// Number of legs.
    pub legs: usize,
    /// Number of joints.
    pub joints: usize,
    /// Of the whole robot.
    pub mass_kg: f64,
    /// How far the centre of mass of the stance is inside the polygon of its feet; negative outside.
    pub stance_margin_m: Option<f64>,
    /// How far the body leans after it has stood for a while.
    pub standing_tilt_deg: Option<f64>,
    /// Five seconds of walking in full health.
    pub walking: Option<Walking>,
    /// Speed at which the feet are commanded to move.
    pub commanded_speed_m_per_s: Option<f64>,
    /// Why it cannot be used; nothing where it stands and walks.
    pub problems: Vec<String>,
    /// What it is used with nevertheless.
    pub doubts: Vec<String>,
}

/// A robot that cannot be used as it is described.
#[derive(Debug, Error)]
#[error("{robot} with {gait}: {problems}")]
pub struct UnfitRobot {
    robot: String,
    gait: String,
    problems: String,
}

/// Checks reach, stance and walk, in this order, as far as each is possible.
///
/// # Errors
/// [`ModelError`] where the simulation refuses the robot for another reason than its reach.
pub fn check_robot(robot: &Robot, gait: &Gait) -> Result<RobotCheck, ModelError> {
    let mut check = RobotCheck {
        schema: SCHEMA,
        robot: robot.name().into(),
        gait: gait.name.clone(),
        legs: robot.legs().len(),
        joints: robot.layout().total_links(),
        mass_kg: robot.mass_kg(),
        stance_margin_m: None,
        standing_tilt_deg: None,
        walking: None,
        commanded_speed_m_per_s: None,
        problems: Vec::new(),
        doubts: Vec::new(),
    };
    check.reach(robot, gait);
    if check.problems.is_empty()
        && let Err(error) = JointCommands::new(robot, gait, gait.first_pass_s())
    {
        check.problems.push(error.to_string());
    }
    if check.problems.is_empty() {
        check.stand(robot, gait)?;
    }
    if check.problems.is_empty() {
        check.walk(robot, gait)?;
    }
    Ok(check)
}

impl RobotCheck {
    /// Nothing, or why the robot cannot be used.
    ///
    /// # Errors
    /// [`UnfitRobot`] names every problem.
    pub fn verdict(&self) -> Result<(), UnfitRobot> {
        if self.problems.is_empty() {
            return Ok(());
        }
        Err(UnfitRobot {
            robot: self.robot.clone(),
            gait: self.gait.clone(),
            problems: self.problems.join("; "),
        })
    }

    /// Feet are within reach, in the stance and all over the cycle.
    fn reach(&mut self, robot: &Robot, gait: &Gait) {
        let Some(feet) = gait.feet() else { return };
        let legs = robot.legs();
        if feet.phase_offsets.len() != legs.len() {
            self.problems.push(format!(
                "the gait has {} phase_offsets, expected one for each of {} legs",
                feet.phase_offsets.len(),
                legs.len()
            ));
            return;
        }
        let times_s = (0..=LOOKS).map(|look| match look {
            0 => 0.0,
            _ => gait.steady_from_s() + gait.period_s * look as f64 / LOOKS as f64,
        });
        let times_s: Vec<f64> = times_s.collect();
        for (index, leg) in legs.iter().enumerate() {
            let misses = times_s.iter().filter_map(|&time_s| {
                let target = feet.foot_target(gait.period_s, index, leg, time_s);
                let miss = inverse(leg, target).err()?;
                Some((time_s, target, miss.miss_m))
            });
            let Some((time_s, target, miss_m)) = misses.max_by(|a, b| a.2.total_cmp(&b.2)) else {
                continue;
            };
            let when = match time_s > 0.0 {
                true => format!("{time_s:.2} s into the gait"),
                false => "in the stance".into(),
            };
            self.problems.push(format!(
                "the foot of leg {} is to be at ({:.3}, {:.3}, {:.3}) m {when}, {:.0} mm out of its reach: \
                 expected another nominal_foot_m, longer links, or a gait with another body_height_m, \
                 stride_m or lift_m",
                robot.numbered_name(index + 1),
                target.x,
                target.y,
                target.z,
                (1e3 * miss_m).ceil()
            ));
        }
    }

    /// It stands on its feet, and on nothing else, without falling.
    fn stand(&mut self, robot: &Robot, gait: &Gait) -> Result<(), ModelError> {
        self.stance_margin_m = stance_margin_m(robot, gait);
        if let Some(margin_m) = self.stance_margin_m.filter(|margin_m| *margin_m <= 0.0) {
            self.problems.push(format!(
                "the centre of mass is {:.0} mm outside the feet that it stands on: expected another \
                 nominal_foot_m or center_of_mass_m",
                -1e3 * margin_m
            ));
        }
        let mut still = gait.clone();
        let Some(feet) = still.feet_mut() else {
            return Ok(());
        };
        (feet.stride_m, feet.lift_m) = (0.0, 0.0);
        let settings = SimulationSettings {
            duration_s: STAND_S,
            record: Record {
                contacts: true,
                ..Record::default()
            },
            ..SimulationSettings::default()
        };
        let simulator = Simulator::new(robot.clone(), &still, settings)?;
        let Outcome::Walked(stood) = simulator.simulate(&Morphology::healthy(&robot.layout()))
        else {
            self.problems.push(
                "the simulation of the stance diverges: masses, inertias or the servo \
                                make no sense together"
                    .into(),
            );
            return Ok(());
        };
        let tilt_deg = tilts_deg(&stood).last().copied().unwrap_or(f64::INFINITY);
        self.standing_tilt_deg = Some(tilt_deg);
        if tilt_deg > FALLEN_DEG {
            self.problems
                .push(format!("it falls over where it stands, by {tilt_deg:.0}°"));
            return Ok(());
        }
        let forces_n = mean_forces_n(&stood);
        let weight_n: f64 = forces_n.iter().sum();
        let carries = |force_n: &f64| *force_n > TOUCHING * weight_n;
        if forces_n.first().is_some_and(carries) {
            self.problems.push(
                "the body lies on the ground where it should stand: expected stronger \
                                servos or a higher body_height_m"
                    .into(),
            );
        }
        for (index, force_n) in forces_n.iter().skip(1).enumerate() {
            if !carries(force_n) {
                self.problems.push(format!(
                    "leg {} does not touch the ground in the stance",
                    robot.numbered_name(index + 1)
                ));
            }
        }
        Ok(())
    }

    /// It walks for five seconds.
    fn walk(&mut self, robot: &Robot, gait: &Gait) -> Result<(), ModelError> {
        let from_s = gait.steady_from_s();
        let healthy = PossibleRobot {
            robot: robot.clone(),
            morphology: Morphology::healthy(&robot.layout()),
            simulation: SimulationSettings::default(),
        };
        let Some(walked) = healthy.walk(gait, from_s + WALK_S)? else {
            self.problems
                .push("the simulation of the walk diverges".into());
            return Ok(());
        };
        let detector = DetectorSettings::default();
        let cycle_s = gait.cycle_s().unwrap_or(WALK_S);
        let walking = Walking::of(&healthy, &walked, from_s, cycle_s, detector);
        self.walking = Some(walking);
        if walking.tilt_deg > FALLEN_DEG {
            self.problems.push(format!(
                "it falls as it walks: it leans by {:.0}°",
                walking.tilt_deg
            ));
            return Ok(());
        }
        if walking.fluctuation_deg > detector.threshold_deg {
            self.doubts.push(format!(
                "roll or pitch fluctuate by {:.1}° in {} s while nothing is wrong: a detector.threshold_deg \
                 of {:.0}° takes that for damage",
                walking.fluctuation_deg, detector.window_s, detector.threshold_deg
            ));
        }
        if walking.saturated > OFTEN {
            self.doubts.push(format!(
                "a servo is at its torque_limit_nm for {:.0} % of the time",
                100.0 * walking.saturated
            ));
        }
        if let Some(feet) = gait.feet() {
            let told = feet.stride_m / (gait.period_s * (1.0 - feet.swing_fraction));
            self.commanded_speed_m_per_s = Some(told);
            if walking.speed_m_per_s.abs() < SLOW * told.abs() {
                self.doubts.push(format!(
                    "it walks at {:.0} mm/s where {:.0} mm/s are commanded",
                    1e3 * walking.speed_m_per_s,
                    1e3 * told
                ));
            }
        }
        Ok(())
    }
}

/// Positions of the joints of a leg in its stance, and of its foot tip, in the body frame; `None` where
/// the foot is out of reach or the gait knows no feet.
pub fn stance_joints_m(robot: &Robot, gait: &Gait, leg: usize) -> Option<Vec<[f64; 3]>> {
    let described = robot.legs().get(leg)?;
    let target = gait.foot_target(leg, described, 0.0)?;
    let angles_rad = inverse(described, target).ok()?;
    let joints =
        (0..=angles_rad.len()).map(|count| foot_tip(described, &angles_rad[..count]).into());
    Some(joints.collect())
}

/// How far the centre of mass is inside the feet of the stance.
fn stance_margin_m(robot: &Robot, gait: &Gait) -> Option<f64> {
    let center_m = stance_center_m(robot, gait)?;
    let feet = (0..robot.legs().len()).map(|leg| stance_joints_m(robot, gait, leg)?.pop());
    let feet: Option<Vec<[f64; 2]>> = feet.map(|foot| foot.map(|[x, y, _]| [x, y])).collect();
    Some(margin_m(&feet?, [center_m[0], center_m[1]]))
}

/// The centre of mass in the stance, body frame.
pub fn stance_center_m(robot: &Robot, gait: &Gait) -> Option<[f64; 3]> {
    let body = robot.body();
    let mut moment = body.mass_kg * body.center_of_mass_m.coords;
    for (index, leg) in robot.legs().iter().enumerate() {
        let target = gait.foot_target(index, leg, 0.0)?;
        let angles_rad = inverse(leg, target).ok()?;
        moment += mass_moment(leg, &angles_rad).1;
    }
    Some((moment / robot.mass_kg()).into())
}

/// Angles between the body's z axis and the vertical.
fn tilts_deg(trajectory: &Trajectory) -> Vec<f64> {
    let angles = trajectory.orientation.angles_rad();
    let each = angles.roll.iter().zip(&angles.pitch);
    each.map(|(roll, pitch)| libm::acos(libm::cos(*roll) * libm::cos(*pitch)).to_degrees())
        .collect()
}

/// Mean forces on the body and on each leg over the end of a trajectory.
fn mean_forces_n(trajectory: &Trajectory) -> Vec<f64> {
    let times_s = trajectory.orientation.times_s();
    let end_s = times_s.last().copied().unwrap_or_default();
    let rows = trajectory.contact_force_n.as_deref().unwrap_or_default();
    let late = times_s
        .iter()
        .zip(rows)
        .filter(|(time_s, _)| **time_s >= end_s - LOOKED_AT_S);
    let mut sums: Vec<f64> = Vec::new();
    let mut count = 0;
    for (_, row) in late {
        sums.resize(row.len(), 0.0);
        sums.iter_mut()
            .zip(row)
            .for_each(|(sum, force_n)| *sum += force_n);
        count += 1;
    }
    sums.into_iter()
        .map(|sum| sum / f64::from(count.max(1)))
        .collect()
}
