use mlr_model::{LostLinks, Morphology};
use serde::Deserialize;

/// Which legs are damaged: what a page shows of `mlr.identification/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Identification {
    /// The first log.
    pub log: String,
    /// Of several logs each.
    #[serde(default)]
    pub logs: Vec<OneLog>,
    /// What decided: `mlr` or `paper`.
    pub method: String,
    /// How the morphologies were searched: `ga`, `exact` or `atlas`.
    pub search: String,
    /// Seed of the search.
    pub seed: u64,
    /// The best morphology.
    pub morphology: Morphology,
    /// The damage in words.
    pub description: String,
    /// Whether no morphology explains the log.
    #[serde(default)]
    pub implausible: bool,
    /// Probability that something else than damage decides how the robot walks.
    #[serde(default)]
    pub something_else_probability: Option<f64>,
    /// Probability of exactly this morphology.
    pub probability: f64,
    /// Probability that exactly these legs are damaged.
    pub legs_probability: f64,
    /// Probability of each leg to miss a link.
    pub leg_damage_probability: Vec<f64>,
    /// Probability that the lost links are locked and not gone.
    #[serde(default)]
    pub locked_probability: Option<f64>,
    /// The paper's F on the nominal model.
    pub cost_rad: f64,
    /// F per sample and axis.
    pub mean_error_deg: f64,
    /// How the walk fits best, of the first log.
    pub fit: Fit,
    /// The next most probable morphologies.
    #[serde(default)]
    pub alternatives: Vec<Alternative>,
    /// Morphologies that the log cannot tell from the best.
    #[serde(default)]
    pub indistinguishable: Vec<Morphology>,
    /// Log time at which the walk started.
    #[serde(default)]
    pub motion_start_s: Option<f64>,
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// Its length.
    pub window_s: f64,
    /// Morphologies evaluated.
    pub evaluations: usize,
    /// Best cost so far in degrees, generation by generation; none where every walk had diverged.
    #[serde(default)]
    pub cost_per_generation: Vec<Option<f64>>,
    /// What the first log says about itself.
    #[serde(default)]
    pub log_quality: LogQuality,
    /// For people.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Time that it took.
    #[serde(default)]
    pub elapsed_s: Option<f64>,
}

impl Identification {
    /// Start, in log time, and length of the compared stretch of a log, counted from 0.
    pub fn window_s(&self, log: usize) -> [f64; 2] {
        match self.logs.get(log) {
            Some(log) => [log.window_start_s, log.window_s],
            None => [self.window_start_s, self.window_s],
        }
    }
}

/// One of several logs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OneLog {
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// Its length.
    pub window_s: f64,
    /// How the walk fits best.
    pub fit: Fit,
    /// What the log says about itself.
    #[serde(default)]
    pub log_quality: LogQuality,
    /// For people.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// How a walk fits best.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Fit {
    /// What lost links are taken to be.
    pub lost_links: LostLinks,
    /// Duration of the robot's gait over the nominal one, less one.
    pub clock: f64,
    /// How much later than the model the robot moves.
    pub delay_s: f64,
    /// Friction over the nominal one.
    pub friction: f64,
    /// Stiffness of the servos over the nominal one.
    pub stiffness: f64,
    /// Mass of a payload over that of the body.
    pub payload: f64,
    /// Slope of the ground.
    pub slope_deg: f64,
    /// What is left of roll, pitch and yaw, root mean square.
    pub error_deg: [f64; 3],
    /// Measured roll, pitch and yaw, root mean square.
    pub motion_deg: [f64; 3],
}

/// A morphology that is less probable.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Alternative {
    /// The morphology.
    pub morphology: Morphology,
    /// Its F on the nominal model.
    pub cost_rad: f64,
    /// Its probability.
    pub probability: f64,
    /// Probability that its lost links are locked and not gone.
    #[serde(default)]
    pub locked_probability: Option<f64>,
}

/// What a log says about itself.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct LogQuality {
    /// Rows per second.
    pub sample_rate_hz: f64,
    /// How often a second the values change.
    pub value_rate_hz: f64,
    /// Length of the mean specific force.
    #[serde(default)]
    pub gravity_mps2: Option<f64>,
    /// What is wrong, the worst first.
    pub findings: Vec<Finding>,
}

/// Something that is wrong with a log.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Log time at which it begins.
    pub from_s: f64,
    /// Log time at which it ends.
    pub to_s: f64,
    /// What was seen, in words.
    pub reason: String,
    /// What to do about it.
    #[serde(default)]
    pub cure: Option<String>,
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Where it is, the log says nothing about the robot.
    Useless,
    /// The log may mislead.
    Worse,
    /// Worth knowing.
    Note,
}
