//! Simpler corrections that an explanation must be compared with: what is done about a gyroscope
//! without looking for effects.

use mlr_imu::{RawSeries, STANDARD_GRAVITY_MPS2};
use nalgebra::{Rotation3, Vector3};

use crate::{
    AxisName, Baseline, ErrorDeg, SensorRecord, SensorSignals,
    fitted_model::{ChosenEffect, FittedModel},
    sensor_effects::{find, rest_bias_dps},
};

/// An axis is level when the direction up has no more of it than this: 17°.
const MAX_LEVEL: f64 = 0.3;
/// An axis is upright when the direction up has at least so much of it: 18°.
const MIN_UPRIGHT: f64 = 0.95;

/// The error of each baseline that the record allows, the data sheet first.
///
/// * `data_sheet`: the integral of the rate.
/// * `constant_bias_fit`, `constant_bias`: less one bias, fitted on the fit stretch alone, and on
///   fit and selection as the explanation's final parameters are.
/// * `bias_and_scale`: a linear calibration, fitted on fit and selection.
/// * `rest_bias`: less the mean rate at rest on fit and selection, where the log shows any.
/// * `vqf`: the orientation filter VQF, which estimates the bias itself, where the log has all
///   rates and accelerations: the tilt about a level axis, the heading about an upright one. Its
///   zero is where it differs least from the reference on fit and selection.
pub(crate) fn baselines(record: &SensorRecord) -> Vec<Baseline> {
    let (fit, seen) = (record.fit_stretch(), record.before_test());
    let fitted = |on: &SensorRecord, kinds: &[&str]| {
        FittedModel::new(on, effects(on, kinds)).residual_deg(record)
    };
    let named = |name: &'static str, residual_deg: &[f64]| Baseline {
        name,
        error_deg: ErrorDeg::new(record, residual_deg),
    };
    let mut found = vec![
        named("data_sheet", &fitted(&fit, &[])),
        named("constant_bias_fit", &fitted(&fit, &["gyro_bias"])),
        named("constant_bias", &fitted(&seen, &["gyro_bias"])),
        named(
            "bias_and_scale",
            &fitted(&seen, &["gyro_bias", "gyro_scale"]),
        ),
    ];
    if let Some(bias_dps) = rest_bias_dps(seen.signals()) {
        let mut effects = effects(&seen, &["gyro_bias"]);
        for parameter in effects.iter_mut().flat_map(|(_, parameters)| parameters) {
            parameter.start = bias_dps * record.signals().sign;
            *parameter = parameter.clone().fixed();
        }
        let model = FittedModel::new(&seen, effects);
        found.push(named("rest_bias", &model.residual_deg(record)));
    }
    if let Some(angle_deg) = vqf_angle_deg(record.signals()) {
        found.push(named("vqf", &less_offset(record, &angle_deg)));
    }
    found
}

fn effects(record: &SensorRecord, kinds: &[&str]) -> Vec<ChosenEffect> {
    let effects = kinds.iter().filter_map(|kind| find(kind));
    effects
        .filter_map(|effect| Some((effect, effect.parameters(record).ok()?)))
        .collect()
}

/// Reference less angle, less the mean of that before the test stretch.
fn less_offset(record: &SensorRecord, angle_deg: &[f64]) -> Vec<f64> {
    let difference_deg = record.error_deg(angle_deg);
    let [fit, selection, _] = record.stretches().divide(record, &difference_deg);
    let (sum, count) = (
        fit.iter().chain(selection).sum::<f64>(),
        fit.len() + selection.len(),
    );
    let offset_deg = sum / count.max(1) as f64;
    difference_deg.iter().map(|d| d - offset_deg).collect()
}

