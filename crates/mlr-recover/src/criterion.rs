//! What is asked of a gait.

use mlr_filter::DetectorSettings;

use crate::walking::Walking;

/// The speed that can be counted on:
///
/// `J = s(m) · mean over robots of  v · P(fluctuation < threshold) · P(drift < bound) · (1 − τ)`
///
/// with speed v and saturated share τ of the model's walk, and the share s of the static stability
/// margin m in what is enough. A real robot's fluctuation and drift are the
/// model's times a factor whose logarithm has a logistic distribution, so that
/// `P(x < bound) = 1 / (1 + (x/bound)^(1/scale))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Criterion {
    pub(crate) detector: DetectorSettings,
}

/// Margin that is enough: four standard deviations of the centre of mass of robots of one make.
const ENOUGH_M: f64 = 0.010;
/// What is left of the score where nothing is statically stable: a limp is still better or worse.
const LIMP: f64 = 0.05;
/// Scale of the logarithm of a real robot's fluctuation over its model's.
const FLUCTUATION_SCALE: f64 = 1.0 / 6.0;
/// The same of drifts, and the bound that they should keep.
const DRIFT_SCALE: f64 = 0.3;
const DRIFT_DEG_PER_M: f64 = 3.0;

impl Criterion {
    /// The probability that a robot stays below the threshold whose model walks like this.
    pub(crate) fn calm_probability(&self, walking: &Walking) -> f64 {
        let threshold_deg = self.detector.threshold_deg;
        below(walking.fluctuation_deg, threshold_deg, FLUCTUATION_SCALE)
    }

    /// J; `None` of a robot stands for a walk that diverges.
    pub(crate) fn score(&self, margin_m: f64, walks: &[Option<Walking>]) -> f64 {
        let stable = (margin_m / ENOUGH_M).clamp(LIMP, 1.0);
        let each = walks.iter().flatten().map(|walking| {
            let straight = below(walking.drift_deg_per_m.abs(), DRIFT_DEG_PER_M, DRIFT_SCALE);
            let unsaturated = 1.0 - walking.saturated;
            walking.speed_m_per_s * self.calm_probability(walking) * straight * unsaturated
        });
        stable * each.sum::<f64>() / walks.len().max(1) as f64
    }
}

fn below(value: f64, bound: f64, scale: f64) -> f64 {
    1.0 / (1.0 + libm::pow(value / bound, 1.0 / scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walking(fluctuation_deg: f64) -> Walking {
        Walking {
            speed_m_per_s: 0.1,
            fluctuation_deg,
            drift_deg_per_m: 0.0,
            tilt_deg: 0.0,
            saturated: 0.0,
            torque_share: 0.0,
            turn_rad_per_cycle: 0.0,
        }
    }

    #[test]
    fn the_score_is_speed_that_falls_with_what_is_wrong() {
        let criterion = Criterion {
            detector: DetectorSettings::default(),
        };
        let score = |one: Walking| criterion.score(0.02, &[Some(one)]);
        assert!((score(walking(0.0)) - 0.1).abs() < 1e-12);
        // At the threshold it is as likely below as above.
        assert!((score(walking(5.0)) - 0.05).abs() < 1e-12);
        assert!(score(walking(3.0)) > score(walking(4.0)));
        let turning = Walking {
            drift_deg_per_m: -3.0,
            ..walking(0.0)
        };
        assert!((score(turning) - 0.05).abs() < 1e-12);
        // One robot of two that diverges halves it.
        let half = criterion.score(0.02, &[Some(walking(0.0)), None]);
        assert!((half - 0.05).abs() < 1e-12);
        // Less margin than is enough counts in proportion, and a limp for something.
        let with_margin = |margin_m| criterion.score(margin_m, &[Some(walking(0.0))]);
        assert!((with_margin(0.005) - 0.05).abs() < 1e-12);
        assert!((with_margin(-0.02) - 0.005).abs() < 1e-12);
    }
}
