//! Notices damage while the robot walks: the paper's sliding window.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::SettingError;

/// Parameters of the damage detector, with the paper's values as defaults.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct DetectorSettings {
    /// Length of the window in which roll and pitch fluctuate; about half a gait
    /// cycle. Rounded to whole steps.
    pub window_s: f64,
    /// By how much the window moves.
    pub step_s: f64,
    /// Fluctuation that a healthy robot stays below.
    pub threshold_deg: f64,
    /// For how long the fluctuation must go on to count as damage.
    pub persistence_s: f64,
    /// Calm that does not interrupt it. A leg that is missing is missed once per
    /// gait cycle; for the rest of the cycle the body may rest on the others.
    pub lull_s: f64,
    /// Samples that a window must have on average. Fewer do not show how far the
    /// body swings.
    pub min_samples: usize,
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self {
            window_s: 0.5,
            step_s: 0.1,
            threshold_deg: 5.0,
            persistence_s: 2.0,
            lull_s: 1.0,
            min_samples: 10,
        }
    }
}

impl DetectorSettings {
    /// Checks every number. No lull and no persistence are valid: the first swing counts then.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("window_s", self.window_s, 0.01..=60.0, "s")?;
        check("step_s", self.step_s, 0.001..=60.0, "s")?;
        if self.step_s > self.window_s {
            let expected = format!("no more than window_s, {} s", self.window_s);
            return Err(SettingError::new("step_s", self.step_s, expected));
        }
        check("threshold_deg", self.threshold_deg, 1e-6..=360.0, "degrees")?;
        check("persistence_s", self.persistence_s, 0.0..=3600.0, "s")?;
        check("lull_s", self.lull_s, 0.0..=3600.0, "s")?;
        // One sample does not fluctuate.
        SettingError::check("min_samples", self.min_samples, 2..=100_000, "")
    }
}

/// The samples are too far apart for the detector's window.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "sampled too slowly: {rate_hz:.1} Hz, a window of {window_s} s needs at least {min_rate_hz:.0} Hz"
)]
pub struct SampledTooSlowly {
    /// Mean rate of the last samples.
    pub rate_hz: f64,
    /// Length of the window.
    pub window_s: f64,
    /// Rate needed.
    pub min_rate_hz: f64,
}

/// What the detector makes of one position of its window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assessment {
    /// Time of the window's end.
    pub time_s: f64,
    /// The larger of the fluctuations of roll and pitch: maximum minus minimum
    /// within the window.
    pub fluctuation_deg: f64,
    /// Whether the robot counts as damaged now.
    pub damaged: bool,
}

/// The detector: samples in, an [`Assessment`] out each time the window moves.
///
/// Memory is constant whatever the rate: extremes are kept per step, and the
/// window is the last few steps.
///
/// ```
/// use mlr_filter::{DamageDetector, DetectorSettings};
///
/// let mut detector = DamageDetector::new(DetectorSettings::default())?;
/// let mut flagged_s = None;
/// for i in 0..6000 {
///     let t = f64::from(i) / 1000.0;
///     // Rocks by 6 degrees from 2 s on.
///     let roll_rad = if t < 2.0 { 0.0 } else { 0.105 * (6.28 * t).sin() };
///     if let Some(assessment) = detector.push(t, roll_rad, 0.0)?
///         && assessment.damaged
///     {
///         flagged_s = flagged_s.or(Some(assessment.time_s));
///     }
/// }
/// let flagged_s = flagged_s.expect("this is damage");
/// assert!(flagged_s > 4.0 && flagged_s < 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct DamageDetector {
    settings: DetectorSettings,
    /// The steps of the window that have samples, the last one still filling.
    steps: VecDeque<Step>,
    steps_per_window: i64,
    /// Time at which step 0 began: that of the first sample.
    origin_s: f64,
    /// Samples since then.
    received: usize,
    /// Runs of samples in a row, between pauses, that were too short for a window.
    short_runs: u32,
    /// First and last time at which the current episode exceeded the threshold.
    episode: Option<(f64, f64)>,
}

/// Extremes of roll and pitch within one step.
#[derive(Debug, Clone, Copy)]
struct Step {
    number: i64,
    samples: usize,
    roll: Extremes,
    pitch: Extremes,
}

#[derive(Debug, Clone, Copy)]
struct Extremes {
    low: f64,
    high: f64,
}

impl Extremes {
    const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn including(self, value: f64) -> Self {
        self.joined(Self {
            low: value,
            high: value,
        })
    }