/// The unwrapped angle about the rate's axis by VQF, up to a constant, degrees.
fn vqf_angle_deg(signals: &SensorSignals) -> Option<Vec<f64>> {
    let axis = signals.axis?;
    let rate_dps = |wanted: AxisName| -> Option<Vec<f64>> {
        if wanted == axis {
            return Some(signals.rate_dps.iter().map(|r| r * signals.sign).collect());
        }
        let mut cross = signals.cross_rates_dps.iter();
        let (_, rate_dps) = cross.find(|(other, _)| *other == wanted)?;
        Some(rate_dps.clone())
    };
    let [x_dps, y_dps, z_dps] = AxisName::ALL.map(rate_dps);
    let rates_dps = [x_dps?, y_dps?, z_dps?];
    let raw = RawSeries {
        times_s: signals.times_s.clone(),
        accelerations_mps2: vectors(signals.accelerations_g.as_ref()?, STANDARD_GRAVITY_MPS2),
        angular_rates_radps: vectors(&rates_dps, 1_f64.to_radians()),
    };
    let orientation = raw.fuse().ok()?;
    let angles_rad = orientation.angles_rad();
    let tilts_rad = angles_rad.roll.iter().zip(&angles_rad.pitch);
    let ups: Vec<Vector3<f64>> = tilts_rad
        .map(|(roll, pitch)| {
            Rotation3::from_euler_angles(*roll, *pitch, 0.0).inverse() * Vector3::z()
        })
        .collect();
    let along = |wanted: AxisName| ups.iter().map(move |up| up[wanted as usize]);
    let upright = along(axis).sum::<f64>() / ups.len().max(1) as f64;
    let angles_rad: Vec<f64> = if upright.abs() < MAX_LEVEL {
        // A turn about x moves the direction up from z towards y in the body frame.
        let (towards, from) = (axis.next(), axis.next().next());
        let pairs = along(towards).zip(along(from));
        pairs.map(|(towards, from)| towards.atan2(from)).collect()
    } else if upright.abs() > MIN_UPRIGHT {
        angles_rad
            .yaw
            .iter()
            .map(|yaw| upright.signum() * yaw)
            .collect()
    } else {
        return None;
    };
    let mut unwrapped_rad = 0.0;
    let angles_deg = angles_rad.into_iter().map(|angle_rad| {
        unwrapped_rad = mlr_filter::unwrapped_rad(unwrapped_rad, angle_rad);
        signals.sign * unwrapped_rad.to_degrees()
    });
    Some(angles_deg.collect())
}

fn vectors([x, y, z]: &[Vec<f64>; 3], scale: f64) -> Vec<Vector3<f64>> {
    let rows = x.iter().zip(y).zip(z);
    rows.map(|((x, y), z)| scale * Vector3::new(*x, *y, *z))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A level shaft along y that swings by 60°, with a gyroscope whose rates are all off by
    /// 0.4 °/s, and mounted the other way around.
    fn record(rests: bool) -> SensorRecord {
        let times_s: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 0.01).collect();
        let moved_s = |t: f64| if rests { (t - 10.0).max(0.0) } else { t };
        let angle_deg = |t: f64| 60.0 * (TAU * moved_s(t) / 6.3).sin();
        let rate_dps = |t: f64| (angle_deg(t + 1e-4) - angle_deg(t - 1e-4)) / 2e-4;
        let of_times = |f: &dyn Fn(f64) -> f64| times_s.iter().map(|t| f(*t)).collect();
        let signals = SensorSignals {
            sign: -1.0,
            axis: Some(AxisName::Y),
            cross_rates_dps: vec![
                (AxisName::Z, vec![0.4; times_s.len()]),
                (AxisName::X, vec![0.4; times_s.len()]),
            ],
            accelerations_g: Some([
                of_times(&|t| angle_deg(t).to_radians().sin()),
                vec![0.0; times_s.len()],
                of_times(&|t| angle_deg(t).to_radians().cos()),
            ]),
            ..SensorSignals::new(times_s.clone(), of_times(&|t| rate_dps(t) - 0.4))
        };
        let angles_deg = of_times(&angle_deg);
        SensorRecord::new(signals, angles_deg).unwrap()
    }

    fn error_deg(found: &[Baseline], name: &str) -> Option<f64> {
        let baseline = found.iter().find(|baseline| baseline.name == name);
        Some(baseline?.error_deg.validation_deg)
    }

    #[test]
    fn a_bias_is_removed_by_every_baseline_but_the_data_sheet() {
        let found = baselines(&record(true));
        assert!(error_deg(&found, "data_sheet").unwrap() > 30.0);
        for name in [
            "constant_bias_fit",
            "constant_bias",
            "bias_and_scale",
            "rest_bias",
        ] {
            let error_deg = error_deg(&found, name).unwrap();
            assert!(error_deg < 0.1, "{name}: {error_deg}");
        }
        let vqf_deg = error_deg(&found, "vqf").unwrap();
        assert!(vqf_deg < 1.0, "{vqf_deg}");
    }

    #[test]
    fn what_a_record_does_not_show_is_left_out() {
        let turning = record(false);
        assert_eq!(error_deg(&baselines(&turning), "rest_bias"), None);
        let alone = SensorSignals {
            accelerations_g: None,
            ..turning.signals().clone()
        };
        let alone = SensorRecord::new(alone, turning.angle_deg().to_vec()).unwrap();
        assert_eq!(error_deg(&baselines(&alone), "vqf"), None);
    }
}
