//! The model's own error: how the walk of the right model differs from the robot's.

mod covariance;

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

pub(crate) use self::covariance::{Compared, Correlations, Scatter, Spread, Unknown, turned_s};

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
    /// Robots whose errors are of another kind, as something unknown would make them; none where a table has none. Counts
    /// only where means of walks are compared.
    #[serde(default)]
    pub missed: Option<MissedShare>,
    /// Error of the rates at rest, degrees per second.
    pub rest_rate_dps: f64,
    /// Share of the errors that count as independent evidence. The process is no better than what it
    /// was learned from, and the most probable parameters are found only so well: a power of
    /// the likelihood below 1 asks that a model comes near the data, not that it made them (Miller and
    /// Dunson 2019, "Robust Bayesian inference via coarsening"). An explanation takes that of means for single walks,
    /// too.
    pub power: f64,
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
    /// How far it errs along what compliant impacts change, in units of half their difference from rigid ones.
    #[serde(default)]
    pub impacts_share: f64,
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

/// Share of robots whose walk the engine misses as something unknown would make it: the more, the farther robots of one make
/// spread in it (`tools/plant/missed.py`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MissedShare {
    /// Where they spread so far, half of them are missed, degrees.
    pub half_at_deg: f64,
    /// The odds to be missed grow with this power of the spread.
    pub power: f64,
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
    /// As a share of how far impacts change the walk. Counts only where means of walks are compared.
    #[serde(default)]
    pub impacts_share: f64,
}

/// Half octaves of the scale of the discrepancy: from a third of what is usual to what throws a
/// robot over.
const SCALE_OCTAVES: std::ops::RangeInclusive<i32> = -3..=10;
/// Harmonics of the gait that a record at [`super::WalkRecord::RATE_HZ`] shows.
const HARMONICS: usize = 8;

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
        if let Some(missed) = &self.missed {
            let half_at_deg = missed.half_at_deg;
            check("missed.half_at_deg", half_at_deg, 1e-6..=1e6, "degrees")?;
            check("missed.power", missed.power, 1e-3..=10.0, "")?;
        }
        let spread_deg = self.largest_spread_deg;
        check("largest_spread_deg", spread_deg, 1e-3..=1e3, "degrees")?;
        check("power", self.power, 1e-3..=1.0, "")?;
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
        check("scatter_share", self.scatter_share, 0.0..=100.0, "")?;
        check("impacts_share", self.impacts_share, 0.0..=100.0, "")
    }

    /// What the right model usually leaves of a body that swings so far where robots spread little: what
    /// repeats with the gait, and what does not.
    pub(crate) fn usual_deg(&self, swing_deg: f64) -> [f64; 2] {
        let irregular =
            self.irregular.variance(swing_deg, 0.0, 0.0) + self.white.variance(swing_deg, 0.0, 0.0);
        [self.periodic.variance(swing_deg, 0.0, 0.0), irregular].map(f64::sqrt)
    }

    /// Factors by which the discrepancy of one robot exceeds what is usual, with the logarithms of
    /// their probabilities: where a walk depends on details, it is either met or missed.
    fn scales(&self, spread: Spread) -> Vec<(f64, f64)> {
        let deviation = self.ln_scale_deviation + self.ln_scale_spread * spread.tilt_deg.ln_1p();
        let weights = SCALE_OCTAVES
            .map(|octave| 0.5 * f64::from(octave))
            .map(|octave| {
                let ln_weight = -0.5 * (octave * std::f64::consts::LN_2 / deviation).powi(2);
                (octave.exp2(), ln_weight)
            });
        let weights: Vec<(f64, f64)> = weights.collect();
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

impl MissedShare {
    /// Where robots of one make spread so far.
    pub(crate) fn share(self, spread: Spread) -> f64 {
        let odds = libm::pow(spread.tilt_deg / self.half_at_deg, self.power);
        odds / (1.0 + odds)
    }
}

impl Amplitude {
    fn check(self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("base_deg", self.base_deg, 0.0..=45.0, "degrees")?;
        check("swing_share", self.swing_share, 0.0..=100.0, "")?;
        check("spread_share", self.spread_share, 0.0..=100.0, "")?;
        check("impacts_share", self.impacts_share, 0.0..=100.0, "")
    }

    /// Squared degrees, where the body swings, robots of one make spread and impacts change the walk so far.
    fn variance(self, swing_deg: f64, spread_deg: f64, impacts_deg: f64) -> f64 {
        let of_swing = self.swing_share * swing_deg;
        let of_spread = self.spread_share * spread_deg;
        let of_impacts = self.impacts_share * impacts_deg;
        self.base_deg.powi(2) + of_swing.powi(2) + of_spread.powi(2) + of_impacts.powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let scales = tilt.scales(Spread::default());
        let sum: f64 = scales.iter().map(|(_, ln)| ln.exp()).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let likeliest = scales.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert_eq!(likeliest.0, 1.0);
    }

    #[test]
    fn more_robots_are_missed_where_they_spread_more() {
        let missed = MissedShare {
            half_at_deg: 10.0,
            power: 0.5,
        };
        let share = |tilt_deg: f64| {
            missed.share(Spread {
                tilt_deg,
                ..Spread::default()
            })
        };
        assert!((share(10.0) - 0.5).abs() < 1e-12);
        assert_eq!(share(0.0), 0.0);
        assert!((share(0.1) - 0.1 / 1.1).abs() < 1e-12);
    }
}
