//! What the sensor says, and whether the daemon can use it.

use std::time::Duration;

use mlr_imu::{AccelerometerRange, Mounting, STANDARD_GRAVITY_MPS2};
use nalgebra::{UnitQuaternion, Vector3};

use super::{
    findings::{Findings, Mark},
    listening::{self, Listened},
    progress,
};
use crate::{
    FramingName, Settings,
    line_health::LineFault,
    mounting_check::{UPSIDE_DOWN, cure as upside_down_cure},
    source::{SerialLine, Source},
};

/// Judges what was heard, from the bytes to what they say of the robot.
pub(super) fn judge(settings: &Settings, heard: &Listened, findings: &mut Findings) {
    if !framing(settings, heard, findings) {
        return;
    }
    rate(settings, heard, findings);
    if values(heard, findings) {
        mounting(settings, heard, findings);
        gravity(settings, heard, findings);
    }
}

/// Speeds of devices that are known, most of them beside the daemon's default.
const SPEEDS_BAUD: [u32; 7] = [9600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800];
/// Long enough for a few frames of a module at 10 Hz.
const TRIED: Duration = Duration::from_millis(700);
/// A share of bad or lost frames that is worth a look at the wires.
const BAD_SHARE: f64 = 0.01;
/// So many may be bad when listening begins and ends in mid-frame.
const FEW_BAD: u64 = 3;

/// Whether there are frames to judge.
fn framing(settings: &Settings, heard: &Listened, findings: &mut Findings) -> bool {
    const CHECK: &str = "framing";
    let counts = heard.counts;
    let bad = counts.bad + counts.lost;
    if counts.good > 0 {
        let name = match (settings.framing(), heard.framing) {
            (FramingName::Lines, _) => "lines of text".into(),
            (_, Some(framing)) => framing.to_string(),
            (told, None) => format!("{told:?}").to_lowercase(),
        };
        let found = format!(
            "{name}: {} good frames, {} bad, {} lost in {:.0} s",
            counts.good, counts.bad, counts.lost, heard.time_s
        );
        if bad > FEW_BAD && bad as f64 > BAD_SHARE * counts.good as f64 {
            let cure = "shorten the wires, connect GND beside the data, let one program alone send; a \
                        line that is full loses frames: choose a higher speed or a lower rate";
            findings.warning(CHECK, found, cure);
        } else {
            findings.ok(CHECK, found);
        }
        return true;
    }
    if heard.bytes == 0 {
        let (found, cure) = silent(settings, heard);
        findings.failed(CHECK, found, cure);
        return false;
    }
    let found = match &heard.line_fault {
        Some(fault) => fault.to_string(),
        None => format!(
            "{} bytes in {:.0} s and no valid frame",
            heard.bytes, heard.time_s
        ),
    };
    let cure = match &heard.line_fault {
        Some(LineFault::OtherFraming { found, .. }) => format!("--format {found}"),
        Some(LineFault::NoSamples { .. }) => {
            "send a line of names first, as in docs/onboard.md".into()
        }
        _ => other_speed(settings),
    };
    findings.failed(CHECK, found, cure);
    false
}

fn silent(settings: &Settings, heard: &Listened) -> (String, String) {
    if settings.stdin {
        let cure = "hand samples on: DRIVER | mlrd check --stdin";
        return ("the input ends without a sample".into(), cure.into());
    }
    let found = match &heard.lost {
        Some(loss) => format!("no byte, and then the port was lost: {loss:?}"),
        None => format!("silent: no byte in {:.0} s", heard.time_s),
    };
    let cure = "check that the sensor has power and GND, and that its TX is wired to the computer's RX \
                (pin 10 of J41); some modules send only when told to";
    (found, cure.into())
}

/// Looks for a speed at which frames come.
fn other_speed(settings: &Settings) -> String {
    let Some(device) = &settings.port else {
        return "check the wires of SDA, SCL and GND".into();
    };
    progress("trying other speeds of the port");
    let speeds = SPEEDS_BAUD
        .into_iter()
        .filter(|&baud| baud != settings.baud);
    for baud in speeds {
        let device = device.clone();
        let Ok(mut port) = (SerialLine { device, baud }).open() else {
            continue;
        };
        if let Some(framing) = listening::framing(&mut *port, settings, TRIED) {
            return format!("--baud {baud} (at this speed come {framing} frames)");
        }
    }
    "set the device to 115200 baud and to a framing that mlrd knows (docs/onboard.md), and look for \
     another program that writes to this port: no usual speed makes sense of it"
        .into()
}

