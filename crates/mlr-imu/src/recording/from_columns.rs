//! A recording from columns of numbers, wherever they were read.

use mlr_filter::{Axes, OrientationSeries, SeriesError};
use nalgebra::Vector3;

use super::{OrientationSource, Recording};
use crate::{RawSeries, log::unwrapped};

/// Share of the rows that may lack raw samples beside an orientation.
const MAX_MISSING_RAW_SHARE: f64 = 0.01;
/// Names of the raw columns in errors.
const RAW: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

impl Recording {
    /// A recording of roll, pitch and yaw in rad, of the six raw columns of accelerometer (m/s², x, y, z)
    /// and gyroscope (rad/s, x, y, z), or of both; time stamps in seconds, taken as they are.
    ///
    /// Angles that jump by a turn at ±π or 2π are unwrapped. Without angles, they are fused from the raw
    /// samples ([`RawSeries::fuse`]). Raw samples beside angles may be missing in a few rows, where they
    /// are not finite: those before them are taken, and a note tells.
    ///
    /// # Errors
    /// [`SeriesError`] when columns differ in length, or a number that is needed is not finite.
    pub fn from_columns(
        times_s: Vec<f64>,
        angles_rad: Option<Axes<Vec<f64>>>,
        raw: Option<[Vec<f64>; 6]>,
    ) -> Result<Self, SeriesError> {
        if let Some(columns) = &raw {
            check_lengths(times_s.len(), columns)?;
        }
        let Some(angles_rad) = angles_rad else {
            let columns = raw.unwrap_or_default();
            check_finite(&columns)?;
            let raw = raw_series(times_s, columns);
            return Ok(Self {
                raw: Some(raw.clone()),
                source: OrientationSource::Fused,
                ..Self::from(raw.fuse()?)
            });
        };
        let (raw, note) = match raw {
            Some(columns) => without_gaps(columns),
            None => (None, None),
        };
        let raw = raw.map(|columns| raw_series(times_s.clone(), columns));
        Ok(Self {
            raw,
            notes: note.into_iter().collect(),
            ..Self::from(OrientationSeries::new(times_s, unwrapped(angles_rad))?)
        })
    }
}

fn check_lengths(times: usize, columns: &[Vec<f64>; 6]) -> Result<(), SeriesError> {
    match columns.iter().zip(RAW).find(|(c, _)| c.len() != times) {
        Some((column, axis)) => Err(SeriesError::Length {
            times,
            axis,
            samples: column.len(),
        }),
        None => Ok(()),
    }
}

fn check_finite(columns: &[Vec<f64>; 6]) -> Result<(), SeriesError> {
    let not_finite = columns.iter().zip(RAW).find_map(|(values, column)| {
        let index = values.iter().position(|value| !value.is_finite())?;
        Some(SeriesError::NotFinite {
            index,
            column,
            value: values[index],
        })
    });
    not_finite.map_or(Ok(()), Err)
}

fn raw_series(times_s: Vec<f64>, [ax, ay, az, gx, gy, gz]: [Vec<f64>; 6]) -> RawSeries {
    RawSeries {
        times_s,
        accelerations_mps2: vectors(ax, ay, az),
        angular_rates_radps: vectors(gx, gy, gz),
    }
}

fn vectors(x: Vec<f64>, y: Vec<f64>, z: Vec<f64>) -> Vec<Vector3<f64>> {
    let yz = y.into_iter().zip(z);
    x.into_iter()
        .zip(yz)
        .map(|(x, (y, z))| Vector3::new(x, y, z))
        .collect()
}

/// Columns in which a number that is missing is the one before it; `None` if too many are. The
/// note tells of either.
fn without_gaps(mut columns: [Vec<f64>; 6]) -> (Option<[Vec<f64>; 6]>, Option<String>) {
    let rows = columns[0].len();
    let is_missing = |row: &usize| columns.iter().any(|column| !column[*row].is_finite());
    let missing = (0..rows).filter(is_missing).count();
    if missing == 0 {
        return (Some(columns), None);
    }
    let note = format!("{missing} of {rows} rows have no raw samples");
    if missing as f64 > MAX_MISSING_RAW_SHARE * rows as f64 {
        return (None, Some(format!("{note}; none are used")));
    }
    for column in &mut columns {
        let first = column.iter().copied().find(|x| x.is_finite());
        let mut before = first.unwrap_or_default();
        for value in column {
            if !value.is_finite() {
                *value = before;
            }
            before = *value;
        }
    }
    (
        Some(columns),
        Some(format!("{note}; those before them are taken")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 200;

    fn times_s() -> Vec<f64> {
        (0..ROWS).map(|i| i as f64 * 0.01).collect()
    }

    fn angles_rad(rows: usize) -> Axes<Vec<f64>> {
        Axes::from_fn(|_| vec![0.1; rows])
    }

    fn raw() -> [Vec<f64>; 6] {
        let mut columns = [(); 6].map(|()| vec![0.0; ROWS]);
        columns[2] = vec![9.81; ROWS];
        columns
    }

    #[test]
    fn raw_samples_alone_are_fused_and_must_all_be_there() {
        let fused = Recording::from_columns(times_s(), None, Some(raw())).unwrap();
        assert_eq!(fused.source, OrientationSource::Fused);
        assert!(fused.raw_beside_angles().is_none());
        let mut gap = raw();
        gap[4][7] = f64::NAN;
        let error = Recording::from_columns(times_s(), None, Some(gap)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "sample 7 of gy is NaN, expected a finite number"
        );
    }

    #[test]
    fn a_few_raw_samples_may_be_missing_beside_angles() {
        let with_missing = |rows: usize| {
            let mut columns = raw();
            columns[2][..rows].fill(f64::INFINITY);
            Recording::from_columns(times_s(), Some(angles_rad(ROWS)), Some(columns)).unwrap()
        };
        let few = with_missing(2);
        assert_eq!(few.raw.unwrap().accelerations_mps2[0].z, 9.81);
        assert!(few.notes[0].contains("2 of 200 rows"), "{:?}", few.notes);
        let many = with_missing(3);
        assert!(many.raw.is_none() && many.notes[0].contains("none are used"));
    }

    #[test]
    fn columns_of_other_lengths_are_named() {
        let message = |angles, raw| {
            let read = Recording::from_columns(times_s(), angles, raw);
            read.unwrap_err().to_string()
        };
        let mut short = raw();
        short[1].pop();
        assert_eq!(
            message(Some(angles_rad(ROWS)), Some(short)),
            "200 time stamps but 199 samples of ay"
        );
        assert_eq!(
            message(Some(angles_rad(ROWS - 1)), None),
            "200 time stamps but 199 samples of roll"
        );
    }
}
