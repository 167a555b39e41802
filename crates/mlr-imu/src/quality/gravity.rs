//! Gravity as the accelerometer shows it.

use mlr_filter::unwrapped_rad;
use nalgebra::Vector3;

use super::{Finding, FindingKind, Severity, rows::Rows};
use crate::{Correction, STANDARD_GRAVITY_MPS2};

/// The mean specific force: of the standing robot where the log shows it, else of the whole
/// log. Over whole gait cycles the body's own accelerations cancel. A log without raw samples
/// shows its direction only, by roll and pitch of the standing robot.
pub(super) struct Gravity {
    up: Vector3<f64>,
    norm_mps2: Option<f64>,
}

/// Samples of the standing robot that a mean needs; otherwise the whole log is taken.
const FEWEST_STANDING: usize = 20;
/// What an MPU6050 may be off: 3 % of scale and 80 mg of offset along z (data sheet,
/// accelerometer specifications), with a hundredth for tilt.
const SENSOR_ACCURACY: f64 = 0.12;
/// Beyond this no calibration of a working sensor reaches: the vendor's calibration of one
/// JetHexa takes off 2.3 m/s².
const USELESS: f64 = 0.35;
/// Tilt at rest that neither a slope nor lost legs explain: a JetHexa without its front legs
/// rests on its nose at 35°.
const LARGEST_TILT_DEG: f64 = 60.0;
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
        match rows.raw {
            Some(raw) => Self::of_forces(rows, &raw.accelerations_mps2),
            None => rows.standing_roll_pitch_rad().map(|[roll, pitch]| Self {
                up: Vector3::new(
                    -pitch.sin(),
                    roll.sin() * pitch.cos(),
                    roll.cos() * pitch.cos(),
                ),
                norm_mps2: None,
            }),
        }
    }

    fn of_forces(rows: &Rows<'_>, forces: &[Vector3<f64>]) -> Option<Self> {
        let standing = forces.get(rows.standing.clone()).unwrap_or_default();
        let forces = if standing.len() < FEWEST_STANDING {
            forces
        } else {
            standing
        };
        let mean = forces.iter().sum::<Vector3<f64>>() / forces.len() as f64;
        (!forces.is_empty()).then(|| Self {
            up: mean.try_normalize(1e-9).unwrap_or_else(Vector3::z),
            norm_mps2: Some(mean.norm()),
        })
    }

    pub(super) fn norm_mps2(&self) -> Option<f64> {
        self.norm_mps2
    }

    pub(super) fn findings(&self, rows: &Rows<'_>) -> Vec<Finding> {
        let mut found = Vec::new();
        if let Some(norm) = self.norm_mps2 {
            found.extend(size(rows, norm));
            if found.iter().any(|it| it.severity == Severity::Useless) {
                return found;
            }
        }
        found.extend(self.direction(rows));
        found
    }

    fn direction(&self, rows: &Rows<'_>) -> Option<Finding> {
        let up = self.up;
        let (roll_rad, pitch_rad) = (up.y.atan2(up.z), (-up.x).atan2(up.y.hypot(up.z)));
        let tilt_deg = up.z.clamp(-1.0, 1.0).acos().to_degrees();
        if tilt_deg > 180.0 - LARGEST_TILT_DEG {
            return Some(rows.finding(
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
                Severity::Note
            };
            // What turns the sensor's axes into the body's, whose z axis points up.
            return Some(rows.finding(
                FindingKind::Axes,
                severity,
                format!("at rest, the robot or its sensor is tilted by {tilt_deg:.0}°"),
                Some(format!(
                    "[mounting] roll_deg = {:.0}, pitch_deg = {:.0} in --config if it is the sensor, \
                     and yaw_deg if its x axis does not point forward",
                    -roll_rad.to_degrees(),
                    -pitch_rad.to_degrees()
                )),
            ));
        }
        self.disagreement(rows, [roll_rad, pitch_rad])
    }

    /// At rest, recorded roll and pitch are those of gravity.
    fn disagreement(&self, rows: &Rows<'_>, of_gravity_rad: [f64; 2]) -> Option<Finding> {
        rows.raw?;
        let [roll_rad, pitch_rad] = rows.standing_roll_pitch_rad()?;
        [("roll", roll_rad), ("pitch", pitch_rad)]
            .into_iter()
            .zip(of_gravity_rad)
            .find(|((_, angle_rad), gravity_rad)| {
                let apart_rad = unwrapped_rad(0.0, angle_rad - gravity_rad);
                apart_rad.to_degrees().abs() > LARGEST_DISAGREEMENT_DEG
            })
            .map(|((name, angle_rad), gravity_rad)| {
                rows.finding(
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

/// Whether a mean specific force can be gravity in m/s².
fn size(rows: &Rows<'_>, norm_mps2: f64) -> Option<Finding> {
    let off = (norm_mps2 / STANDARD_GRAVITY_MPS2 - 1.0).abs();
    let seen = format!("gravity is {norm_mps2:.3} m/s², expected 9.81");
    if off > USELESS {
        let unit = UNITS
            .iter()
            .find(|(_, gravity)| (norm_mps2 / gravity - 1.0).abs() < USELESS);
        return Some(match unit {
            Some((unit, _)) => rows.finding(
                FindingKind::AccelerationUnit,
                Severity::Useless,
                format!("{seen}: the accelerations are in {unit}"),
                (*unit == "g").then(|| rows.arguments(&["ax", "ay", "az"], Correction::Unit("g"))),
            ),
            None => rows.finding(
                FindingKind::Gravity,
                Severity::Useless,
                format!("{seen}: the accelerometer is dead or not scaled"),
                None,
            ),
        });
    }
    (off > SENSOR_ACCURACY).then(|| {
        rows.finding(
            FindingKind::Gravity,
            Severity::Worse,
            format!(
                "{seen} within the accuracy of the sensor: the accelerometer needs a calibration"
            ),
            Some("[mounting] accelerometer_bias_mps2 in --config".into()),
        )
    })
}

/// What to type for a sensor whose z axis points down.
fn downward_cure(rows: &Rows<'_>) -> String {
    let flipped = |keys: &[&str]| rows.arguments(keys, Correction::Sign);
    match rows.standing_roll_pitch_rad() {
        // The angles show it too: the sensor itself is turned.
        Some([roll_rad, _]) if roll_rad.cos() < 0.0 => {
            "[mounting] roll_deg = 180.0 in --config".into()
        }
        Some(_) => flipped(&["pitch", "yaw", "ay", "az", "gy", "gz"]),
        None => format!(
            "[mounting] roll_deg = 180.0 in --config, or {}",
            flipped(&["ay", "az", "gy", "gz"])
        ),
    }
}