fn rate(settings: &Settings, heard: &Listened, findings: &mut Findings) {
    const CHECK: &str = "rate";
    let identification = &settings.identification;
    let detector = &identification.detector;
    let needed_hz = identification
        .sampling
        .min_rate_hz
        .max(detector.min_samples as f64 / detector.window_s);
    match heard.rate_hz {
        Some(rate_hz) if rate_hz >= needed_hz => {
            findings.ok(
                CHECK,
                format!("{rate_hz:.0} Hz, {needed_hz:.0} Hz are needed"),
            );
        }
        rate_hz => findings.failed(
            CHECK,
            format!(
                "{:.1} Hz, {needed_hz:.0} Hz are needed",
                rate_hz.unwrap_or(0.0)
            ),
            "set the device to a higher rate, and to a speed of the port that carries it (--baud)",
        ),
    }
}

/// Whether the values can be those of a body.
fn values(heard: &Listened, findings: &mut Findings) -> bool {
    const CHECK: &str = "sensor";
    match &heard.fault {
        None => findings.ok(CHECK, "its values are those of a body"),
        // What follows says so.
        Some(fault) if fault.name == "upside_down" => {
            findings.ok(CHECK, "its values are those of a body");
        }
        Some(fault) => {
            let cure = match fault.name {
                "saturated" => {
                    "choose larger ranges, as in [full_scale] accelerometer = \"g8\", gyroscope = \
                     \"dps2000\", on the device as well"
                }
                "impossible" => {
                    "let one program and one sensor alone use the line, and check its GND"
                }
                _ => "take the sensor's power off and on; where that does not help, replace it",
            };
            findings.failed(CHECK, format!("{}: {}", fault.name, fault.reason), cure);
            return false;
        }
    }
    true
}

/// A robot whose roll and pitch go further does not rest.
const REST_RAD: f64 = 1.5_f64.to_radians();
/// Tilt of a sensor on a robot that stands level: within the zero points of an accelerometer
/// (50 mg, 3°, of an MPU6050 across its axis at most, as a rule less) and of the floor; and what
/// the detector's threshold of 5° cannot bear.
const LEVEL_DEG: f64 = 2.0;
const TILTED_DEG: f64 = 5.0;

fn mounting(settings: &Settings, heard: &Listened, findings: &mut Findings) {
    const CHECK: &str = "mounting";
    let told = &settings.mounting;
    let Some(up) = heard.rest.up() else {
        let cure = "let the robot stand still on level ground for longer: --listen-s 10";
        findings.warning(CHECK, "no attitude was heard", cure);
        return;
    };
    let is_upside_down = |name: &str| name == "upside_down";
    if heard
        .fault
        .as_ref()
        .is_some_and(|fault| is_upside_down(fault.name))
    {
        findings.failed(CHECK, UPSIDE_DOWN, upside_down_cure(told));
        return;
    }
    let swing_rad = heard.rest.swing_rad();
    if swing_rad > REST_RAD {
        let found = format!(
            "the robot moves (roll or pitch by {:.1}°): how the sensor sits cannot be told",
            swing_rad.to_degrees()
        );
        findings.warning(
            CHECK,
            found,
            "let it stand still on level ground, and check again",
        );
        return;
    }
    let roll_deg = up.y.atan2(up.z).to_degrees();
    let pitch_deg = (-up.x).asin().to_degrees();
    let tilt_deg = up.angle(&Vector3::z()).to_degrees();
    let mark = match tilt_deg {
        tilt_deg if tilt_deg <= LEVEL_DEG => Mark::Ok,
        tilt_deg if tilt_deg <= TILTED_DEG => Mark::Warning,
        _ => Mark::Failed,
    };
    let cure = (mark != Mark::Ok).then(|| {
        let [roll_deg, pitch_deg, yaw_deg] = levelled_deg(told, &up);
        format!(
            "stand the robot on level ground; where it does, set [mounting] roll_deg = {roll_deg:.1}, \
             pitch_deg = {pitch_deg:.1}, yaw_deg = {yaw_deg:.1} in mlrd.toml"
        )
    });
    let found = format!("at rest, roll {roll_deg:.1}°, pitch {pitch_deg:.1}°");
    findings.add(CHECK, mark, found, cure);
}

