//! Whether an effect changes the walk by more than what is usual.

use serde::{Deserialize, Serialize};

/// What the effects of a log change of roll, pitch and yaw while the robot walks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrueTrace {
    /// Mean of the change.
    pub mean_deg: [f64; 3],
    /// Root mean square of the change without mean and trend.
    pub swing_deg: [f64; 3],
    /// What another body of the same make changes; zero where that was not recorded.
    #[serde(default)]
    pub spread: Spread,
}

/// By how much the walks of robots of one make differ, in the root mean square.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spread {
    /// Of the mean of the change.
    pub mean_deg: [f64; 3],
    /// Of the change without mean and trend.
    pub swing_deg: [f64; 3],
}

/// Whether an effect is large enough to be detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Visibility {
    /// Its change of the walk was not recorded.
    Unknown,
    /// It changes less than the limits of [`TrueTrace::visibility`].
    Hidden,
    /// It changes more than the limits, but no more than the spread between robots of the same
    /// make. Close to tipping, that spread is large.
    WithinSpread,
    /// It changes more than both.
    StandsOut,
}

impl TrueTrace {
    /// Visible is what makes roll or pitch swing by 0.3° more or less, or lean by two
    /// standard deviations of a usual mounting (1°), or bends yaw by 1°. A constant rate of
    /// turning does not count: it cannot be told from gyroscope bias and friction.
    pub fn visibility(&self) -> Visibility {
        let of = |values_deg: [f64; 3], spread_deg: [f64; 3], limits_deg: [f64; 3]| {
            [0, 1, 2].map(|axis| (values_deg[axis].abs(), spread_deg[axis], limits_deg[axis]))
        };
        let swings = of(self.swing_deg, self.spread.swing_deg, [0.3, 0.3, 1.0]);
        let means = of(
            self.mean_deg,
            self.spread.mean_deg,
            [1.0, 1.0, f64::INFINITY],
        );
        let mut visible = swings
            .into_iter()
            .chain(means)
            .filter(|(v, _, limit)| v >= limit);
        match visible.clone().next() {
            None => Visibility::Hidden,
            Some(_) if visible.any(|(value, spread, _)| value > spread) => Visibility::StandsOut,
            Some(_) => Visibility::WithinSpread,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(swing_deg: [f64; 3], mean_deg: [f64; 3], spread_deg: f64) -> TrueTrace {
        TrueTrace {
            mean_deg,
            swing_deg,
            spread: Spread {
                mean_deg: [spread_deg; 3],
                swing_deg: [spread_deg; 3],
            },
        }
    }

    #[test]
    fn what_swings_leans_or_bends_is_visible() {
        let none = [0.0; 3];
        for (swing_deg, mean_deg) in [
            ([0.4, 0.0, 0.0], none),
            ([0.0, 0.0, 1.5], none),
            (none, [0.0, -1.2, 0.0]),
        ] {
            let visibility = trace(swing_deg, mean_deg, 0.0).visibility();
            assert_eq!(visibility, Visibility::StandsOut);
        }
        let turning = trace([0.2, 0.2, 0.9], [0.5, 0.0, 30.0], 0.0);
        assert_eq!(turning.visibility(), Visibility::Hidden);
    }

    #[test]
    fn what_any_other_robot_changes_as_much_does_not_stand_out() {
        let swing_deg = [2.0, 0.1, 0.0];
        let steady = trace(swing_deg, [0.0; 3], 1.0);
        assert_eq!(steady.visibility(), Visibility::StandsOut);
        let nearly_tipping = trace(swing_deg, [0.0; 3], 3.0);
        assert_eq!(nearly_tipping.visibility(), Visibility::WithinSpread);
    }
}
