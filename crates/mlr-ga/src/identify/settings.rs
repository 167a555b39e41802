use std::{ops::RangeInclusive, str::FromStr};

use mlr_filter::{DetectorSettings, FilterSettings, MotionSettings, SamplingLimits, SettingError};
use mlr_model::{Robot, SimulationSettings, Variation};
use serde::{Deserialize, Serialize};

use super::WalkStart;
use crate::{
    AnswerError, LossHypothesis,
    belief::{DamagePrior, PlausibilitySettings},
    comparison::LikelihoodSettings,
    genetic::GeneticSettings,
    walks::usual_variations,
};

/// What decides which morphology is the answer. Each method has a preset of all settings,
/// [`IdentifySettings::of`]; what differs between them, and why, stands in `docs/decision.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Likelihood of what is left of the spectra, times prior probability, over variations of
    /// the model: the most probable morphology. The search only proposes.
    #[default]
    Mlr,
    /// The method of Farghdani, Patel and Chhabra as published: the least F after Algorithm 2
    /// that the genetic algorithm met, in most of its runs.
    Paper,
}

impl FromStr for Method {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        match text {
            "mlr" => Ok(Self::Mlr),
            "paper" => Ok(Self::Paper),
            other => Err(SettingError::new(
                "method",
                format!("{other:?}"),
                "mlr or paper",
            )),
        }
    }
}

/// How the morphologies are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Search {
    /// The genetic algorithm.
    Ga,
    /// Every feasible morphology, simulated.
    Exact,
    /// Every feasible morphology, as the atlas has it.
    Atlas,
}

/// Everything about an identification that can be chosen. The default is the preset of
/// [`Method::Mlr`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct IdentifySettings {
    /// What decides.
    pub method: Method,
    /// How the morphologies are searched; if absent, in the atlas where there is one, else
    /// by the genetic algorithm.
    pub search: Option<Search>,
    /// Seed of the genetic algorithm. Comes with each call, not from a file.
    #[serde(skip)]
    pub seed: u64,
    /// Length of the compared stretch.
    pub window_s: f64,
    /// How it is known when the walk started.
    pub walk_start: WalkStart,
    /// Log time at which the compared stretch begins, instead of the start of the
    /// walk or the time at which damage was flagged.
    pub from_s: Option<f64>,
    /// Largest share of samples that may be lost to bad time stamps.
    pub max_dropped_share: f64,
    /// What a lost link may have become.
    pub lost_links: LossHypothesis,
    /// The FFT filter.
    pub filter: FilterSettings,
    /// The search for the start of the walk.
    pub motion: MotionSettings,
    /// The damage detector, which tells damage in mid-walk.
    pub detector: DetectorSettings,
    /// Whether damage that the detector does not flag counts as well where the body comes to
    /// swing several times as far as it did at first.
    pub unflagged_damage: bool,
    /// Whether what the walk before damage in mid-walk tells of its robot is known when the rest is
    /// explained.
    pub calibrate_before_damage: bool,
    /// What the recording must offer within the window.
    pub sampling: SamplingLimits,
    /// The genetic algorithm.
    pub genetic: GeneticSettings,
    /// What misfits say against a candidate.
    pub likelihood: LikelihoodSettings,
    /// What is thought of damage before the log is seen.
    pub prior: DamagePrior,
    /// How far off the right morphology usually is.
    pub plausibility: PlausibilitySettings,
    /// The nominal model, and how a robot may differ from it. The leading
    /// candidates are tried under all of them.
    pub variations: Vec<Variation>,
    /// Candidates that are tried under variations of the model, at most.
    pub leaders: usize,
    /// Share of the probability that the morphologies reported as indistinguishable
    /// hold together.
    pub credible_share: f64,
    /// How candidates are simulated. Duration and lost links follow from the
    /// settings above.
    pub simulation: SimulationSettings,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            method: Method::Mlr,
            search: None,
            seed: 1,
            window_s: 5.0,
            walk_start: WalkStart::default(),
            from_s: None,
            max_dropped_share: 0.2,
            lost_links: LossHypothesis::default(),
            filter: FilterSettings::default(),
            motion: MotionSettings::default(),
            detector: DetectorSettings::default(),
            unflagged_damage: true,
            calibrate_before_damage: true,
            sampling: SamplingLimits::default(),
            genetic: GeneticSettings::default(),
            likelihood: LikelihoodSettings::default(),
            prior: DamagePrior::default(),
            plausibility: PlausibilitySettings::default(),
            variations: usual_variations(),
            leaders: 48,
            credible_share: 0.995,
            simulation: SimulationSettings::default(),
        }
    }
}

