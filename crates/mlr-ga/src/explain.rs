//! From a recording to the effects that the model of its robot lacks.

mod earlier;
mod healthy_stretch;
mod reckoning;
mod report;

pub use earlier::earlier_effects_of_json;
pub use report::ExplanationReport;

use mlr_imu::{RawSeries, Recording};
use mlr_model::Morphology;
use mlr_residual::{
    Progress,
    walk::{
        Beforehand, EarlierEffects, EvidenceSettings, NuisanceSettings, Suspect, WalkError,
        WalkExplanation, WalkModel, WalkRecord, explain_walk,
    },
};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::{
    AnswerError, GaitPhase, Identification, IdentifySettings, MeasuredWalk, Method, Model,
    evaluation::PartOf, identify,
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
    /// The log does not tell the phase of the gait, which nothing but an identification would find.
    #[error(
        "the log does not show the start of the walk soon before it is compared, expected the robot to stand first"
    )]
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
    /// Log times of the walk before damage in mid-walk that the robot is known by; `None` where there
    /// is none, or it does not tell.
    pub calibrated_on_s: Option<[f64; 2]>,
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
/// Most probable alternatives to the identified morphology, which are candidates before those with other damaged legs.
const NEXT: usize = 2;
/// Sets of other damaged legs, at most; how many of them are simulated, `effort.bases` bounds.
const OTHER_LEGS: usize = 4;
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
    explain_after(None, recording, model, settings, progress)
}

/// The same where an earlier log of the robot says which effects it has.
///
/// # Errors
/// [`ExplainError`].
pub fn explain_after(
    earlier: Option<&EarlierEffects>,
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
    let gait = model.gait;
    let mut measured = MeasuredWalk::new(recording, gait, identify_settings)?;
    let from_the_start = IdentifySettings {
        from_s: Some(measured.start().start_s),
        ..identify_settings.clone()
    };
    // A stretch that the settings name is used as it is.
    let before = identify_settings.from_s.is_none();
    let part = PartOf(progress);
    let before =
        before.then(|| before_the_change(recording, &measured, model, &from_the_start, &part));
    let before = before.flatten();
    let was_damaged =
        |found: &Identification| !found.damaged_legs.is_empty() && found.legs_probability > SURE;
    let was_healthy = |found: &Identification| found.damaged_legs.is_empty();
    let healthy_until_s = measured.unchanged_until_s().filter(|_| {
        identify_settings.calibrate_before_damage && before.as_ref().is_some_and(was_healthy)
    });
    let mut warnings = Vec::new();
    let healthy = healthy_until_s.and_then(|until_s| {
        healthy_stretch::calibrated(recording, &measured, until_s, model, settings, progress)
            .inspect_err(|reason| {
                warnings.push(format!(
                    "the walk before the damage is not taken for the robot's own: {reason}"
                ));
            })
            .ok()
    });
    // An atlas is of the robot as described.
    let model = match &healthy {
        Some(healthy) => Model::new(&healthy.robot, gait),
        None => model,
    };
    let identify_settings = if before.as_ref().is_some_and(was_damaged) {
        measured = MeasuredWalk::new(recording, gait, &from_the_start)?;
        &from_the_start
    } else {
        identify_settings
    };
    let told_start_s = virtual_start_s(&measured, model, &explanation.nuisance);
    let record_from = |start_s: f64| {
        let raw = recording.raw_beside_angles();
        // All of a motion that ends was made to be looked at.
        let longest_s = match gait.duration_s() {
            Some(_) => WalkRecord::LONGEST_MOTION_S,
            None => WalkRecord::LONGEST_WALK_S,
        };
        record(longest_s, start_s, &measured, raw, identify_settings)
    };
    // The record comes first: a recording without one needs no search.
    let record = record_from(told_start_s.unwrap_or(measured.window().start_s))?;
    let identification = identify(recording, model, identify_settings, &part)?;
    // Where the log does not tell the phase of the gait, the robot as identified does.
    let record = match (told_start_s, identification.fit.gait_start_s) {
        (None, Some(found_s)) => record_from(found_s)?,
        _ => record,
    };
    let nominal = WalkModel::of_make(
        model.robot.clone(),
        gait.clone(),
        identify_settings.simulation.clone(),
        &explanation.nuisance,
    );
    let suspects = suspects(&identification, identify_settings);
    let ln_prior =
        |morphology: &Morphology| ln_prior(&identification, identify_settings, morphology);
    let mut explanation = explain_walk(
        &record,
        &nominal,
        &suspects,
        Beforehand {
            ln_morphology: &ln_prior,
            effects: earlier,
        },
        explanation,
        &ChaCha8Rng::seed_from_u64(identify_settings.seed),
        progress,
    )?;
    explanation.warnings.extend(warnings);
    Ok(Explained {
        identification,
        explanation,
        calibrated_on_s: healthy.map(|healthy| healthy.stretch_s),
    })
}

