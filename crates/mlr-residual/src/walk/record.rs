//! The part of a recording that a model has to explain.

use std::ops::Range;

use mlr_filter::{Axes, MovingMean, OrientationSeries};

use super::WalkError;
use crate::walk_effects::WalkEffect;

/// Roll, pitch and yaw of a standing and then walking robot at an even rate, divided
/// into the stretch that hypotheses are weighed by and one that nothing sees.
#[derive(Debug, Clone)]
pub struct WalkRecord {
    times_s: Vec<f64>,
    measured_deg: Axes<Vec<f64>>,
    start_s: f64,
    start_is_told: bool,
    standing: Range<usize>,
    fit: Range<usize>,
    unseen: Range<usize>,
    rest_rate_dps: Option<[f64; 3]>,
    is_dead_reckoned: bool,
    noise_deg: Axes<f64>,
}

/// Share of the walk that decides between hypotheses. The rest measures their errors, which takes
/// fewer samples than a decision.
const FIT_SHARE: f64 = 0.65;
/// Half of the shortest one of any use, three gait cycles of a second.
const SHORTEST_S: f64 = 1.5;
/// Standing longer ago than this before the walk is left out.
const STANDING_S: f64 = 8.0;
/// The end of the standing stretch, where the start may already show.
const MARGIN_S: f64 = 0.1;

impl WalkRecord {
    /// Samples per second.
    pub const RATE_HZ: f64 = 25.0;
    /// Time between two samples.
    pub const PERIOD_S: f64 = 1.0 / Self::RATE_HZ;
    /// Angles are means over the time between two samples.
    pub(crate) const HALF_WIDTH_S: f64 = 0.5 / Self::RATE_HZ;
    /// The longest walk that explanations look at.
    pub const LONGEST_WALK_S: f64 = 12.0;
    /// The longest motion that ends, of which all is looked at.
    pub const LONGEST_MOTION_S: f64 = 40.0;

    /// Divides a recording whose time stamps increase and whose robot starts to walk at
    /// `start_s`: `start_is_told` where that is when it was commanded to, rather than
    /// when it was seen to. The first 65 % of the walk weigh hypotheses, and the rest measures
    /// errors. What comes before `from_s` of the walk is left out.
    ///
    /// `rest_rate_dps` is the mean of the gyroscope's raw rates while the robot stands,
    /// where they are known and went into roll, pitch and yaw.
    ///
    /// # Errors
    /// [`WalkError::TooShort`] when there is too little of the walk for two stretches.
    pub fn new(
        recording: &OrientationSeries,
        start_s: f64,
        start_is_told: bool,
        from_s: f64,
        rest_rate_dps: Option<[f64; 3]>,
    ) -> Result<Self, WalkError> {
        let longest_s = Self::LONGEST_WALK_S;
        Self::up_to(
            longest_s,
            recording,
            start_s,
            start_is_told,
            from_s,
            rest_rate_dps,
        )
    }

