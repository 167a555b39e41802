//! Which columns of a log hold the rate, the reference angle and what else the
//! same sensor reports.

use mlr_imu::STANDARD_GRAVITY_MPS2;

use super::AxisName;

/// Unit of a time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    Seconds,
    /// Milliseconds.
    Milliseconds,
    /// Microseconds.
    Microseconds,
}

/// Unit of a rate column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateUnit {
    /// °/s.
    DegreesPerSecond,
    /// rad/s.
    RadiansPerSecond,
}

/// Unit of an angle column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleUnit {
    /// Degrees.
    Degrees,
    /// Radians.
    Radians,
}

impl TimeUnit {
    /// What a number of this unit is multiplied by to give s.
    pub fn to_s(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e-3,
            Self::Microseconds => 1e-6,
        }
    }
}

impl RateUnit {
    /// What a number of this unit is multiplied by to give °/s.
    pub fn to_dps(self) -> f64 {
        match self {
            Self::DegreesPerSecond => 1.0,
            Self::RadiansPerSecond => 1.0_f64.to_degrees(),
        }
    }
}

impl AngleUnit {
    /// What a number of this unit is multiplied by to give degrees.
    pub fn to_deg(self) -> f64 {
        match self {
            Self::Degrees => 1.0,
            Self::Radians => 1.0_f64.to_degrees(),
        }
    }
}

/// The columns of a sensor's log.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorColumns {
    /// Name and unit of the time stamps.
    pub time: (String, TimeUnit),
    /// Name and unit of the gyroscope's rate.
    pub rate: (String, RateUnit),
    /// Name and unit of the measured angle.
    pub angle: (String, AngleUnit),
    /// +1, or -1 where the reported rate is negative while the angle grows.
    pub sign: f64,
}

/// Columns of the same sensor, recognised by their names.
#[derive(Debug, Default)]
pub(super) struct Siblings {
    pub(super) axis: Option<AxisName>,
    /// Index of the column of each other axis.
    pub(super) cross: Vec<(AxisName, usize)>,
    /// Indices of the columns along x, y, z, and their scale to g.
    pub(super) accelerations: Option<([usize; 3], f64)>,
    /// Index of the column.
    pub(super) temperature: Option<usize>,
}

impl Siblings {
    /// Finds the other columns of the sensor whose rate is in the column `rate`:
    /// the names that differ from it in the letter of the axis, those that have a
    /// for g and `_g` or `_mps2` for the unit besides, and `temperature_c`.
    pub(super) fn find(header: &[impl AsRef<str>], rate: &str) -> Self {
        let position = |name: &str| {
            let mut found = header
                .iter()
                .enumerate()
                .filter(|(_, h)| h.as_ref() == name);
            match (found.next(), found.next()) {
                (Some((index, _)), None) => Some(index),
                _ => None,
            }
        };
        let mut siblings = Self {
            temperature: position("temperature_c"),
            ..Self::default()
        };
        let stem = rate
            .strip_suffix("_dps")
            .or_else(|| rate.strip_suffix("_radps"))
            .unwrap_or(rate);
        let suffix = &rate[stem.len()..];
        for axis in AxisName::ALL {
            let Some(place) = stem.rfind(axis.letter()) else {
                continue;
            };
            let named = |stem: &str, other: AxisName, suffix: &str| {
                let mut name = stem.to_string();
                name.replace_range(place..=place, &other.letter().to_string());
                name + suffix
            };
            let others = [axis.next(), axis.next().next()];
            let cross: Vec<_> = others
                .into_iter()
                .filter_map(|other| Some((other, position(&named(stem, other, suffix))?)))
                .collect();
            if cross.len() != others.len() {
                continue;
            }
            siblings.axis = Some(axis);
            siblings.cross = cross;
            let stem = stem.replacen('g', "a", 1);
            siblings.accelerations = [("_g", 1.0), ("_mps2", 1.0 / STANDARD_GRAVITY_MPS2)]
                .into_iter()
                .find_map(|(suffix, scale)| {
                    let [x, y, z] = AxisName::ALL.map(|axis| position(&named(&stem, axis, suffix)));
                    Some(([x?, y?, z?], scale))
                });
            break;
        }
        siblings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_columns_of_the_same_sensor_are_known_by_name() {
        let header = [
            "t_s", "g1x_dps", "g2x_dps", "g2y_dps", "g2z_dps", "a2x_g", "a2y_g", "a2z_g",
        ];
        let siblings = Siblings::find(&header, "g2y_dps");
        assert_eq!(siblings.axis, Some(AxisName::Y));
        assert_eq!(siblings.cross, [(AxisName::Z, 4), (AxisName::X, 2)]);
        assert_eq!(siblings.accelerations, Some(([5, 6, 7], 1.0)));
        assert!(Siblings::find(&header, "g1x_dps").cross.is_empty());

        let header = [
            "t_s", "ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps",
        ];
        let siblings = Siblings::find(&header, "gz_radps");
        let (columns, scale) = siblings.accelerations.unwrap();
        assert_eq!(columns, [1, 2, 3]);
        assert!((scale * 9.80665 - 1.0).abs() < 1e-12);
    }
}