/// The walk of a recording of a robot of this make as explanations see it: for learning what the model gets wrong.
///
/// # Errors
/// [`ExplainError`] where there is no walk or its start is not known.
pub fn walk_record(
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    nuisance: &NuisanceSettings,
) -> Result<WalkRecord, ExplainError> {
    let longest_s = WalkRecord::LONGEST_WALK_S;
    walk_record_up_to(longest_s, recording, model, settings, nuisance)
}

/// The same where so much of the walk is looked at.
pub(crate) fn walk_record_up_to(
    longest_s: f64,
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    nuisance: &NuisanceSettings,
) -> Result<WalkRecord, ExplainError> {
    let measured = MeasuredWalk::new(recording, model.gait, settings)?;
    let start_s = virtual_start_s(&measured, model, nuisance).ok_or(ExplainError::NoStart)?;
    let raw = recording.raw_beside_angles();
    record(longest_s, start_s, &measured, raw, settings)
}

/// The walk to be explained: dead-reckoned from the raw rates where these are known, the log
/// shows the robot standing, and both agree; else as recorded. The model's walk starts at
/// `start_s` of the log.
fn record(
    longest_s: f64,
    start_s: f64,
    measured: &MeasuredWalk,
    raw: Option<&RawSeries>,
    settings: &IdentifySettings,
) -> Result<WalkRecord, ExplainError> {
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

/// The robot before its swing changed in mid-walk. `from_the_start` are the settings that compare from the
/// start of the walk.
fn before_the_change(
    recording: &Recording,
    measured: &MeasuredWalk,
    model: Model<'_>,
    from_the_start: &IdentifySettings,
    progress: &dyn crate::Progress,
) -> Option<Identification> {
    let GaitPhase::Elapsed { since_start_s } = measured.phase() else {
        return None;
    };
    let before = IdentifySettings {
        window_s: since_start_s.min(from_the_start.window_s),
        ..from_the_start.clone()
    };
    identify(recording, model, &before, progress).ok()
}

/// Log time at which the simulated walk starts: with the measured walk, or, where damage
/// struck in mid-walk, so early that the simulation has reached its steady gait at the start
/// of the compared stretch. `None` where the log does not tell the phase of the gait: it does not show
/// the start of the walk, or the clock of a robot known by its make alone had longer to go wrong since
/// than a start is found with.
fn virtual_start_s(
    measured: &MeasuredWalk,
    model: Model<'_>,
    nuisance: &NuisanceSettings,
) -> Option<f64> {
    match measured.phase() {
        GaitPhase::Start => Some(measured.start().start_s),
        GaitPhase::Elapsed { since_start_s } => {
            let clock_is_known = model.robot.calibration().is_some();
            let error_s = nuisance.clock * since_start_s;
            (clock_is_known || error_s <= nuisance.start_s).then(|| {
                // Gait time passes by the robot's own clock.
                let clock = model.robot.clock();
                let [steady_s, phase_s] = GaitPhase::steady_s(model.gait, since_start_s / clock);
                measured.window().start_s - (steady_s + phase_s) * clock
            })
        }
        GaitPhase::Unknown => None,
    }
}

/// The candidate morphologies for the explanation: the most probable, then the nearest of every other set of
/// damaged legs, then what else is probable.
///
/// The identification knows no effects: it takes a weak leg for a lost one. Other links of the same damaged legs
/// usually change the walk less than other damaged legs, and come last.
fn suspects(found: &Identification, settings: &IdentifySettings) -> Vec<Suspect> {
    let alternatives = found.alternatives.iter().map(|one| &one.morphology);
    let most_probable: Vec<&Morphology> = std::iter::once(&found.morphology)
        .chain(alternatives.clone().take(NEXT))
        .collect();
    let has_other_legs = |one: &&Morphology| {
        let mut known = most_probable.iter();
        known.all(|other| other.damaged_legs() != one.damaged_legs())
    };
    let of_other_legs = found.nearest_of_legs.iter().filter(has_other_legs);
    let morphologies = most_probable
        .iter()
        .copied()
        .chain(of_other_legs.take(OTHER_LEGS))
        .chain(alternatives.skip(NEXT))
        .chain(&found.indistinguishable);
    let mut suspects: Vec<Suspect> = Vec::new();
    for morphology in morphologies {
        if !suspects.iter().any(|s| s.morphology == *morphology) {
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
