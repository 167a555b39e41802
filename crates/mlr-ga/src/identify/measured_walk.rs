use mlr_filter::{Conditioned, EvenSamples, FourierFilter, MotionStart, OrientationSeries, Window};
use mlr_imu::{
    Recording,
    quality::{Finding, LogQuality, Severity},
};
use mlr_model::Gait;

use super::{GaitPhase, IdentifySettings, beginning::Beginning};
use crate::{
    AnswerError,
    comparison::{Alignment, ComparableWalk},
    recording::repair_time_stamps,
};

/// Every log time.
const ALL_TIME: std::ops::Range<f64> = f64::NEG_INFINITY..f64::INFINITY;

/// The part of a recording that a morphology has to explain: some seconds of the
/// walk, after the filter.
#[derive(Debug, Clone)]
pub struct MeasuredWalk {
    recording: OrientationSeries,
    start: MotionStart,
    window: Window,
    phase: GaitPhase,
    stretch: Stretch,
    unfiltered: EvenSamples,
    conditioned: Conditioned,
    quality: LogQuality,
    unchanged_until_s: Option<f64>,
    warnings: Vec<String>,
}

/// The samples that are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Log time of the first one.
    pub start_s: f64,
    /// How many there are, at [`ComparableWalk::RATE_HZ`].
    pub samples: usize,
    /// Indices of the samples of a simulated walk that the first one is aligned with in turn.
    pub offsets: Vec<usize>,
    /// How much later in the gait than such a sample the window starts; the first
    /// compared sample is earlier than the window by as much.
    pub later_s: f64,
    /// Period of the gait.
    pub gait_period_s: f64,
    /// After how long the gait repeats itself; `None` of a motion that ends.
    pub cycle_s: Option<f64>,
}

impl Stretch {
    /// As many samples as every alignment finds in the recording.
    fn new(recording: &OrientationSeries, window: Window, phase: GaitPhase, gait: &Gait) -> Self {
        let offsets = phase.offsets(gait);
        let start_s = window.start_s - offsets.later_s;
        let end_s = recording.times_s().last().copied().unwrap_or(start_s);
        let wanted = (window.duration_s * ComparableWalk::RATE_HZ).round() as usize;
        let fits = |samples: &usize| {
            let duration_s = samples.saturating_sub(1) as f64 / ComparableWalk::RATE_HZ;
            start_s + Alignment::longest_s(duration_s) <= end_s
        };
        Self {
            start_s,
            samples: (2..=wanted).rev().find(fits).unwrap_or(2),
            offsets: offsets.samples,
            later_s: offsets.later_s,
            gait_period_s: gait.period_s,
            cycle_s: gait.cycle_s(),
        }
    }

    /// Log time at which a simulated walk starts whose sample `offset` is laid over the first one.
    pub(crate) fn gait_start_s(&self, offset: usize, alignment: Alignment) -> f64 {
        self.start_s + alignment.robot_time_s(-(offset as f64) / ComparableWalk::RATE_HZ)
    }

    /// Samples that a simulated walk must have.
    pub fn walk_samples(&self) -> usize {
        self.offsets
            .iter()
            .max()
            .map_or(0, |last| last + self.samples)
    }

    /// Checkpoints, in samples of the stretch, at which a candidate that does not fit
    /// may be abandoned. They are whole gait cycles, whose harmonics have bins of their own. Of
    /// a motion that repeats nothing, no part stands for the rest: there are none.
    pub fn parts(&self) -> Vec<usize> {
        let Some(cycle_s) = self.cycle_s else {
            return Vec::new();
        };
        [2.0, 3.0, 4.0]
            .iter()
            .map(|cycles| cycles * cycle_s * ComparableWalk::RATE_HZ)
            .map(|samples| samples.round() as usize)
            .filter(|part| *part < self.samples)
            .collect()
    }

    /// The same checkpoints in samples of a simulated walk, for every alignment.
    pub fn looks(&self) -> Vec<usize> {
        let last = self.offsets.iter().max().copied().unwrap_or(0);
        self.parts().into_iter().map(|part| last + part).collect()
    }
}

