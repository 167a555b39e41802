//! The model of a walk: the body, its gait, its ground, and the sensor on it.

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    CommandCache, Gait, ModelError, Morphology, Outcome, Robot, Servo, SimulationSettings,
    Simulator, Trajectory,
};

use super::{NuisanceSettings, Sensing, WalkRecord};

/// How long a robot is recorded standing before it walks: what comes before is the
/// same.
const STAND_S: f64 = 0.1;

/// Everything that decides what a sensor reports of a walk but for the morphology.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkModel {
    /// The robot in full health.
    pub robot: Robot,
    /// The servo in every joint.
    pub servo: Servo,
    /// The gait that it walks.
    pub gait: Gait,
    /// Ground, payload, faults, and how it is simulated. Durations follow from what
    /// is asked for.
    pub simulation: SimulationSettings,
    /// Duration of the robot's gait over the nominal one, where only the clock differs.
    pub clock: f64,
    /// The sensor on the body.
    pub sensing: Sensing,
    /// Joint commands of walks before, which models made of this one share.
    commands: CommandCache,
}

impl WalkModel {
    /// A robot as described, with a sensor without faults.
    pub fn nominal(robot: Robot, gait: Gait, simulation: SimulationSettings) -> Self {
        Self {
            servo: *robot.servo(),
            clock: robot.clock(),
            sensing: Sensing {
                misalignment_deg: robot.imu().mounting_deg,
                scale: robot.imu().gyro_scale,
                ..Sensing::default()
            },
            robot,
            gait,
            simulation,
            commands: CommandCache::default(),
        }
    }

    /// The same with the play that the gears of every robot of its make have.
    pub fn of_make(
        robot: Robot,
        gait: Gait,
        simulation: SimulationSettings,
        settings: &NuisanceSettings,
    ) -> Self {
        let mut model = Self::nominal(robot, gait, simulation);
        let play_rad = &mut model.servo.drive.backlash_rad;
        *play_rad = settings.usual_backlash_rad(*play_rad);
        model
    }

    /// The body's orientation over the time since the start of the walk, long enough for
    /// the first `samples` samples of the record; `None` when it diverges.
    ///
    /// # Errors
    /// [`ModelError`] when a parameter makes no sense.
    pub(crate) fn walk(
        &self,
        morphology: &Morphology,
        record: &WalkRecord,
        samples: usize,
    ) -> Result<Option<OrientationSeries>, ModelError> {
        let walked = self.trajectory(morphology, record, samples)?;
        Ok(walked.map(|trajectory| trajectory.orientation))
    }

    /// The same with all that the simulation's settings record.
    ///
    /// # Errors
    /// [`ModelError`] when a parameter makes no sense.
    pub(crate) fn trajectory(
        &self,
        morphology: &Morphology,
        record: &WalkRecord,
        samples: usize,
    ) -> Result<Option<Trajectory>, ModelError> {
        let settings = SimulationSettings {
            duration_s: record.walk_s(samples),
            stand_s: STAND_S,
            ..self.simulation.clone()
        };
        let robot = self.robot.clone().with_servo(self.servo)?;
        let simulator = Simulator::sharing(&self.commands, robot, &self.gait, settings)?;
        Ok(match simulator.simulate(morphology) {
            Outcome::Walked(trajectory) => Some(trajectory),
            Outcome::Diverged { .. } => None,
        })
    }

    /// What the sensor reports of such a walk, degrees.
    pub(crate) fn observe(
        &self,
        body: &OrientationSeries,
        record: &WalkRecord,
        samples: usize,
    ) -> Axes<Vec<f64>> {
        self.sensing.observe(body, self.clock, record, samples)
    }

    /// The same, and its rates at rest.
    pub(crate) fn predict(
        &self,
        body: &OrientationSeries,
        record: &WalkRecord,
        samples: usize,
    ) -> Prediction {
        Prediction {
            angles_deg: self.observe(body, record, samples),
            rest_rate_dps: self.sensing.rest_rate_dps(record),
        }
    }
}

/// What the sensor of a model reports.
#[derive(Debug, Clone)]
pub(crate) struct Prediction {
    /// Roll, pitch and yaw at the samples of a record.
    pub(crate) angles_deg: Axes<Vec<f64>>,
    /// Rates while the robot stands, degrees per second about x, y, z.
    pub(crate) rest_rate_dps: [f64; 3],
}
