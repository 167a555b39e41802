//! From a recording to the effects that the model of its robot lacks.

mod reckoning;
mod report;

pub use report::ExplanationReport;

use mlr_filter::OrientationSeries;
use mlr_imu::{RawSeries, Recording};
use mlr_model::Morphology;
use mlr_residual::{
    Progress,
    walk::{
        MorphologySearch, Suspect, TracingSettings, WalkError, WalkExplanation, WalkModel,
        WalkRecord, explain_walk,
    },
};
use thiserror::Error;

use crate::{
    AnswerError, GaitPhase, Identification, IdentifySettings, MeasuredWalk, Method, Model, Search,
    WalkStart, identify,
};

/// Why a recording has no explanation.
#[derive(Debug, Error)]
pub enum ExplainError {
    /// The robot could not be identified.
    #[error(transparent)]
    Answer(#[from] AnswerError),
    /// The search for effects failed.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// The walk started before the recording: the phase of the gait is unknown.
    #[error("the log does not show the start of the walk, expected the robot to stand first")]
    NoStart,
    /// Effects are weighed against morphologies by their probabilities.
    #[error("method: \"paper\" gives no probabilities to weigh effects by, expected \"mlr\"")]
    MethodWithoutProbabilities,
}

impl ExplainError {
    /// Whether the recording is at fault, rather than what was asked of it.
    pub fn is_recordings_fault(&self) -> bool {
        match self {
            Self::Answer(error) => error.is_recordings_fault(),
            Self::Walk(error) => error.is_recordings_fault(),
            Self::NoStart => true,
            Self::MethodWithoutProbabilities => false,
        }
    }
}

/// An explanation, and the identification without effects that it starts from.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// The robot as identified without any effect.
    pub identification: Identification,
    /// What the model lacks.
    pub explanation: WalkExplanation,
}

/// What is explained, and how.
#[derive(Debug, Clone, Copy)]
pub struct ExplainSettings<'a> {
    /// The identification, with and without effects.
    pub identify: &'a IdentifySettings,
    /// The search for effects.
    pub tracing: &'a TracingSettings,
}

/// Candidate morphologies compared with the one identified, at most.
const SUSPECTS: usize = 16;
/// The robot was damaged from the start if its set of damaged legs has more than this
/// probability there.
const SURE: f64 = 0.9;
/// Time before the detected start of the walk that is not counted as standing.
const MARGIN_S: f64 = 0.1;
/// Longest time before the start of the walk whose rest the sensor's offsets are taken from.
const REST_S: f64 = 8.0;

/// Identifies the robot, attributes the residual of its walk to effects that the model
/// lacks, and identifies it again with each of them in the model.
///
/// # Errors
/// [`ExplainError`].
pub fn explain(
    recording: &Recording,
    model: Model<'_>,
    settings: ExplainSettings<'_>,
    progress: &(impl Progress + crate::Progress),
) -> Result<Explained, ExplainError> {
    let ExplainSettings {
        identify: identify_settings,
        tracing,
    } = settings;
    if identify_settings.method != Method::Mlr {
        return Err(ExplainError::MethodWithoutProbabilities);
    }
    let Model { robot, gait, .. } = model;
    let mut measured = MeasuredWalk::new(recording, gait, identify_settings)?;
    let from_the_start = IdentifySettings {
        from_s: Some(measured.start().start_s),
        ..identify_settings.clone()
    };
    // A stretch that the settings name is used as it is.
    let was_damaged_before = identify_settings.from_s.is_none()
        && was_damaged_before(recording, &measured, model, &from_the_start);
    let identify_settings = if was_damaged_before {
        measured = MeasuredWalk::new(recording, gait, &from_the_start)?;
        &from_the_start
    } else {
        identify_settings
    };
    let record = record(
        &measured,
        recording.raw_beside_angles(),
        gait,
        identify_settings,
    )?;
    // The record comes first: a recording without one needs no search.
    let identification = identify(recording, model, identify_settings, progress)?;
    let nominal = WalkModel::nominal(
        robot.clone(),
        gait.clone(),
        identify_settings.simulation.clone(),
    );
    let suspects = suspects(&identification, identify_settings);
    let again = Again {
        recording: &recording.orientation,
        settings: identify_settings,
        walk_start: match identify_settings.walk_start {
            WalkStart::FoundInRecording => WalkStart::ObservedAtS(measured.start().start_s),
            known => known,
        },
    };
    let explanation = explain_walk(&record, &nominal, &suspects, &again, tracing, progress)?;
    Ok(Explained {
        identification,
        explanation,
    })
}