    fn joined(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn range(self) -> f64 {
        (self.high - self.low).max(0.0)
    }
}

impl DamageDetector {
    /// A detector that has seen nothing.
    ///
    /// # Errors
    /// [`SettingError`] for a setting that makes no sense.
    pub fn new(settings: DetectorSettings) -> Result<Self, SettingError> {
        settings.check()?;
        Ok(Self {
            settings,
            steps: VecDeque::new(),
            steps_per_window: (settings.window_s / settings.step_s).round() as i64,
            origin_s: 0.0,
            received: 0,
            short_runs: 0,
            episode: None,
        })
    }

    /// Adds a sample. Time must not run backwards; a sample that does is
    /// ignored. After a pause longer than the window the detector is reset.
    ///
    /// # Errors
    /// [`SampledTooSlowly`] when a full window has too few samples.
    pub fn push(
        &mut self,
        time_s: f64,
        roll_rad: f64,
        pitch_rad: f64,
    ) -> Result<Option<Assessment>, SampledTooSlowly> {
        let Some(last) = self.steps.back().map(|step| step.number) else {
            self.begin_anew(time_s, roll_rad, pitch_rad);
            return Ok(None);
        };
        // A hair of tolerance: a time that is a multiple of the step, but for
        // rounding, begins the next one.
        let number = ((time_s - self.origin_s) / self.settings.step_s + 1e-6).floor() as i64;
        if number <= last {
            if number == last {
                self.add_to_step(roll_rad, pitch_rad);
            }
            return Ok(None);
        }
        if number - last > self.steps_per_window {
            self.check_pause(time_s)?;
            self.begin_anew(time_s, roll_rad, pitch_rad);
            return Ok(None);
        }
        let assessment = if last + 1 >= self.steps_per_window {
            let end_s = self.origin_s + (last + 1) as f64 * self.settings.step_s;
            self.check_rate(time_s)?;
            self.short_runs = 0;
            Some(self.assess(end_s))
        } else {
            None
        };
        self.begin_step(number, roll_rad, pitch_rad);
        Ok(assessment)
    }

    fn begin_anew(&mut self, time_s: f64, roll_rad: f64, pitch_rad: f64) {
        self.steps.clear();
        self.episode = None;
        self.origin_s = time_s;
        self.received = 0;
        self.begin_step(0, roll_rad, pitch_rad);
    }

    fn begin_step(&mut self, number: i64, roll_rad: f64, pitch_rad: f64) {
        let oldest = number - self.steps_per_window;
        self.steps.retain(|step| step.number > oldest);
        self.steps.push_back(Step {
            number,
            samples: 0,
            roll: Extremes::NONE,
            pitch: Extremes::NONE,
        });
        self.add_to_step(roll_rad, pitch_rad);
    }

    fn add_to_step(&mut self, roll_rad: f64, pitch_rad: f64) {
        self.received += 1;
        if let Some(step) = self.steps.back_mut() {
            step.samples += 1;
            step.roll = step.roll.including(roll_rad);
            step.pitch = step.pitch.including(pitch_rad);
        }
    }

    /// After a pause: a lost connection is no fault of the rate, pauses between
    /// all samples are.
    fn check_pause(&mut self, now_s: f64) -> Result<(), SampledTooSlowly> {
        const SHORT_RUNS: u32 = 5;
        self.short_runs += 1;
        if self.short_runs < SHORT_RUNS {
            return Ok(());
        }
        self.check_rate(now_s)
    }

    /// The window must have enough samples when the next one comes at `now_s`.
    fn check_rate(&self, now_s: f64) -> Result<(), SampledTooSlowly> {
        let samples: usize = self.steps.iter().map(|step| step.samples).sum();
        // One sample more or less falls into a window by chance.
        if samples + 1 >= self.settings.min_samples {
            return Ok(());
        }
        Err(SampledTooSlowly {
            rate_hz: self.received as f64 / (now_s - self.origin_s),
            window_s: self.settings.window_s,
            min_rate_hz: self.settings.min_samples as f64 / self.settings.window_s,
        })
    }

