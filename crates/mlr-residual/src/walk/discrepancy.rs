//! The model's own error: how the walk of the right model differs from the robot's.

use mlr_filter::SettingError;
use nalgebra::{DMatrix, DMatrixView};
use serde::{Deserialize, Serialize};

use super::{WalkRecord, observation::GROUPS};

/// Covariance of the model discrepancy of a walk, learned from robots that lack nothing
/// (`tools/plant/discrepancy.py`).
///
/// Each axis is a Gaussian process over time. While the robot walks it is the sum of a constant,
/// a periodic part that repeats with the gait and changes its shape slowly, an irregular part,
/// and independent errors; yaw has an error of the rate of turning besides. Amplitudes grow with
/// how far the measured body swings on these axes, and with how far robots of one make spread in this walk: where
/// the walk is sensitive to the robot's parameters, it is as sensitive to what the physics engine
/// gets wrong. The errors of roll and pitch are multiplied by a scale that differs from robot to
/// robot, those of yaw by another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// Roll and pitch.
    pub tilt: AxisDiscrepancy,
    /// Yaw.
    pub yaw: AxisDiscrepancy,
    /// Rate of turning.
    pub turning: TurningDiscrepancy,
    /// Spreads far above this count as this.
    pub largest_spread_deg: f64,
    /// Error of the rates at rest, degrees per second.
    pub rest_rate_dps: f64,
    /// Share of the errors that count as independent evidence. The process is no better than what it
    /// was learned from, and the most probable parameters are found only so well: a power of
    /// the likelihood below 1 asks that a model comes near the data, not that it made them (Miller and
    /// Dunson 2019, "Robust Bayesian inference via coarsening").
    pub power: f64,
    /// The same where it is asked what the robot's own parameters are, rather than with which ones
    /// this model walks like it: what the engine gets wrong of one robot on every day passes for
    /// parameters.
    pub physical_power: f64,
    /// How far off the body of a robot is that an engine makes walk like a given one, in standard
    /// deviations of the make: more walks of one kind do not tell it.
    pub engine_bias: f64,
}

/// Standard deviations of the parts of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AxisDiscrepancy {
    /// Independent errors of the samples.
    pub white: Amplitude,
    /// Constant while the robot walks.
    pub constant: Amplitude,
    /// Periodic part.
    pub periodic: Amplitude,
    /// Irregular part.
    pub irregular: Amplitude,
    /// Harmonic k of the gait has an amplitude in proportion to k to the minus this.
    pub harmonic_decay: f64,
    /// Time over which the periodic part keeps its shape.
    pub coherence_s: f64,
    /// Correlation time of the irregular part.
    pub irregular_s: f64,
    /// Standard deviation of the logarithm of the scale between robots that all walk alike.
    pub ln_scale_deviation: f64,
    /// What is added to it where robots of one make spread: times the logarithm of 1 and this spread
    /// of roll and pitch in degrees.
    pub ln_scale_spread: f64,
    /// How far the mean walk errs where single walks scatter about it, in units of their scatter. Counts only
    /// where means of walks are compared.
    #[serde(default)]
    pub scatter_share: f64,
}

/// Standard deviation of the rate of turning.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TurningDiscrepancy {
    /// Of a robot that goes straight on, where robots of one make turn alike, degrees per second.
    pub base_dps: f64,
    /// As a share of the measured rate.
    pub share: f64,
    /// As a share of how far their rates of turning spread.
    pub spread_share: f64,
}

/// A standard deviation that grows with how far the body swings, and with how far robots of one
/// make spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Amplitude {
    /// Without any swing, degrees.
    pub base_deg: f64,
    /// As a share of the swing.
    pub swing_share: f64,
    /// As a share of the spread.
    pub spread_share: f64,
}

/// Half octaves of the scale of the discrepancy: from a third of what is usual to what throws a
/// robot over.
const SCALE_OCTAVES: std::ops::RangeInclusive<i32> = -3..=10;
/// Harmonics of the gait that a record at [`WalkRecord::RATE_HZ`] shows.
const HARMONICS: usize = 8;
/// A yaw angle has no zero: this much off is nothing.
const ANY_YAW_DEG: f64 = 180.0;
/// Noise of an MPU-6050's integrated rate: 0.12 °/s RMS at 960 samples per second, as one at rest shows
/// it; its data sheet has 0.005 °/s/√Hz.
const GYROSCOPE_DEG_PER_SQRT_S: f64 = 0.004;

