//! From the answer to a gait that walks again.

mod diagnoses;
mod report;
mod reported_gait;
mod steering;

pub use report::{RecoveryReport, ReportedOutlook};
pub use reported_gait::ReportedGait;
pub use steering::{GaitJsonError, SteerError, Steering, SteeringReport, gait_of_json, steer};

pub use diagnoses::{diagnosis_of_explanation, diagnosis_of_identification, diagnosis_of_json};

use mlr_filter::DetectorSettings;
use mlr_model::{Gait, Robot, SimulationSettings};
use mlr_recover::{
    Diagnosis, PossibleRobot, RecoverError, RecoverSettings, Recovery, Task, recover,
};
use mlr_residual::walk::{NuisanceSettings, WalkError, WalkModel};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

/// Why there is no gait.
#[derive(Debug, Error)]
pub enum NoRecovery {
    /// The search found none.
    #[error(transparent)]
    Recover(#[from] RecoverError),
    /// The robots cannot be drawn.
    #[error(transparent)]
    Walk(#[from] WalkError),
}

/// What a recovery gait is searched for, and with what.
#[derive(Debug, Clone, Copy)]
pub struct RecoveryOf<'a> {
    /// The robot in full health.
    pub robot: &'a Robot,
    /// Its nominal gait.
    pub gait: &'a Gait,
    /// What may be left of it.
    pub diagnosis: &'a Diagnosis,
    /// How it is simulated.
    pub simulation: &'a SimulationSettings,
    /// What robots of its make differ by.
    pub nuisance: &'a NuisanceSettings,
    /// The damage detector, whose threshold fluctuations should stay below.
    pub detector: DetectorSettings,
}

/// Shares of probability that are far from each other, however many are taken (Weyl 1916).
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// Finds a gait over robots drawn from what is known of this one: what may be left of it, and what
/// robots of its make differ by.
///
/// # Errors
/// [`NoRecovery`].
pub fn recovery_gait(
    of: RecoveryOf<'_>,
    settings: &RecoverSettings,
    seed: u64,
    progress: &dyn mlr_residual::Progress,
) -> Result<Recovery, NoRecovery> {
    settings.check().map_err(RecoverError::from)?;
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let first: f64 = generator.random();
    let mut robots = Vec::new();
    for index in 0..settings.judged_robots {
        let share = first + GOLDEN_RATIO * index as f64;
        let case = of.diagnosis.at(share - share.floor());
        let simulation = case.simulated(of.simulation);
        let nominal =
            WalkModel::of_make(of.robot.clone(), of.gait.clone(), simulation, of.nuisance);
        let drawn = nominal.drawn(&case.morphology, of.nuisance, &mut generator)?;
        let robot = drawn.robot.with_servo(drawn.servo);
        robots.push(PossibleRobot {
            robot: robot.map_err(WalkError::from)?,
            morphology: case.morphology.clone(),
            simulation: drawn.simulation,
        });
    }
    let task = Task {
        robot: of.robot,
        nominal: of.gait,
        diagnosis: of.diagnosis,
        robots: &robots,
        detector: of.detector,
    };
    Ok(recover(task, settings, &mut generator, progress)?)
}
