//! Whether what remains is more than a model usually leaves, and what it looks like.

use mlr_filter::{Axis, SettingError};
use serde::{Deserialize, Serialize};

use super::{ByAxis, RemainingResidual, WalkModel, WalkRecord, record::deviation_from_trend};

/// What the model of a walk leaves of robots that lack nothing: measured on logs of
/// undisturbed robots of an independent plant (`docs/explain.md`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UsualRemainder {
    /// Where angles are integrated from the rates of the walk alone.
    pub dead_reckoned: Leavings,
    /// Where a sensor's own filter made the angles, which wander more than the model errs.
    pub filtered: Leavings,
}

/// What is left of a walk, without offset and trend, as root mean squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leavings {
    /// All of it.
    pub remaining: Allowance,
    /// What does not repeat with the gait.
    pub irregular: Allowance,
    /// What of this is faster than about three hertz.
    pub fast: Allowance,
}

/// What may be left of each axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Allowance {
    /// Of roll, pitch and yaw.
    pub deg: [f64; 3],
    /// The same as a share of the measured swing of the axis, added to it.
    pub share_of_swing: f64,
}

impl Default for UsualRemainder {
    fn default() -> Self {
        let allowance = |deg, share_of_swing| Allowance {
            deg,
            share_of_swing,
        };
        Self {
            dead_reckoned: Leavings {
                remaining: allowance([0.15, 0.15, 0.35], 0.04),
                irregular: allowance([0.1, 0.1, 0.25], 0.03),
                fast: allowance([0.05, 0.05, 0.08], 0.015),
            },
            filtered: Leavings {
                remaining: allowance([0.3, 0.3, 1.2], 0.15),
                irregular: allowance([0.2, 0.2, 0.8], 0.1),
                fast: allowance([0.06, 0.06, 0.15], 0.03),
            },
        }
    }
}

impl UsualRemainder {
    /// Checks every number. Nothing may be left where an allowance is zero.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, leavings) in [
            ("dead_reckoned", &self.dead_reckoned),
            ("filtered", &self.filtered),
        ] {
            leavings.check().map_err(|error| error.under(name))?;
        }
        Ok(())
    }
}

impl Leavings {
    fn check(&self) -> Result<(), SettingError> {
        for (name, allowance) in [
            ("remaining", &self.remaining),
            ("irregular", &self.irregular),
            ("fast", &self.fast),
        ] {
            allowance.check().map_err(|error| error.under(name))?;
        }
        Ok(())
    }
}

impl Allowance {
    fn check(&self) -> Result<(), SettingError> {
        SettingError::check_each("deg", &self.deg, 0.0..=360.0, "degrees")?;
        SettingError::check("share_of_swing", self.share_of_swing, 0.0..=100.0, "")
    }

    /// With noise and swing of that axis.
    fn usual_deg(&self, axis: usize, swing_deg: f64, noise_deg: f64) -> f64 {
        (self.deg[axis] + self.share_of_swing * swing_deg).hypot(noise_deg)
    }
}

/// What remains, and whether it is more than usual.
pub(crate) struct Remainder {
    pub(crate) unexplained: bool,
    pub(crate) floor_deg: f64,
    pub(crate) residual: RemainingResidual,
}

/// Looks at what is left on each axis of the walk.
pub(crate) fn remainder(
    record: &WalkRecord,
    model: &WalkModel,
    left: &ByAxis,
    usual: &UsualRemainder,
) -> Remainder {
    let swing_deg = swings_deg(record);
    let noise_deg = record.noise_deg().into_array();
    let usual = match record.is_dead_reckoned() {
        true => usual.dead_reckoned,
        false => usual.filtered,
    };
    let mut worst: Option<(f64, RemainingResidual)> = None;
    let mut floor2 = 0.0;
    for (index, (axis, left)) in left.each().into_iter().enumerate() {
        let allowed =
            |allowance: Allowance| allowance.usual_deg(index, swing_deg[index], noise_deg[index]);
        let remaining_deg = left.locked_to_gait_deg().hypot(left.irregular_deg);
        let usual_deg = allowed(usual.remaining);
        floor2 += usual_deg * usual_deg / 3.0;
        let excess = remaining_deg / usual_deg;
        let irregular_excess = left.irregular_deg / allowed(usual.irregular);
        let irregular_excess = irregular_excess.max(left.fast_deg / allowed(usual.fast));
        let worse = excess.max(irregular_excess);
        if worst.as_ref().is_none_or(|(most, _)| worse > *most) {
            let harmonic = left.strongest_harmonic();
            let locked = irregular_excess < excess
                && harmonic.is_some_and(|h| {
                    h.amplitude_deg >= left.irregular_amplitude_deg.unwrap_or(0.0)
                });
            let (frequency_hz, amplitude_deg) = if locked {
                harmonic.map(|h| (h.frequency_hz, h.amplitude_deg)).unzip()
            } else {
                (left.irregular_hz, left.irregular_amplitude_deg)
            };
            let residual = RemainingResidual {
                axis: axis.name(),
                frequency_hz,
                amplitude_deg,
                locked_to_gait: locked,
                body_torque_nm: frequency_hz
                    .zip(amplitude_deg)
                    .map(|(f, a)| body_torque_nm(model, axis, f, a)),
                remaining_deg,
                usual_deg,
                explains: String::new(),
            };
            worst = Some((worse, residual));
        }
    }
    let (excess, mut residual) = worst.expect("there are three axes");
    let unexplained = excess > 1.0;
    residual.explains = explains(&residual, unexplained);
    Remainder {
        unexplained,
        floor_deg: floor2.sqrt(),
        residual,
    }
}