impl MeasuredWalk {
    /// Repairs the time stamps, finds the stretch to compare, and filters it.
    ///
    /// The stretch starts with the walk; where damage strikes in mid-walk, when it is
    /// flagged; or at the time that the settings give.
    ///
    /// # Errors
    /// [`AnswerError`] when the recording has no such stretch, or the settings
    /// make no sense.
    pub fn new(
        recording: &Recording,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, AnswerError> {
        let begin = |recording: &OrientationSeries, start: MotionStart| {
            let told = Beginning::told(settings);
            // A motion that ends is meant to sway now more, now less.
            let struck = || match gait.cycle_s() {
                Some(_) => Beginning::after_damage_in_mid_walk(recording, start, settings),
                None => None,
            };
            told.or_else(struck)
        };
        Self::beginning(recording, gait, settings, begin)
    }

    /// The same where the robot is taken to walk all the time as it began, however it sways: compared
    /// from its start, unless the settings name a stretch.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(crate) fn from_its_start(
        recording: &Recording,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, AnswerError> {
        let begin = |_: &OrientationSeries, _| Beginning::told(settings);
        Self::beginning(recording, gait, settings, begin)
    }

    /// Where the compared stretch begins is found in the recording and its start; at the start if
    /// nothing else is.
    fn beginning(
        recording: &Recording,
        gait: &Gait,
        settings: &IdentifySettings,
        begin: impl Fn(&OrientationSeries, MotionStart) -> Option<Beginning>,
    ) -> Result<Self, AnswerError> {
        settings.check()?;
        let mut warnings = recording.notes.clone();
        let recording = repair_time_stamps(recording, settings.max_dropped_share, &mut warnings)?;
        let quality = LogQuality::of(&recording, &settings.motion);
        require_usable(&quality, &recording)?;
        warnings.extend(quality.warnings());
        let recording = recording.orientation;
        let start = match settings.walk_start.time_s() {
            Some(start_s) => MotionStart {
                start_s,
                stood_before: true,
            },
            None => MotionStart::find(&recording, &settings.motion)
                .map_err(|still| blamed_on(quality.spoilt_within(ALL_TIME), still))?,
        };
        let begin = begin(&recording, start);
        let start_of_window_s = begin.as_ref().map_or(start.start_s, |begin| begin.time_s);
        let since_start_s = start_of_window_s - start.start_s;
        let phase = if !start.stood_before {
            warnings.push(
                "the log does not show the robot standing before it walks: the phase of the gait \
                 is searched, which takes longer"
                    .into(),
            );
            GaitPhase::Unknown
        } else if since_start_s.abs() < f64::EPSILON {
            GaitPhase::Start
        } else {
            GaitPhase::Elapsed { since_start_s }
        };
        let window = Window {
            start_s: start_of_window_s,
            duration_s: match phase {
                GaitPhase::Start => {
                    let whole_s = gait.duration_s().unwrap_or(0.0);
                    let end_s = recording.times_s().last().copied().unwrap_or(0.0);
                    // All that there is of a motion that ends: no part stands for the rest.
                    let seen_s = whole_s.min(end_s - start_of_window_s);
                    settings.window_s.max(seen_s)
                }
                _ => what_is_left_s(&recording, start_of_window_s, settings.window_s),
            },
        };
        let end_s = window.start_s + window.duration_s;
        if let Some(finding) = quality.spoilt_within(window.start_s..end_s) {
            return Err(finding.clone().into());
        }
        require_fast_enough(&quality, settings)?;
        let unfiltered = window.cut(&recording, &settings.sampling)?;
        let mut filter = FourierFilter::new(settings.filter, window.duration_s)?;
        let conditioned = filter.condition(&unfiltered);
        let stretch = Stretch::new(&recording, window, phase, gait);
        Ok(Self {
            recording,
            start,
            window,
            phase,
            stretch,
            unfiltered,
            conditioned,
            quality,
            unchanged_until_s: begin.and_then(|begin| begin.unchanged_until_s),
            warnings,
        })
    }

    /// Quality of the recording.
    pub fn quality(&self) -> &LogQuality {
        &self.quality
    }

    /// The recording with increasing time stamps.
    pub fn recording(&self) -> &OrientationSeries {
        &self.recording
    }

    /// The samples that are compared.
    pub fn stretch(&self) -> &Stretch {
        &self.stretch
    }

    /// When the walk started.
    pub fn start(&self) -> MotionStart {
        self.start
    }

    /// The compared stretch.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Log time until which a robot that was damaged in mid-walk walked as it began; `None` where
    /// nothing changed in mid-walk.
    pub fn unchanged_until_s(&self) -> Option<f64> {
        self.unchanged_until_s
    }

    /// Phase of the gait at its start.
    pub fn phase(&self) -> GaitPhase {
        self.phase
    }

    /// Roll, pitch and yaw before the filter.
    pub fn unfiltered(&self) -> &EvenSamples {
        &self.unfiltered
    }

    /// Roll, pitch and yaw after the filter.
    pub fn conditioned(&self) -> &Conditioned {
        &self.conditioned
    }

    /// Warnings for people.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Refuses a recording with a defect over its whole length that makes it useless.
fn require_usable(quality: &LogQuality, recording: &Recording) -> Result<(), AnswerError> {
    let times_s = recording.orientation.times_s();
    let throughout = quality.findings.iter().find(|finding| {
        finding.severity == Severity::Useless
            && times_s
                .first()
                .is_some_and(|first| finding.from_s <= *first)
            && times_s.last().is_some_and(|last| finding.to_s >= *last)
    });
    if let Some(finding) = throughout {
        return Err(finding.clone().into());
    }
    Ok(())
}

/// Refuses a recording whose sensor is slower than its time stamps, and too slow.
fn require_fast_enough(
    quality: &LogQuality,
    settings: &IdentifySettings,
) -> Result<(), AnswerError> {
    let min_rate_hz = settings.sampling.min_rate_hz;
    if quality.value_rate_hz < min_rate_hz && quality.sample_rate_hz >= min_rate_hz {
        return Err(AnswerError::HeldValues {
            value_rate_hz: quality.value_rate_hz,
            sample_rate_hz: quality.sample_rate_hz,
            min_rate_hz,
        });
    }
    Ok(())
}

/// Why there is no answer: a defect of the recording, if there is one.
fn blamed_on(finding: Option<&Finding>, otherwise: impl Into<AnswerError>) -> AnswerError {
    finding
        .cloned()
        .map_or_else(|| otherwise.into(), AnswerError::from)
}

/// Damage that strikes late leaves less than a whole window: half of one is enough.
fn what_is_left_s(recording: &OrientationSeries, from_s: f64, window_s: f64) -> f64 {
    let end_s = recording.times_s().last().copied().unwrap_or(from_s);
    (end_s - from_s).clamp(window_s / 2.0, window_s)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use mlr_filter::Axes;
    use mlr_model::{JointTrajectory, Motion, Robot};

    use super::*;

    /// Stands for 2 s, rocks by 0.4° from side to side, and from 10 s on by another
    /// angle, both ways.
    fn recording(later_deg: f64) -> OrientationSeries {
        let times_s: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.005).collect();
        let roll = times_s.iter().map(|&t| {
            let swing_deg = match t {
                t if t < 2.0 => 0.0,
                t if t < 10.0 => 0.4,
                _ => later_deg,
            };
            f64::to_radians(swing_deg / 2.0) * (TAU * t).sin()
        });
        let roll: Vec<f64> = roll.collect();
        let still = vec![0.0; times_s.len()];
        let angles_rad = Axes {
            roll,
            pitch: still.clone(),
            yaw: still,
        };
        OrientationSeries::new(times_s, angles_rad).unwrap()
    }

    #[test]
    fn parts_are_cycles_of_what_repeats_and_there_are_none_of_what_ends() {
        let parts = |gait: &Gait| {
            let settings = IdentifySettings::default();
            let measured = MeasuredWalk::new(&recording(0.4).into(), gait, &settings).unwrap();
            measured.stretch().parts()
        };
        let tripod = Gait::tripod();
        assert_eq!(parts(&tripod), [50, 75, 100]);
        let joints = JointTrajectory::commanded(&Robot::jethexa(), &tripod, 4.0).unwrap();
        let rows = |rows_rad: &[Vec<f64>], repeat_rows| Gait {
            motion: Motion::Joints(
                JointTrajectory::new(0.02, rows_rad.to_vec(), repeat_rows).unwrap(),
            ),
            ..Gait::tripod()
        };
        assert_eq!(
            parts(&rows(joints.rows_rad(), joints.repeat_rows())),
            [50, 75, 100]
        );
        // Both of its periods together are the cycle.
        assert_eq!(parts(&rows(joints.rows_rad(), Some(101..201))), [100]);
        assert!(parts(&rows(joints.rows_rad(), None)).is_empty());
    }

    fn window_start_s(later_deg: f64) -> f64 {
        let settings = IdentifySettings::default();
        let measured = MeasuredWalk::new(&recording(later_deg).into(), &Gait::tripod(), &settings);
        measured.unwrap().window().start_s
    }

    #[test]
    fn damage_that_is_never_flagged_is_still_compared_where_it_shows() {
        assert!((window_start_s(0.4) - 2.0).abs() < 0.2, "nothing changes");
        assert!((window_start_s(0.9) - 2.0).abs() < 0.2, "hardly anything");
        assert!((11.0..13.5).contains(&window_start_s(4.0)), "below 5°");
        assert!((11.0..13.5).contains(&window_start_s(8.0)), "flagged");
    }
}
