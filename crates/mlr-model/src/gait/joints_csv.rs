//! Joint trajectories as CSV: what a robot's controller plays.
//!
//! ```text
//! # repeat 51..101
//! t_s,leg1_coxa_rad,leg1_femur_rad,…
//! 0,0.1,0.4,…
//! 0.02,…
//! ```

use std::fmt::Write as _;

use super::JointTrajectory;
use crate::{ModelError, Robot};

/// Before the rows that repeat.
const REPEAT: &str = "# repeat ";
/// By so much may a row be early or late.
const TIME_TOLERANCE_S: f64 = 1e-6;

impl JointTrajectory {
    /// The trajectory as CSV: gait time and the angle of every joint of the undamaged robot, with
    /// all their digits. The first line names the rows that repeat, where some do.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] for a robot with other joints.
    pub fn to_csv(&self, robot: &Robot) -> Result<String, ModelError> {
        self.check_on(robot)?;
        let mut text = String::new();
        if let Some(rows) = self.repeat_rows() {
            text += &format!("{REPEAT}{}..{}\n", rows.start, rows.end);
        }
        text += &columns(robot).join(",");
        for (row, angles_rad) in self.rows_rad().iter().enumerate() {
            // To the picosecond: 0.06 s and not 0.06000000000000001 s.
            let time_s = (row as f64 * self.row_s() * 1e12).round() / 1e12;
            // Writing to a string cannot fail.
            let _ = write!(text, "\n{time_s}");
            for angle_rad in angles_rad {
                let _ = write!(text, ",{angle_rad}");
            }
        }
        text.push('\n');
        Ok(text)
    }

    /// Reads what [`Self::to_csv`] writes. Other comment lines are left out.
    ///
    /// # Errors
    /// [`ModelError::JointsCsv`] naming the line, [`ModelError::Setting`] where a number makes no
    /// sense.
    pub fn from_csv(text: &str, robot: &Robot) -> Result<Self, ModelError> {
        let mut repeat_rows = None;
        let mut header_read = false;
        let mut times_s = Vec::new();
        let mut rows_rad = Vec::new();
        let columns = columns(robot);
        for (line, content) in (1..).zip(text.lines()) {
            let content = content.trim_end();
            let fail = |reason: String| ModelError::JointsCsv { line, reason };
            if let Some(rows) = content.strip_prefix(REPEAT) {
                let range = rows.split_once("..").and_then(|(start, end)| {
                    Some(start.trim().parse().ok()?..end.trim().parse().ok()?)
                });
                let expected = || {
                    fail(format!(
                        "rows {rows:?}, expected two numbers as in 100..150"
                    ))
                };
                repeat_rows = Some(range.ok_or_else(expected)?);
            } else if content.is_empty() || content.starts_with('#') {
                continue;
            } else if header_read {
                let numbers = numbers(content, &columns).map_err(fail)?;
                if let Some((time_s, row_rad)) = numbers.split_first() {
                    let row_s = times_s.get(1).map_or(*time_s, |row_s: &f64| *row_s);
                    let expected_s = times_s.len() as f64 * row_s;
                    if (time_s - expected_s).abs() > TIME_TOLERANCE_S {
                        let expected = "expected a first row at 0 s and rows at even distances";
                        return Err(fail(format!(
                            "t_s: {time_s}, {expected}, here {expected_s:.6}"
                        )));
                    }
                    times_s.push(*time_s);
                    rows_rad.push(row_rad.to_vec());
                }
            } else {
                let found: Vec<&str> = content.split(',').map(str::trim).collect();
                if found != columns {
                    return Err(fail(unlike(&found, &columns)));
                }
                header_read = true;
            }
        }
        let row_s = times_s.get(1).copied().unwrap_or_default();
        Ok(Self::new(row_s, rows_rad, repeat_rows)?)
    }

    /// Whether it has an angle for every joint of this robot.
    pub(crate) fn check_on(&self, robot: &Robot) -> Result<(), ModelError> {
        let (gait, robot) = (self.joints(), robot.layout().total_links());
        match gait == robot {
            true => Ok(()),
            false => Err(ModelError::JointCount { gait, robot }),
        }
    }
}

/// Names of all columns.
fn columns(robot: &Robot) -> Vec<String> {
    let joints = robot.joint_names().into_iter();
    let joints = joints.map(|joint| format!("{joint}_rad"));
    std::iter::once("t_s".to_string()).chain(joints).collect()
}

