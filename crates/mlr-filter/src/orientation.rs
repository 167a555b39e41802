//! Roll, pitch and yaw over time.

use thiserror::Error;

/// One value for each of roll, pitch and yaw: rotations about x, y and z of the
/// REP-103 body frame, with `R = Rz(yaw) Ry(pitch) Rx(roll)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Axes<T> {
    /// About x (forward): positive lowers the right side.
    pub roll: T,
    /// About y (left): positive lowers the front.
    pub pitch: T,
    /// About z (up): positive turns left.
    pub yaw: T,
}

/// Which of the three rotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// About x.
    Roll,
    /// About y.
    Pitch,
    /// About z.
    Yaw,
}

impl Axis {
    /// Lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Roll => "roll",
            Self::Pitch => "pitch",
            Self::Yaw => "yaw",
        }
    }
}

impl<T> Axes<T> {
    /// One value per axis, in the order roll, pitch, yaw.
    pub fn from_fn(mut f: impl FnMut(Axis) -> T) -> Self {
        Self {
            roll: f(Axis::Roll),
            pitch: f(Axis::Pitch),
            yaw: f(Axis::Yaw),
        }
    }

    /// Borrows each value.
    pub fn as_ref(&self) -> Axes<&T> {
        Axes {
            roll: &self.roll,
            pitch: &self.pitch,
            yaw: &self.yaw,
        }
    }

    /// Applies `f` to each axis.
    pub fn map<U>(self, mut f: impl FnMut(Axis, T) -> U) -> Axes<U> {
        Axes {
            roll: f(Axis::Roll, self.roll),
            pitch: f(Axis::Pitch, self.pitch),
            yaw: f(Axis::Yaw, self.yaw),
        }
    }

    /// The values in the order roll, pitch, yaw.
    pub fn into_array(self) -> [T; 3] {
        [self.roll, self.pitch, self.yaw]
    }
}

impl<T> Axes<Vec<T>> {
    /// Appends one sample of each axis.
    pub fn push(&mut self, sample: Axes<T>) {
        self.roll.push(sample.roll);
        self.pitch.push(sample.pitch);
        self.yaw.push(sample.yaw);
    }
}

/// The angle equal to `angle_rad` up to full turns that lies nearest to
/// `previous_rad`: continues an angle across the seam at ±π.
pub fn unwrapped_rad(previous_rad: f64, angle_rad: f64) -> f64 {
    const TURN: f64 = std::f64::consts::TAU;
    angle_rad + ((previous_rad - angle_rad) / TURN).round() * TURN
}

/// Samples of roll, pitch and yaw with a time stamp each.
///
/// The three axes and the time stamps have the same length and every number is
/// finite. Time stamps are as recorded: not necessarily even, nor increasing.
#[derive(Debug, Clone, PartialEq)]
pub struct OrientationSeries {
    times_s: Vec<f64>,
    angles_rad: Axes<Vec<f64>>,
}

/// Samples that do not make an [`OrientationSeries`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SeriesError {
    /// The columns differ in length.
    #[error("{times} time stamps but {samples} samples of {axis}")]
    Length {
        /// Number of time stamps.
        times: usize,
        /// Name of the axis that differs.
        axis: &'static str,
        /// Its number of samples.
        samples: usize,
    },
    /// A number is infinite or not a number.
    #[error("sample {index} of {column} is {value}, expected a finite number")]
    NotFinite {
        /// Index from 0.
        index: usize,
        /// "time", or the name of the axis.
        column: &'static str,
        /// What was found.
        value: f64,
    },
}

impl OrientationSeries {
    /// Checks lengths and finiteness.
    ///
    /// # Errors
    /// [`SeriesError`] naming the offending column.
    pub fn new(times_s: Vec<f64>, angles_rad: Axes<Vec<f64>>) -> Result<Self, SeriesError> {
        check_finite("time", &times_s)?;
        let named = angles_rad
            .as_ref()
            .map(|axis, samples| (axis.name(), samples));
        for (axis, samples) in named.into_array() {
            if samples.len() != times_s.len() {
                return Err(SeriesError::Length {
                    times: times_s.len(),
                    axis,
                    samples: samples.len(),
                });
            }
            check_finite(axis, samples)?;
        }
        Ok(Self {
            times_s,
            angles_rad,
        })
    }

    /// The samples of these indices, in this order; indices beyond the end are left out.
    #[must_use]
    pub fn picked(&self, indices: &[usize]) -> Self {
        let pick = |values: &[f64]| {
            indices
                .iter()
                .filter_map(|&index| values.get(index).copied())
                .collect::<Vec<f64>>()
        };
        Self {
            times_s: pick(&self.times_s),
            angles_rad: self.angles_rad.as_ref().map(|_, samples| pick(samples)),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// Time stamps in seconds.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The angles in radians.
    pub fn angles_rad(&self) -> &Axes<Vec<f64>> {
        &self.angles_rad
    }
}

fn check_finite(column: &'static str, values: &[f64]) -> Result<(), SeriesError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(SeriesError::NotFinite {
            index,
            column,
            value: values[index],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unwrapping_follows_across_the_seam() {
        let turned = unwrapped_rad(3.1, -3.1);
        assert!((turned - (std::f64::consts::TAU - 3.1)).abs() < 1e-12);
        assert_eq!(unwrapped_rad(0.1, 0.2), 0.2);
    }
}
