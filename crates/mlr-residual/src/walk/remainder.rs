//! Whether what remains is more than a model usually leaves, and what it looks like.

use mlr_filter::Axis;
use serde::{Deserialize, Serialize};

use super::{ByAxis, RemainingResidual, WalkModel, WalkRecord, record::deviation_from_trend};

/// What the model of a walk leaves of robots that lack nothing: measured on logs of
/// undisturbed robots of an independent plant (`docs/explain.md`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UsualRemainder {
    /// Root mean square of roll, pitch and yaw, without offset and trend.
    pub remaining_deg: [f64; 3],
    /// The same as a share of the measured swing of that axis, added to it.
    pub share_of_swing: f64,
    /// Part of it that does not repeat with the gait.
    pub irregular_deg: [f64; 3],
    /// The same as a share of the measured swing.
    pub irregular_share: f64,
    /// Part of the irregular that is faster than about three hertz.
    pub fast_deg: [f64; 3],
    /// The same as a share of the measured swing.
    pub fast_share: f64,
}

impl Default for UsualRemainder {
    fn default() -> Self {
        Self {
            remaining_deg: [0.3, 0.3, 1.2],
            share_of_swing: 0.15,
            irregular_deg: [0.2, 0.2, 0.8],
            irregular_share: 0.1,
            fast_deg: [0.06, 0.06, 0.15],
            fast_share: 0.03,
        }
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
    let noise = record.noise_deg().into_array();
    let mut worst: Option<(f64, RemainingResidual)> = None;
    let mut floor2 = 0.0;
    for (index, (axis, left)) in left.each().into_iter().enumerate() {
        let remaining_deg = left.locked_to_gait_deg().hypot(left.irregular_deg);
        let usual_deg = (usual.remaining_deg[index] + usual.share_of_swing * swing_deg[index])
            .hypot(noise[index]);
        let irregular_usual_deg = (usual.irregular_deg[index]
            + usual.irregular_share * swing_deg[index])
            .hypot(noise[index]);
        floor2 += usual_deg * usual_deg / 3.0;
        let excess = remaining_deg / usual_deg;
        let irregular_excess = left.irregular_deg / irregular_usual_deg;
        let fast_usual_deg =
            (usual.fast_deg[index] + usual.fast_share * swing_deg[index]).hypot(noise[index]);
        let irregular_excess = irregular_excess.max(left.fast_deg / fast_usual_deg);
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
