//! Which column of a log holds what, and in which unit.

use thiserror::Error;

/// The columns of time, roll, pitch and yaw. The defaults are the names that
/// this project writes: `t_s`, `roll_rad`, `pitch_rad`, `yaw_rad`.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    pub(super) time: Column,
    pub(super) roll: Column,
    pub(super) pitch: Column,
    pub(super) yaw: Column,
}

/// One column: its name in the file and what its numbers are multiplied by to
/// give seconds or radians.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) scale: f64,
}

/// A `--column` argument that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{argument:?} is not a column, expected {expected}")]
pub struct ColumnError {
    argument: String,
    expected: &'static str,
}

impl Default for Columns {
    fn default() -> Self {
        let column = |name: &str| Column {
            name: name.into(),
            scale: 1.0,
        };
        Self {
            time: column("t_s"),
            roll: column("roll_rad"),
            pitch: column("pitch_rad"),
            yaw: column("yaw_rad"),
        }
    }
}

impl Columns {
    /// Maps a foreign name: `roll=NAME,deg`. The quantity is `t`, `roll`,
    /// `pitch` or `yaw`; the unit `s`, `ms`, `us` or `ns` for time, `rad` or
    /// `deg` for angles. Without a unit, seconds and radians.
    ///
    /// # Errors
    /// [`ColumnError`] saying what was expected.
    pub fn rename(&mut self, argument: &str) -> Result<(), ColumnError> {
        let error = |expected| ColumnError {
            argument: argument.into(),
            expected,
        };
        let (quantity, source) = argument
            .split_once('=')
            .ok_or_else(|| error("QUANTITY=NAME or QUANTITY=NAME,UNIT"))?;
        let (name, unit) = match source.rsplit_once(',') {
            Some((name, unit)) => (name.trim(), Some(unit.trim())),
            None => (source.trim(), None),
        };
        if name.is_empty() {
            return Err(error("a name after the equals sign"));
        }
        let (column, scale) = match quantity.trim() {
            "t" => (
                &mut self.time,
                match unit {
                    None | Some("s") => Some(1.0),
                    Some("ms") => Some(1e-3),
                    Some("us") => Some(1e-6),
                    Some("ns") => Some(1e-9),
                    Some(_) => None,
                }
                .ok_or_else(|| error("one of the units s, ms, us, ns"))?,
            ),
            angle => {
                let column = match angle {
                    "roll" => &mut self.roll,
                    "pitch" => &mut self.pitch,
                    "yaw" => &mut self.yaw,
                    _ => return Err(error("one of the quantities t, roll, pitch, yaw")),
                };
                let scale = match unit {
                    None | Some("rad") => 1.0,
                    Some("deg") => 1.0_f64.to_radians(),
                    Some(_) => return Err(error("one of the units rad, deg")),
                };
                (column, scale)
            }
        };
        *column = Column {
            name: name.into(),
            scale,
        };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_names_and_units() {
        let mut columns = Columns::default();
        columns.rename("roll=euler.x,deg").unwrap();
        columns.rename("t=stamp,ns").unwrap();
        columns.rename("yaw=heading").unwrap();
        assert_eq!(columns.roll.name, "euler.x");
        assert!((columns.roll.scale - 0.017_453_292_519_943_295).abs() < 1e-18);
        assert_eq!(columns.time.scale, 1e-9);
        assert_eq!(columns.yaw.scale, 1.0);
    }

    #[test]
    fn nonsense_says_what_was_expected() {
        let mut columns = Columns::default();
        for (argument, expected) in [
            ("roll", "QUANTITY=NAME"),
            ("height=z", "quantities"),
            ("roll=x,grad", "rad, deg"),
            ("t=x,deg", "units s"),
            ("roll=", "a name"),
        ] {
            let message = columns.rename(argument).unwrap_err().to_string();
            assert!(message.contains(expected), "{argument}: {message}");
        }
        assert_eq!(columns, Columns::default());
    }
}
