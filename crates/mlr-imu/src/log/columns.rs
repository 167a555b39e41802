//! Which column of a log holds what, and in which unit.

use thiserror::Error;

use crate::STANDARD_GRAVITY_MPS2;

/// What a column can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Angle,
    Acceleration,
    Rate,
    /// An element of a quaternion, which has no unit.
    Element,
}

impl Quantity {
    /// Units by name and what their numbers are multiplied by to give s, rad,
    /// m/s² or rad/s; the first is the default.
    pub(super) fn units(self) -> &'static [(&'static str, f64)] {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        match self {
            Self::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
            Self::Angle => &[("rad", 1.0), ("deg", DEGREE)],
            Self::Acceleration => &[("mps2", 1.0), ("g", STANDARD_GRAVITY_MPS2)],
            Self::Rate => &[("radps", 1.0), ("dps", DEGREE)],
            Self::Element => &[],
        }
    }
}

/// One column: its name in the file and the scale of its numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    /// What it is called in a `--column` argument.
    pub(super) key: &'static str,
    pub(super) quantity: Quantity,
    pub(super) name: String,
    pub(super) scale: f64,
    /// Whether the name is that of a `--column` argument.
    pub(super) is_mapped: bool,
}

impl Column {
    fn new(key: &'static str, quantity: Quantity, name: &str) -> Self {
        Self {
            key,
            quantity,
            name: name.into(),
            scale: 1.0,
            is_mapped: false,
        }
    }
}

/// The columns of a log. The defaults are the names that this project writes:
/// `t_s`; `roll_rad`, `pitch_rad`, `yaw_rad`; and of raw samples `ax_mps2`,
/// `ay_mps2`, `az_mps2`, `gx_radps`, `gy_radps`, `gz_radps`. The elements of a quaternion are
/// looked for as `qw`, `qx`, `qy`, `qz`.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    pub(super) time: Column,
    /// Roll, pitch, yaw.
    pub(super) angles: [Column; 3],
    /// w, x, y, z of the rotation from body to world.
    pub(super) quaternion: [Column; 4],
    /// Acceleration along x, y, z, then rate about x, y, z.
    pub(super) raw: [Column; 6],
}

/// What is wrong with how a column was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Correction {
    /// It is in this unit.
    Unit(&'static str),
    /// Its sign is the other one.
    Sign,
}

/// A `--column` argument that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{argument:?} is not a column, expected {expected}")]
pub struct ColumnError {
    argument: String,
    expected: String,
}

impl Default for Columns {
    fn default() -> Self {
        use Quantity::{Acceleration, Angle, Element, Rate, Time};
        Self {
            time: Column::new("t", Time, "t_s"),
            angles: [
                Column::new("roll", Angle, "roll_rad"),
                Column::new("pitch", Angle, "pitch_rad"),
                Column::new("yaw", Angle, "yaw_rad"),
            ],
            quaternion: ["qw", "qx", "qy", "qz"].map(|key| Column::new(key, Element, key)),
            raw: [
                Column::new("ax", Acceleration, "ax_mps2"),
                Column::new("ay", Acceleration, "ay_mps2"),
                Column::new("az", Acceleration, "az_mps2"),
                Column::new("gx", Rate, "gx_radps"),
                Column::new("gy", Rate, "gy_radps"),
                Column::new("gz", Rate, "gz_radps"),
            ],
        }
    }
}

impl Columns {
    /// Maps a foreign name: `roll=NAME,deg`. The quantity is `t`, `roll`, `pitch`,
    /// `yaw`, `qw`, `qx`, `qy`, `qz`, `ax`, `ay`, `az`, `gx`, `gy` or `gz`; the unit `s`, `ms`,
    /// `us` or `ns` for time, `rad` or `deg` for angles, `mps2` or `g` for accelerations, `radps`
    /// or `dps` for rates. Without a unit, the first of these.
    ///
    /// A minus before the name turns the sign of the numbers: `ay=-ay_mps2`, `az=-az_mps2`,
    /// `gy=-gy_radps` and `gz=-gz_radps` make a body frame with z up of one with z down.
    ///
    /// # Errors
    /// [`ColumnError`] saying what was expected.
    pub fn rename(&mut self, argument: &str) -> Result<(), ColumnError> {
        let error = |expected: String| ColumnError {
            argument: argument.into(),
            expected,
        };
        let (key, source) = argument
            .split_once('=')
            .ok_or_else(|| error("QUANTITY=NAME, QUANTITY=NAME,UNIT or QUANTITY=-NAME".into()))?;
        let (name, unit) = match source.rsplit_once(',') {
            Some((name, unit)) => (name.trim(), Some(unit.trim())),
            None => (source.trim(), None),
        };
        let (name, sign) = match name.strip_prefix('-') {
            Some(name) => (name.trim(), -1.0),
            None => (name, 1.0),
        };
        if name.is_empty() {
            return Err(error("a name after the equals sign".into()));
        }
        let keys = listed(self.all().map(|column| column.key));
        let column = self
            .all_mut()
            .find(|column| column.key == key.trim())
            .ok_or_else(|| error(format!("one of the quantities {keys}")))?;
        if sign < 0.0 && column.quantity == Quantity::Time {
            return Err(error("no sign: time runs forward".into()));
        }
        let units = column.quantity.units();
        let scale = match (unit, units) {
            (None, []) => 1.0,
            (None, [(_, scale), ..]) => *scale,
            (Some(_), []) => return Err(error("no unit: a quaternion has none".into())),
            (Some(unit), units) => units
                .iter()
                .find(|(name, _)| *name == unit)
                .map(|(_, scale)| *scale)
                .ok_or_else(|| {
                    let names = listed(units.iter().map(|(name, _)| *name));
                    error(format!("one of the units {names}"))
                })?,
        };
        column.name = name.into();
        column.scale = sign * scale;
        column.is_mapped = true;
        Ok(())
    }

