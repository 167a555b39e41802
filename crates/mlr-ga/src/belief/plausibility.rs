//! Whether any morphology explains a walk at all.

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

/// How far the walk of the best morphology is from the measured one, when it is the right
/// one, and when something else is wrong.
///
/// Two hypotheses compete for the errors e of roll, pitch and yaw, given how far the body
/// moved (m): that the robot has the morphology that fits best, and that what it does has
/// nothing to do with any. Under both, ln e has a Student distribution
/// ([`ErrorModel`]); Bayes' rule gives the probability of the second. The same is asked of the
/// mean error of the nominal model (the paper's F per sample and axis), which sees what the
/// others forgive: yaw's drift, and a morphology that fits under an odd variation only. The two
/// are not independent; the graver counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PlausibilitySettings {
    /// Probability that something else than damage to legs decides how a robot walks, before
    /// the log is seen.
    pub something_else: f64,
    /// Prior probability of damage to each leg in that case, higher than for any robot. The share of damaged legs on the 40 logs
    /// of seed 1 that were held for unexplained (`docs/decision.md`).
    pub leg_damaged: f64,
    /// The least probability of something else for a log whose sensor has a defect.
    pub defective_sensor: f64,
    /// Errors of the right morphology.
    pub usual: ErrorModel,
    /// Errors of the best morphology where none is right.
    pub unexplained: ErrorModel,
    /// Mean error of the right morphology on the nominal model.
    pub usual_mean: MeanErrorModel,
    /// Mean error of the best morphology where none is right.
    pub unexplained_mean: MeanErrorModel,
}

/// The mean error of the nominal model, given how far the body moves in the root mean square of
/// all axes: its median is a share of that, and its logarithm spreads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MeanErrorModel {
    /// The median error as a share of the motion.
    pub motion_share: f64,
    /// Standard deviation of the error's logarithm.
    pub spread: f64,
}

/// Errors on roll, pitch and yaw, given how far the body moves on each axis.
///
/// The median error is √(n² + (k·m)²): noise of sensor and contacts, and a share of the
/// motion. ln e spreads about it by the noise's or the share's spread, whichever dominates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ErrorModel {
    /// n, the error in the limit of no motion.
    pub noise_deg: [f64; 3],
    /// k, the error in the limit of large motion, as a share of the motion.
    pub motion_share: [f64; 3],
    /// Standard deviation of ln e where noise dominates.
    pub noise_spread: [f64; 3],
    /// Standard deviation of ln e where motion dominates.
    pub motion_spread: [f64; 3],
    /// Correlation of ln e between any two axes.
    pub correlation: f64,
}

/// Degrees of freedom of the Student distribution: close to tipping, errors are larger than
/// a normal distribution has them.
const DEGREES_OF_FREEDOM: f64 = 6.0;

impl Default for ErrorModel {
    fn default() -> Self {
        Self {
            noise_deg: [0.031, 0.12, 0.031],
            motion_share: [0.06, 0.06, 0.17],
            noise_spread: [0.15, 0.4, 0.2],
            motion_spread: [0.58, 0.63, 0.76],
            correlation: 0.4,
        }
    }
}

impl Default for PlausibilitySettings {
    fn default() -> Self {
        let usual = ErrorModel::default();
        Self {
            something_else: 0.03,
            leg_damaged: 0.3,
            defective_sensor: 0.3,
            usual,
            unexplained: ErrorModel {
                motion_share: [0.85, 0.93, 0.97],
                noise_spread: [0.4, 0.3, 0.3],
                motion_spread: [0.4, 0.3, 0.3],
                correlation: 0.2,
                ..usual
            },
            usual_mean: MeanErrorModel::default(),
            unexplained_mean: MeanErrorModel {
                motion_share: 1.5,
                spread: 0.4,
            },
        }
    }
}

impl Default for MeanErrorModel {
    fn default() -> Self {
        Self {
            motion_share: 0.4,
            spread: 0.53,
        }
    }
}

