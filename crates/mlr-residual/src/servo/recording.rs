//! What was recorded of a servo on a bench.

use std::io::Read;

use mlr_imu::{LogColumn, LogProblem, LogTable};
use thiserror::Error;

/// Fewest samples of a recording.
const MIN_SAMPLES: usize = 50;
/// Least motion that tells anything of a servo.
const MIN_RANGE_RAD: f64 = 0.05;
/// Longest time without a sample, s: friction cannot be told from what is not seen.
const MAX_GAP_S: f64 = 0.2;

/// Goals and angles of a servo over time.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoRecording {
    /// For people.
    pub name: String,
    /// Time stamps, s, strictly increasing.
    pub times_s: Vec<f64>,
    /// Commanded angle, rad.
    pub goals_rad: Vec<f64>,
    /// Where it says that it is, rad.
    pub positions_rad: Vec<f64>,
    /// Whether its motor has current.
    pub motor_on: Vec<bool>,
    /// Supply voltage, V; empty where it was not recorded.
    pub supply_v: Vec<f64>,
    /// Value of its gain register; empty where it was not recorded.
    pub p_gain: Vec<f64>,
    /// The effort that it says its controller makes, in its own unit; empty where it was not recorded.
    pub load: Vec<f64>,
}

/// Why a recording has no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ServoError {
    /// Time does not run forward.
    #[error(
        "sample {sample}: {time_s} s is not later than the sample before; expected increasing time stamps"
    )]
    Disordered {
        /// Number of the sample, from 1.
        sample: usize,
        /// Its time stamp.
        time_s: f64,
    },
    /// Too few samples.
    #[error("{samples} samples, expected at least {MIN_SAMPLES}")]
    TooShort {
        /// Samples in it.
        samples: usize,
    },
    /// Nothing was recorded for too long.
    #[error(
        "no sample for {gap_s:.2} s after {after_s:.2} s, expected one every {MAX_GAP_S} s or more often"
    )]
    Gap {
        /// How long.
        gap_s: f64,
        /// From when on.
        after_s: f64,
    },
    /// The servo never moves.
    #[error("the servo moves by {range_rad:.3} rad, expected at least {MIN_RANGE_RAD} rad")]
    NoMotion {
        /// Largest less smallest angle.
        range_rad: f64,
    },
    /// A recording changes its gain, and the bench does not say which gain its servo's stiffness is for.
    #[error(
        "p_gain was recorded, but the bench does not say which p_gain the servo's stiffness is for; expected [reference] p_gain in its file"
    )]
    GainWithoutReference,
    /// No simulation of the bench as described stays finite.
    #[error("the simulated pendulum does not stay finite with the servo as described")]
    Diverged,
}

impl ServoError {
    /// Whether a recording cannot answer, rather than the bench being described wrongly.
    pub fn is_recordings_fault(&self) -> bool {
        !matches!(self, Self::GainWithoutReference | Self::Diverged)
    }
}

impl ServoRecording {
    /// Reads `t_s`, `goal_rad` and `position_rad`, and where they are there `torque_enabled` (0 where
    /// the motor has no current), `volts`, `p_gain` and `load`. Other columns are ignored.
    ///
    /// # Errors
    /// [`LogProblem`] naming line and column.
    pub fn from_table(name: String, table: LogTable<impl Read>) -> Result<Self, LogProblem> {
        let optional = ["torque_enabled", "volts", "p_gain", "load"].map(|column| {
            let there = table.names().iter().any(|name| name == column);
            there.then(|| table.find(column)).transpose()
        });
        let [on, volts, gain, load] = optional;
        let optional = [on?, volts?, gain?, load?];
        let mut wanted = vec![
            LogColumn::of_times(table.find("t_s")?, 1.0),
            LogColumn::of_numbers(table.find("goal_rad")?, 1.0),
            LogColumn::of_numbers(table.find("position_rad")?, 1.0),
        ];
        let numbers = optional.iter().flatten();
        wanted.extend(numbers.map(|index| LogColumn::of_numbers(*index, 1.0)));
        let mut columns = table.read(&wanted)?.columns.into_iter();
        let mut next = || columns.next().unwrap_or_default();
        let (times_s, goals_rad, positions_rad) = (next(), next(), next());
        let [on, supply_v, p_gain, load] = optional.map(|there| there.map(|_| next()));
        let motor_on = match on {
            Some(on) => on.into_iter().map(|on| on != 0.0).collect(),
            None => vec![true; times_s.len()],
        };
        Ok(Self {
            name,
            times_s,
            goals_rad,
            positions_rad,
            motor_on,
            supply_v: supply_v.unwrap_or_default(),
            p_gain: p_gain.unwrap_or_default(),
            load: load.unwrap_or_default(),
        })
    }

