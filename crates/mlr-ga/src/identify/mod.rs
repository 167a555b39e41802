//! From a recording to the damaged legs.

mod answer;
mod beginning;
mod by_paper_cost;
mod by_posterior;
mod gait_phase;
mod leading;
mod log_answer;
mod measured_walk;
mod model_walks;
mod overrides;
mod report;
mod searched;
mod settings;
mod walk_start;

pub use answer::{Alternative, BestFit, ComparedSignals, Course, Frequency, Identification};
pub use gait_phase::{GaitPhase, WalkOffsets};
pub use log_answer::IdentifiedLog;
pub use measured_walk::{MeasuredWalk, Stretch};
pub use overrides::IdentifyOverrides;
pub use report::{IdentificationReport, LogReport};
pub use settings::{IdentifySettings, Method, Search};
pub use walk_start::WalkStart;

use log_answer::LogVerdict;
use mlr_imu::Recording;
use mlr_model::{Gait, Morphology, Robot};
use searched::Searched;

use crate::{
    AnswerError, Model, Progress,
    atlas::Atlas,
    belief::Belief,
    paper_cost::{PaperCost, PaperCosts},
};

/// How many alternatives are reported.
const ALTERNATIVES: usize = 5;

/// A recording of a robot, and the gait that it walked.
#[derive(Debug, Clone, Copy)]
pub struct RecordedWalk<'a> {
    /// What its sensor recorded.
    pub recording: &'a Recording,
    /// The gait.
    pub gait: &'a Gait,
    /// Walks of the robot's candidates with this gait, if they were simulated beforehand.
    pub atlas: Option<&'a Atlas>,
}

/// Names the lost links of the robot that made the recording while walking its gait.
/// [`IdentifySettings::method`] says what decides. Same inputs, same answer, whatever the
/// number of threads.
///
/// # Errors
/// [`AnswerError`]; [`AnswerError::is_recordings_fault`] tells a recording
/// that cannot answer from settings that make no sense.
pub fn identify(
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> Result<Identification, AnswerError> {
    let walk = RecordedWalk {
        recording,
        gait: model.gait,
        atlas: model.atlas,
    };
    let answer = identify_together(&[walk], model.robot, settings, progress);
    answer.map_err(|(_, error)| error)
}

/// Names the lost links of a robot from several walks, between which nothing more was damaged: every
/// morphology in question is compared with all of them, and its likelihoods multiply. What belongs to
/// the day, such as phase, clock, delay, zero of yaw and the variation of the model, is fitted for
/// each. The answer's `fit`, window, start, quality and signals are those of the first walk;
/// [`Identification::logs`] has those of all.
///
/// # Errors
/// [`AnswerError`], with the index of the walk; 0 where it is not the fault of any.
pub fn identify_together(
    walks: &[RecordedWalk<'_>],
    robot: &Robot,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> Result<Identification, (usize, AnswerError)> {
    let of_all = |error| (0, error);
    if walks.len() != 1 {
        settings.check_for_several(walks.len()).map_err(of_all)?;
    }
    let logs = walks.iter().enumerate().map(|(index, walk)| {
        let measured = MeasuredWalk::new(walk.recording, walk.gait, settings);
        let model = Model::new(robot, walk.gait).with_atlas(walk.atlas);
        Ok((measured.map_err(|error| (index, error))?, model))
    });
    let logs = logs.collect::<Result<Vec<_>, _>>()?;
    let search = settings.search_with(walks.iter().all(|walk| walk.atlas.is_some()));
    let verdict = match settings.method {
        Method::Mlr => by_posterior::verdict(&logs, robot, search, settings, progress)?,
        Method::Paper => {
            by_paper_cost::verdict(&logs, robot, search, settings, progress).map_err(of_all)?
        }
    };
    verdict.into_answer(&logs, search, settings)
}

/// A walk that is identified, with the model that it is compared with.
type MeasuredLog<'a> = (MeasuredWalk, Model<'a>);

/// F of candidates for all logs.
fn paper_costs(
    logs: &[MeasuredLog<'_>],
    settings: &IdentifySettings,
) -> Result<PaperCosts, (usize, AnswerError)> {
    let costs = logs.iter().enumerate().map(|(index, (measured, model))| {
        let cost = PaperCost::new(measured, model.robot, model.gait, settings);
        cost.map_err(|error| (index, error.into()))
    });
    Ok(PaperCosts::new(costs.collect::<Result<_, _>>()?))
}

/// What a method decided.
struct Verdict {
    best: Morphology,
    belief: Belief,
    /// What it decided of each log.
    logs: Vec<LogVerdict>,
    /// F of the best morphology, summed over the logs.
    cost_rad: f64,
    mean_error_deg: f64,
    /// Probability of something else than damage, where the method asks for it.
    something_else: Option<f64>,
    alternatives: Vec<Alternative>,
    /// Of every set of damaged legs that was tried the nearest, the nearest first.
    nearest_of_legs: Vec<Morphology>,
    /// Probability that the lost links of the best morphology are locked, where that is asked.
    locked_probability: Option<f64>,
    evaluations: usize,
    diverged: usize,
    searched: Searched,
    warnings: Vec<String>,
}

impl Verdict {
    fn into_answer(
        self,
        logs: &[MeasuredLog<'_>],
        search: Search,
        settings: &IdentifySettings,
    ) -> Result<Identification, (usize, AnswerError)> {
        let Self { best, belief, .. } = self;
        let each = self.logs.into_iter().zip(logs);
        let logs: Vec<IdentifiedLog> = each
            .map(|(verdict, (measured, model))| {
                verdict.into_answer(&model.gait.name, measured, settings)
            })
            .collect();
        let first = logs.first().cloned().ok_or((0, AnswerError::NoLogs))?;
        let mut warnings = self.warnings;
        if logs.len() == 1 {
            warnings = [first.warnings, warnings].concat();
        }
        Ok(Identification {
            method: settings.method,
            search,
            seed: settings.seed,
            damaged_legs: best.damaged_legs(),
            description: best.describe(),
            implausible: self.something_else.is_some_and(|doubt| doubt > 0.5),
            something_else_probability: self.something_else,
            probability: belief.of(&best),
            legs_probability: belief.of_legs_of(&best),
            leg_damage_probability: belief.leg_damage(best.legs()),
            link_loss_probability: belief.link_loss((0..best.legs()).map(|leg| best.links(leg))),
            locked_probability: self.locked_probability,
            cost_rad: self.cost_rad,
            mean_error_deg: self.mean_error_deg,
            fit: first.fit,
            alternatives: self.alternatives,
            indistinguishable: belief
                .posterior
                .credible(settings.credible_share)
                .into_iter()
                .filter(|morphology| **morphology != best)
                .cloned()
                .collect(),
            nearest_of_legs: self.nearest_of_legs,
            motion_start_s: first.motion_start_s,
            window_start_s: first.window_start_s,
            window_s: first.window_s,
            evaluations: self.evaluations,
            diverged: self.diverged,
            cost_per_generation: self.searched.cost_per_generation(),
            frequencies: self.searched.frequencies(),
            runs: self.searched.courses(),
            log_quality: first.log_quality,
            warnings,
            morphology: best,
            signals: first.signals,
            logs,
        })
    }
}
