//! Robots that may be the one that was damaged.

use mlr_model::{
    Gait, ModelError, Morphology, Outcome, Record, Robot, SimulationSettings, Simulator, Trajectory,
};

/// One robot that may be the case: drawn from what is known of its damage and of what robots of its
/// make differ by.
#[derive(Debug, Clone, PartialEq)]
pub struct PossibleRobot {
    /// The robot in full health.
    pub robot: Robot,
    /// The links that are still there.
    pub morphology: Morphology,
    /// Ground, what became of lost links, and what else is wrong. How long it walks follows from what
    /// is asked for.
    pub simulation: SimulationSettings,
}

impl PossibleRobot {
    /// Lets it do what a gait commands for so long, following its heading; `None` where it diverges.
    ///
    /// # Errors
    /// [`ModelError`] where robot, gait and settings do not fit.
    pub fn walk(&self, gait: &Gait, duration_s: f64) -> Result<Option<Trajectory>, ModelError> {
        let settings = SimulationSettings {
            duration_s,
            stand_s: 0.0,
            record: Record {
                position: true,
                torques: true,
                ..Record::default()
            },
            ..self.simulation.clone()
        };
        let simulator = Simulator::new(self.robot.clone(), gait, settings)?;
        Ok(match simulator.simulate(&self.morphology) {
            Outcome::Walked(trajectory) => Some(trajectory),
            Outcome::Diverged { .. } => None,
        })
    }
}