    /// Looks at the full window that ends at `time_s`.
    fn assess(&mut self, time_s: f64) -> Assessment {
        let range_of = |axis: fn(&Step) -> Extremes| {
            self.steps
                .iter()
                .map(axis)
                .fold(Extremes::NONE, Extremes::joined)
                .range()
        };
        let fluctuation_deg = range_of(|step| step.roll)
            .max(range_of(|step| step.pitch))
            .to_degrees();
        if fluctuation_deg > self.settings.threshold_deg {
            let (begin_s, _) = self.episode.unwrap_or((time_s, time_s));
            self.episode = Some((begin_s, time_s));
        }
        // A hair of tolerance: times are sums of steps.
        let slack_s = 1e-6;
        self.episode = self
            .episode
            .filter(|(_, last_s)| time_s - last_s <= self.settings.lull_s + slack_s);
        Assessment {
            time_s,
            fluctuation_deg,
            damaged: self.episode.is_some_and(|(begin_s, last_s)| {
                last_s - begin_s + slack_s >= self.settings.persistence_s
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    /// Times at which the detector calls a rolling body damaged.
    fn damaged_times(
        rate_hz: f64,
        duration_s: f64,
        roll_deg: impl Fn(f64) -> f64,
    ) -> Result<Vec<f64>, SampledTooSlowly> {
        let mut detector = DamageDetector::new(DetectorSettings::default()).unwrap();
        let mut times = Vec::new();
        for i in 0..(duration_s * rate_hz) as usize {
            let t = i as f64 / rate_hz;
            if let Some(assessment) = detector.push(t, roll_deg(t).to_radians(), 0.0)?
                && assessment.damaged
            {
                times.push(assessment.time_s);
            }
        }
        Ok(times)
    }

    #[test]
    fn a_healthy_walk_is_never_flagged() {
        let rocking = |t: f64| 2.4 * (TAU * t).sin();
        assert_eq!(
            damaged_times(1000.0, 60.0, rocking).unwrap(),
            Vec::<f64>::new()
        );
    }

    #[test]
    fn a_single_knock_is_not_damage() {
        let knock = |t: f64| if (5.0..5.2).contains(&t) { 10.0 } else { 0.0 };
        assert_eq!(
            damaged_times(1000.0, 20.0, knock).unwrap(),
            Vec::<f64>::new()
        );
    }

    #[test]
    fn a_fall_once_per_cycle_is_damage_until_it_ends() {
        // Falls for a tenth of a second each second, from 3 s to 13 s.
        let falling = |t: f64| {
            if (3.0..13.0).contains(&t) && t.fract() < 0.1 {
                -7.0
            } else {
                0.0
            }
        };
        let times = damaged_times(1000.0, 20.0, falling).unwrap();
        assert!((5.0..5.8).contains(&times[0]), "flagged at {}", times[0]);
        let last = times.last().unwrap();
        assert!((13.0..14.2).contains(last), "until {last}");
    }

    #[test]
    fn a_rate_too_low_for_the_window_is_refused() {
        let message = damaged_times(4.8, 20.0, |_| 0.0).unwrap_err().to_string();
        assert!(
            message.contains("4.8 Hz") && message.contains("20 Hz"),
            "{message}"
        );
        assert!(damaged_times(25.0, 20.0, |_| 0.0).is_ok());
        assert!(
            damaged_times(1.0, 20.0, |_| 0.0).is_err(),
            "slower than the window"
        );
    }

    #[test]
    fn a_lost_connection_is_no_low_rate() {
        let mut detector = DamageDetector::new(DetectorSettings::default()).unwrap();
        for outage in 0..10 {
            for i in 0..1000 {
                let t = f64::from(outage) * 60.0 + f64::from(i) / 1000.0;
                detector.push(t, 0.0, 0.0).unwrap();
            }
        }
    }

    #[test]
    fn settings_that_make_no_sense_are_named() {
        let with = |change: fn(&mut DetectorSettings)| {
            let mut settings = DetectorSettings::default();
            change(&mut settings);
            DamageDetector::new(settings).unwrap_err().to_string()
        };
        assert!(with(|s| s.window_s = 0.0).starts_with("window_s: 0 "));
        assert!(with(|s| s.step_s = 1.0).contains("no more than window_s"));
        assert!(with(|s| s.threshold_deg = f64::NAN).starts_with("threshold_deg: NaN"));
        assert!(with(|s| s.min_samples = 0).starts_with("min_samples: 0 "));
    }

    proptest! {
        #[test]
        fn memory_does_not_grow_and_the_window_sees_the_extremes(
            rolls in prop::collection::vec(-10.0..10.0_f64, 3000),
        ) {
            let mut detector = DamageDetector::new(DetectorSettings::default()).unwrap();
            for (i, roll_deg) in rolls.iter().enumerate() {
                let t = i as f64 / 1000.0;
                let assessment = detector.push(t, roll_deg.to_radians(), 0.0).unwrap();
                prop_assert!(detector.steps.len() <= 5);
                if let Some(assessment) = assessment {
                    let end = (assessment.time_s * 1000.0).round() as usize;
                    let window = &rolls[end - 500..end];
                    let high = window.iter().copied().fold(f64::MIN, f64::max);
                    let low = window.iter().copied().fold(f64::MAX, f64::min);
                    prop_assert!((assessment.fluctuation_deg - (high - low)).abs() < 1e-9);
                }
            }
        }

        #[test]
        fn any_time_stamps_are_survived(times in prop::collection::vec(-1e3..1e3_f64, 1..200)) {
            let mut detector = DamageDetector::new(DetectorSettings::default()).unwrap();
            for t in times {
                let _ = detector.push(t, 0.0, 0.0);
            }
        }
    }
}
