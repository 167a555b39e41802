//! Walking the damaged robot.

mod contacts;
pub(crate) mod leg_state;
pub(crate) mod physics;
pub(crate) mod servo_state;
mod settings;
mod trajectory;
mod walk;
mod world;

pub use leg_state::Obedience;
pub use settings::{GroundContact, Impacts, LostLinks, Record, SimulationSettings};
pub use trajectory::{Outcome, Trajectory};
pub use walk::Walk;

use std::sync::Arc;

use nalgebra::UnitQuaternion;
use rapier3d::prelude::SharedShape;

use crate::{CommandCache, Gait, JointCommands, ModelError, Morphology, Robot};

/// Simulates one robot with one gait for any morphology.
///
/// What does not depend on the morphology (joint commands, terrain) is prepared
/// once. A `Simulator` can be shared between threads; every simulation has a
/// world of its own.
#[derive(Debug)]
pub struct Simulator {
    robot: Robot,
    commands: Arc<JointCommands>,
    settings: SimulationSettings,
    ground: SharedShape,
    ground_rotation: UnitQuaternion<f64>,
}

impl Simulator {
    /// Checks that the robot can follow the gait and prepares it.
    ///
    /// # Errors
    /// [`ModelError::Unreachable`], [`ModelError::NoFooting`] or [`ModelError::LegCount`]
    /// when robot and gait do not fit, [`ModelError::Setting`] when a setting makes no sense.
    pub fn new(
        robot: Robot,
        gait: &Gait,
        settings: SimulationSettings,
    ) -> Result<Self, ModelError> {
        Self::sharing(&CommandCache::default(), robot, gait, settings)
    }

    /// The same, whose joint commands are taken from this cache, or kept there.
    ///
    /// # Errors
    /// Those of [`Simulator::new`].
    pub fn sharing(
        cache: &CommandCache,
        robot: Robot,
        gait: &Gait,
        settings: SimulationSettings,
    ) -> Result<Self, ModelError> {
        settings.check_on(&robot)?;
        let commands = cache.commands(&robot, gait, settings.duration_s)?;
        let (ground, up) = settings.terrain.level_shape();
        let ground_rotation = settings.terrain.inclination() * up;
        Ok(Self {
            robot,
            commands,
            settings,
            ground,
            ground_rotation,
        })
    }

    /// The robot in full health.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The settings of every simulation.
    pub fn settings(&self) -> &SimulationSettings {
        &self.settings
    }

    /// Lets the robot with `morphology` stand for the settling time and then
    /// walk for the duration of the settings.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn simulate(&self, morphology: &Morphology) -> Outcome {
        self.start(morphology).finish()
    }

    /// Sets the robot with `morphology` down and begins to let it stand and walk.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn start(&self, morphology: &Morphology) -> Walk<'_> {
        assert_eq!(
            morphology.layout(),
            self.robot.layout(),
            "the morphology must have the robot's legs and links"
        );
        Walk::new(self, morphology)
    }

    fn commands(&self) -> &JointCommands {
        &self.commands
    }
}

fn whole_steps(duration_s: f64, time_step_s: f64) -> i64 {
    libm::round(duration_s / time_step_s) as i64
}
