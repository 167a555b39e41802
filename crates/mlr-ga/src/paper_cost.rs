//! The paper's cost F of candidates: what decides by the paper's method, and what every report
//! states.

mod of_logs;

pub(crate) use of_logs::PaperCosts;

use mlr_filter::{Conditioned, EvenSamples, FilterSettings, FourierFilter, SamplingLimits, Window};
use mlr_model::{
    Gait, LostLinks, ModelError, Morphology, Outcome, Robot, SimulationSettings, Simulator,
};

use crate::{
    BestFit, IdentifySettings, LossHypothesis, MeasuredWalk,
    comparison::{Alignment, ComparableWalk},
    mean_error_deg, orientation_error_rad,
};

/// Simulates a candidate on the nominal model, filters its orientation and compares
/// it with the filtered measurement by F.
#[derive(Debug)]
pub struct PaperCost {
    measured: Conditioned,
    lost_links: LossHypothesis,
    /// Gait times at which the measured window may start. The candidate is
    /// compared from each, and the best counts.
    gait_times_s: Vec<f64>,
    simulators: Vec<Simulator>,
    alignment: Alignment,
    filter: FilterSettings,
    window_s: f64,
}

/// The walk of a candidate that F compares with the measured one.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFit {
    /// What the lost links of the candidate are taken to be.
    pub lost_links: LostLinks,
    /// Its walk on the nominal model after the filter, from the gait time that fits best on.
    pub simulated: Conditioned,
    /// The same before the filter.
    pub unfiltered: EvenSamples,
    /// F.
    pub cost_rad: f64,
}

impl PaperFit {
    /// F per sample and axis, in degrees.
    pub fn mean_error_deg(&self) -> f64 {
        mean_error_deg(self.cost_rad, self.simulated.roll.len())
    }
}

/// How finely an unknown phase of the gait is tried.
const PHASE_STEP_S: f64 = 0.020;

impl PaperCost {
    /// F for the `measured` walk of the same settings.
    ///
    /// # Errors
    /// [`ModelError`] when robot, gait and settings do not fit.
    pub fn new(
        measured: &MeasuredWalk,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, ModelError> {
        Self::aligned(measured, robot, gait, settings, Alignment::default())
    }

    /// F not of the nominal model, but of the model that a `fit` says, laid over the measured walk as
    /// it says.
    pub(crate) fn of_fit(
        measured: &MeasuredWalk,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
        fit: &BestFit,
    ) -> Result<Self, ModelError> {
        let (robot, simulation) = fit.variation.apply(robot, &settings.simulation)?;
        let settings = IdentifySettings {
            simulation,
            lost_links: fit.lost_links.into(),
            ..settings.clone()
        };
        Self::aligned(measured, &robot, gait, &settings, fit.alignment)
    }

    fn aligned(
        measured: &MeasuredWalk,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
        alignment: Alignment,
    ) -> Result<Self, ModelError> {
        let gait_times_s = gait_times_s(measured);
        let last_s = gait_times_s.iter().copied().fold(0.0, f64::max);
        let window_s = measured.window().duration_s;
        let simulators = settings
            .lost_links
            .cases()
            .iter()
            .map(|&lost_links| {
                let simulation = SimulationSettings {
                    duration_s: last_s + alignment.gait_time_s(window_s).max(window_s),
                    stand_s: 0.0,
                    lost_links,
                    ..settings.simulation.clone()
                };
                Simulator::new(robot.clone(), gait, simulation)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            measured: measured.conditioned().clone(),
            lost_links: settings.lost_links,
            gait_times_s,
            simulators,
            alignment,
            filter: settings.filter,
            window_s,
        })
    }

    /// The walk of a candidate and its F. `None` when it diverged, or when
    /// `lost_links` is no case of the hypothesis.
    pub fn of(&self, candidate: &Morphology, lost_links: LostLinks) -> Option<PaperFit> {
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
                let aligned = self.alignment.of_walk(&trajectory.orientation, start_s);
                let unfiltered = window
                    .cut(&aligned, &SamplingLimits::default())
                    .expect("a simulated walk covers its windows at more than the lowest rate");
                let simulated = filter.condition(&unfiltered);
                PaperFit {
                    lost_links,
                    cost_rad: orientation_error_rad(&self.measured, &simulated),
                    simulated,
                    unfiltered,
                }
            })
            .min_by(|a, b| a.cost_rad.total_cmp(&b.cost_rad))
    }

    /// The walk with the least F among those that the lost links of the candidate allow. `None`
    /// when every walk diverged.
    pub fn least(&self, candidate: &Morphology) -> Option<PaperFit> {
        self.lost_links
            .cases_of(candidate)
            .iter()
            .filter_map(|&lost_links| self.of(candidate, lost_links))
            .min_by(|a, b| a.cost_rad.total_cmp(&b.cost_rad))
    }
}

/// A walk that starts with the window has one gait time; in mid-walk the whole range of
/// possible ones is tried.
fn gait_times_s(measured: &MeasuredWalk) -> Vec<f64> {
    let stretch = measured.stretch();
    let time_s = |sample: usize| sample as f64 / ComparableWalk::RATE_HZ + stretch.later_s;
    match (stretch.offsets.first(), stretch.offsets.last()) {
        (Some(&first), Some(&last)) => {
            let steps = ((time_s(last) - time_s(first)) / PHASE_STEP_S).round() as u32;
            (0..=steps)
                .map(|step| time_s(first) + f64::from(step) * PHASE_STEP_S)
                .collect()
        }
        _ => vec![0.0],
    }
}