/// The walk to be explained: dead-reckoned from the raw rates where these are known, the log
/// shows the robot standing, and both agree; else as recorded.
fn record(
    measured: &MeasuredWalk,
    raw: Option<&RawSeries>,
    gait: &mlr_model::Gait,
    settings: &IdentifySettings,
) -> Result<WalkRecord, ExplainError> {
    let start_s = virtual_start_s(measured, gait)?;
    let walk_start_s = measured.start().start_s;
    let rest_s = walk_start_s - REST_S..walk_start_s - MARGIN_S;
    let rest_rate_dps = raw
        .and_then(|raw| raw.rest_rate_radps(rest_s.start, rest_s.end))
        .map(|rate| [rate.x, rate.y, rate.z].map(f64::to_degrees));
    let record = |recording| {
        WalkRecord::new(
            recording,
            start_s,
            settings.walk_start.is_commanded(),
            measured.window().start_s,
            rest_rate_dps,
        )
    };
    let stands_first = matches!(measured.phase(), GaitPhase::Start) && rest_rate_dps.is_some();
    let reckoned = raw
        .filter(|_| stands_first)
        .and_then(|raw| reckoning::dead_reckoned(raw, measured.recording(), rest_s));
    Ok(match &reckoned {
        Some(reckoned) => record(reckoned)?.dead_reckoned(),
        None => record(measured.recording())?,
    })
}

/// Whether a robot whose swing changes in mid-walk was damaged before that. `from_the_start`
/// are the settings that compare from the start of the walk.
fn was_damaged_before(
    recording: &Recording,
    measured: &MeasuredWalk,
    model: Model<'_>,
    from_the_start: &IdentifySettings,
) -> bool {
    let GaitPhase::Elapsed { since_start_s } = measured.phase() else {
        return false;
    };
    let before = IdentifySettings {
        window_s: since_start_s.min(from_the_start.window_s),
        ..from_the_start.clone()
    };
    identify(recording, model, &before, &())
        .is_ok_and(|found| !found.damaged_legs.is_empty() && found.legs_probability > SURE)
}

/// Log time at which the simulated walk starts: with the measured walk, or, where damage
/// struck in mid-walk, so early that the simulation has reached its steady gait at the start
/// of the compared stretch.
fn virtual_start_s(measured: &MeasuredWalk, gait: &mlr_model::Gait) -> Result<f64, ExplainError> {
    match measured.phase() {
        GaitPhase::Start => Ok(measured.start().start_s),
        GaitPhase::Elapsed { since_start_s } => {
            let steady_s = GaitPhase::steady_s(gait);
            let phase_s = since_start_s.rem_euclid(gait.period_s);
            Ok(measured.window().start_s - steady_s - phase_s)
        }
        GaitPhase::Unknown => Err(ExplainError::NoStart),
    }
}

/// The candidate morphologies for the explanation, the most probable first.
fn suspects(found: &Identification, settings: &IdentifySettings) -> Vec<Suspect> {
    let alternatives = found.alternatives.iter().map(|one| &one.morphology);
    let morphologies = std::iter::once(&found.morphology)
        .chain(alternatives)
        .chain(&found.indistinguishable);
    let mut suspects: Vec<Suspect> = Vec::new();
    for morphology in morphologies {
        if suspects.len() < SUSPECTS && !suspects.iter().any(|s| s.morphology == *morphology) {
            suspects.push(Suspect {
                ln_prior: settings.prior.ln(morphology),
                morphology: morphology.clone(),
            });
        }
    }
    suspects
}

/// Identifies the robot with effects in its model.
struct Again<'a> {
    recording: &'a OrientationSeries,
    settings: &'a IdentifySettings,
    walk_start: WalkStart,
}

impl Again<'_> {
    /// Variations are left out: the model is calibrated already.
    fn identify(&self, model: &WalkModel) -> Option<Identification> {
        let robot = model.robot.clone().with_servo(model.servo).ok()?;
        let corrected = model.sensing.correct(self.recording);
        let settings = IdentifySettings {
            variations: self.settings.variations.iter().take(1).copied().collect(),
            simulation: model.simulation.clone(),
            walk_start: self.walk_start,
            search: Some(Search::Ga),
            ..self.settings.clone()
        };
        let model = Model::new(&robot, &model.gait);
        identify(&corrected.into(), model, &settings, &()).ok()
    }
}

impl MorphologySearch for Again<'_> {
    fn with_effects(&self, model: &WalkModel) -> Vec<Suspect> {
        self.identify(model)
            .map(|found| suspects(&found, self.settings))
            .unwrap_or_default()
    }

    fn ln_prior(&self, morphology: &Morphology) -> f64 {
        self.settings.prior.ln(morphology)
    }
}