impl PlausibilitySettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("something_else", self.something_else, 1e-9..=0.999, "")?;
        SettingError::check("leg_damaged", self.leg_damaged, 1e-9..=0.999, "")?;
        SettingError::check("defective_sensor", self.defective_sensor, 0.0..=0.999, "")?;
        let usual = self.usual.check();
        usual.map_err(|error| error.under("usual"))?;
        let unexplained = self.unexplained.check();
        unexplained.map_err(|error| error.under("unexplained"))?;
        let usual = self.usual_mean.check();
        usual.map_err(|error| error.under("usual_mean"))?;
        let unexplained = self.unexplained_mean.check();
        unexplained.map_err(|error| error.under("unexplained_mean"))
    }

    /// Probability that something else decides how the robot walks. `error_deg` and
    /// `motion_deg` are root mean squares of roll, pitch and yaw without mean and trend.
    ///
    /// `mean_error_deg` is that of the nominal model, per sample and axis.
    pub fn something_else(
        &self,
        error_deg: [f64; 3],
        motion_deg: [f64; 3],
        mean_error_deg: f64,
    ) -> f64 {
        let by_axis = self.ln_ratio_of_axes(error_deg, motion_deg);
        let by_mean = self.ln_ratio_of_mean(mean_error_deg, motion_deg);
        let odds = self.something_else / (1.0 - self.something_else) * by_axis.max(by_mean).exp();
        if odds.is_finite() {
            odds / (1.0 + odds)
        } else {
            1.0
        }
    }

    /// Logarithm of how much better the mean error is explained by something else.
    fn ln_ratio_of_mean(&self, mean_error_deg: f64, motion_deg: [f64; 3]) -> f64 {
        let squares: f64 = motion_deg.iter().map(|motion| motion * motion).sum();
        let motion_deg = (squares / 3.0).sqrt();
        if motion_deg < MeanErrorModel::LEAST_MOTION_DEG {
            return f64::NEG_INFINITY;
        }
        let error_deg = mean_error_deg.max(self.usual_mean.median_deg(motion_deg));
        self.unexplained_mean.ln_density(error_deg, motion_deg)
            - self.usual_mean.ln_density(error_deg, motion_deg)
    }

    /// Logarithm of how much better the errors of the axes are explained by something else.
    fn ln_ratio_of_axes(&self, error_deg: [f64; 3], motion_deg: [f64; 3]) -> f64 {
        // A walk that fits better than usual is no reason for doubt.
        let median_deg = self.usual.median_deg(motion_deg);
        let ln_error = std::array::from_fn(|axis| error_deg[axis].max(median_deg[axis]).ln());
        self.unexplained.ln_density(ln_error, motion_deg)
            - self.usual.ln_density(ln_error, motion_deg)
    }
}

impl MeanErrorModel {
    /// The mean error of a body that moves less says nothing: drift and noise of the sensor are
    /// as large (healthy robots move by 0.1°, damaged ones by 1° or more).
    const LEAST_MOTION_DEG: f64 = 0.5;

    fn check(&self) -> Result<(), SettingError> {
        SettingError::check("motion_share", self.motion_share, 1e-4..=100.0, "")?;
        SettingError::check("spread", self.spread, 0.01..=10.0, "")
    }

    fn median_deg(&self, motion_deg: f64) -> f64 {
        self.motion_share * motion_deg
    }

    /// Logarithm of the density of the error's logarithm, up to a constant.
    fn ln_density(&self, error_deg: f64, motion_deg: f64) -> f64 {
        let z = (error_deg / self.median_deg(motion_deg)).ln() / self.spread;
        -self.spread.ln() - 0.5 * (DEGREES_OF_FREEDOM + 1.0) * (z * z / DEGREES_OF_FREEDOM).ln_1p()
    }
}

impl ErrorModel {
    fn check(&self) -> Result<(), SettingError> {
        for (name, values, bounds, unit) in [
            ("noise_deg", &self.noise_deg, 1e-4..=45.0, "degrees"),
            ("motion_share", &self.motion_share, 1e-4..=10.0, ""),
            ("noise_spread", &self.noise_spread, 0.01..=10.0, ""),
            ("motion_spread", &self.motion_spread, 0.01..=10.0, ""),
        ] {
            SettingError::check_each(name, values, bounds, unit)?;
        }
        SettingError::check("correlation", self.correlation, 0.0..=0.95, "")
    }