impl Default for Discrepancy {
    /// What was learned of single walks of the embedded robot.
    fn default() -> Self {
        Self::embedded(include_str!("../../../../data/discrepancy/jethexa.toml"))
    }
}

impl Discrepancy {
    /// What was learned of means of walks of the embedded robot.
    #[must_use]
    pub fn of_means() -> Self {
        Self::embedded(include_str!(
            "../../../../data/discrepancy/jethexa-mean.toml"
        ))
    }

    fn embedded(text: &str) -> Self {
        Self::from_toml(text).unwrap_or_else(|error| unreachable!("the embedded table: {error}"))
    }

    /// Reads a table.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let table: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        table.check().map_err(|error| error.to_string())?;
        Ok(table)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, axis) in [("tilt", &self.tilt), ("yaw", &self.yaw)] {
            axis.check().map_err(|error| error.under(name))?;
        }
        let check = SettingError::check::<f64>;
        check("turning.base_dps", self.turning.base_dps, 0.0..=1e3, "°/s")?;
        check("turning.share", self.turning.share, 0.0..=1e3, "")?;
        check(
            "turning.spread_share",
            self.turning.spread_share,
            0.0..=1e3,
            "",
        )?;
        let spread_deg = self.largest_spread_deg;
        check("largest_spread_deg", spread_deg, 1e-3..=1e3, "degrees")?;
        check("power", self.power, 1e-3..=1.0, "")?;
        check("physical_power", self.physical_power, 1e-6..=1.0, "")?;
        check("engine_bias", self.engine_bias, 0.0..=100.0, "")?;
        check("rest_rate_dps", self.rest_rate_dps, 1e-6..=1e3, "°/s")
    }
}

impl AxisDiscrepancy {
    fn check(&self) -> Result<(), SettingError> {
        for (name, amplitude) in [
            ("white", self.white),
            ("constant", self.constant),
            ("periodic", self.periodic),
            ("irregular", self.irregular),
        ] {
            amplitude.check().map_err(|error| error.under(name))?;
        }
        let check = SettingError::check::<f64>;
        check(
            "white.base_deg",
            self.white.base_deg,
            1e-6..=45.0,
            "degrees",
        )?;
        check("harmonic_decay", self.harmonic_decay, 0.0..=10.0, "")?;
        check("coherence_s", self.coherence_s, 0.01..=1e4, "s")?;
        check("irregular_s", self.irregular_s, 1e-3..=1e3, "s")?;
        let deviation = self.ln_scale_deviation;
        check("ln_scale_deviation", deviation, 1e-3..=10.0, "")?;
        check("ln_scale_spread", self.ln_scale_spread, 0.0..=10.0, "")?;
        check("scatter_share", self.scatter_share, 0.0..=100.0, "")
    }

    /// What the right model usually leaves of a body that swings so far where robots spread little: what
    /// repeats with the gait, and what does not.
    pub(crate) fn usual_deg(&self, swing_deg: f64) -> [f64; 2] {
        let irregular =
            self.irregular.variance(swing_deg, 0.0) + self.white.variance(swing_deg, 0.0);
        [self.periodic.variance(swing_deg, 0.0), irregular].map(f64::sqrt)
    }

    /// Factors by which the discrepancy of one robot exceeds what is usual, with the logarithms of
    /// their probabilities: where a walk depends on details, it is either met or missed. All are
    /// equally probable where something unknown adds to the discrepancy.
    fn scales(&self, spread: Spread, is_unknown: bool) -> Vec<(f64, f64)> {
        let deviation = self.ln_scale_deviation + self.ln_scale_spread * spread.tilt_deg.ln_1p();
        let weights = SCALE_OCTAVES
            .map(|octave| 0.5 * f64::from(octave))
            .map(|octave| {
                let ln_weight = match is_unknown {
                    true if octave >= 0.0 => 0.0,
                    true => f64::NEG_INFINITY,
                    false => -0.5 * (octave * std::f64::consts::LN_2 / deviation).powi(2),
                };
                (octave.exp2(), ln_weight)
            });
        let weights: Vec<(f64, f64)> = weights.filter(|(_, ln)| ln.is_finite()).collect();
        let sum: f64 = weights.iter().map(|(_, ln)| ln.exp()).sum();
        let normalised = |(scale, ln): (f64, f64)| (scale, ln - sum.ln());
        weights.into_iter().map(normalised).collect()
    }