/// Root mean square of each measured angle over the walk, without mean and trend.
fn swings_deg(record: &WalkRecord) -> [f64; 3] {
    let walking = record.fit().start..record.unseen().end;
    let axes = record.measured_deg().as_ref().into_array();
    axes.map(|angles_deg| deviation_from_trend(&angles_deg[walking.clone()]))
}

/// The torque that swings the body alone at this frequency and amplitude: an upper limit
/// of what the legs let through.
fn body_torque_nm(model: &WalkModel, axis: Axis, frequency_hz: f64, amplitude_deg: f64) -> f64 {
    let inertia = model.robot.body().inertia_kg_m2;
    let inertia_kg_m2 = match axis {
        Axis::Roll => inertia.x,
        Axis::Pitch => inertia.y,
        Axis::Yaw => inertia.z,
    };
    let rate = std::f64::consts::TAU * frequency_hz;
    inertia_kg_m2 * rate * rate * amplitude_deg.to_radians()
}

fn explains(residual: &RemainingResidual, unexplained: bool) -> String {
    if !unexplained {
        return "no more than the model usually leaves".into();
    }
    let what = match (residual.locked_to_gait, residual.frequency_hz) {
        (true, _) => "periodic torque in step with the gait, of unknown origin",
        (false, Some(f)) if f > 0.5 => "oscillation out of step with the gait, of unknown origin",
        _ => "slow wander of unknown origin",
    };
    what.into()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use mlr_filter::{Axes, OrientationSeries};
    use mlr_model::{Gait, Robot, SimulationSettings};

    use super::*;
    use crate::walk::decomposition::decompose;

    const GAIT_HZ: f64 = 1.0;

    /// A robot that stands for 2 s, then rolls by this amplitude at this frequency.
    fn rolling(amplitude_deg: f64, frequency_hz: f64) -> WalkRecord {
        let times_s: Vec<f64> = (0..1400).map(|i| f64::from(i) * 0.01).collect();
        let walked = times_s.iter().map(|t| (t - 2.0).max(0.0));
        let roll = walked.map(|t| amplitude_deg.to_radians() * (TAU * frequency_hz * t).sin());
        let angles_rad = Axes {
            roll: roll.collect(),
            ..Axes::from_fn(|_| vec![0.0; 1400])
        };
        let recording = OrientationSeries::new(times_s, angles_rad).unwrap();
        WalkRecord::new(&recording, 2.0, true, 2.0, None).unwrap()
    }

    /// What is said of a robot that rolls by `swing_deg` with the gait where the model leaves a
    /// rolling of this amplitude and frequency.
    fn left(swing_deg: f64, left_deg: f64, frequency_hz: f64, reckoned: bool) -> Remainder {
        let record = rolling(swing_deg, GAIT_HZ);
        let record = match reckoned {
            true => record.dead_reckoned(),
            false => record,
        };
        let residual_deg = rolling(left_deg, frequency_hz).measured_deg().clone();
        let left = decompose(&record, &residual_deg, 1.0 / GAIT_HZ).into();
        let model = WalkModel::nominal(
            Robot::jethexa(),
            Gait::tripod(),
            SimulationSettings::default(),
        );
        remainder(&record, &model, &left, &UsualRemainder::default())
    }

    #[test]
    fn what_is_more_than_usual_is_unexplained_and_described() {
        let much = left(1.0, 0.4, GAIT_HZ, true);
        assert!(much.unexplained);
        let Remainder { residual, .. } = much;
        assert!(residual.locked_to_gait && residual.axis == "roll");
        assert_eq!(residual.frequency_hz, Some(GAIT_HZ));
        assert!((residual.amplitude_deg.unwrap() - 0.4).abs() < 0.03);
        assert!(residual.explains.contains("in step"), "{residual:?}");
        assert!(!left(1.0, 0.1, GAIT_HZ, true).unexplained);
    }

    #[test]
    fn a_sensors_own_filter_and_a_larger_swing_leave_more() {
        assert!(!left(1.0, 0.4, GAIT_HZ, false).unexplained);
        assert!(!left(8.0, 0.4, GAIT_HZ, true).unexplained);
    }

    #[test]
    fn less_of_what_is_out_of_step_with_the_gait_is_usual() {
        let out_of_step = left(1.0, 0.22, 1.37, true);
        assert!(out_of_step.unexplained && !out_of_step.residual.locked_to_gait);
        assert!(!left(1.0, 0.22, GAIT_HZ, true).unexplained);
    }
}