    /// The same where so much of the walk is looked at.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn up_to(
        longest_s: f64,
        recording: &OrientationSeries,
        start_s: f64,
        start_is_told: bool,
        from_s: f64,
        rest_rate_dps: Option<[f64; 3]>,
    ) -> Result<Self, WalkError> {
        let ends = recording.times_s().first().zip(recording.times_s().last());
        let (first_s, last_s) = ends.map_or((start_s, start_s), |(first, last)| (*first, *last));
        let from_s = from_s.max(start_s);
        let walked_s = last_s - Self::HALF_WIDTH_S - from_s;
        let stretch_s = (walked_s / 2.0).min(longest_s / 2.0);
        if stretch_s < SHORTEST_S {
            return Err(WalkError::TooShort {
                walked_s,
                needed_s: 2.0 * SHORTEST_S,
            });
        }
        let begin_s = first_s.max(start_s - STANDING_S);
        let count = ((from_s + 2.0 * stretch_s - begin_s) * Self::RATE_HZ).floor() as usize;
        let times_s: Vec<f64> = (0..count)
            .map(|index| begin_s + index as f64 * Self::PERIOD_S)
            .collect();
        let means = MovingMean::new(recording);
        let mut measured_deg = Axes::<Vec<f64>>::default();
        for time_s in &times_s {
            let mean = means.around(*time_s, Self::HALF_WIDTH_S);
            measured_deg.push(mean.map(|_, angle_rad| angle_rad.to_degrees()));
        }
        let index_of = |time_s: f64| times_s.partition_point(|t| *t < time_s);
        let stood = from_s <= start_s + Self::PERIOD_S;
        let standing = 0..if stood {
            index_of(start_s - MARGIN_S)
        } else {
            0
        };
        let from = index_of(from_s);
        let middle = from + (FIT_SHARE * (count - from) as f64) as usize;
        let noise_deg = measured_deg
            .as_ref()
            .map(|_, angles| deviation_from_trend(&angles[standing.clone()]));
        Ok(Self {
            measured_deg,
            start_s,
            start_is_told,
            standing,
            fit: from..middle,
            unseen: middle..count,
            rest_rate_dps,
            is_dead_reckoned: false,
            noise_deg,
            times_s,
        })
    }

    /// The same, where roll, pitch and yaw were integrated from the rates alone, the bias
    /// included, beginning with the tilt of the standing sensor at the first sample.
    #[must_use]
    pub fn dead_reckoned(self) -> Self {
        Self {
            is_dead_reckoned: true,
            ..self
        }
    }

    /// Log time of each sample.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Measured roll, pitch and yaw.
    pub fn measured_deg(&self) -> &Axes<Vec<f64>> {
        &self.measured_deg
    }

    /// Log time at which the walk starts.
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// Whether that is when it was commanded to.
    pub fn start_is_told(&self) -> bool {
        self.start_is_told
    }

    /// Whether it does not show such an effect, however large it is: one that shifts the whole walk, where it is not
    /// told when that was commanded.
    pub(crate) fn hides(&self, effect: &dyn WalkEffect) -> bool {
        effect.is_a_delay() && !self.start_is_told
    }

    /// The samples at which the robot stands; none where the log does not show it.
    pub fn standing(&self) -> Range<usize> {
        self.standing.clone()
    }

    /// The samples of the walk that hypotheses are weighed by.
    pub fn fit(&self) -> Range<usize> {
        self.fit.clone()
    }

    /// The samples that neither fit nor search sees.
    pub fn unseen(&self) -> Range<usize> {
        self.unseen.clone()
    }

    /// All samples of the walk.
    pub(crate) fn walking(&self) -> Range<usize> {
        self.fit.start..self.unseen.end
    }

    /// Mean raw rates while the robot stands, degrees per second about x, y, z.
    pub fn rest_rate_dps(&self) -> Option<[f64; 3]> {
        self.rest_rate_dps
    }

    /// Whether roll, pitch and yaw were integrated from the rates alone, rather than made by
    /// the filter of some sensor.
    pub fn is_dead_reckoned(&self) -> bool {
        self.is_dead_reckoned
    }

    /// How much the angles scatter about a straight line while the robot stands.
    pub fn noise_deg(&self) -> Axes<f64> {
        self.noise_deg
    }

    /// Mean roll and pitch while the robot stands, or walks where the log does not show
    /// it standing.
    pub(crate) fn mean_tilt_deg(&self) -> [f64; 2] {
        let stretch = match self.standing() {
            standing if standing.len() > 1 => standing,
            _ => self.fit(),
        };
        [&self.measured_deg.roll, &self.measured_deg.pitch].map(|angles_deg| {
            let angles_deg = &angles_deg[stretch.clone()];
            angles_deg.iter().sum::<f64>() / angles_deg.len().max(1) as f64
        })
    }

    /// Root mean square of roll and pitch together about their means while the robot walks, over
    /// the stretch that hypotheses are weighed by.
    pub(crate) fn swing_deg(&self) -> f64 {
        let fit = self.fit();
        let square = [&self.measured_deg.roll, &self.measured_deg.pitch].map(|angles_deg| {
            let angles_deg = &angles_deg[fit.clone()];
            let n = angles_deg.len().max(1) as f64;
            let mean = angles_deg.iter().sum::<f64>() / n;
            angles_deg.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / n
        });
        square.iter().sum::<f64>().sqrt()
    }

    /// Root mean square of yaw about its mean and trend there.
    pub(crate) fn yaw_swing_deg(&self) -> f64 {
        deviation_from_trend(&self.measured_deg.yaw[self.fit()])
    }

    /// Mean rate of turning there, degrees per second.
    pub(crate) fn turned_dps(&self) -> f64 {
        slope(&self.measured_deg.yaw[self.fit()]) * Self::RATE_HZ
    }

    /// How long the walk is simulated to cover the first `samples` samples.
    pub(crate) fn walk_s(&self, samples: usize) -> f64 {
        let last_s = samples
            .checked_sub(1)
            .map_or(0.0, |last| self.times_s[last]);
        (last_s - self.start_s + 2.0 * Self::PERIOD_S).max(Self::PERIOD_S)
    }
}

/// Slope of the straight line through evenly spaced values, per value.
fn slope(values: &[f64]) -> f64 {
    let middle = (values.len() as f64 - 1.0) / 2.0;
    let line = || (0..values.len()).map(|index| index as f64 - middle);
    let along: f64 = line().zip(values).map(|(x, value)| x * value).sum();
    along / line().map(|x| x * x).sum::<f64>().max(1e-9)
}