    /// The `--column` argument that reads the quantity `key` (as in `roll`) from where it is
    /// read now, but in another unit, or with the other sign. `None` for unknown keys.
    pub fn corrected(&self, key: &str, correction: Correction) -> Option<String> {
        let column = self.all().find(|column| column.key == key)?;
        let units = column.quantity.units();
        let now = units
            .iter()
            .find(|(_, scale)| *scale == column.scale.abs())
            .map_or("", |(name, _)| *name);
        let (sign, unit) = match correction {
            Correction::Unit(unit) => (column.scale < 0.0, unit),
            Correction::Sign => (column.scale > 0.0, now),
        };
        let sign = if sign { "-" } else { "" };
        let name = &column.name;
        Some(as_typed(&match units.first() {
            Some((default, _)) if *default == unit => format!("{key}={sign}{name}"),
            _ => format!("{key}={sign}{name},{unit}"),
        }))
    }

    /// Whether a column of this name is one of these.
    pub fn has(&self, name: &str) -> bool {
        let folded = name.to_lowercase();
        self.all()
            .any(|column| column.name.to_lowercase() == folded)
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &Column> {
        std::iter::once(&self.time)
            .chain(&self.angles)
            .chain(&self.quaternion)
            .chain(&self.raw)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Column> {
        std::iter::once(&mut self.time)
            .chain(&mut self.angles)
            .chain(&mut self.quaternion)
            .chain(&mut self.raw)
    }
}

/// A mapping as a person types it: what a shell would take apart is quoted.
pub(super) fn as_typed(mapping: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "=,._/-:%+@".contains(c);
    if mapping.chars().all(is_plain) {
        format!("--column {mapping}")
    } else {
        format!("--column '{}'", mapping.replace('\'', "'\\''"))
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
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
        columns.rename("az=acc_z,g").unwrap();
        assert_eq!(columns.angles[0].name, "euler.x");
        assert!((columns.angles[0].scale - 0.017_453_292_519_943_295).abs() < 1e-18);
        assert_eq!(columns.time.scale, 1e-9);
        assert_eq!(columns.angles[2].scale, 1.0);
        assert_eq!(columns.raw[2].scale, 9.806_65);
        columns.rename("qx=orientation.x").unwrap();
        assert_eq!(columns.quaternion[1].name, "orientation.x");
    }

    #[test]
    fn a_minus_turns_the_sign() {
        let mut columns = Columns::default();
        columns.rename("ay=-ay_mps2").unwrap();
        columns.rename("az=-a-z,g").unwrap();
        assert_eq!(
            (columns.raw[1].name.as_str(), columns.raw[1].scale),
            ("ay_mps2", -1.0)
        );
        assert_eq!(
            (columns.raw[2].name.as_str(), columns.raw[2].scale),
            ("a-z", -9.806_65)
        );
    }

    #[test]
    fn a_correction_is_an_argument_that_can_be_typed() {
        let mut columns = Columns::default();
        columns.rename("roll=euler.x").unwrap();
        let corrected = |key, correction| columns.corrected(key, correction).unwrap();
        assert_eq!(
            corrected("roll", Correction::Unit("deg")),
            "--column roll=euler.x,deg"
        );
        assert_eq!(corrected("ay", Correction::Sign), "--column ay=-ay_mps2");
        assert_eq!(columns.corrected("height", Correction::Sign), None);
    }

    #[test]
    fn nonsense_says_what_was_expected() {
        let mut columns = Columns::default();
        for (argument, expected) in [
            ("roll", "QUANTITY=NAME"),
            ("height=z", "quantities t, roll, pitch"),
            ("roll=x,grad", "units rad, deg"),
            ("t=x,deg", "units s, ms"),
            ("gx=x,g", "units radps, dps"),
            ("roll=", "a name"),
            ("roll=-", "a name"),
            ("t=-time", "time runs forward"),
            ("qw=w,rad", "a quaternion has none"),
        ] {
            let message = columns.rename(argument).unwrap_err().to_string();
            assert!(message.contains(expected), "{argument}: {message}");
        }
        assert_eq!(columns, Columns::default());
    }
}
