//! `mlr.read_log`.

use std::path::PathBuf;

use anyhow::Context;
use mlr_filter::SettingError;
use mlr_imu::{Columns, LogError, LogLimits, LogTable, OrientationSource, Recording};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::{
    Bound, FromPyObject, PyResult, Python, pyfunction,
    types::{PyDict, PyDictMethods},
};

use crate::running::Running;

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    column: Vec<String>,
    topic: Option<String>,
    max_rows: Option<i64>,
}

/// The columns of a log under the names of the arguments that take them.
#[pyfunction]
pub(crate) fn read_log<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: Options,
    running: Running,
) -> PyResult<Bound<'py, PyDict>> {
    let log = path.display().to_string();
    let recording = running.run(py, move |_| options.read(path))?;
    let columns = PyDict::new(py);
    columns.set_item(
        "t",
        recording.orientation.times_s().to_vec().into_pyarray(py),
    )?;
    // What was fused here is fused again, once the mounting is known.
    if recording.source == OrientationSource::Recorded {
        let angles = recording.orientation.angles_rad();
        columns.set_item("roll", angles.roll.clone().into_pyarray(py))?;
        columns.set_item("pitch", angles.pitch.clone().into_pyarray(py))?;
        columns.set_item("yaw", angles.yaw.clone().into_pyarray(py))?;
    }
    if let Some(raw) = &recording.raw {
        for (name, vectors) in [
            ("acceleration", &raw.accelerations_mps2),
            ("angular_rate", &raw.angular_rates_radps),
        ] {
            let flat = vectors.iter().flat_map(|v| [v.x, v.y, v.z]);
            let flat = flat.collect::<Vec<f64>>().into_pyarray(py);
            let vectors: Bound<'_, PyArray2<f64>> = flat.reshape([vectors.len(), 3])?;
            columns.set_item(name, vectors)?;
        }
    }
    columns.set_item("in_body_axes", recording.in_body_axes)?;
    columns.set_item("notes", recording.notes)?;
    columns.set_item("log", log)?;
    Ok(columns)
}

impl Options {
    fn read(&self, path: PathBuf) -> anyhow::Result<Recording> {
        let mut columns = Columns::default();
        for mapping in &self.column {
            columns.rename(mapping).context("column")?;
        }
        let mut limits = LogLimits::default();
        if let Some(rows) = self.max_rows {
            let max_rows = u64::try_from(rows);
            limits.max_rows = max_rows
                .map_err(|_| SettingError::new("max_rows", rows, "a whole number from 0 on"))?;
        }
        let table = LogTable::open(&path, self.topic.as_deref(), limits);
        let read = table.and_then(|table| Recording::from_table(table, &columns));
        Ok(read.map_err(|problem| LogError { path, problem })?)
    }
}