/// Roll, pitch and yaw of a mounting with which what is up now is up, turned as little as
/// possible from the one told.
fn levelled_deg(told: &Mounting, up: &Vector3<f64>) -> [f64; 3] {
    let body_from_sensor = UnitQuaternion::from_euler_angles(
        told.roll_deg.to_radians(),
        told.pitch_deg.to_radians(),
        told.yaw_deg.to_radians(),
    );
    let levelling = UnitQuaternion::rotation_between(up, &Vector3::z()).unwrap_or_default();
    let (roll, pitch, yaw) = (levelling * body_from_sensor).euler_angles();
    // No negative zeros.
    [roll, pitch, yaw].map(|angle_rad| angle_rad.to_degrees() + 0.0)
}

/// An MPU6050's scale is within 3 % by its data sheet; what is off by more is not
/// calibrated, or was read with the wrong range.
const SCALE_OFF: f64 = 0.03;
const RANGE_OFF: f64 = 0.2;
/// With the right range, gravity is this close. Values in g instead of m/s², which are a tenth, fit no range.
const RANGE_FITS: f64 = 0.1;

fn gravity(settings: &Settings, heard: &Listened, findings: &mut Findings) {
    const CHECK: &str = "gravity";
    let Some(force_mps2) = heard.rest.force_mps2() else {
        findings.ok(CHECK, "the device sends orientation alone");
        return;
    };
    let ratio = force_mps2 / STANDARD_GRAVITY_MPS2;
    let found = format!("{force_mps2:.2} m/s², {STANDARD_GRAVITY_MPS2:.2} are right");
    let off = (ratio - 1.0).abs();
    if off <= SCALE_OFF {
        findings.ok(CHECK, found);
    } else if off <= RANGE_OFF {
        let cure = format!(
            "calibrate the accelerometer; in the simplest case set [mounting] accelerometer_scale = \
             [[{0:.3}, 0.0, 0.0], [0.0, {0:.3}, 0.0], [0.0, 0.0, {0:.3}]] in mlrd.toml",
            1.0 / ratio
        );
        findings.warning(CHECK, found, cure);
    } else {
        findings.failed(
            CHECK,
            found,
            range_cure(settings.full_scale.accelerometer, ratio),
        );
    }
}

/// The range with which gravity would be right.
fn range_cure(told: AccelerometerRange, ratio: f64) -> String {
    let counts_per_g = told.counts_per_g() * ratio;
    let ranges = [
        ("g2", AccelerometerRange::G2),
        ("g4", AccelerometerRange::G4),
        ("g8", AccelerometerRange::G8),
        ("g16", AccelerometerRange::G16),
    ];
    let fitting = ranges
        .into_iter()
        .find(|(_, range)| (counts_per_g / range.counts_per_g() - 1.0).abs() <= RANGE_FITS);
    match fitting {
        Some((name, _)) => format!("set [full_scale] accelerometer = \"{name}\" in mlrd.toml"),
        None => "the units are wrong: m/s² are expected of lines of text, the chip's ranges of \
                 frames"
            .into(),
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::ImuSample;

    use super::*;

    #[test]
    fn the_mounting_that_is_proposed_levels_the_robot() {
        let told = Mounting {
            roll_deg: 180.0,
            yaw_deg: 40.0,
            ..Mounting::default()
        };
        for up in [Vector3::new(0.3, -0.2, 0.9), Vector3::new(0.8, 0.5, 0.1)] {
            let up = up.normalize();
            let back = |mounting: &Mounting| {
                UnitQuaternion::from_euler_angles(
                    mounting.roll_deg.to_radians(),
                    mounting.pitch_deg.to_radians(),
                    mounting.yaw_deg.to_radians(),
                )
                .inverse()
            };
            let raw = ImuSample {
                acceleration_mps2: Some(back(&told) * up),
                ..ImuSample::default()
            };
            let [roll_deg, pitch_deg, yaw_deg] = levelled_deg(&told, &up);
            let cured = Mounting {
                roll_deg,
                pitch_deg,
                yaw_deg,
                ..told
            };
            cured.check().unwrap();
            let levelled = cured.in_body_axes(&raw).acceleration_mps2.unwrap();
            assert!((levelled - Vector3::z()).norm() < 1e-9, "{levelled}");
        }
    }

    #[test]
    fn a_wrong_range_is_named() {
        // Told 2 g, the chip is set to 8 g: a quarter of gravity.
        assert!(range_cure(AccelerometerRange::G2, 0.25).contains("\"g8\""));
        assert!(range_cure(AccelerometerRange::G8, 4.05).contains("\"g2\""));
        assert!(range_cure(AccelerometerRange::G2, 0.102).contains("units"));
    }
}
