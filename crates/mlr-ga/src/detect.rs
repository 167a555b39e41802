//! When the robot started to walk, and when it was damaged.

use mlr_filter::{
    Assessment, DamageDetector, DetectorSettings, MotionSettings, MotionStart, OrientationSeries,
    SettingError,
};
use mlr_imu::{Recording, quality::LogQuality};
use serde::Serialize;

use crate::{AnswerError, IdentifySettings, recording::repair_time_stamps};

/// All settings of a detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionSettings {
    /// Largest share of samples that may be lost to bad time stamps.
    pub max_dropped_share: f64,
    /// The search for the start of the walk.
    pub motion: MotionSettings,
    /// The damage detector.
    pub detector: DetectorSettings,
}

impl Default for DetectionSettings {
    fn default() -> Self {
        Self::from(&IdentifySettings::default())
    }
}

impl From<&IdentifySettings> for DetectionSettings {
    /// The settings with which an identification detects damage.
    fn from(settings: &IdentifySettings) -> Self {
        Self {
            max_dropped_share: settings.max_dropped_share,
            motion: settings.motion,
            detector: settings.detector,
        }
    }
}

impl DetectionSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let dropped_share = self.max_dropped_share;
        SettingError::check("max_dropped_share", dropped_share, 0.0..=1.0, "")?;
        self.motion.check().map_err(|error| error.under("motion"))?;
        let detector = self.detector.check();
        detector.map_err(|error| error.under("detector"))
    }

    /// Least duration of walking in which damage can be flagged.
    fn needed_s(&self) -> f64 {
        self.detector.window_s + self.detector.persistence_s
    }
}

/// Version of the JSON form.
const SCHEMA: &str = "mlr.detection/1";

/// The answer with where it comes from: the object that other programs read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DetectionReport {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Where the recording came from: a file, or a port.
    pub log: String,
    /// The answer.
    #[serde(flatten)]
    pub detection: Detection,
}

impl DetectionReport {
    /// The report of a detection in a recording of this name.
    pub fn new(log: String, detection: Detection) -> Self {
        Self {
            schema: SCHEMA,
            log,
            detection,
        }
    }
}

/// The answer. Serialises to the fields of `mlr.detection/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Detection {
    /// Log time at which the walk started, if the recording shows it.
    pub motion_start_s: Option<f64>,
    /// Log time at which damage was flagged first, if it was.
    pub damage_s: Option<f64>,
    /// Whether damage was flagged.
    pub flagged: bool,
    /// Largest fluctuation of roll or pitch within a window.
    pub max_fluctuation_deg: f64,
    /// Fluctuation that a healthy robot stays below.
    pub threshold_deg: f64,
    /// Quality of the recording.
    pub log_quality: LogQuality,
    /// Warnings for people.
    pub warnings: Vec<String>,
    /// What the detector made of each position of its window.
    #[serde(skip)]
    pub assessments: Vec<Assessment>,
}

/// Runs the damage detector over a recording.
///
/// # Errors
/// [`AnswerError`] when the time stamps do not increase, when the recording is sampled
/// too slowly for the detector's window, when damage is not flagged and the walk is too
/// short to exclude it, or when a setting makes no sense.
pub fn detect(
    recording: &Recording,
    settings: &DetectionSettings,
) -> Result<Detection, AnswerError> {
    settings.check()?;
    let mut warnings = recording.notes.clone();
    let recording = repair_time_stamps(recording, settings.max_dropped_share, &mut warnings)?;
    let log_quality = LogQuality::of(&recording, &settings.motion);
    let orientation = &recording.orientation;
    let start = MotionStart::find(orientation, &settings.motion);
    let detection = detect_in(orientation, settings.detector)?;
    // Only the walk up to the flag decides.
    let from_s = start.map_or(f64::NEG_INFINITY, |start| start.start_s);
    let to_s = detection.damage_s.unwrap_or(f64::INFINITY);
    if let Some(finding) = log_quality.spoilt_within(from_s..to_s) {
        return Err(finding.clone().into());
    }
    warnings.extend(log_quality.warnings());
    if !detection.flagged {
        let end_s = orientation.times_s().last().copied().unwrap_or_default();
        let walked_s = end_s - start?.start_s;
        let needed_s = settings.needed_s();
        if walked_s < needed_s {
            return Err(AnswerError::TooShortToDetect { walked_s, needed_s });
        }
    }
    Ok(Detection {
        motion_start_s: start
            .ok()
            .filter(|start| start.stood_before)
            .map(|start| start.start_s),
        log_quality,
        warnings,
        ..detection
    })
}

/// The detector's part of a detection, on increasing time stamps.
pub(crate) fn detect_in(
    recording: &OrientationSeries,
    settings: DetectorSettings,
) -> Result<Detection, AnswerError> {
    let mut detector = DamageDetector::new(settings)?;
    let mut assessments = Vec::new();
    let angles = recording.angles_rad();
    for (index, &time_s) in recording.times_s().iter().enumerate() {
        let assessment = detector.push(time_s, angles.roll[index], angles.pitch[index])?;
        assessments.extend(assessment);
    }
    let damaged = assessments.iter().find(|assessment| assessment.damaged);
    let damage_s = damaged.map(|assessment| assessment.time_s);
    let fluctuations_deg = assessments.iter().map(|one| one.fluctuation_deg);
    Ok(Detection {
        motion_start_s: None,
        damage_s,
        flagged: damage_s.is_some(),
        max_fluctuation_deg: fluctuations_deg.fold(0.0, f64::max),
        threshold_deg: settings.threshold_deg,
        log_quality: LogQuality::default(),
        warnings: Vec::new(),
        assessments,
    })
}
