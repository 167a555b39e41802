use std::ops::{Range, RangeInclusive};

use mlr_filter::SettingError;

use super::Gait;
use crate::{JointCommands, ModelError, Robot};

/// Commanded angles of all joints, row by row.
///
/// Row k is commanded at gait time k · `row_s`. The robot stands in row 0 before; after the last
/// row it holds that one, or goes back to the first of the rows that repeat. A servo that asks
/// between two rows, because its commands last longer or shorter or the gait is slowed down, gets
/// the angles on the straight line between them: a motion must change smoothly with its speed.
///
/// The numbers are checked from construction on.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTrajectory {
    row_s: f64,
    rows_rad: Vec<Vec<f64>>,
    repeat_rows: Option<Range<usize>>,
}

impl JointTrajectory {
    /// Half a turn either way, and a little.
    const ANGLES_RAD: RangeInclusive<f64> = -3.2..=3.2;
    /// No motion lasts longer: an hour, like the longest simulation.
    const LONGEST_S: f64 = 3600.0;
    /// Within this share of a row a time counts as that row's.
    const TOLERANCE: f64 = 1e-6;
    /// As many rows of commands at most make up the cycle of a gait whose own cycle is no whole
    /// number of them.
    const MOST_CYCLES: usize = 10;

    /// Angles of all joints (leg by leg, from the body outward) for each row. Of `repeat_rows`,
    /// the first row follows the last.
    ///
    /// How far apart two rows are is not checked: a servo that is too slow for a step follows at
    /// its own speed.
    ///
    /// # Errors
    /// [`SettingError`] naming the first number that makes no sense.
    pub fn new(
        row_s: f64,
        rows_rad: Vec<Vec<f64>>,
        repeat_rows: Option<Range<usize>>,
    ) -> Result<Self, SettingError> {
        let trajectory = Self::unchecked(row_s, rows_rad, repeat_rows);
        trajectory.check()?;
        Ok(trajectory)
    }

    /// For who checks it later, with the gait that it belongs to.
    pub(super) fn unchecked(
        row_s: f64,
        rows_rad: Vec<Vec<f64>>,
        repeat_rows: Option<Range<usize>>,
    ) -> Self {
        Self {
            row_s,
            rows_rad,
            repeat_rows,
        }
    }

    /// What this gait commands the robot from the stance at gait time 0 until `duration_s`, one
    /// row for each command of the servos.
    ///
    /// Its last rows repeat where they hold whole cycles of the gait.
    ///
    /// # Errors
    /// Those of [`JointCommands::new`].
    pub fn commanded(robot: &Robot, gait: &Gait, duration_s: f64) -> Result<Self, ModelError> {
        let hold_s = robot.servo().command_hold_s;
        let commands = JointCommands::new(robot, gait, duration_s)?;
        let last = (duration_s / hold_s + Self::TOLERANCE).max(1.0) as usize;
        let rows_rad = (0..=last).map(|row| commands.all_rad(row as f64 * hold_s).to_vec());
        let rows_rad: Vec<_> = rows_rad.collect();
        let cycle_rows = gait.cycle_s().and_then(|cycle_s| {
            let rows = (1..=Self::MOST_CYCLES).map(|cycles| cycles as f64 * cycle_s / hold_s);
            let mut whole = rows.filter(|rows| (rows - rows.round()).abs() < Self::TOLERANCE);
            whole.next().map(|rows| rows.round() as usize)
        });
        let steady_row = (gait.steady_from_s() / hold_s - Self::TOLERANCE).ceil();
        let end = rows_rad.len();
        let repeat_rows = cycle_rows
            .and_then(|rows| end.checked_sub(rows))
            .filter(|first| *first as f64 >= steady_row)
            .map(|first| first..end);
        Ok(Self::new(hold_s, rows_rad, repeat_rows)?)
    }

    pub(super) fn check(&self) -> Result<(), SettingError> {
        SettingError::check("row_s", self.row_s, 1e-4..=10.0, "s")?;
        let rows = self.rows_rad.len();
        if rows < 2 {
            let expected = "at least 2 rows";
            return Err(SettingError::new(
                "joints_rad",
                counted(rows, "row"),
                expected,
            ));
        }
        // From the first row to the last.
        let longest_row_s = Self::LONGEST_S / (rows - 1) as f64;
        if self.row_s > longest_row_s {
            let expected = format!(
                "at most {longest_row_s} s for {rows} rows, which last {} s",
                Self::LONGEST_S
            );
            return Err(SettingError::new("row_s", self.row_s, expected));
        }
        let joints = self.joints();
        for (index, row_rad) in self.rows_rad.iter().enumerate() {
            let name = format!("joints_rad[{index}]");
            if row_rad.is_empty() || row_rad.len() != joints {
                let expected = match joints {
                    0 => "the angle of every joint".to_string(),
                    _ => format!("{joints}, as in the first row"),
                };
                let found = counted(row_rad.len(), "angle");
                return Err(SettingError::new(name, found, expected));
            }
            SettingError::check_each(&name, row_rad, Self::ANGLES_RAD, "rad")?;
        }
        let Some(Range { start, end }) = self.repeat_rows else {
            return Ok(());
        };
        SettingError::check("repeat_rows[0]", start, 0..=rows - 1, "")?;
        SettingError::check("repeat_rows[1]", end, start + 1..=rows, "")
    }

