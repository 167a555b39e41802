//! Gravity as the accelerometer shows it.

use nalgebra::Vector3;

use super::{Finding, FindingKind, Severity, rows::Rows};
use crate::{Correction, STANDARD_GRAVITY_MPS2};

/// The mean specific force: of the standing robot where the log shows it, else of the whole
/// log. Over whole gait cycles the body's own accelerations cancel.
pub(super) struct Gravity {
    mean_mps2: Vector3<f64>,
}

/// Seconds of standing that a mean needs; otherwise the whole log is taken.
const FEWEST_STANDING: usize = 20;
/// What an MPU6050 may be off: 3 % of scale and 80 mg of offset along z (data sheet,
/// accelerometer specifications), with a hundredth for tilt.
const SENSOR_ACCURACY: f64 = 0.12;
/// Beyond this no calibration of a working sensor reaches: the vendor's calibration of one
/// JetHexa takes off 2.3 m/s².
const USELESS: f64 = 0.35;
/// Tilt of the sensor at rest that no slope and no careless mounting explains.
const LARGEST_TILT_DEG: f64 = 45.0;
/// Tilt that is worth a word.
const ODD_TILT_DEG: f64 = 20.0;
/// Roll and pitch of a good filter follow gravity at rest within this.
const LARGEST_DISAGREEMENT_DEG: f64 = 15.0;

/// Units in which gravity is not 9.81, by what it is in them.
const UNITS: [(&str, f64); 8] = [
    ("g", 1.0),
    ("mg", 1000.0),
    ("cm/s²", 980.665),
    ("ft/s²", 32.174),
    ("raw counts of a ±2 g range", 16384.0),
    ("raw counts of a ±4 g range", 8192.0),
    ("raw counts of a ±8 g range", 4096.0),
    ("raw counts of a ±16 g range", 2048.0),
];

impl Gravity {
    pub(super) fn of(rows: &Rows<'_>) -> Option<Self> {
        let forces = &rows.raw?.accelerations_mps2;
        let standing = forces.get(rows.standing.clone()).unwrap_or_default();
        let forces = if standing.len() < FEWEST_STANDING {
            forces.as_slice()
        } else {
            standing
        };
        (!forces.is_empty()).then(|| Self {
            mean_mps2: forces.iter().sum::<Vector3<f64>>() / forces.len() as f64,
        })
    }

    pub(super) fn norm_mps2(&self) -> f64 {
        self.mean_mps2.norm()
    }

    pub(super) fn findings(&self, rows: &Rows<'_>) -> Vec<Finding> {
        let finding = |kind, severity, reason, cure| {
            let (from_s, to_s) = rows.span_s();
            Finding {
                kind,
                severity,
                from_s,
                to_s,
                reason,
                cure,
            }
        };
        let norm = self.norm_mps2();
        let off = (norm / STANDARD_GRAVITY_MPS2 - 1.0).abs();
        if off > USELESS {
            let unit = UNITS
                .iter()
                .find(|(_, gravity)| (norm / gravity - 1.0).abs() < USELESS);
            let seen = format!("gravity is {norm:.3} m/s², expected 9.81");
            return vec![match unit {
                Some((unit, _)) => finding(
                    FindingKind::AccelerationUnit,
                    Severity::Useless,
                    format!("{seen}: the accelerations are in {unit}"),
                    (*unit == "g").then(|| self.in_g(rows)),
                ),
                None => finding(
                    FindingKind::Gravity,
                    Severity::Useless,
                    format!("{seen}: the accelerometer is dead or not scaled"),
                    None,
                ),
            }];
        }
        let mut found = Vec::new();
        if off > SENSOR_ACCURACY {
            found.push(finding(
                FindingKind::Gravity,
                Severity::Worse,
                format!(
                    "gravity is {norm:.2} m/s², expected 9.81 within the accuracy of the sensor: \
                     the accelerometer needs a calibration"
                ),
                Some("[mounting] accelerometer_bias_mps2 in --config".into()),
            ));
        }
        found.extend(self.direction(rows, &finding));
        found
    }

    /// The `--column` arguments that read accelerations in g.
    fn in_g(&self, rows: &Rows<'_>) -> String {
        let arguments = ["ax", "ay", "az"]
            .iter()
            .filter_map(|key| rows.columns.corrected(key, Correction::Unit("g")));
        arguments.collect::<Vec<_>>().join(" ")
    }

