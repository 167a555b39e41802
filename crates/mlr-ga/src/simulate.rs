//! A log from the model.

use mlr_filter::{OrientationSeries, SeriesError, SettingError};
use mlr_model::{
    Gait, GroundContact, LostLinks, ModelError, Morphology, Outcome, Robot, Roughness,
    SimulationSettings, Simulator, Terrain,
};
use serde::Serialize;
use thiserror::Error;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.simulation/1";
/// Distance between the grid points of the rubble.
const RUBBLE_SPACING_M: f64 = 0.05;

/// What a simulated robot does, where it walks, and what its joints have beyond the described ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogSimulation {
    /// What became of lost links.
    pub lost_links: LostLinks,
    /// How long the robot stands first.
    pub stand_s: f64,
    /// How long it then walks.
    pub walk_s: f64,
    /// Time between two samples, and of a simulation step.
    pub time_step_s: f64,
    /// Friction between feet and ground.
    pub friction: f64,
    /// Dry friction in every joint beyond the described one.
    pub joint_friction_nm: f64,
    /// Play in every joint beyond the described one: it is free over this angle.
    pub backlash_rad: f64,
    /// Inclination of the ground.
    pub slope_deg: f64,
    /// Direction in which the ground rises, counter-clockwise from straight ahead.
    pub uphill_deg: f64,
    /// Height of the rubble that covers the ground, if there is any.
    pub rubble_m: Option<f64>,
    /// Chooses the rubble.
    pub seed: u64,
}

impl Default for LogSimulation {
    fn default() -> Self {
        Self {
            lost_links: LostLinks::Absent,
            stand_s: 2.0,
            walk_s: 10.0,
            time_step_s: 0.002,
            friction: GroundContact::default().friction,
            joint_friction_nm: 0.0,
            backlash_rad: 0.0,
            slope_deg: 0.0,
            uphill_deg: 0.0,
            rubble_m: None,
            seed: 1,
        }
    }
}

/// Why there is no log.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// A number makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Robot, gait and settings do not fit together.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The simulation did not stay finite.
    #[error("the simulation of {morphology} diverged at {at_s:.3} s; a shorter time step may help")]
    Diverged {
        /// What was simulated.
        morphology: Box<Morphology>,
        /// Time of the simulation.
        at_s: f64,
    },
    /// The walk is no series of finite numbers.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

impl LogSimulation {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first field that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check(
            "slope_deg",
            self.slope_deg,
            0.0..=Terrain::STEEPEST_DEG,
            "degrees",
        )?;
        check("uphill_deg", self.uphill_deg, -360.0..=360.0, "degrees")?;
        check(
            "joint_friction_nm",
            self.joint_friction_nm,
            0.0..=1e6,
            "N m",
        )?;
        check("backlash_rad", self.backlash_rad, 0.0..=1.0, "rad")?;
        self.settings().check().map_err(|error| {
            error.as_option(&[
                ("duration_s", "walk_s"),
                ("contact.friction", "friction"),
                ("terrain.roughness.height_m", "rubble_m"),
            ])
        })
    }

    /// The robot with friction and play in its joints.
    ///
    /// # Errors
    /// [`ModelError`] when no robot can have them.
    pub fn robot(&self, robot: Robot) -> Result<Robot, ModelError> {
        let mut servo = *robot.servo();
        servo.drive.coulomb_nm += self.joint_friction_nm;
        servo.drive.backlash_rad += self.backlash_rad;
        robot.with_servo(servo)
    }

    /// The log that the sensor of such a [robot](Self::robot) records. Its time starts with the recording;
    /// the walk starts after [`LogSimulation::stand_s`].
    ///
    /// # Errors
    /// [`SimulateError`].
    pub fn log(
        &self,
        robot: &Robot,
        gait: &Gait,
        morphology: &Morphology,
    ) -> Result<OrientationSeries, SimulateError> {
        self.check()?;
        let simulator = Simulator::new(robot.clone(), gait, self.settings())?;
        let orientation = match simulator.simulate(morphology) {
            Outcome::Walked(trajectory) => trajectory.orientation,
            Outcome::Diverged { at_s } => {
                return Err(SimulateError::Diverged {
                    morphology: Box::new(morphology.clone()),
                    at_s,
                });
            }
        };
        // Log time starts with the recording, gait time with the walk, by the robot's own clock.
        let orientation = robot.imu().on(&orientation);
        let times_s = orientation
            .times_s()
            .iter()
            .map(|gait_time_s| gait_time_s.min(0.0) + gait_time_s.max(0.0) * robot.clock())
            .map(|time_s| time_s + self.stand_s)
            .collect();
        let angles_rad = orientation.angles_rad().clone();
        Ok(OrientationSeries::new(times_s, angles_rad)?)
    }

    fn settings(&self) -> SimulationSettings {
        SimulationSettings {
            duration_s: self.walk_s,
            stand_s: self.stand_s,
            time_step_s: self.time_step_s,
            lost_links: self.lost_links,
            contact: GroundContact {
                friction: self.friction,
                ..Default::default()
            },
            terrain: Terrain {
                slope_rad: self.slope_deg.to_radians(),
                uphill_rad: self.uphill_deg.to_radians(),
                roughness: self.rubble_m.map(|height_m| Roughness {
                    height_m,
                    spacing_m: RUBBLE_SPACING_M,
                    seed: self.seed,
                }),
            },
            ..Default::default()
        }
    }
}

/// What is said about a simulated log: the object that other programs read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimulationReport {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// The file of the log; empty where it went to none.
    pub log: String,
    /// The file of joint angles, if one was asked for.
    pub joints: Option<String>,
    /// The robot that walked.
    pub morphology: Morphology,
    /// Numbered from 1.
    pub damaged_legs: Vec<usize>,
    /// Samples of the log.
    pub samples: usize,
    /// Log time at which the walk starts.
    pub motion_start_s: f64,
}

impl SimulationReport {
    /// The report of a log of this robot, in no file.
    pub fn new(
        simulation: &LogSimulation,
        morphology: &Morphology,
        log: &OrientationSeries,
    ) -> Self {
        Self {
            schema: SCHEMA,
            log: String::new(),
            joints: None,
            damaged_legs: morphology.damaged_legs(),
            morphology: morphology.clone(),
            samples: log.len(),
            motion_start_s: simulation.stand_s,
        }
    }
}
