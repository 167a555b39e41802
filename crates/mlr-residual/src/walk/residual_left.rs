//! What remains of a residual, and what it looks like.

use mlr_filter::Axis;

use super::{ByAxis, Discrepancy, RemainingResidual, WalkModel, WalkRecord};

/// What remains.
pub(crate) struct ResidualLeft {
    /// What the model usually leaves, over all axes.
    pub(crate) floor_deg: f64,
    pub(crate) residual: RemainingResidual,
}

/// Describes what is left on the axis on which most is left, compared with what usually is.
pub(crate) fn residual_left(
    record: &WalkRecord,
    model: &WalkModel,
    left: &ByAxis,
    discrepancy: &Discrepancy,
    is_unexplained: bool,
) -> ResidualLeft {
    let swing_deg = [
        record.swing_deg(),
        record.swing_deg(),
        record.yaw_swing_deg(),
    ];
    let noise_deg = record.noise_deg().into_array();
    let mut worst: Option<(f64, RemainingResidual)> = None;
    let mut floor2 = 0.0;
    for (index, (axis, left)) in left.each().into_iter().enumerate() {
        let of_axis = if index == 2 {
            &discrepancy.yaw
        } else {
            &discrepancy.tilt
        };
        let [periodic_deg, irregular_deg] = of_axis.usual_deg(swing_deg[index]);
        let irregular_deg = irregular_deg.hypot(noise_deg[index]);
        let remaining_deg = left.locked_to_gait_deg().hypot(left.irregular_deg);
        let usual_deg = periodic_deg.hypot(irregular_deg);
        floor2 += usual_deg * usual_deg / 3.0;
        let excess = remaining_deg / usual_deg;
        let irregular_excess = left.irregular_deg / irregular_deg;
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
    let (_, mut residual) = worst.expect("there are three axes");
    residual.explains = explains(&residual, is_unexplained);
    ResidualLeft {
        floor_deg: floor2.sqrt(),
        residual,
    }
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
