//! The cost of a morphology: its simulated walk against the measured one.

use mlr_filter::{
    Conditioned, FilterError, FilterSettings, FourierFilter, OrientationSeries, SamplingLimits,
    Window,
};
use mlr_model::{
    Gait, LostLinks, ModelError, Morphology, Outcome, Robot, SimulationSettings, Simulator,
};
use serde::{Deserialize, Serialize};

use crate::{Evaluation, IdentifySettings, Objective, orientation_error_rad};

/// What a lost link may have become.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LossHypothesis {
    /// Gone, with its mass.
    Absent,
    /// Locked clear of the ground, its mass still on the robot.
    Locked,
    /// Either of the two, the same for all lost links: a candidate is simulated
    /// both ways and the better one counts.
    #[default]
    Either,
}

impl LossHypothesis {
    fn cases(self) -> &'static [LostLinks] {
        match self {
            Self::Absent => &[LostLinks::Absent],
            Self::Locked => &[LostLinks::Locked],
            Self::Either => &[LostLinks::Absent, LostLinks::Locked],
        }
    }
}

/// Simulates a candidate, filters its orientation and compares it with the
/// filtered measurement by the paper's F.
#[derive(Debug)]
pub struct WalkObjective {
    measured: Conditioned,
    simulators: Vec<Simulator>,
    filter: FilterSettings,
    window_s: f64,
}

impl WalkObjective {
    /// `measured` is the window of the recording from the start of the walk on,
    /// after the filter of the same settings.
    ///
    /// # Errors
    /// [`ModelError`] when robot, gait and settings do not fit.
    pub fn new(
        measured: Conditioned,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, ModelError> {
        let simulators = settings
            .lost_links
            .cases()
            .iter()
            .map(|&lost_links| {
                let simulation = SimulationSettings {
                    duration_s: settings.window_s,
                    stand_s: 0.0,
                    lost_links,
                    ..settings.simulation.clone()
                };
                Simulator::new(robot.clone(), gait, simulation)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            measured,
            simulators,
            filter: settings.filter,
            window_s: settings.window_s,
        })
    }

    /// The simulated walk of a candidate after the filter. `None` when it
    /// diverged, or when `lost_links` is no case of the hypothesis.
    pub fn walk(&self, candidate: &Morphology, lost_links: LostLinks) -> Option<Conditioned> {
        let simulator = self
            .simulators
            .iter()
            .find(|simulator| simulator.settings().lost_links == lost_links)?;
        match simulator.simulate(candidate) {
            Outcome::Walked(trajectory) => {
                condition(&trajectory.orientation, self.filter, self.window_s).ok()
            }
            Outcome::Diverged { .. } => None,
        }
    }
}

/// Filters the first `window_s` of a simulated walk.
fn condition(
    walk: &OrientationSeries,
    filter: FilterSettings,
    window_s: f64,
) -> Result<Conditioned, FilterError> {
    let window = Window {
        start_s: 0.0,
        duration_s: window_s,
    };
    let even = window
        .cut(walk, &SamplingLimits::default())
        .expect("a simulated walk covers its window at more than the lowest rate");
    Ok(FourierFilter::new(filter, window_s)?.condition(&even))
}

impl Objective for WalkObjective {
    fn evaluate(&self, candidate: &Morphology) -> Evaluation {
        // Without a lost link the hypotheses are the same.
        let cases = if candidate.is_healthy() {
            &self.simulators[..1]
        } else {
            &self.simulators[..]
        };
        let mut best = Evaluation {
            cost_rad: f64::INFINITY,
            lost_links: cases[0].settings().lost_links,
            diverged: 0,
        };
        for lost_links in cases
            .iter()
            .map(|simulator| simulator.settings().lost_links)
        {
            match self.walk(candidate, lost_links) {
                Some(simulated) => {
                    let cost_rad = orientation_error_rad(&self.measured, &simulated);
                    if cost_rad < best.cost_rad {
                        best.cost_rad = cost_rad;
                        best.lost_links = lost_links;
                    }
                }
                None => best.diverged += 1,
            }
        }
        best
    }
}
