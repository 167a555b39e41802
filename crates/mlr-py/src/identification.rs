//! `mlr.identify` and `mlr.identify_together`.

use std::{path::PathBuf, time::Instant};

use mlr_filter::SettingError;
use mlr_ga::{
    Configuration, DescribedRobot, IdentificationReport, IdentifyOverrides, Method,
    atlas::AtlasesOfLogs, identify_together,
};
use pyo3::{FromPyObject, PyResult, Python, pyfunction};

use crate::{
    arguments::{Columns, ModelFiles, Named, count, named, search, seed},
    failure::blame,
    running::{Running, Steps},
};

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    search: Option<String>,
    seed: i64,
    method: Option<String>,
    repeats: Option<i64>,
    window_s: Option<f64>,
    from_s: Option<f64>,
    lost_links: Option<String>,
    friction: Option<f64>,
    atlas: Vec<PathBuf>,
    config: Option<PathBuf>,
}

/// The answer of `mlr-ga identify --json`.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    recordings: Vec<Columns<'_>>,
    options: Options,
    model: ModelFiles,
    running: Running,
) -> PyResult<String> {
    let started = Instant::now();
    let logs: Vec<Named> = recordings.into_iter().map(Columns::copied).collect();
    running.run(py, move |steps| {
        let report = options.answer(logs, &model, started, steps)?;
        Ok(serde_json::to_string(&report)?)
    })
}

/// What decides.
pub(crate) fn method(name: Option<&str>) -> Result<Option<Method>, SettingError> {
    named("method", name, "mlr or paper")
}

impl Options {
    fn answer(
        &self,
        logs: Vec<Named>,
        model: &ModelFiles,
        started: Instant,
        steps: &Steps,
    ) -> anyhow::Result<IdentificationReport> {
        let method = method(self.method.as_deref())?;
        let configuration = Configuration::read(self.config.as_deref(), method)?;
        let settings = self.overrides()?.over(configuration.identification)?;
        let described = DescribedRobot::read(model.robot.as_deref())?;
        let robot = &described.robot;
        let gaits = described.gaits(&model.gait, logs.len())?;
        settings.check_on(robot)?;
        let names: Vec<String> = logs.iter().map(|log| log.log.clone()).collect();
        let recordings = logs
            .into_iter()
            .map(|log| log.recording(&configuration.mounting))
            .collect::<Result<Vec<_>, _>>()?;
        let atlases = AtlasesOfLogs::open(&self.atlas, robot, &gaits, &settings)?;
        let walks = atlases.walks(&recordings, &gaits);
        let answer = identify_together(&walks, robot, &settings, steps);
        let found = answer.map_err(|(log, error)| blame(error, names.get(log)))?;
        Ok(IdentificationReport::of_files(
            names,
            found,
            started.elapsed(),
        ))
    }

    fn overrides(&self) -> Result<IdentifyOverrides, SettingError> {
        let lost_links = self.lost_links.as_deref();
        Ok(IdentifyOverrides {
            search: search(self.search.as_deref())?,
            seed: Some(seed(self.seed)?),
            repeats: self.repeats.map(|n| count("repeats", n)).transpose()?,
            start_s: None,
            window_s: self.window_s,
            from_s: self.from_s,
            lost_links: named("lost_links", lost_links, "absent, locked or either")?,
            friction: self.friction,
        })
    }
}
