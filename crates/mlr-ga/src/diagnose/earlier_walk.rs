//! The walk that an explanation is of, as far as its most probable robot makes it.

use mlr_filter::OrientationSeries;
use mlr_model::{
    Gait, ModelError, Morphology, Outcome, Robot, SimulationSettings, Simulator, Variation,
};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::{question::Hypothesis, recorded::Recorded};
use crate::{
    IdentifySettings,
    comparison::{Alignment, ComparableWalk},
};

/// As much of a walk as identifications compare.
const WALK_S: f64 = 5.0;
/// Draws of an effect before the one that walks most like the robot is taken.
const TRIES: usize = 8;

/// What an effect of any size may be is known by this walk: it did not show there.
pub(super) struct EarlierWalk<'s> {
    gait: &'s Gait,
    recorded: Recorded<'s>,
    /// Of the walk itself.
    ln_likelihood: f64,
}

impl<'s> EarlierWalk<'s> {
    /// Of a robot in question that is known; `None` where it does not walk.
    pub(super) fn new(
        of: &Hypothesis<'_>,
        robot: &Robot,
        gait: &'s Gait,
        settings: &'s IdentifySettings,
        generator: &mut ChaCha8Rng,
    ) -> Result<Option<Self>, ModelError> {
        let (robot, simulation) = of.model(robot, gait, &settings.simulation, generator)?;
        let walked = walked(&robot, gait, &simulation, &of.robot.morphology)?;
        Ok(walked.map(|walk| {
            let recorded = Recorded::new(&walk, WALK_S, gait.period_s, settings);
            Self {
                gait,
                ln_likelihood: recorded.ln_likelihood(&ComparableWalk::new(&walk)),
                recorded,
            }
        }))
    }

    /// A draw of a hypothesis under a variation, as probable as it walks like this (rejection sampling).
    pub(super) fn draw(
        &self,
        of: &Hypothesis<'_>,
        robot: &Robot,
        simulation: &SimulationSettings,
        variation: &Variation,
        generator: &mut ChaCha8Rng,
    ) -> Result<(Robot, SimulationSettings), ModelError> {
        let mut drawn = self.drawn(of, robot, simulation, generator)?;
        let mut most_alike = drawn.clone();
        for _ in 1..TRIES {
            if generator.random::<f64>() < drawn.ln_likeness.exp() {
                most_alike = drawn;
                break;
            }
            drawn = self.drawn(of, robot, simulation, generator)?;
            if drawn.ln_likeness > most_alike.ln_likeness {
                most_alike = drawn.clone();
            }
        }
        // What robots of the make differ by shows in every walk, and does not count here.
        variation.apply(&most_alike.robot, &most_alike.simulation)
    }

    fn drawn(
        &self,
        of: &Hypothesis<'_>,
        robot: &Robot,
        simulation: &SimulationSettings,
        generator: &mut ChaCha8Rng,
    ) -> Result<Drawn, ModelError> {
        let (robot, simulation) = of.model(robot, self.gait, simulation, generator)?;
        let walk = walked(&robot, self.gait, &simulation, &of.robot.morphology)?;
        let ln_likelihood = walk.map_or(f64::NEG_INFINITY, |walk| {
            self.recorded.ln_likelihood(&ComparableWalk::new(&walk))
        });
        Ok(Drawn {
            robot,
            simulation,
            ln_likeness: ln_likelihood - self.ln_likelihood,
        })
    }
}

/// A robot with an effect of some size.
#[derive(Clone)]
struct Drawn {
    robot: Robot,
    simulation: SimulationSettings,
    /// Logarithm of its likelihood over that of the robot that made the walk.
    ln_likeness: f64,
}

/// `None` where it diverges.
fn walked(
    robot: &Robot,
    gait: &Gait,
    simulation: &SimulationSettings,
    morphology: &Morphology,
) -> Result<Option<OrientationSeries>, ModelError> {
    let simulation = SimulationSettings {
        duration_s: Alignment::longest_s(WALK_S) + 0.1,
        stand_s: super::STAND_S,
        ..simulation.clone()
    };
    let simulator = Simulator::new(robot.clone(), gait, simulation)?;
    Ok(match simulator.simulate(morphology) {
        Outcome::Walked(walk) => Some(walk.orientation),
        Outcome::Diverged { .. } => None,
    })
}