/// The numbers of a row, one for each column.
fn numbers(content: &str, columns: &[String]) -> Result<Vec<f64>, String> {
    let fields: Vec<&str> = content.split(',').map(str::trim).collect();
    if fields.len() != columns.len() {
        let (found, expected) = (fields.len(), columns.len());
        return Err(format!(
            "{found} fields, expected {expected}: time and the angle of every joint"
        ));
    }
    let number = |(field, column): (&str, &String)| match field.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{column}: {field:?}, expected a number")),
    };
    fields.into_iter().zip(columns).map(number).collect()
}

/// Names the first column that differs.
fn unlike(found: &[&str], columns: &[String]) -> String {
    let mut pairs = columns.iter().zip(found);
    match pairs.find(|(column, found)| column != *found) {
        Some((column, found)) => format!("column {found:?}, expected {column}"),
        None => format!(
            "{} columns, expected {}, up to {}",
            found.len(),
            columns.len(),
            columns[columns.len() - 1]
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Gait;

    fn tripod() -> JointTrajectory {
        JointTrajectory::commanded(&Robot::jethexa(), &Gait::tripod(), 2.0).unwrap()
    }

    #[test]
    fn what_is_written_is_read_back_bit_for_bit() {
        let robot = Robot::jethexa();
        let text = tripod().to_csv(&robot).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("# repeat 51..101"));
        let header = lines.next().unwrap();
        assert!(
            header.starts_with("t_s,leg1_coxa_rad,leg1_femur_rad,leg1_tibia_rad,leg2_coxa_rad,")
        );
        assert!(header.ends_with(",leg6_tibia_rad"));
        assert_eq!(lines.clone().count(), 101);
        assert!(lines.nth(3).unwrap().starts_with("0.06,"));
        assert_eq!(JointTrajectory::from_csv(&text, &robot).unwrap(), tripod());
        // The control: without its first line it ends.
        let (_, ending) = text.split_once('\n').unwrap();
        let ending = JointTrajectory::from_csv(ending, &robot).unwrap();
        assert_eq!(
            (ending.rows_rad(), ending.repeat_rows()),
            (tripod().rows_rad(), None)
        );
    }

    #[test]
    fn a_line_that_makes_no_sense_is_named() {
        let robot = Robot::jethexa();
        let good = tripod().to_csv(&robot).unwrap();
        let third_row = good.lines().nth(4).unwrap();
        let without_last = third_row.rsplit_once(',').unwrap().0;
        for (text, expected) in [
            (good.replace("51..101", "51-101"), "line 1: rows \"51-101\""),
            (
                good.replace("leg2_femur", "leg2_thigh"),
                "line 2: column \"leg2_thigh_rad\", expected leg2_femur_rad",
            ),
            (
                good.replace(",leg6_tibia_rad", ""),
                "line 2: 18 columns, expected 19",
            ),
            (
                good.replace(third_row, without_last),
                "line 5: 18 fields, expected 19",
            ),
            (
                good.replace(third_row, &format!("{without_last},x")),
                "line 5: leg6_tibia_rad: \"x\", expected a number",
            ),
            (
                good.replace(third_row, &format!("{without_last},nan")),
                "line 5: leg6_tibia_rad: \"nan\"",
            ),
            (
                good.replace("\n0.04,", "\n0.05,"),
                "line 5: t_s: 0.05, expected",
            ),
            (
                good.replace("\n0,", "\n1,"),
                "line 3: t_s: 1, expected a first row at 0 s",
            ),
            (good.replace("51..101", "51..102"), "repeat_rows[1]: 102"),
            (String::new(), "row_s: 0"),
        ] {
            let message = JointTrajectory::from_csv(&text, &robot)
                .unwrap_err()
                .to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn links_of_one_name_and_odd_names_get_columns_of_their_own() {
        let text = Robot::JETHEXA_TOML
            .replace(
                "[\"coxa\", \"femur\", \"tibia\"]",
                "[\"coxa\", \"femur\", \"femur\"]",
            )
            .replace("coxa", "\"hip, inner\"")
            .replace("\"\"hip, inner\"\"", "\"hip, inner\"");
        let robot = Robot::from_toml(&text).unwrap();
        let names = robot.joint_names();
        assert_eq!(
            names[..3],
            ["leg1_hip__inner", "leg1_femur_2", "leg1_femur_3"]
        );
        assert_eq!(names.len(), 18);
    }
}
