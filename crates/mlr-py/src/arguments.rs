//! What the Python package hands over.

use std::path::PathBuf;

use mlr_filter::{Axes, SettingError};
use mlr_ga::{LARGEST_SEED, Search};
use mlr_imu::{Mounting, Recording};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::FromPyObject;
use serde::de::{DeserializeOwned, value::StrDeserializer};

/// The samples of a recording.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Columns<'py> {
    t: PyReadonlyArray1<'py, f64>,
    roll: Option<PyReadonlyArray1<'py, f64>>,
    pitch: Option<PyReadonlyArray1<'py, f64>>,
    yaw: Option<PyReadonlyArray1<'py, f64>>,
    acceleration: Option<PyReadonlyArray2<'py, f64>>,
    angular_rate: Option<PyReadonlyArray2<'py, f64>>,
    in_body_axes: bool,
    notes: Vec<String>,
    log: String,
}

/// A recording that has been copied from arrays, and its name.
#[derive(Debug)]
pub(crate) struct Named {
    pub(crate) log: String,
    columns: Copied,
}

#[derive(Debug)]
struct Copied {
    times_s: Vec<f64>,
    angles_rad: Option<Axes<Vec<f64>>>,
    raw: Option<[Vec<f64>; 6]>,
    in_body_axes: bool,
    notes: Vec<String>,
}

impl Columns<'_> {
    /// A copy that needs no interpreter.
    pub(crate) fn copied(self) -> Named {
        let numbers = |array: &PyReadonlyArray1<'_, f64>| array.as_array().to_vec();
        let angles_rad = match (&self.roll, &self.pitch, &self.yaw) {
            (Some(roll), Some(pitch), Some(yaw)) => Some(Axes {
                roll: numbers(roll),
                pitch: numbers(pitch),
                yaw: numbers(yaw),
            }),
            _ => None,
        };
        let raw = match (&self.acceleration, &self.angular_rate) {
            (Some(acceleration), Some(rate)) => {
                let [ax, ay, az] = xyz(acceleration);
                let [gx, gy, gz] = xyz(rate);
                Some([ax, ay, az, gx, gy, gz])
            }
            _ => None,
        };
        Named {
            log: self.log,
            columns: Copied {
                times_s: numbers(&self.t),
                angles_rad,
                raw,
                in_body_axes: self.in_body_axes,
                notes: self.notes,
            },
        }
    }
}

/// The columns of vectors: the package has checked that there are three.
fn xyz(vectors: &PyReadonlyArray2<'_, f64>) -> [Vec<f64>; 3] {
    let vectors = vectors.as_array();
    [0, 1, 2].map(|axis| vectors.column(axis).to_vec())
}

impl Named {
    /// The recording, in the axes of a robot that its sensor is mounted on like this.
    pub(crate) fn recording(self, mounting: &Mounting) -> anyhow::Result<Recording> {
        let Copied {
            times_s,
            angles_rad,
            raw,
            in_body_axes,
            mut notes,
        } = self.columns;
        let recording = Recording::from_columns(times_s, angles_rad, raw)?;
        notes.extend(recording.notes);
        let recording = Recording {
            in_body_axes,
            notes,
            ..recording
        };
        Ok(recording.mounted(mounting)?)
    }
}

/// Robot and gaits from files.
#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ModelFiles {
    pub(crate) robot: Option<PathBuf>,
    pub(crate) gait: Vec<PathBuf>,
}

/// One of the names that a setting can have.
pub(crate) fn named<T: DeserializeOwned>(
    setting: &str,
    name: Option<&str>,
    expected: &str,
) -> Result<Option<T>, SettingError> {
    name.map(|name| {
        let read: Result<T, serde::de::value::Error> = T::deserialize(StrDeserializer::new(name));
        read.map_err(|_| SettingError::new(setting, format!("{name:?}"), expected))
    })
    .transpose()
}

pub(crate) fn search(name: Option<&str>) -> Result<Option<Search>, SettingError> {
    named("search", name, "ga, exact or atlas")
}

/// A seed, which no negative number is.
pub(crate) fn seed(seed: i64) -> Result<u64, SettingError> {
    let most = i64::try_from(LARGEST_SEED).unwrap_or(i64::MAX);
    SettingError::check("seed", seed, 0..=most, "")?;
    Ok(u64::try_from(seed).unwrap_or_default())
}

/// A number of things.
pub(crate) fn count(setting: &str, count: i64) -> Result<usize, SettingError> {
    usize::try_from(count)
        .map_err(|_| SettingError::new(setting, count, "a whole number from 1 on"))
}
