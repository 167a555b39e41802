//! From the answer to a gait that walks again.

mod report;

pub use report::{RecoveryReport, ReportedOutlook};

use mlr_model::{Gait, Robot, SimulationSettings};
use mlr_recover::{PossibleRobot, RecoverError, RecoverSettings, Recovery, WhatIsLeft, recover};
use mlr_residual::walk::{NuisanceSettings, WalkError, WalkModel};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::Identification;

/// What may be left of a robot, each with its probability, the most probable first. Never empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis(Vec<(WhatIsLeft, f64)>);

impl Diagnosis {
    /// What is left is known.
    pub fn certain(left: WhatIsLeft) -> Self {
        Self(vec![(left, 1.0)])
    }

    /// The morphologies of an identification.
    pub fn of(found: &Identification) -> Self {
        let best = (found.morphology.clone(), found.probability);
        let others = found.alternatives.iter();
        let others = others.map(|one| (one.morphology.clone(), one.probability));
        let with = |(morphology, probability)| {
            let left = WhatIsLeft {
                lost_links: found.fit.lost_links,
                ..WhatIsLeft::of(morphology)
            };
            (left, probability)
        };
        let mut cases: Vec<_> = std::iter::once(best).chain(others).map(with).collect();
        if cases
            .iter()
            .map(|(_, probability)| probability)
            .sum::<f64>()
            <= 0.0
        {
            cases.truncate(1);
            cases[0].1 = 1.0;
        }
        Self(cases)
    }

    /// What is left most probably.
    pub fn most_probable(&self) -> &WhatIsLeft {
        &self.0[0].0
    }

    /// The case that a share of all probability, from 0 to 1, falls into.
    fn at(&self, share: f64) -> &WhatIsLeft {
        let total: f64 = self.0.iter().map(|(_, probability)| probability).sum();
        let mut left = share * total;
        for (case, probability) in &self.0 {
            left -= probability;
            if left <= 0.0 {
                return case;
            }
        }
        self.most_probable()
    }
}

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
}

/// Robots that a gait is judged on.
const ROBOTS: usize = 24;
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
    progress: &dyn mlr_recover::Progress,
) -> Result<Recovery, NoRecovery> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let first: f64 = generator.random();
    let mut robots = Vec::with_capacity(ROBOTS);
    for index in 0..ROBOTS {
        let share = first + GOLDEN_RATIO * index as f64;
        let case = of.diagnosis.at(share - share.floor());
        let simulation = SimulationSettings {
            lost_links: case.lost_links,
            faults: case.faults.clone(),
            ..of.simulation.clone()
        };
        let nominal = WalkModel::nominal(of.robot.clone(), of.gait.clone(), simulation);
        let drawn = nominal.drawn(&case.morphology, of.nuisance, &mut generator)?;
        let robot = drawn.robot.with_servo(drawn.servo);
        robots.push(PossibleRobot {
            robot: robot.map_err(WalkError::from)?,
            morphology: case.morphology.clone(),
            simulation: drawn.simulation,
        });
    }
    let left = of.diagnosis.most_probable();
    let found = recover(
        of.robot,
        of.gait,
        left,
        &robots,
        settings,
        &mut generator,
        progress,
    )?;
    Ok(found)
}