    /// Share of the periodic variance in each harmonic.
    fn harmonic_shares(&self) -> [f64; HARMONICS] {
        let mut shares = [0.0; HARMONICS];
        for (k, share) in shares.iter_mut().enumerate() {
            *share = libm::pow((k + 1) as f64, -2.0 * self.harmonic_decay);
        }
        let sum: f64 = shares.iter().sum();
        shares.map(|share| share / sum)
    }
}

impl Amplitude {
    fn check(self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("base_deg", self.base_deg, 0.0..=45.0, "degrees")?;
        check("swing_share", self.swing_share, 0.0..=100.0, "")?;
        check("spread_share", self.spread_share, 0.0..=100.0, "")
    }

    /// Squared degrees.
    fn variance(self, swing_deg: f64, spread_deg: f64) -> f64 {
        let of_swing = self.swing_share * swing_deg;
        let of_spread = self.spread_share * spread_deg;
        self.base_deg * self.base_deg + of_swing * of_swing + of_spread * of_spread
    }
}

/// Correlations over time that do not depend on the amplitudes: computed once for a record.
#[derive(Debug, Clone)]
pub(crate) struct Correlations {
    discrepancy: Discrepancy,
    /// Of roll and pitch, and of yaw.
    swing_deg: [f64; 2],
    turned_dps: f64,
    /// For roll and pitch, and for yaw.
    axes: [AxisCorrelations; 2],
}

#[derive(Debug, Clone)]
struct AxisCorrelations {
    /// Where no discrepancy acts: sensor noise, any yaw; squared degrees.
    always: DMatrix<f64>,
    /// Of a rate of turning that is one degree per second off, squared degrees.
    turning: DMatrix<f64>,
    walking: DMatrix<f64>,
    periodic: DMatrix<f64>,
    irregular: DMatrix<f64>,
}

impl Correlations {
    /// Of the samples with these indices, for a gait of this period.
    pub(crate) fn new(
        discrepancy: &Discrepancy,
        record: &WalkRecord,
        indices: &[usize],
        period_s: f64,
    ) -> Self {
        let of =
            |is_yaw: bool| AxisCorrelations::new(discrepancy, record, indices, period_s, is_yaw);
        Self {
            discrepancy: discrepancy.clone(),
            swing_deg: [record.swing_deg(), record.yaw_swing_deg()],
            turned_dps: record.turned_dps(),
            axes: [of(false), of(true)],
        }
    }

    /// Factors by which errors of roll and pitch, of yaw, and of the rates at rest may exceed what is
    /// usual, with the logarithms of their probabilities. Those of the rates do not.
    pub(crate) fn scales(&self, spread: Spread, unknown: Unknown) -> [Vec<(f64, f64)>; GROUPS] {
        [
            self.discrepancy.tilt.scales(spread, unknown.in_tilt),
            self.discrepancy.yaw.scales(spread, unknown.in_yaw),
            vec![(1.0, 0.0)],
        ]
    }

    /// Covariance on an axis (0 roll, 1 pitch, 2 yaw) where robots of one make spread so far, squared degrees.
    pub(crate) fn covariance(
        &self,
        axis: usize,
        spread: Spread,
        compared: Compared<'_>,
    ) -> DMatrix<f64> {
        let (of_axis, parts, swing_deg) = match axis {
            2 => (&self.discrepancy.yaw, &self.axes[1], self.swing_deg[1]),
            _ => (&self.discrepancy.tilt, &self.axes[0], self.swing_deg[0]),
        };
        let largest_deg = self.discrepancy.largest_spread_deg;
        let spread_deg = spread.tilt_deg / (1.0 + spread.tilt_deg / largest_deg);
        let variance = |amplitude: Amplitude| amplitude.variance(swing_deg, spread_deg);
        let turning = self.discrepancy.turning;
        let turning_dps = turning
            .base_dps
            .hypot(turning.share * self.turned_dps)
            .hypot(turning.spread_share * spread.turning_dps);
        let mut sum = &parts.always + turning_dps * turning_dps * &parts.turning;
        sum += variance(of_axis.constant) * &parts.walking;
        sum += variance(of_axis.periodic) * &parts.periodic;
        sum += variance(of_axis.irregular) * &parts.irregular;
        let of_mean = of_axis.scatter_share;
        let scattered = match compared {
            Compared::Walk => None,
            Compared::WalkOf(scatter) => Some((scatter, of_mean.hypot(1.0))),
            Compared::MeanOf(scatter) => Some((scatter, of_mean)),
        };
        if let Some((scatter, share)) = scattered {
            let errors = share * scatter.of_axis(axis, sum.nrows());
            sum += &errors * errors.transpose();
        }
        let base = of_axis.white.base_deg * of_axis.white.base_deg;
        for k in 0..sum.nrows() {
            let walking = parts.walking[(k, k)];
            sum[(k, k)] += base + walking * (variance(of_axis.white) - base);
        }
        sum
    }
}

