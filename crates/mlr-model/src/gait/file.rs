//! The TOML form of gaits: flat keys of one kind of motion or the other.

use std::fmt::Write as _;

use serde::{Deserialize, de::IgnoredAny};

use super::{FootMotion, Gait, JointTrajectory, Motion};
use crate::{ModelError, setting_place::located};

/// What tells the two forms apart.
#[derive(Deserialize)]
struct Kind {
    joints_rad: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FootFile {
    name: String,
    period_s: f64,
    ramp_s: f64,
    stride_m: f64,
    lift_m: f64,
    body_height_m: f64,
    swing_fraction: f64,
    phase_offsets: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointFile {
    name: String,
    period_s: f64,
    row_s: f64,
    repeat_rows: Option<[usize; 2]>,
    joints_rad: Vec<Vec<f64>>,
}

pub(super) fn parse(text: &str) -> Result<Gait, ModelError> {
    let gait = match toml::from_str(text).map_err(syntax)? {
        Kind { joints_rad: None } => of_feet(toml::from_str(text).map_err(syntax)?),
        Kind { .. } => of_joints(toml::from_str(text).map_err(syntax)?),
    };
    gait.check().map_err(|error| located(error, text))?;
    Ok(gait)
}

fn syntax(source: toml::de::Error) -> ModelError {
    ModelError::Syntax {
        what: "gait",
        source: Box::new(source),
    }
}

fn of_feet(file: FootFile) -> Gait {
    Gait {
        name: file.name,
        period_s: file.period_s,
        motion: Motion::Feet(FootMotion {
            ramp_s: file.ramp_s,
            stride_m: file.stride_m,
            lift_m: file.lift_m,
            body_height_m: file.body_height_m,
            swing_fraction: file.swing_fraction,
            phase_offsets: file.phase_offsets,
        }),
    }
}

fn of_joints(file: JointFile) -> Gait {
    let repeat_rows = file.repeat_rows.map(|[start, end]| start..end);
    Gait {
        name: file.name,
        period_s: file.period_s,
        motion: Motion::Joints(JointTrajectory::unchecked(
            file.row_s,
            file.joints_rad,
            repeat_rows,
        )),
    }
}

pub(super) fn write(gait: &Gait) -> String {
    let name = toml::Value::String(gait.name.clone());
    let mut text = format!("name = {name}\nperiod_s = {:?}\n", gait.period_s);
    match &gait.motion {
        Motion::Feet(feet) => {
            for (key, value) in [
                ("ramp_s", feet.ramp_s),
                ("stride_m", feet.stride_m),
                ("lift_m", feet.lift_m),
                ("body_height_m", feet.body_height_m),
                ("swing_fraction", feet.swing_fraction),
            ] {
                text += &format!("{key} = {value:?}\n");
            }
            text += &format!("phase_offsets = {:?}\n", feet.phase_offsets);
        }
        Motion::Joints(joints) => {
            text += &format!("row_s = {:?}\n", joints.row_s());
            if let Some(rows) = joints.repeat_rows() {
                text += &format!("repeat_rows = [{}, {}]\n", rows.start, rows.end);
            }
            text += "joints_rad = [\n";
            for row_rad in joints.rows_rad() {
                text += "  [";
                for (joint, angle_rad) in row_rad.iter().enumerate() {
                    let comma = if joint == 0 { "" } else { ", " };
                    // Adding zero makes a plain zero of a negative one.
                    let rounded_rad = (angle_rad * 1e5).round() / 1e5 + 0.0;
                    // Writing to a string cannot fail.
                    let _ = write!(text, "{comma}{rounded_rad:.5}");
                }
                text += "],\n";
            }
            text += "]\n";
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Robot;

    /// Lines 1 to 4 are keys, row k of two joints is line k + 6.
    const TWITCH: &str = "name = \"twitch\"\nperiod_s = 1\nrow_s = 0.02\n\
        repeat_rows = [0, 50]\njoints_rad = [\n";

    fn twitch() -> String {
        let rows: Vec<String> = (0..50)
            .map(|row| format!("  [0.{row:02}, -1],\n"))
            .collect();
        format!("{TWITCH}{}]\n", rows.concat())
    }

    fn message(text: &str) -> String {
        Gait::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn a_trajectory_is_read_with_its_rows() {
        let gait = Gait::from_toml(&twitch()).unwrap();
        let Motion::Joints(joints) = &gait.motion else {
            panic!("{gait:?}");
        };
        assert_eq!((joints.row_s(), joints.joints()), (0.02, 2));
        assert_eq!(joints.repeat_rows(), Some(0..50));
        assert_eq!(joints.rows_rad()[17], [0.17, -1.0]);
    }

    #[test]
    fn unknown_and_missing_keys_are_named() {
        for (text, key) in [
            (Gait::TRIPOD_TOML.replace("stride_m", "strde_m"), "strde_m"),
            (Gait::TRIPOD_TOML.replace("stride_m", "# "), "stride_m"),
            (twitch().replace("row_s", "# "), "row_s"),
            (twitch().replace("repeat_rows", "repeat_row"), "repeat_row"),
            (format!("ramp_s = 1.0\n{}", twitch()), "ramp_s"),
            (
                twitch().replace("period_s = 1", "period_s = \"1\""),
                "period_s",
            ),
        ] {
            let message = message(&text);
            assert!(message.contains(key), "{message}");
            assert!(message.contains("line"), "{message}");
        }
    }

    #[test]
    fn a_row_that_makes_no_sense_is_named_with_its_line() {
        let row = "  [0.17, -1],";
        for (text, expected) in [
            // A column is missing, or one too many.
            (
                twitch().replace(row, "  [0.17],"),
                "line 23: joints_rad[17]: 1 angle is not valid, expected 2, as in the first row",
            ),
            (
                twitch().replace(row, "  [0.17, -1, 0],"),
                "line 23: joints_rad[17]: 3 angles is not valid, expected 2, as in the first row",
            ),
            (
                twitch().replace(row, "  [],"),
                "line 23: joints_rad[17]: 0 angles is not valid, expected 2, as in the first row",
            ),
            (
                twitch().replace(row, "  [0.17, nan],"),
                "line 23: joints_rad[17][1]: NaN is not valid, expected -3.2 to 3.2 rad",
            ),
            // Degrees.
            (
                twitch().replace(row, "  [0.17, -57.3],"),
                "line 23: joints_rad[17][1]: -57.3 is not valid, expected -3.2 to 3.2 rad",
            ),
            // A row is missing.
            (
                twitch().replace(row, ""),
                "line 4: repeat_rows[1]: 50 is not valid, expected 1 to 49",
            ),
            (
                twitch().replace("[0, 50]", "[50, 50]"),
                "line 4: repeat_rows[0]: 50 is not valid, expected 0 to 49",
            ),
            (
                twitch().replace("[0, 50]", "[20, 20]"),
                "line 4: repeat_rows[1]: 20 is not valid, expected 21 to 50",
            ),
            (
                twitch().replace("0.02\n", "0\n"),
                "line 3: row_s: 0 is not valid, expected 0.0001 to 10 s",
            ),
            (
                twitch().replace("[0, 50]", "[0, 45]"),
                "line 2: period_s: 1 is not valid, expected the time that repeat_rows take, 0.9 s, or a whole fraction of it; or other rows",
            ),
            (
                "name = \"\"\nperiod_s = 1\nrow_s = 0.02\njoints_rad = [[0]]".into(),
                "line 4: joints_rad: 1 row is not valid, expected at least 2 rows",
            ),
            (
                "name = \"\"\nperiod_s = 1\nrow_s = 0.02\njoints_rad = [[], []]".into(),
                "line 4: joints_rad[0]: 0 angles is not valid, expected the angle of every joint",
            ),
        ] {
            assert_eq!(message(&text), expected);
        }
        let longer = twitch().replace("  [0.00, -1],\n", &"  [0.00, -1],\n".repeat(352));
        assert_eq!(
            message(&longer.replace("0.02\n", "10\n")),
            "line 3: row_s: 10 is not valid, expected at most 9 s for 401 rows, which last 3600 s"
        );
        // What is no list of lists of numbers is named by the reader of TOML.
        for text in ["joints_rad = [0.1, 0.2]", "joints_rad = [[0.1], [\"a\"]]"] {
            let text = format!("name = \"\"\nperiod_s = 1\nrow_s = 0.02\n{text}");
            let message = message(&text);
            assert!(message.contains("line 4"), "{message}");
        }
    }

    #[test]
    fn thirty_seconds_of_a_hexapod_fit_into_the_file() {
        let hold_s = Robot::jethexa().servo().command_hold_s;
        let rows = (0..=1500).map(|row| vec![-0.123_456_789_012_345_67 * f64::from(row % 20); 18]);
        let joints = JointTrajectory::new(hold_s, rows.collect(), None).unwrap();
        let long = Gait {
            name: "long".into(),
            period_s: 1.0,
            motion: Motion::Joints(joints),
        };
        let text = long.to_toml();
        assert!((text.len() as u64) < Gait::MOST_FILE_BYTES);
        assert_eq!(Gait::from_toml(&text).unwrap().duration_s(), Some(30.0));
    }

    #[test]
    fn the_motion_of_feet_is_read_back_bit_for_bit() {
        let mut gait = Gait::tripod();
        gait.name = "a \"quoted\"\nname".into();
        gait.slow_down(1.1);
        assert_eq!(Gait::from_toml(&gait.to_toml()).unwrap(), gait);
    }

    proptest! {
        #[test]
        fn a_trajectory_is_read_back_to_the_last_digit_written(
            rows_rad in prop::collection::vec(prop::collection::vec(-3.2..=3.2_f64, 3), 2..20),
            repeats in any::<bool>(),
        ) {
            let end = rows_rad.len();
            let repeat_rows = repeats.then_some(1..end);
            let period_s = 0.2 * (end - 1) as f64;
            let joints = JointTrajectory::new(0.2, rows_rad, repeat_rows).unwrap();
            let motion = Motion::Joints(joints.clone());
            let gait = Gait { name: "any".into(), period_s, motion };
            let text = gait.to_toml();
            let read = Gait::from_toml(&text).unwrap();
            let Motion::Joints(read_joints) = &read.motion else { panic!("{text}") };
            let pairs = joints.rows_rad().iter().flatten().zip(read_joints.rows_rad().iter().flatten());
            for (written, read) in pairs {
                prop_assert!((written - read).abs() <= 0.5e-5 + 1e-12, "{written} {read}");
            }
            prop_assert_eq!(read_joints.repeat_rows(), joints.repeat_rows());
            prop_assert_eq!(read_joints.row_s(), 0.2);
            // One row a line, and nothing is lost once it is rounded.
            prop_assert_eq!(text.lines().filter(|line| line.starts_with("  [")).count(), end);
            prop_assert_eq!(read.to_toml(), text);
        }
    }
}
