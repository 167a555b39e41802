//! From walks in which nothing is wrong with a robot to its own parameters.

mod report;

pub use report::{CalibrationReport, MeasuredReport, ParameterReport, WalkOrigin, WalkReport};

use mlr_imu::Recording;
use mlr_model::{Gait, Morphology, Robot};
use mlr_residual::{
    Progress,
    walk::{
        Beforehand, CalibratedRobot, EvidenceSettings, Suspect, WalkError, WalkModel, WalkRecord,
        calibrate_walk, explain_walk,
    },
};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use crate::{
    AnswerError, ExplainError, ExplainSettings, IdentifySettings, MeasuredWalk, Model,
    evaluation::PartOf, explain::walk_record_up_to, identify,
};

/// A walk in which nothing should be wrong with the robot.
#[derive(Debug, Clone, Copy)]
pub struct HealthyWalk<'a> {
    /// What its sensor recorded.
    pub recording: &'a Recording,
    /// The gait that it walked.
    pub gait: &'a Gait,
}

/// A robot with its own parameters, and how each walk added to them.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// The robot with its most probable parameters, and how surely these are known.
    pub robot: Robot,
    /// What was known after each walk.
    pub walks: Vec<CalibratedRobot>,
}

/// Why a robot cannot be calibrated by a walk.
#[derive(Debug, Error)]
pub enum CalibrateError {
    /// The walk cannot be identified.
    #[error(transparent)]
    Answer(#[from] AnswerError),
    /// The walk cannot be compared with that of a model.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// The walk started before the recording.
    #[error("the log does not show the start of the walk, expected the robot to stand first")]
    NoStart,
    /// Legs seem to be damaged.
    #[error(
        "the robot does not walk like a whole one: most probably leg{} {} {} damaged \
         ({:.0} %), expected a healthy walk",
        if legs.len() > 1 { "s" } else { "" },
        legs.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        if legs.len() > 1 { "are" } else { "is" },
        100.0 * probability
    )]
    Damaged {
        /// Numbers of the legs.
        legs: Vec<usize>,
        /// Probability of this set of legs.
        probability: f64,
    },
    /// Its parameters would be unlike those of any healthy robot.
    #[error(
        "something is wrong with this walk: of healthy robots, {probability:.0e} are found to differ as much from \
         what is known of this one, expected a healthy walk"
    )]
    Unusual {
        /// The share of them.
        probability: f64,
    },
    /// Something else seems to be wrong.
    #[error(
        "something is wrong with this walk: most probably {what} ({:.0} %), expected a healthy one",
        100.0 * probability
    )]
    Disturbed {
        /// Kinds of effects, or "something unknown".
        what: String,
        /// Probability that nothing is wrong.
        probability: f64,
    },
}

impl CalibrateError {
    /// Whether the recording is at fault, rather than what was asked of it.
    pub fn is_recordings_fault(&self) -> bool {
        match self {
            Self::Answer(error) => error.is_recordings_fault(),
            Self::Walk(error) => error.is_recordings_fault(),
            Self::NoStart
            | Self::Damaged { .. }
            | Self::Unusual { .. }
            | Self::Disturbed { .. } => true,
        }
    }
}

impl From<ExplainError> for CalibrateError {
    fn from(error: ExplainError) -> Self {
        match error {
            ExplainError::Answer(error) => Self::Answer(error),
            ExplainError::Walk(error) => Self::Walk(error),
            // Records are made without a method that decides.
            ExplainError::NoStart | ExplainError::MethodWithoutProbabilities => Self::NoStart,
        }
    }
}

/// A walk is taken for disturbed where something is wrong with more than this probability: what is
/// learned of it would be taken for the robot's.
const SURE: f64 = 0.9;

/// Of healthy robots at most so many are not believed to be healthy: what makes them differ so much would
/// be taken for their own.
const UNUSUAL: f64 = 0.01;

/// The error of a robot that is found to be unlike healthy ones.
pub(crate) fn unusual(found: &CalibratedRobot) -> Option<CalibrateError> {
    let probability = found.tail_probability;
    (probability < UNUSUAL).then_some(CalibrateError::Unusual { probability })
}