impl IdentifySettings {
    /// The preset of a method.
    pub fn of(method: Method) -> Self {
        match method {
            Method::Mlr => Self::default(),
            Method::Paper => Self::paper(),
        }
    }

    /// The paper's method with the values of its table of parameters.
    fn paper() -> Self {
        Self {
            method: Method::Paper,
            search: Some(Search::Ga),
            lost_links: LossHypothesis::Absent,
            detector: DetectorSettings {
                lull_s: 0.0,
                ..DetectorSettings::default()
            },
            unflagged_damage: false,
            genetic: GeneticSettings::paper(),
            variations: vec![Variation::default()],
            ..Self::default()
        }
    }

    /// The search of these settings, where there is an atlas or none.
    pub fn search_with(&self, has_atlas: bool) -> Search {
        self.search.unwrap_or(match has_atlas {
            true => Search::Atlas,
            false => Search::Ga,
        })
    }

    /// Log times, which may be those of a clock that began in 1970 or run from before zero.
    pub(super) const LOG_TIMES_S: RangeInclusive<f64> = -1e12..=1e12;

    /// Checks every number, those of the parts included.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let share = |name, value| SettingError::check::<f64>(name, value, 0.0..=1.0, "");
        SettingError::check("window_s", self.window_s, 0.5..=600.0, "s")?;
        self.walk_start.check()?;
        if let Some(from_s) = self.from_s {
            SettingError::check("from_s", from_s, Self::LOG_TIMES_S, "s")?;
        }
        share("max_dropped_share", self.max_dropped_share)?;
        share("credible_share", self.credible_share)?;
        SettingError::check("leaders", self.leaders, 1..=100_000, "")?;
        let variations = self.variations.len();
        SettingError::check("variations", variations, 1..=10_000, "of them")?;
        for (index, variation) in self.variations.iter().enumerate() {
            let checked = variation.check();
            checked.map_err(|error| error.under(&format!("variations[{index}]")))?;
        }
        for (part, checked) in [
            ("filter", self.filter.check()),
            ("motion", self.motion.check()),
            ("detector", self.detector.check()),
            ("sampling", self.sampling.check()),
            ("genetic", self.genetic.check()),
            ("likelihood", self.likelihood.check()),
            ("prior", self.prior.check()),
            ("plausibility", self.plausibility.check()),
            ("simulation", self.simulation.check()),
        ] {
            checked.map_err(|error| error.under(part))?;
        }
        let (cutoff_hz, min_rate_hz) = (self.filter.cutoff_hz, self.sampling.min_rate_hz);
        if min_rate_hz <= 2.0 * cutoff_hz {
            let expected = format!("more than twice filter.cutoff_hz, {} Hz", 2.0 * cutoff_hz);
            let name = "sampling.min_rate_hz";
            return Err(SettingError::new(name, min_rate_hz, expected));
        }
        Ok(())
    }

    /// Checks that nothing in them is a time of one log among several.
    pub(super) fn check_for_several(&self, logs: usize) -> Result<(), AnswerError> {
        if logs == 0 {
            return Err(AnswerError::NoLogs);
        }
        let named = match (self.from_s, self.walk_start) {
            (Some(_), _) => "from_s",
            (None, WalkStart::CommandedAtS(_)) => "walk_start.commanded_at_s",
            (None, WalkStart::ObservedAtS(_)) => "walk_start.observed_at_s",
            (None, WalkStart::FoundInRecording) => return Ok(()),
        };
        Err(AnswerError::TimeOfOneLog {
            setting: named,
            logs,
        })
    }

    /// Checks every number, and whether this robot can have the faults of the simulation.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check_on(&self, robot: &Robot) -> Result<(), SettingError> {
        self.check()?;
        let simulation = self.simulation.check_on(robot);
        simulation.map_err(|error| error.under("simulation"))
    }
}