/// Root mean square of what is left without mean and trend, degrees; 0 for fewer than three.
pub(super) fn deviation_from_trend(angles_deg: &[f64]) -> f64 {
    let n = angles_deg.len() as f64;
    if n < 3.0 {
        return 0.0;
    }
    let middle = (n - 1.0) / 2.0;
    let mean = angles_deg.iter().sum::<f64>() / n;
    let slope = slope(angles_deg);
    let line = (0..angles_deg.len()).map(|index| index as f64 - middle);
    let squares = line
        .zip(angles_deg)
        .map(|(x, a)| (a - mean - slope * x).powi(2));
    (squares.sum::<f64>() / n).sqrt()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A robot that stands for two seconds, then rolls, pitches and turns for ten.
    pub(crate) fn walking_record() -> WalkRecord {
        let times_s: Vec<f64> = (0..1200).map(|i| f64::from(i) * 0.01).collect();
        let walked = |t: &f64| (t - 2.0).max(0.0);
        let wave = |amplitude: f64, hz: f64| -> Vec<f64> {
            let angle = |t: &f64| amplitude * (std::f64::consts::TAU * hz * walked(t)).sin();
            times_s.iter().map(angle).collect()
        };
        let angles_rad = Axes {
            roll: wave(0.02, 1.0),
            pitch: wave(0.01, 2.0),
            yaw: times_s.iter().map(|t| 0.05 * walked(t)).collect(),
        };
        let recording = OrientationSeries::new(times_s, angles_rad).unwrap();
        WalkRecord::new(&recording, 2.0, false, 2.0, Some([0.0; 3]))
            .unwrap()
            .dead_reckoned()
    }

    /// A robot that was commanded to walk after a second, and is level all the time.
    pub(crate) fn level_record() -> WalkRecord {
        level_record_where(true)
    }

    /// The same where the start of the walk is that of the command, or when it was seen.
    pub(crate) fn level_record_where(start_is_told: bool) -> WalkRecord {
        let times_s: Vec<f64> = (0..420).map(|i| f64::from(i) * 0.01).collect();
        let level = Axes::from_fn(|_| vec![0.0; times_s.len()]);
        let recording = OrientationSeries::new(times_s, level).unwrap();
        WalkRecord::new(&recording, 1.0, start_is_told, 1.0, None).unwrap()
    }

    fn recording(duration_s: f64) -> OrientationSeries {
        let times_s: Vec<f64> = (0..(duration_s * 200.0) as u32)
            .map(|i| f64::from(i) / 200.0)
            .collect();
        let roll: Vec<f64> = times_s
            .iter()
            .map(|t| {
                if *t < 2.0 {
                    0.01
                } else {
                    0.1 * (5.0 * t).sin()
                }
            })
            .collect();
        OrientationSeries::new(times_s, Axes::from_fn(|_| roll.clone())).unwrap()
    }

    #[test]
    fn a_log_is_divided_into_standing_fitted_and_unseen() {
        let record = WalkRecord::new(&recording(12.0), 2.0, false, 2.0, None).unwrap();
        let time_s = |index: usize| record.times_s()[index];
        assert!(time_s(record.standing().end) < 2.0);
        assert!((time_s(record.fit().start) - 2.0).abs() < 0.05);
        assert_eq!(record.fit().end, record.unseen().start);
        assert_eq!(record.unseen().end, record.times_s().len());
        assert!((time_s(record.fit().end) - 8.5).abs() < 0.1);
        let [roll_deg, _] = record.mean_tilt_deg();
        assert!((roll_deg - 0.01_f64.to_degrees()).abs() < 1e-9);
        assert!(record.noise_deg().roll < 1e-9);
    }

    #[test]
    fn a_long_walk_is_cut_and_a_short_one_refused() {
        let long = WalkRecord::new(&recording(60.0), 2.0, false, 2.0, None).unwrap();
        assert!((long.times_s().last().unwrap() - 14.0).abs() < 0.1);
        let whole = WalkRecord::up_to(30.0, &recording(60.0), 2.0, false, 2.0, None).unwrap();
        assert!((whole.times_s().last().unwrap() - 32.0).abs() < 0.1);
        assert_eq!(whole.walking(), whole.fit().start..whole.times_s().len());
        let error = WalkRecord::new(&recording(4.0), 2.0, false, 2.0, None).unwrap_err();
        assert!(error.to_string().contains("2.0 s of the walk"), "{error}");
        assert!(error.is_recordings_fault());
    }

    #[test]
    fn damage_in_mid_walk_has_no_standing_stretch() {
        let record = WalkRecord::new(&recording(20.0), 6.0, false, 8.5, None).unwrap();
        assert!(record.standing().is_empty());
        assert!((record.times_s()[record.fit().start] - 8.5).abs() < 0.05);
    }
}