    /// Checks that it can tell anything.
    ///
    /// # Errors
    /// [`ServoError`] saying what is wrong with it.
    pub fn check(&self) -> Result<(), ServoError> {
        let samples = self.times_s.len();
        if samples < MIN_SAMPLES {
            return Err(ServoError::TooShort { samples });
        }
        for (index, pair) in self.times_s.windows(2).enumerate() {
            let gap_s = pair[1] - pair[0];
            if gap_s.is_nan() || gap_s <= 0.0 {
                return Err(ServoError::Disordered {
                    sample: index + 2,
                    time_s: pair[1],
                });
            }
            if gap_s > MAX_GAP_S {
                return Err(ServoError::Gap {
                    gap_s,
                    after_s: pair[0],
                });
            }
        }
        let angles = self.positions_rad.iter().copied();
        let range_rad =
            angles.clone().fold(f64::NEG_INFINITY, f64::max) - angles.fold(f64::INFINITY, f64::min);
        if range_rad < MIN_RANGE_RAD {
            return Err(ServoError::NoMotion { range_rad });
        }
        Ok(())
    }

    /// From the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        match (self.times_s.first(), self.times_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Smallest change of the reported angle, rad: the step of its encoder where it is coarse.
    pub fn resolution_rad(&self) -> f64 {
        let steps = self.positions_rad.windows(2).map(|w| (w[1] - w[0]).abs());
        let least = steps
            .filter(|step| *step > 1e-9)
            .fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::LogLimits;

    use super::*;

    fn read(text: &str) -> Result<ServoRecording, LogProblem> {
        let table = LogTable::new(text.as_bytes(), LogLimits::default())?;
        ServoRecording::from_table("test".into(), table)
    }

    fn moving() -> ServoRecording {
        let times_s: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01).collect();
        ServoRecording {
            name: "moving".into(),
            goals_rad: times_s.iter().map(|t| t.sin()).collect(),
            positions_rad: times_s.iter().map(|t| (t - 0.05).sin()).collect(),
            motor_on: vec![true; times_s.len()],
            supply_v: Vec::new(),
            p_gain: Vec::new(),
            load: Vec::new(),
            times_s,
        }
    }

    #[test]
    fn columns_are_found_by_name_and_those_that_are_not_needed_may_be_missing() {
        let plain = read("position_rad,t_s,goal_rad\n0.1,0,0.2\n0.2,0.01,0.3\n").unwrap();
        assert_eq!(plain.positions_rad, [0.1, 0.2]);
        assert_eq!(plain.motor_on, [true, true]);
        assert!(plain.supply_v.is_empty() && plain.p_gain.is_empty() && plain.load.is_empty());
        let full = read("t_s,goal_rad,position_rad,load,volts,torque_enabled\n0,0,0,-9,7.4,0\n");
        let full = full.unwrap();
        assert_eq!((full.supply_v, full.motor_on), (vec![7.4], vec![false]));
        assert_eq!(full.load, [-9.0]);
        let error = read("t_s,goal_rad\n0,0\n").unwrap_err().to_string();
        assert!(error.contains("position_rad"), "{error}");
    }

    #[test]
    fn recordings_that_tell_nothing_are_refused() {
        assert_eq!(moving().check(), Ok(()));
        let mut still = moving();
        still.positions_rad.fill(0.3);
        assert!(matches!(still.check(), Err(ServoError::NoMotion { .. })));
        let mut back = moving();
        back.times_s[70] = back.times_s[69];
        assert!(matches!(
            back.check(),
            Err(ServoError::Disordered { sample: 71, .. })
        ));
        let mut gap = moving();
        gap.times_s[100..].iter_mut().for_each(|t| *t += 0.5);
        assert!(matches!(gap.check(), Err(ServoError::Gap { .. })));
        let mut short = moving();
        short.times_s.truncate(20);
        assert_eq!(short.check(), Err(ServoError::TooShort { samples: 20 }));
    }

    #[test]
    fn the_resolution_is_the_smallest_change() {
        let mut coarse = moving();
        let step = 0.0015;
        for angle in &mut coarse.positions_rad {
            *angle = (*angle / step).round() * step;
        }
        assert!((coarse.resolution_rad() - step).abs() < 1e-9);
    }
}
