//! The covariance of errors, sample by sample, that a table of the discrepancy makes.

use nalgebra::{DMatrix, DVector};

use super::{Amplitude, Discrepancy};
use crate::walk::{WalkRecord, observation::GROUPS};

/// A yaw angle has no zero: this much off is nothing.
const ANY_YAW_DEG: f64 = 180.0;
/// Noise of an MPU-6050's integrated rate: 0.12 °/s RMS at 960 samples per second, as one at rest shows
/// it; its data sheet has 0.005 °/s/√Hz.
const GYROSCOPE_DEG_PER_SQRT_S: f64 = 0.004;

/// Correlations over time that do not depend on the amplitudes: computed once for a record.
#[derive(Debug, Clone)]
pub(crate) struct Correlations {
    discrepancy: Discrepancy,
    /// Of roll and pitch, and of yaw.
    swing_deg: [f64; 2],
    turned_dps: f64,
    /// For roll and pitch, and for yaw.
    axes: [AxisCorrelations; 2],
    /// Of something unknown that is irregular, on any axis.
    irregular_of_unknown: DMatrix<f64>,
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
            irregular_of_unknown: irregular_of_unknown(record, indices, period_s),
        }
    }

    /// Share of robots whose errors are as something unknown would make them.
    pub(crate) fn missed_share(&self, spread: Spread) -> f64 {
        let missed = self.discrepancy.missed;
        missed.map_or(0.0, |missed| missed.share(spread))
    }

    /// Factors by which errors of roll and pitch, of yaw, and of the rates at rest may exceed what is
    /// usual, with the logarithms of their probabilities. Those of the rates do not.
    pub(crate) fn scales(&self, spread: Spread) -> [Vec<(f64, f64)>; GROUPS] {
        [
            self.discrepancy.tilt.scales(spread),
            self.discrepancy.yaw.scales(spread),
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
        // A walk is off the mean by what it scatters, and by what its impacts change.
        let off_mean = match compared {
            Compared::Walk => None,
            Compared::WalkOf(scatter) => Some((scatter, 1.0)),
            Compared::MeanOf(scatter) => Some((scatter, 0.0)),
        };
        let impacts_deg = off_mean.map_or(0.0, |(scatter, _)| {
            scatter.impacts_deg(axis, &parts.walking.diagonal())
        });
        let variance =
            |amplitude: Amplitude| amplitude.variance(swing_deg, spread_deg, impacts_deg);
        let turning = self.discrepancy.turning;
        let turning_dps = turning
            .base_dps
            .hypot(turning.share * self.turned_dps)
            .hypot(turning.spread_share * spread.turning_dps);
        let mut sum = &parts.always + turning_dps * turning_dps * &parts.turning;
        sum += variance(of_axis.constant) * &parts.walking;
        sum += variance(of_axis.periodic) * &parts.periodic;
        sum += variance(of_axis.irregular) * &parts.irregular;
        if let Some((scatter, of_walk)) = off_mean {
            let rows = sum.nrows();
            let walks =
                scatter.walks.rows(axis * rows, rows) * of_axis.scatter_share.hypot(of_walk);
            let impacts =
                scatter.impacts.rows(axis * rows, rows) * of_axis.impacts_share.hypot(of_walk);
            sum += &walks * walks.transpose() + &impacts * impacts.transpose();
        }
        let base = of_axis.white.base_deg * of_axis.white.base_deg;
        for k in 0..sum.nrows() {
            let walking = parts.walking[(k, k)];
            sum[(k, k)] += base + walking * (variance(of_axis.white) - base);
        }
        sum
    }

    /// What something unknown adds to the covariance on an axis, squared degrees; `None` where it does not act.
    pub(crate) fn of_unknown(&self, axis: usize, unknown: Unknown) -> Option<DMatrix<f64>> {
        let deviation_deg = unknown.deviation_deg(axis)?;
        let (parts, lasting) = match axis {
            2 => (&self.axes[1], &self.axes[1].turning),
            _ => (&self.axes[0], &self.axes[0].walking),
        };
        let each = deviation_deg * deviation_deg / 3.0;
        Some(each * (lasting + &parts.periodic + &self.irregular_of_unknown))
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
        let walked_s = walked_s(record, indices);
        let of_walk = |value: &dyn Fn(usize, usize) -> f64| while_walking(&walked_s, value);
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
        let irregular = |a: usize, b: usize| matern(walked_s[a] - walked_s[b], of_axis.irregular_s);
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

/// Time of each of these samples since the start of the walk.
fn walked_s(record: &WalkRecord, indices: &[usize]) -> Vec<f64> {
    let times_s = indices.iter().map(|k| record.times_s()[*k]);
    times_s.map(|time_s| time_s - record.start_s()).collect()
}

/// A correlation of samples that both are of the walk.
fn while_walking(walked_s: &[f64], value: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let both_walk = |a: usize, b: usize| walked_s[a] > 0.0 && walked_s[b] > 0.0;
    DMatrix::from_fn(walked_s.len(), walked_s.len(), |a, b| {
        if both_walk(a, b) { value(a, b) } else { 0.0 }
    })
}

/// The correlation of something unknown that is as fast as it likes: equal parts of all [`UNKNOWN_TIME_OCTAVES`].
fn irregular_of_unknown(record: &WalkRecord, indices: &[usize], period_s: f64) -> DMatrix<f64> {
    let walked_s = walked_s(record, indices);
    while_walking(&walked_s, |a, b| {
        let lag_s = walked_s[a] - walked_s[b];
        let each = UNKNOWN_TIME_OCTAVES.map(|k| matern(lag_s, period_s * f64::from(k).exp2()));
        each.sum::<f64>() / UNKNOWN_TIME_OCTAVES.count() as f64
    })
}

/// Matérn's correlation of order 3/2, of what is continuous with its slope.
fn matern(lag_s: f64, correlation_s: f64) -> f64 {
    let lag = 3.0_f64.sqrt() * lag_s.abs() / correlation_s;
    (1.0 + lag) * libm::exp(-lag)
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

/// Something that no effect of the library makes. It adds to the errors of an axis, while the robot walks, a third
/// of its variance each that is constant (of yaw: a rate of turning), that repeats with the gait, and that is irregular.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unknown {
    acts: Acts,
    /// Standard deviation; of yaw's rate of turning as many degrees per second.
    deviation_deg: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Acts {
    Tilting,
    Turning,
    Both,
}

/// Standard deviations of what is unknown, in octaves of a degree: from what the sensor's noise hides to what throws
/// a robot over. All are equally probable.
const UNKNOWN_OCTAVES: std::ops::RangeInclusive<i32> = -3..=4;

/// Correlation times of what is unknown and irregular, in octaves of the gait's period: from a vibration to a sway that
/// lasts for the walk. It has equal parts of all.
const UNKNOWN_TIME_OCTAVES: std::ops::RangeInclusive<i32> = -4..=2;

impl Unknown {
    /// Every way in which it may act, all equally probable.
    pub(crate) fn ways() -> impl Iterator<Item = Self> {
        [Acts::Tilting, Acts::Turning, Acts::Both]
            .into_iter()
            .flat_map(|acts| {
                UNKNOWN_OCTAVES.map(move |octave| Self {
                    acts,
                    deviation_deg: f64::from(octave).exp2(),
                })
            })
    }

    /// On an axis: 0 roll, 1 pitch, 2 yaw.
    fn deviation_deg(self, axis: usize) -> Option<f64> {
        match (self.acts, axis) {
            (Acts::Tilting, 2) | (Acts::Turning, 0 | 1) => None,
            _ => Some(self.deviation_deg),
        }
    }
}

/// How far robots of one make spread in a walk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Spread {
    /// Root mean square of roll and pitch together about their means.
    pub(crate) tilt_deg: f64,
    /// Rate of turning.
    pub(crate) turning_dps: f64,
}

/// How single walks scatter about their mean.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scatter {
    /// Errors whose products with themselves sum to the covariance of walks with impacts of one kind, a column each.
    pub(crate) walks: DMatrix<f64>,
    /// How walks with compliant impacts differ from the mean of both kinds.
    pub(crate) impacts: DVector<f64>,
}

impl Scatter {
    /// How far impacts change a walk on an axis, where `walking` is one: the standard deviation over the samples, of
    /// roll and pitch the root of the mean of both variances.
    fn impacts_deg(&self, axis: usize, walking: &DVector<f64>) -> f64 {
        let rows = walking.len();
        let count = walking.sum().max(1.0);
        let variance = |axis: usize| {
            let change = self.impacts.rows(axis * rows, rows).component_mul(walking);
            change.norm_squared() / count - (change.sum() / count).powi(2)
        };
        let variance = match axis {
            2 => variance(2),
            _ => 0.5 * (variance(0) + variance(1)),
        };
        variance.max(0.0).sqrt()
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
    use crate::walk::{Observation, observation::Whitening, record::tests::walking_record};

    /// By how much something unknown raises the logarithm of the density of a sway of so many degrees at this
    /// frequency, of a robot of a make whose walks spread so far.
    fn ln_gain(table: &Discrepancy, sway_deg: f64, rad_per_s: f64, tilt_deg: f64) -> f64 {
        let record = walking_record();
        let observation = Observation::new(&record, table, 1.0);
        let spread = Spread {
            tilt_deg,
            ..Spread::default()
        };
        let mut errors = DVector::zeros(observation.len());
        for (k, time_s) in observation.times_s().iter().enumerate() {
            if *time_s > record.start_s() {
                errors[k] = sway_deg * (rad_per_s * time_s).sin();
            }
        }
        assert_eq!(observation.samples_of_an_axis() * 3 + 3, observation.len());
        let ln = |whitening: &Whitening| {
            let squares = whitening.squares(&errors);
            whitening.ln_density(squares, observation.len()).0
        };
        let usual = observation.whitening(spread, Compared::Walk).unwrap();
        let with_unknown = observation.with_unknown(&usual);
        crate::ln_mean(with_unknown.iter().map(ln), with_unknown.len()) - ln(&usual)
    }

    #[test]
    fn errors_far_beyond_the_usual_are_likelier_where_something_unknown_acts() {
        // A sway that is no multiple of the gait.
        let ln_gain =
            |sway_deg, tilt_deg| ln_gain(&Discrepancy::default(), sway_deg, 9.0, tilt_deg);
        assert!(ln_gain(0.0, 0.25) < -0.5, "{}", ln_gain(0.0, 0.25));
        assert!(ln_gain(4.0, 0.25) > 2.0, "{}", ln_gain(4.0, 0.25));
        // Control: a robot that may walk in many ways is often missed.
        assert!(ln_gain(4.0, 30.0) < ln_gain(4.0, 0.25) - 2.0);
    }

    #[test]
    fn something_unknown_is_as_fast_as_it_likes_where_the_engine_errs_slowly() {
        let slow = Discrepancy::of_means();
        assert!(slow.tilt.irregular_s > 1.0);
        for rad_per_s in [9.0, 22.0] {
            let gain = ln_gain(&slow, 1.0, rad_per_s, 0.25);
            assert!(gain > 2.0, "{rad_per_s} {gain}");
        }
        let nothing = ln_gain(&slow, 0.0, 9.0, 0.25);
        assert!(nothing < -0.5, "{nothing}");
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
