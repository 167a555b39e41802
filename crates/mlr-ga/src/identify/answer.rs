use mlr_filter::{Conditioned, EvenSamples};
use mlr_imu::quality::LogQuality;
use mlr_model::{LostLinks, Morphology, Variation};
use serde::{Deserialize, Serialize};

use super::{IdentifiedLog, IdentifySettings, MeasuredWalk, Method, Search, Stretch};
use crate::{PaperFit, comparison::Alignment, evaluation::CaseFit};

/// The answer. Serialises to the fields of `mlr.identification/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Identification {
    /// What decided.
    pub method: Method,
    /// How the morphologies were searched.
    pub search: Search,
    /// Seed of the search.
    pub seed: u64,
    /// The best morphology.
    pub morphology: Morphology,
    /// Numbers (from 1) of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// The damage in words.
    pub description: String,
    /// Whether no morphology explains the recording: it is more probable than not that
    /// something else decides how the robot walks. The morphology is then only the closest.
    pub implausible: bool,
    /// Probability that something else than damage to legs decides how the robot walks. The
    /// probabilities of legs, links and morphologies allow for it. The paper's method does not
    /// ask.
    pub something_else_probability: Option<f64>,
    /// Probability of exactly this morphology. By the paper's method, this and every other
    /// probability is the share of the runs that ended so.
    pub probability: f64,
    /// Probability that exactly these legs are damaged.
    pub legs_probability: f64,
    /// Probability of each leg to miss a link.
    pub leg_damage_probability: Vec<f64>,
    /// Probability of each link to be gone, leg by leg from the body outward.
    pub link_loss_probability: Vec<Vec<f64>>,
    /// Probability that the lost links of this morphology are locked and not gone; `None` where it
    /// lost none, and by the paper's method.
    pub locked_probability: Option<f64>,
    /// The paper's F of the best morphology on the nominal model.
    pub cost_rad: f64,
    /// F per sample and axis.
    pub mean_error_deg: f64,
    /// How the walk of the best morphology fits best.
    pub fit: BestFit,
    /// The next most probable morphologies.
    pub alternatives: Vec<Alternative>,
    /// Morphologies that this recording cannot tell from the best: together with
    /// it, those that hold nearly all of the probability.
    pub indistinguishable: Vec<Morphology>,
    /// Of every set of damaged legs that was tried the morphology whose walk on the nominal model comes nearest,
    /// the nearest first.
    #[serde(skip)]
    pub nearest_of_legs: Vec<Morphology>,
    /// Log time at which the walk started, if the recording shows it.
    pub motion_start_s: Option<f64>,
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// Length of the compared stretch.
    pub window_s: f64,
    /// Morphologies evaluated. By the paper's method, candidates of all generations and runs,
    /// those that were met again included.
    pub evaluations: usize,
    /// Simulations that diverged and count as infinitely costly.
    pub diverged: usize,
    /// Best deciding cost so far in degrees, generation by generation, of the
    /// genetic algorithm's most frequent result. Empty for the exact search.
    pub cost_per_generation: Vec<f64>,
    /// The results of repeated runs, most frequent first. Empty for a single
    /// run.
    pub frequencies: Vec<Frequency>,
    /// The repeated runs one by one. Empty for a single run.
    pub runs: Vec<Course>,
    /// Quality of the recording.
    pub log_quality: LogQuality,
    /// Warnings for people. Of several recordings, what concerns one of them stands with it.
    pub warnings: Vec<String>,
    /// The compared signals.
    #[serde(skip)]
    pub signals: ComparedSignals,
    /// What each recording says of the best morphology.
    #[serde(skip)]
    pub logs: Vec<IdentifiedLog>,
}