    /// Time from one row to the next.
    pub fn row_s(&self) -> f64 {
        self.row_s
    }

    /// Angles of all joints, leg by leg from the body outward, for each row.
    pub fn rows_rad(&self) -> &[Vec<f64>] {
        &self.rows_rad
    }

    /// The rows that repeat, if any do.
    pub fn repeat_rows(&self) -> Option<Range<usize>> {
        self.repeat_rows.clone()
    }

    /// How many joints the robot has.
    pub fn joints(&self) -> usize {
        self.rows_rad.first().map_or(0, Vec::len)
    }

    /// How long the repeating rows take, if any repeat.
    pub(super) fn cycle_s(&self) -> Option<f64> {
        let rows = self.repeat_rows.as_ref()?.len();
        Some(rows as f64 * self.row_s)
    }

    /// When the first of the repeating rows is commanded; the last row where none repeat.
    pub(super) fn steady_from_s(&self) -> f64 {
        let row = match &self.repeat_rows {
            Some(repeated) => repeated.start,
            None => self.rows_rad.len() - 1,
        };
        row as f64 * self.row_s
    }

    pub(super) fn slow_down(&mut self, by: f64) {
        self.row_s *= by;
    }

    /// The angles at gait time `time_s`.
    pub(crate) fn angles_rad(&self, time_s: f64) -> Vec<f64> {
        let rows = (time_s / self.row_s).max(0.0);
        let nearest = libm::round(rows);
        if (rows - nearest).abs() <= Self::TOLERANCE {
            return self.row(nearest as usize).to_vec();
        }
        let before = libm::floor(rows);
        let share = rows - before;
        let (before, after) = (self.row(before as usize), self.row(before as usize + 1));
        let between = before.iter().zip(after);
        between.map(|(a, b)| a + share * (b - a)).collect()
    }

    /// The row commanded as number `number`, counted on through every repetition.
    fn row(&self, number: usize) -> &[f64] {
        let index = match &self.repeat_rows {
            Some(Range { start, end }) if number >= *end => {
                start + (number - start) % (end - start)
            }
            Some(_) => number,
            None => number.min(self.rows_rad.len() - 1),
        };
        &self.rows_rad[index]
    }
}

fn counted(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// One joint whose angle says which row it is.
    fn numbered(repeat_rows: Option<Range<usize>>) -> JointTrajectory {
        let rows = (0..10).map(|row| vec![0.1 * f64::from(row)]).collect();
        JointTrajectory::new(0.02, rows, repeat_rows).unwrap()
    }

    fn row_at(trajectory: &JointTrajectory, time_s: f64) -> f64 {
        trajectory.angles_rad(time_s)[0] / 0.1
    }

    #[test]
    fn it_stands_in_its_first_row_and_ends_in_its_last() {
        let ending = numbered(None);
        for (time_s, row) in [(-5.0, 0.0), (0.0, 0.0), (0.18, 9.0), (0.2, 9.0), (1e9, 9.0)] {
            assert!((row_at(&ending, time_s) - row).abs() < 1e-12, "{time_s}");
        }
        // The control: where rows repeat, it does not stay at the last.
        assert!((row_at(&numbered(Some(4..10)), 0.2) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_trajectory_of_the_commands_repeats_whole_cycles_after_the_ramp() {
        let robot = Robot::jethexa();
        let repeated = |gait: &Gait, duration_s| {
            let trajectory = JointTrajectory::commanded(&robot, gait, duration_s).unwrap();
            (trajectory.rows_rad().len(), trajectory.repeat_rows())
        };
        let tripod = Gait::tripod();
        assert_eq!(repeated(&tripod, 10.0), (501, Some(451..501)));
        // Too short for a cycle after the ramp of one second.
        assert_eq!(repeated(&tripod, 2.0), (101, Some(51..101)));
        assert_eq!(repeated(&tripod, 1.96), (99, None));
        // 52.5 rows: two cycles are a whole number of them.
        let mut slower = Gait::tripod();
        slower.slow_down(1.05);
        assert_eq!(repeated(&slower, 5.0), (251, Some(146..251)));
        // 51.1 rows ten times over.
        slower = Gait::tripod();
        slower.slow_down(1.022);
        assert_eq!(repeated(&slower, 14.0), (701, Some(190..701)));
        slower.slow_down(1.0001);
        assert_eq!(repeated(&slower, 14.0), (701, None));
    }

    proptest! {
        #[test]
        fn rows_repeat_for_ever(number in 0_usize..1000, start in 0_usize..9, length in 1_usize..9) {
            let end = (start + length).min(10);
            let repeating = numbered(Some(start..end));
            let expected = if number < end { number } else { start + (number - end) % (end - start) };
            prop_assert_eq!(repeating.row(number), repeating.row(expected));
            let time_s = number as f64 * 0.02;
            prop_assert!((row_at(&repeating, time_s) - expected as f64).abs() < 1e-9);
        }

        #[test]
        fn angles_change_smoothly_with_time_and_speed(time_s in 0.0..0.17_f64, by in 0.9..1.1_f64) {
            let mut slow = numbered(None);
            slow.slow_down(by);
            let row = row_at(&slow, time_s);
            prop_assert!((row - (time_s / (0.02 * by)).min(9.0)).abs() < 2e-6);
        }
    }
}