    /// The median error of each axis.
    pub fn median_deg(&self, motion_deg: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            self.noise_deg[axis].hypot(self.motion_share[axis] * motion_deg[axis])
        })
    }

    /// Logarithm of the density of the errors' logarithms, up to a constant that is the same
    /// for every model.
    fn ln_density(&self, ln_error: [f64; 3], motion_deg: [f64; 3]) -> f64 {
        let median_deg = self.median_deg(motion_deg);
        let mut ln_spreads = 0.0;
        let standardised: [f64; 3] = std::array::from_fn(|axis| {
            let noise = self.noise_deg[axis].powi(2);
            let motion = (self.motion_share[axis] * motion_deg[axis]).powi(2);
            let variance = (self.noise_spread[axis].powi(2) * noise
                + self.motion_spread[axis].powi(2) * motion)
                / (noise + motion);
            ln_spreads += 0.5 * variance.ln();
            (ln_error[axis] - median_deg[axis].ln()) / variance.sqrt()
        });
        // The inverse of a matrix of ones and equal correlations r, and its determinant.
        let r = self.correlation;
        let sum: f64 = standardised.iter().sum();
        let squares: f64 = standardised.iter().map(|z| z * z).sum();
        let distance2 = (squares - r * sum * sum / (1.0 + 2.0 * r)) / (1.0 - r);
        let ln_determinant = 2.0 * (1.0 - r).ln() + (1.0 + 2.0 * r).ln();
        -0.5 * ln_determinant
            - ln_spreads
            - 0.5 * (DEGREES_OF_FREEDOM + 3.0) * (distance2 / DEGREES_OF_FREEDOM).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Of a walk whose mean error is usual.
    fn doubt(error_deg: [f64; 3], motion_deg: [f64; 3]) -> f64 {
        PlausibilitySettings::default().something_else(error_deg, motion_deg, 0.0)
    }

    #[test]
    fn a_mean_error_far_beyond_the_usual_is_doubted_whatever_a_variation_explains() {
        let motion_deg = [3.3, 6.7, 1.8];
        let usual = ErrorModel::default().median_deg(motion_deg);
        let doubt = |mean_error_deg| {
            PlausibilitySettings::default().something_else(usual, motion_deg, mean_error_deg)
        };
        assert!(doubt(2.0) < 0.02 && doubt(7.4) > 0.25, "{}", doubt(7.4));
    }

    #[test]
    fn a_walk_that_fits_as_usual_is_believed() {
        for motion_deg in [[0.1, 0.1, 0.05], [2.5, 3.0, 1.8], [5.0, 8.0, 4.0]] {
            let usual = ErrorModel::default().median_deg(motion_deg);
            assert!(doubt(usual, motion_deg) < 0.02, "{motion_deg:?}");
        }
    }

    #[test]
    fn a_walk_of_which_nothing_is_explained_is_not() {
        for motion_deg in [[0.8, 2.0, 0.3], [5.0, 8.0, 4.0]] {
            assert!(doubt(motion_deg, motion_deg) > 0.95, "{motion_deg:?}");
        }
        assert!(doubt([6.9; 3], [6.9; 3]) > 0.99, "6.9° of error");
    }

    #[test]
    fn a_robot_that_should_rock_and_does_not_is_doubted() {
        // A whole tripod rests on the belly; the healthy robot would rock by 0.1°.
        let on_its_belly = doubt([0.085, 0.17, 0.05], [0.035, 0.17, 0.05]);
        let healthy = doubt([0.035, 0.08, 0.035], [0.1, 0.11, 0.045]);
        assert!(
            on_its_belly > 0.2 && healthy < 0.02,
            "{on_its_belly} {healthy}"
        );
    }

    proptest! {
        #[test]
        fn more_error_is_never_less_doubt_up_to_the_whole_motion(
            motion_deg in prop::array::uniform3(0.5..10.0_f64),
            share in 0.1..0.8_f64,
        ) {
            let error = |share: f64| motion_deg.map(|motion| share * motion);
            let (less, more) = (doubt(error(share), motion_deg), doubt(error(1.2 * share), motion_deg));
            prop_assert!((0.0..=1.0).contains(&less) && less <= more + 1e-12);
        }

        #[test]
        fn better_than_usual_is_as_good_as_usual(
            motion_deg in prop::array::uniform3(0.0..10.0_f64),
            share in 0.0..1.0_f64,
        ) {
            let usual = ErrorModel::default().median_deg(motion_deg);
            let better = usual.map(|error| share * error);
            prop_assert_eq!(doubt(better, motion_deg), doubt(usual, motion_deg));
        }
    }
}