/// Fits the parameters of a robot to its walks, one after the other: what is known after one is the
/// prior of the next. `check` looks for damage and effects in each walk first.
///
/// # Errors
/// [`CalibrateError`], with the index of the walk.
pub fn calibrate(
    walks: &[HealthyWalk<'_>],
    robot: &Robot,
    settings: ExplainSettings<'_>,
    check: bool,
    progress: &(impl Progress + crate::Progress),
) -> Result<Calibrated, (usize, CalibrateError)> {
    let ExplainSettings {
        identify: identify_settings,
        explanation,
    } = settings;
    let mut known = robot.clone();
    let mut calibrated = Vec::new();
    for (index, walk) in walks.iter().enumerate() {
        let at = |error: CalibrateError| (index, error);
        // A healthy walk is compared from its start, however folded legs make the robot sway, unless the
        // settings name a stretch of it.
        let measured = MeasuredWalk::from_its_start(walk.recording, walk.gait, identify_settings);
        let measured = measured.map_err(|error| at(error.into()))?;
        let of_the_stretch = IdentifySettings {
            from_s: identify_settings.from_s.or(Some(measured.start().start_s)),
            ..identify_settings.clone()
        };
        let model = Model::new(&known, walk.gait);
        let record = |longest_s: f64| {
            let record = walk_record_up_to(
                longest_s,
                walk.recording,
                model,
                &of_the_stretch,
                &explanation.nuisance,
            );
            record.map_err(|error| at(error.into()))
        };
        let simulation = identify_settings.simulation.clone();
        let nominal = WalkModel::of_make(
            known.clone(),
            walk.gait.clone(),
            simulation,
            &explanation.nuisance,
        );
        let generator = ChaCha8Rng::seed_from_u64(of_the_stretch.seed);
        if check {
            let found = identify(walk.recording, model, &of_the_stretch, &PartOf(progress));
            let found = found.map_err(|error| at(error.into()))?;
            if !found.damaged_legs.is_empty() {
                return Err(at(CalibrateError::Damaged {
                    probability: found.legs_probability,
                    legs: found.damaged_legs,
                }));
            }
            let record = record(WalkRecord::LONGEST_WALK_S)?;
            check_undisturbed(&record, &nominal, explanation, &generator, progress).map_err(at)?;
        }
        // A walk goes on as it began; of a motion that ends, all is looked at.
        let looked_at_s = walk.gait.duration_s().map_or(0.0, |duration_s| {
            duration_s.min(WalkRecord::LONGEST_MOTION_S)
        });
        let record = record(looked_at_s.max(WalkRecord::LONGEST_WALK_S))?;
        let fitted = calibrate_walk(&record, &nominal, explanation, &generator, progress);
        let fitted = fitted.map_err(|error| at(error.into()))?;
        if let Some(error) = unusual(&fitted).filter(|_| check) {
            return Err(at(error));
        }
        known = fitted.robot.clone();
        calibrated.push(fitted);
    }
    Ok(Calibrated {
        robot: known,
        walks: calibrated,
    })
}

/// Whether an effect makes the whole robot walk like this.
fn check_undisturbed(
    record: &WalkRecord,
    nominal: &WalkModel,
    settings: &EvidenceSettings,
    generator: &ChaCha8Rng,
    progress: &dyn Progress,
) -> Result<(), CalibrateError> {
    let morphology = Morphology::healthy(&nominal.robot.layout());
    let whole = Suspect {
        morphology: morphology.clone(),
        ln_prior: 0.0,
    };
    let ln_prior = |other: &Morphology| match *other == morphology {
        true => 0.0,
        false => f64::NEG_INFINITY,
    };
    let known = Beforehand {
        ln_morphology: &ln_prior,
        effects: None,
    };
    let found = explain_walk(
        record,
        nominal,
        &[whole],
        known,
        settings,
        generator,
        progress,
    )?;
    let probability = |kind: &str| found.effect_probability.get(kind).copied().unwrap_or(0.0);
    let wrong = 1.0 - probability("none");
    if wrong <= SURE {
        return Ok(());
    }
    let kinds = found.effects.iter().map(|effect| effect.kind.as_str());
    let kinds: Vec<&str> = kinds.collect();
    let what = match kinds.is_empty() {
        true => "something unknown".to_string(),
        false => kinds.join(" and "),
    };
    Err(CalibrateError::Disturbed {
        what,
        probability: wrong,
    })
}
