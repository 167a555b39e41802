//! From a recording to the damaged legs.

mod answer;
mod by_paper_cost;
mod by_posterior;
mod gait_phase;
mod leading;
mod measured_walk;
mod model_walks;
mod report;
mod searched;
mod settings;
mod walk_start;

pub use answer::{Alternative, BestFit, ComparedSignals, Course, Frequency, Identification};
pub use gait_phase::{GaitPhase, WalkOffsets};
pub use measured_walk::{MeasuredWalk, Stretch};
pub use report::IdentificationReport;
pub use settings::{IdentifySettings, Method, Search};
pub use walk_start::WalkStart;

use mlr_imu::Recording;
use mlr_model::Morphology;
use searched::Searched;

use crate::{AnswerError, Model, PaperFit, Progress, belief::Belief};

/// How many alternatives are reported.
const ALTERNATIVES: usize = 5;

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
    let measured = MeasuredWalk::new(recording, model.gait, settings)?;
    let search = settings.search_with(model.atlas.is_some());
    let verdict = match settings.method {
        Method::Mlr => by_posterior::verdict(&measured, model, search, settings, progress)?,
        Method::Paper => by_paper_cost::verdict(&measured, model, search, settings, progress)?,
    };
    Ok(verdict.into_answer(&measured, search, settings))
}

/// What a method decided.
struct Verdict {
    best: Morphology,
    belief: Belief,
    /// Probability of something else than damage, where the method asks for it.
    something_else: Option<f64>,
    fit: BestFit,
    /// F of the best morphology.
    paper_fit: PaperFit,
    alternatives: Vec<Alternative>,
    evaluations: usize,
    diverged: usize,
    searched: Searched,
    warnings: Vec<String>,
}

impl Verdict {
    fn into_answer(
        self,
        measured: &MeasuredWalk,
        search: Search,
        settings: &IdentifySettings,
    ) -> Identification {
        let Self { best, belief, .. } = self;
        let start = measured.start();
        Identification {
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
            cost_rad: self.paper_fit.cost_rad,
            mean_error_deg: self.paper_fit.mean_error_deg(),
            fit: self.fit,
            alternatives: self.alternatives,
            indistinguishable: belief
                .posterior
                .credible(settings.credible_share)
                .into_iter()
                .filter(|morphology| **morphology != best)
                .cloned()
                .collect(),
            motion_start_s: start.stood_before.then_some(start.start_s),
            window_start_s: measured.window().start_s,
            window_s: measured.window().duration_s,
            evaluations: self.evaluations,
            diverged: self.diverged,
            cost_per_generation: self.searched.cost_per_generation(),
            frequencies: self.searched.frequencies(),
            runs: self.searched.courses(),
            log_quality: measured.quality().clone(),
            warnings: [measured.warnings(), &self.warnings].concat(),
            morphology: best,
            signals: ComparedSignals::new(measured, self.paper_fit.simulated, settings),
        }
    }
}
