//! `mlr.detect`.

use std::path::PathBuf;

use mlr_ga::{Configuration, DetectionReport, DetectionSettings, detect as detect_in};
use pyo3::{FromPyObject, PyResult, Python, pyfunction};

use crate::{
    arguments::{Columns, Named},
    failure::blame,
    identification::method,
    running::Running,
};

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    method: Option<String>,
    config: Option<PathBuf>,
}

/// The answer of `mlr-ga detect --json`.
#[pyfunction]
pub(crate) fn detect(
    py: Python<'_>,
    recording: Columns<'_>,
    options: Options,
    running: Running,
) -> PyResult<String> {
    let log = recording.copied();
    running.run(py, move |_| {
        Ok(serde_json::to_string(&options.answer(log)?)?)
    })
}

impl Options {
    fn answer(&self, log: Named) -> anyhow::Result<DetectionReport> {
        let method = method(self.method.as_deref())?;
        let configuration = Configuration::read(self.config.as_deref(), method)?;
        let settings = DetectionSettings::from(&configuration.identification);
        let name = log.log.clone();
        let recording = log.recording(&configuration.mounting)?;
        let detection = detect_in(&recording, &settings);
        let detection = detection.map_err(|error| blame(error, Some(&name)))?;
        Ok(DetectionReport::new(name, detection))
    }
}
