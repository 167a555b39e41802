//! The cost of a morphology: its simulated walk against the measured one.

use mlr_filter::{Conditioned, FilterSettings, FourierFilter, SamplingLimits, Window};
use mlr_model::{
    Gait, LostLinks, ModelError, Morphology, Outcome, Robot, SimulationSettings, Simulator,
};
use serde::{Deserialize, Serialize};

use crate::{Evaluation, IdentifySettings, MeasuredWalk, Objective, orientation_error_rad};

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
    /// Gait times at which the measured window may have begun. The candidate is
    /// compared from each, and the best counts.
    gait_times_s: Vec<f64>,
    simulators: Vec<Simulator>,
    filter: FilterSettings,
    window_s: f64,
}

impl WalkObjective {
    /// The cost of morphologies for the `measured` walk of the same settings.
    ///
    /// # Errors
    /// [`ModelError`] when robot, gait and settings do not fit.
    pub fn new(
        measured: &MeasuredWalk,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, ModelError> {
        let gait_times_s = measured.phase().gait_times_s(gait);
        let last_s = gait_times_s.iter().copied().fold(0.0, f64::max);
        let simulators = settings
            .lost_links
            .cases()
            .iter()
            .map(|&lost_links| {
                let simulation = SimulationSettings {
                    duration_s: last_s + settings.window_s,
                    stand_s: 0.0,
                    lost_links,
                    ..settings.simulation.clone()
                };
                Simulator::new(robot.clone(), gait, simulation)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            measured: measured.conditioned().clone(),
            gait_times_s,
            simulators,
            filter: settings.filter,
            window_s: settings.window_s,
        })
    }

    /// The simulated walk of a candidate after the filter, from the gait time
    /// that fits best on, and its cost. `None` when it diverged, or when
    /// `lost_links` is no case of the hypothesis.
    pub fn walk(
        &self,
        candidate: &Morphology,
        lost_links: LostLinks,
    ) -> Option<(Conditioned, f64)> {
        let simulator = self
            .simulators
            .iter()
            .find(|simulator| simulator.settings().lost_links == lost_links)?;
        let Outcome::Walked(trajectory) = simulator.simulate(candidate) else {
            return None;
        };
        let mut filter = FourierFilter::new(self.filter, self.window_s)
            .expect("the measured walk went through a filter of the same settings");
        self.gait_times_s
            .iter()
            .map(|&start_s| {
                let window = Window {
                    start_s,
                    duration_s: self.window_s,
                };
                let even = window
                    .cut(&trajectory.orientation, &SamplingLimits::default())
                    .expect("a simulated walk covers its windows at more than the lowest rate");
                let simulated = filter.condition(&even);
                let cost_rad = orientation_error_rad(&self.measured, &simulated);
                (simulated, cost_rad)
            })
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
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
                Some((_, cost_rad)) if cost_rad < best.cost_rad => {
                    best.cost_rad = cost_rad;
                    best.lost_links = lost_links;
                }
                Some(_) => {}
                None => best.diverged += 1,
            }
        }
        best
    }
}