    fn direction(
        &self,
        rows: &Rows<'_>,
        finding: &impl Fn(FindingKind, Severity, String, Option<String>) -> Finding,
    ) -> Option<Finding> {
        let up = self.mean_mps2.normalize();
        let (roll_rad, pitch_rad) = (up.y.atan2(up.z), (-up.x).atan2(up.y.hypot(up.z)));
        let tilt_deg = up.z.clamp(-1.0, 1.0).acos().to_degrees();
        if tilt_deg > 180.0 - LARGEST_TILT_DEG {
            return Some(finding(
                FindingKind::UpsideDown,
                Severity::Useless,
                "gravity points the other way: the sensor is upside down, or its axes are those of \
                 NED (y right, z down)"
                    .into(),
                Some(downward_cure(rows)),
            ));
        }
        if tilt_deg > ODD_TILT_DEG {
            let severity = if tilt_deg > LARGEST_TILT_DEG {
                Severity::Useless
            } else {
                Severity::Worse
            };
            // What turns the sensor's axes into the body's, whose z axis points up.
            return Some(finding(
                FindingKind::Axes,
                severity,
                format!("the sensor's z axis is {tilt_deg:.0}° off the vertical"),
                Some(format!(
                    "[mounting] roll_deg = {:.0}, pitch_deg = {:.0} in --config, and yaw_deg if its \
                     x axis does not point forward",
                    -roll_rad.to_degrees(),
                    -pitch_rad.to_degrees()
                )),
            ));
        }
        self.disagreement(rows, [roll_rad, pitch_rad], finding)
    }

    /// At rest, recorded roll and pitch are those of gravity.
    fn disagreement(
        &self,
        rows: &Rows<'_>,
        of_gravity_rad: [f64; 2],
        finding: &impl Fn(FindingKind, Severity, String, Option<String>) -> Finding,
    ) -> Option<Finding> {
        let angles = rows.angles_rad?;
        if rows.standing.len() < FEWEST_STANDING {
            return None;
        }
        let mean = |values: &[f64]| {
            let standing = &values[rows.standing.clone()];
            standing.iter().sum::<f64>() / standing.len() as f64
        };
        let recorded = [("roll", mean(&angles.roll)), ("pitch", mean(&angles.pitch))];
        recorded
            .into_iter()
            .zip(of_gravity_rad)
            .find(|((_, angle_rad), gravity_rad)| {
                let apart = (angle_rad - gravity_rad).to_degrees();
                (apart + 180.0).rem_euclid(360.0) - 180.0 > LARGEST_DISAGREEMENT_DEG
                    || (apart + 180.0).rem_euclid(360.0) - 180.0 < -LARGEST_DISAGREEMENT_DEG
            })
            .map(|((name, angle_rad), gravity_rad)| {
                finding(
                    FindingKind::Contradiction,
                    Severity::Useless,
                    format!(
                        "at rest the log says {name} {:.1}°, gravity says {:.1}°",
                        angle_rad.to_degrees(),
                        gravity_rad.to_degrees()
                    ),
                    None,
                )
            })
    }
}

/// What to type for a sensor whose z axis points down.
fn downward_cure(rows: &Rows<'_>) -> String {
    let standing_roll = rows.angles_rad.and_then(|angles| {
        let standing = angles.roll.get(rows.standing.clone())?;
        Some(standing.iter().sum::<f64>() / standing.len().max(1) as f64)
    });
    let flipped = |keys: &[&str]| {
        let arguments = keys
            .iter()
            .filter_map(|key| rows.columns.corrected(key, Correction::Sign));
        arguments.collect::<Vec<_>>().join(" ")
    };
    match standing_roll {
        // The angles show it too: the sensor itself is turned.
        Some(roll_rad) if roll_rad.cos() < 0.0 => "[mounting] roll_deg = 180.0 in --config".into(),
        Some(_) => flipped(&["pitch", "yaw", "ay", "az", "gy", "gz"]),
        None => format!(
            "[mounting] roll_deg = 180.0 in --config, or {}",
            flipped(&["ay", "az", "gy", "gz"])
        ),
    }
}
