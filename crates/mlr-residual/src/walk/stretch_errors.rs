//! How wrong a walk is, on the stretch that decides and on the one that nothing has seen.

use mlr_filter::{Axes, Axis};

use super::{StretchErrors, WalkRecord};

/// What of a residual is no error of the robot.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Corrected {
    /// Where yaw has its zero.
    Heading,
    /// The zero of yaw, the rate of turning and the lean of the walking body, which no contact model
    /// gets right: as found on the stretch that decides.
    Drift,
}

/// Errors of a walk on the stretch that decided, and on the one that nothing has seen, with the
/// residual that they are of.
pub(super) fn stretch_errors(
    record: &WalkRecord,
    residual_deg: &Axes<Vec<f64>>,
    corrected: Corrected,
) -> (StretchErrors, Axes<Vec<f64>>) {
    let residual_deg = residual_deg
        .as_ref()
        .map(|axis, residual| without_zeros(record, residual, corrected, axis == Axis::Yaw));
    let square = |range: std::ops::Range<usize>| {
        let axes = residual_deg.as_ref().into_array();
        axes.map(|axis| {
            let axis = &axis[range.clone()];
            axis.iter().map(|x| x * x).sum::<f64>() / axis.len().max(1) as f64
        })
    };
    let errors = StretchErrors::new(square(record.fit()), square(record.unseen()));
    (errors, residual_deg)
}

/// Measured less predicted, degrees, over the whole record.
pub(super) fn residual_deg(record: &WalkRecord, predicted: &Axes<Vec<f64>>) -> Axes<Vec<f64>> {
    let measured = record.measured_deg();
    let of = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    Axes {
        roll: of(&measured.roll, &predicted.roll),
        pitch: of(&measured.pitch, &predicted.pitch),
        yaw: of(&measured.yaw, &predicted.yaw),
    }
}

fn without_zeros(
    record: &WalkRecord,
    residual: &[f64],
    corrected: Corrected,
    is_yaw: bool,
) -> Vec<f64> {
    let fit = record.fit();
    let of_fit = &residual[fit.clone()];
    let n = of_fit.len() as f64;
    let mean = of_fit.iter().sum::<f64>() / n.max(1.0);
    if !is_yaw && corrected == Corrected::Heading {
        return residual.to_vec();
    }
    let walks = |index: usize| record.times_s()[index] > record.start_s();
    if !is_yaw {
        let lean = |(k, x): (usize, &f64)| if walks(k) { x - mean } else { *x };
        return residual.iter().enumerate().map(lean).collect();
    }
    let times_s = record.times_s();
    let middle_s = of_fit.len() as f64 / 2.0 * WalkRecord::PERIOD_S + times_s[fit.start];
    let lever: f64 = fit.clone().map(|k| (times_s[k] - middle_s).powi(2)).sum();
    let along: f64 = fit
        .clone()
        .map(|k| (times_s[k] - middle_s) * residual[k])
        .sum();
    let slope_dps = match corrected {
        Corrected::Heading => 0.0,
        Corrected::Drift => along / lever.max(1e-9),
    };
    residual
        .iter()
        .enumerate()
        .map(|(k, x)| x - mean - slope_dps * (times_s[k] - middle_s))
        .collect()
}
