use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use super::{Alignment, ComparableWalk};

/// What is left between measured and simulated walk, roll, pitch, yaw.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Mean square of each axis; frequencies between the harmonics of the gait have a lower weight.
    pub mean_square_deg2: [f64; 3],
    /// Under this alignment.
    pub alignment: Alignment,
}

/// How likely a misfit is.
///
/// The errors of a simulated walk are not noise: they come from what the model
/// lacks, and their size is not known beforehand. With that size unknown, the
/// likelihood of n independent errors whose mean square is S is proportional to
/// S^(-n/2). The numbers n were fitted to logs of an independent plant
/// (`docs/decision.md`): few, because errors repeat with the gait, and fewer for
/// yaw, which depends on friction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LikelihoodSettings {
    /// Independent errors of roll, pitch and yaw in five seconds of walking.
    pub independent_errors: [f64; 3],
    /// Errors below this size, such as those of sensor noise, do not change the likelihood.
    pub floor_deg: f64,
    /// Weight of the square of an error at a frequency between two harmonics of the gait,
    /// against 1 at a harmonic. Damage changes what repeats with the gait; rubble, noise and
    /// slip change everything.
    pub between_harmonics: f64,
    /// Prior standard deviation of the relative error of the gait clock.
    pub clock_deviation: f64,
}

/// Samples of the paper's window, for which the numbers of independent errors are
/// stated.
const FIVE_SECONDS: f64 = 5.0 * ComparableWalk::RATE_HZ;

impl Default for LikelihoodSettings {
    fn default() -> Self {
        Self {
            independent_errors: [5.0, 5.0, 3.0],
            floor_deg: 0.15,
            between_harmonics: 0.36,
            clock_deviation: 0.035,
        }
    }
}

impl LikelihoodSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let errors = &self.independent_errors;
        SettingError::check_each("independent_errors", errors, 0.01..=1000.0, "")?;
        SettingError::check("floor_deg", self.floor_deg, 1e-6..=45.0, "degrees")?;
        let between = self.between_harmonics;
        SettingError::check("between_harmonics", between, 0.001..=1.0, "")?;
        SettingError::check("clock_deviation", self.clock_deviation, 1e-6..=1.0, "")
    }

    /// The same for a comparison of so many samples of each axis: independent errors in proportion.
    #[must_use]
    pub fn of_samples(&self, samples: usize) -> Self {
        let errors = self.independent_errors;
        Self {
            independent_errors: errors.map(|n| n * samples as f64 / FIVE_SECONDS),
            ..*self
        }
    }

    /// Logarithm of the likelihood, up to a constant.
    pub fn ln_likelihood(&self, misfit: &Misfit) -> f64 {
        self.ln_of_errors(misfit.mean_square_deg2) - self.clock_penalty(misfit.alignment)
    }

    /// An upper bound of the likelihood of a walk from the misfit of its first part, `share` of
    /// the whole. It fails only for an error that changes its sign later.
    pub fn ln_bound(&self, misfit: &Misfit, share: f64) -> f64 {
        // A harmonic that is wrong in the part and right later has this share of its amplitude
        // in the whole.
        let whole = misfit.mean_square_deg2.map(|s| s * share * share);
        self.ln_of_errors(whole)
    }

    /// Independent errors over all axes: how fast the likelihood falls with their mean square.
    pub fn errors(&self) -> f64 {
        self.independent_errors.iter().sum()
    }

    fn ln_of_errors(&self, mean_square_deg2: [f64; 3]) -> f64 {
        let floor = self.floor_deg * self.floor_deg;
        -0.5 * self
            .independent_errors
            .iter()
            .zip(mean_square_deg2)
            .map(|(n, s)| n * (s + floor).ln())
            .sum::<f64>()
    }

    /// Negative logarithm of the prior of an alignment, up to a constant.
    fn clock_penalty(&self, alignment: Alignment) -> f64 {
        0.5 * (alignment.clock / self.clock_deviation).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn misfit(mean_square_deg2: [f64; 3], clock: f64) -> Misfit {
        Misfit {
            mean_square_deg2,
            alignment: Alignment {
                clock,
                delay_s: 0.0,
            },
        }
    }

    #[test]
    fn an_error_of_yaw_counts_less() {
        let settings = LikelihoodSettings::default();
        let ln = |s| settings.ln_likelihood(&misfit(s, 0.0));
        let none = ln([0.1, 0.1, 0.1]);
        assert!(ln([0.2, 0.1, 0.1]) < none);
        assert_eq!(ln([0.2, 0.1, 0.1]), ln([0.1, 0.2, 0.1]));
        assert!(ln([0.2, 0.1, 0.1]) < ln([0.1, 0.1, 0.2]));
    }

    #[test]
    fn errors_far_below_the_floor_do_not_count() {
        let settings = LikelihoodSettings::default();
        let ln = |error_deg: f64| settings.ln_likelihood(&misfit([error_deg.powi(2); 3], 0.0));
        let floor_deg = settings.floor_deg;
        assert!(ln(0.0) - ln(0.2 * floor_deg) < 0.5);
        assert!(ln(2.0 * floor_deg) - ln(4.0 * floor_deg) > 5.0);
    }

    #[test]
    fn a_clock_far_off_is_penalised() {
        let settings = LikelihoodSettings::default();
        let ln = |clock| settings.ln_likelihood(&misfit([0.1; 3], clock));
        assert!((ln(0.0) - ln(0.07) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn the_bound_of_a_part_is_not_below_the_likelihood_of_the_whole() {
        let settings = LikelihoodSettings::default();
        let part = misfit([0.4, 0.3, 0.2], 0.02);
        let whole = misfit([0.2, 0.15, 0.1], 0.02);
        assert!(settings.ln_bound(&part, 0.5) >= settings.ln_likelihood(&whole));
    }
}