impl AxisCorrelations {
    fn new(
        discrepancy: &Discrepancy,
        record: &WalkRecord,
        indices: &[usize],
        period_s: f64,
        is_yaw: bool,
    ) -> Self {
        let of_axis = if is_yaw {
            &discrepancy.yaw
        } else {
            &discrepancy.tilt
        };
        let n = indices.len();
        let times_s: Vec<f64> = indices.iter().map(|k| record.times_s()[*k]).collect();
        let first_s = record.times_s().first().copied().unwrap_or(0.0);
        let walked_s: Vec<f64> = times_s.iter().map(|t| t - record.start_s()).collect();
        let both_walk = |a: usize, b: usize| walked_s[a] > 0.0 && walked_s[b] > 0.0;
        let of_walk = |value: &dyn Fn(usize, usize) -> f64| {
            DMatrix::from_fn(n, n, |a, b| if both_walk(a, b) { value(a, b) } else { 0.0 })
        };
        let shares = of_axis.harmonic_shares();
        let periodic = |a: usize, b: usize| {
            let lag_s = walked_s[a] - walked_s[b];
            let kept = libm::exp(-0.5 * (lag_s / of_axis.coherence_s).powi(2));
            let turns = std::f64::consts::TAU * lag_s / period_s;
            let waves = shares.iter().enumerate();
            let shape: f64 = waves
                .map(|(k, s)| s * libm::cos((k + 1) as f64 * turns))
                .sum();
            kept * shape
        };
        // Matérn's covariance of order 3/2: continuous with its slope.
        let irregular = |a: usize, b: usize| {
            let lag = 3.0_f64.sqrt() * (walked_s[a] - walked_s[b]).abs() / of_axis.irregular_s;
            (1.0 + lag) * libm::exp(-lag)
        };
        let always = DMatrix::from_fn(n, n, |a, b| {
            let noise_s = times_s[a].min(times_s[b]) - first_s;
            let noise = GYROSCOPE_DEG_PER_SQRT_S.powi(2) * noise_s;
            noise + if is_yaw { ANY_YAW_DEG.powi(2) } else { 0.0 }
        });
        let turning = match is_yaw {
            true => {
                let turned_s = turned_s(&walked_s, period_s);
                of_walk(&|a, b| turned_s[a] * turned_s[b])
            }
            false => DMatrix::zeros(n, n),
        };
        Self {
            always,
            turning,
            walking: of_walk(&|_, _| 1.0),
            periodic: of_walk(&periodic),
            irregular: of_walk(&irregular),
        }
    }
}

/// The angle turned at each sample by a robot that turns by one degree per second: its strides grow over
/// the first cycle.
pub(crate) fn turned_s(walked_s: &[f64], period_s: f64) -> Vec<f64> {
    let turned = |walked_s: f64| match walked_s < period_s {
        true => walked_s.max(0.0).powi(2) / (2.0 * period_s),
        false => walked_s - period_s / 2.0,
    };
    walked_s.iter().copied().map(turned).collect()
}

/// Where something acts that no effect of the library makes: it multiplies what the model usually
/// gets wrong there, whatever that is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Unknown {
    pub(crate) in_tilt: bool,
    pub(crate) in_yaw: bool,
}