/// The model and the alignment under which the best morphology is likeliest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BestFit {
    /// What the lost links are taken to be.
    pub lost_links: LostLinks,
    /// Clock and delay of the robot.
    #[serde(flatten)]
    pub alignment: Alignment,
    /// The variation of the model.
    #[serde(flatten)]
    pub variation: Variation,
    /// Log time at which the model's walk starts that fits best, in steps of the alignment: it tells the
    /// phase of the gait where the recording does not show the start of the walk. The paper's method does
    /// not say.
    #[serde(default)]
    pub gait_start_s: Option<f64>,
    /// Root mean square of what is left of roll, pitch and yaw without their means
    /// and trends.
    pub error_deg: [f64; 3],
    /// Root mean square of measured roll, pitch and yaw without their means and trends.
    pub motion_deg: [f64; 3],
}

impl BestFit {
    pub(super) fn new(
        fit: CaseFit,
        stretch: &Stretch,
        error_deg: [f64; 3],
        motion_deg: [f64; 3],
        variations: &[Variation],
    ) -> Self {
        let alignment = fit.misfit.alignment;
        Self {
            lost_links: fit.case.lost_links,
            alignment,
            gait_start_s: Some(stretch.gait_start_s(fit.offset, alignment)),
            variation: variations
                .get(fit.case.variation)
                .copied()
                .unwrap_or_default(),
            error_deg,
            motion_deg,
        }
    }

    /// How the walk of the nominal model fits after Algorithm 2, without any alignment.
    pub(super) fn of_conditioned(fit: &PaperFit, measured: &Conditioned) -> Self {
        let simulated = &fit.simulated;
        let rms_deg = |signal: &mut dyn ExactSizeIterator<Item = f64>| {
            let count = signal.len().max(1) as f64;
            (signal.map(|x| x * x).sum::<f64>() / count)
                .sqrt()
                .to_degrees()
        };
        let axes = [
            (&measured.roll, &simulated.roll),
            (&measured.pitch, &simulated.pitch),
            (&measured.yaw, &simulated.yaw),
        ];
        Self {
            lost_links: fit.lost_links,
            alignment: Alignment::default(),
            gait_start_s: None,
            variation: Variation::default(),
            error_deg: axes.map(|(m, s)| rms_deg(&mut m.iter().zip(s).map(|(m, s)| m - s))),
            motion_deg: axes.map(|(m, _)| rms_deg(&mut m.iter().copied())),
        }
    }
}

/// Measured and simulated orientation of the compared stretch, before and after the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedSignals {
    /// Rate of the common time vector after the filter.
    pub rate_hz: f64,
    /// The recording after the filter.
    pub measured: Conditioned,
    /// The walk of the morphology after the filter.
    pub simulated: Conditioned,
    /// The recording before the filter.
    pub measured_unfiltered: EvenSamples,
    /// The walk of the morphology before the filter.
    pub simulated_unfiltered: EvenSamples,
}

impl ComparedSignals {
    pub(crate) fn new(
        measured: &MeasuredWalk,
        simulated: PaperFit,
        settings: &IdentifySettings,
    ) -> Self {
        Self {
            rate_hz: settings.filter.rate_hz,
            measured: measured.conditioned().clone(),
            simulated: simulated.simulated,
            measured_unfiltered: measured.unfiltered().clone(),
            simulated_unfiltered: simulated.unfiltered,
        }
    }
}

/// A morphology that explains the recording less well.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Alternative {
    /// The morphology.
    pub morphology: Morphology,
    /// Its F on the nominal model.
    pub cost_rad: f64,
    /// Its probability.
    pub probability: f64,
    /// Probability that its lost links are locked and not gone, where that is asked.
    pub locked_probability: Option<f64>,
}

/// How often repeated runs of the genetic algorithm gave a morphology.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Frequency {
    /// The morphology.
    pub morphology: Morphology,
    /// Its deciding cost.
    pub cost_deg: f64,
    /// Runs that ended with it.
    pub count: usize,
}

/// One run of the genetic algorithm.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Course {
    /// Its result.
    pub morphology: Morphology,
    /// The best cost so far in degrees, generation by generation.
    pub cost_per_generation: Vec<f64>,
}
