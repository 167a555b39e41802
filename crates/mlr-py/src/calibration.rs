//! `mlr.calibrate`.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::Context;
use mlr_ga::{
    CalibrationReport, Configuration, DescribedRobot, ExplainSettings, HealthyWalk, WalkOrigin,
    calibrate as calibrate_by,
};
use mlr_imu::NewFile;
use mlr_model::Measurement;
use pyo3::{FromPyObject, PyResult, Python, pyfunction};

use crate::{
    arguments::{Columns, ModelFiles, Named},
    failure::blame,
    running::{Running, Steps},
};

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    healthy: bool,
    measured: Vec<String>,
    output: Option<PathBuf>,
    config: Option<PathBuf>,
}

/// The answer of `mlr-ga calibrate --json`, and the robot's description with its own numbers.
#[pyfunction]
pub(crate) fn calibrate(
    py: Python<'_>,
    recordings: Vec<Columns<'_>>,
    options: Options,
    model: ModelFiles,
    running: Running,
) -> PyResult<(String, String)> {
    let logs: Vec<Named> = recordings.into_iter().map(Columns::copied).collect();
    running.run(py, move |steps| {
        let (report, description) = options.answer(logs, &model, steps)?;
        Ok((serde_json::to_string(&report)?, description))
    })
}

impl Options {
    fn answer(
        &self,
        logs: Vec<Named>,
        model: &ModelFiles,
        steps: &Steps,
    ) -> anyhow::Result<(CalibrationReport, String)> {
        let Configuration {
            identification,
            explanation,
            mounting,
            ..
        } = Configuration::read(self.config.as_deref(), None)?;
        let described = DescribedRobot::read(model.robot.as_deref())?;
        let gaits = described.gaits(&model.gait, logs.len())?;
        let measured = self.measured.iter().map(|text| Measurement::parse(text));
        let measured: Vec<Measurement> = measured.collect::<Result<_, _>>()?;
        let make = &explanation.nuisance;
        let known = measured
            .iter()
            .try_fold(described.robot.clone(), |robot, one| {
                robot.measured(one, |parameter| make.of_make(parameter))
            })?;
        let output = || {
            self.output
                .as_deref()
                .unwrap_or(Path::new(""))
                .display()
                .to_string()
        };
        let file = self.output.as_deref().map(NewFile::reserve);
        let file = file.transpose().with_context(output)?;
        let names: Vec<String> = logs.iter().map(|log| log.log.clone()).collect();
        let recordings = logs
            .into_iter()
            .map(|log| log.recording(&mounting))
            .collect::<Result<Vec<_>, _>>()?;
        let both = recordings.iter().zip(&gaits);
        let walks: Vec<HealthyWalk<'_>> = both
            .map(|(recording, gait)| HealthyWalk { recording, gait })
            .collect();
        let settings = ExplainSettings {
            identify: &identification,
            explanation: &explanation,
        };
        let found = calibrate_by(&walks, &known, settings, !self.healthy, steps);
        let found = found.map_err(|(log, error)| blame(error, names.get(log)))?;
        let origins = names.into_iter().zip(&gaits).map(|(log, gait)| WalkOrigin {
            log,
            // Arrays are no file.
            sha256: String::new(),
            gait: gait.name.clone(),
        });
        let report = CalibrationReport::new(&described.robot, &found, make, origins.collect());
        let report = report.with_measured(&measured);
        let description = report.description(&described.text, &found.robot)?;
        if let Some(file) = file {
            let written = file.write(|file| file.write_all(description.as_bytes()));
            written.with_context(output)?;
        }
        Ok((report, description))
    }
}