impl Unknown {
    /// Every place that it may act at.
    pub(crate) const ANYWHERE: [Self; 3] = [
        Self {
            in_tilt: true,
            in_yaw: false,
        },
        Self {
            in_tilt: false,
            in_yaw: true,
        },
        Self {
            in_tilt: true,
            in_yaw: true,
        },
    ];
}

/// How far robots of one make spread in a walk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Spread {
    /// Root mean square of roll and pitch together about their means.
    pub(crate) tilt_deg: f64,
    /// Rate of turning.
    pub(crate) turning_dps: f64,
}

/// How single walks scatter about their mean: errors whose products with themselves sum to the
/// covariance, a column each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scatter(pub(crate) DMatrix<f64>);

impl Scatter {
    /// The rows of an axis of so many samples.
    fn of_axis(&self, axis: usize, samples: usize) -> DMatrixView<'_, f64> {
        self.0.rows(axis * samples, samples)
    }
}

/// What is compared with a record.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Compared<'s> {
    /// A walk.
    Walk,
    /// A walk whose neighbours scatter so.
    WalkOf(&'s Scatter),
    /// The mean of walks that scatter so.
    MeanOf(&'s Scatter),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::{Observation, record::tests::walking_record};

    #[test]
    fn the_embedded_table_is_valid_and_a_misspelt_one_is_not() {
        assert!(Discrepancy::default().check().is_ok());
        let text = include_str!("../../../../data/discrepancy/jethexa.toml");
        let error = Discrepancy::from_toml(&text.replace("power =", "powr =")).unwrap_err();
        assert!(error.contains("powr"), "{error}");
        let error = Discrepancy::from_toml(&text.replace("power = 0", "power = 7")).unwrap_err();
        assert!(error.contains("power"), "{error}");
    }

    #[test]
    fn the_scales_are_a_distribution_about_one() {
        let tilt = Discrepancy::default().tilt;
        for is_unknown in [false, true] {
            let scales = tilt.scales(Spread::default(), is_unknown);
            let sum: f64 = scales.iter().map(|(_, ln)| ln.exp()).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        let scales = tilt.scales(Spread::default(), false);
        let likeliest = scales.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert_eq!(likeliest.0, 1.0);
    }

    #[test]
    fn errors_far_beyond_the_usual_are_likelier_where_something_unknown_acts() {
        let record = walking_record();
        let observation = Observation::new(&record, &Discrepancy::default(), 1.0);
        let n = observation.samples_of_an_axis() as f64;
        let ln_gain = |scale: f64, tilt_deg: f64| {
            let spread = Spread {
                tilt_deg,
                ..Spread::default()
            };
            // Whitened errors of roll and pitch that are so many times as large as usual.
            let squares = [2.0 * n * scale * scale, n, 3.0];
            let ln = |unknown: Unknown| {
                let usual = observation.whitening(spread, Compared::Walk).unwrap();
                let whitening = observation.with_unknown(&usual, spread, unknown);
                whitening.ln_density(squares, observation.len()).0
            };
            ln(Unknown::ANYWHERE[0]) - ln(Unknown::default())
        };
        assert!(ln_gain(0.5, 0.25) < -1.0);
        assert!(ln_gain(8.0, 0.25) > 2.0);
        // Control: a robot that may walk in many ways is often missed.
        assert!(ln_gain(8.0, 3.0) < ln_gain(8.0, 0.25) - 2.0);
    }

    #[test]
    fn the_model_errs_while_the_robot_walks_and_more_where_robots_spread() {
        let record = walking_record();
        let observation = Observation::new(&record, &Discrepancy::default(), 1.0);
        let roll = |spread_deg: f64| {
            let covariance = observation.covariance(Spread {
                tilt_deg: spread_deg,
                ..Spread::default()
            });
            let n = observation.samples_of_an_axis();
            assert!(covariance.clone().cholesky().is_some());
            (
                covariance[(0, 0)],
                covariance[(n - 1, n - 1)],
                covariance[(0, n - 1)],
            )
        };
        let (still, walking, between) = roll(0.3);
        assert!(walking > 4.0 * still, "{still} {walking}");
        assert!(between.abs() < 1e-3);
        let (other_still, tipping, _) = roll(3.0);
        assert!((other_still - still).abs() < 1e-12 && tipping > 1.5 * walking);
    }
}
