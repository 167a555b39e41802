//! From a recording to the effects that the model of its robot lacks.

mod reckoning;
mod report;

pub use report::ExplanationReport;

use mlr_imu::{RawSeries, Recording};
use mlr_model::Morphology;
use mlr_residual::{
    Progress,
    walk::{
        EvidenceSettings, Suspect, WalkError, WalkExplanation, WalkModel, WalkRecord, explain_walk,
    },
};
use thiserror::Error;

use crate::{
    AnswerError, GaitPhase, Identification, IdentifySettings, MeasuredWalk, Method, Model, identify,
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
    pub explanation: &'a EvidenceSettings,
}

/// Probability that an effect misled the identification about the damaged legs. Assumed, not measured: no
/// morphology is out of the question before its walk with effects is compared.
const MISLED: f64 = 0.1;
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
        explanation,
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
        WalkRecord::LONGEST_WALK_S,
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
    let ln_prior =
        |morphology: &Morphology| ln_prior(&identification, identify_settings, morphology);
    let explanation = explain_walk(
        &record,
        &nominal,
        &suspects,
        &ln_prior,
        explanation,
        progress,
    )?;
    Ok(Explained {
        identification,
        explanation,
    })
}

/// The walk of a recording as explanations see it: for learning what the model gets wrong.
///
/// # Errors
/// [`ExplainError`] where there is no walk or its start is not known.
pub fn walk_record(
    recording: &Recording,
    gait: &mlr_model::Gait,
    settings: &IdentifySettings,
) -> Result<WalkRecord, ExplainError> {
    walk_record_up_to(WalkRecord::LONGEST_WALK_S, recording, gait, settings)
}

/// The same where so much of the walk is looked at.
pub(crate) fn walk_record_up_to(
    longest_s: f64,
    recording: &Recording,
    gait: &mlr_model::Gait,
    settings: &IdentifySettings,
) -> Result<WalkRecord, ExplainError> {
    let measured = MeasuredWalk::new(recording, gait, settings)?;
    let raw = recording.raw_beside_angles();
    record(longest_s, &measured, raw, gait, settings)
}

/// The walk to be explained: dead-reckoned from the raw rates where these are known, the log
/// shows the robot standing, and both agree; else as recorded.
fn record(
    longest_s: f64,
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
        WalkRecord::up_to(
            longest_s,
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
            let [steady_s, phase_s] = GaitPhase::steady_s(gait, since_start_s);
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
                ln_prior: ln_prior(found, settings, morphology),
                morphology: morphology.clone(),
            });
        }
    }
    suspects
}

/// Logarithm of the probability of a morphology for an explanation: as identified where nothing but
/// links is missing, and as of any robot where something else misled the identification.
fn ln_prior(found: &Identification, settings: &IdentifySettings, morphology: &Morphology) -> f64 {
    let identified = match *morphology == found.morphology {
        true => found.probability,
        false => found
            .alternatives
            .iter()
            .find(|one| one.morphology == *morphology)
            .map_or(0.0, |one| one.probability),
    };
    let before = settings.prior.ln(morphology).exp();
    ((1.0 - MISLED) * identified + MISLED * before).ln()
}
