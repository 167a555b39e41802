//! `mlr.explain`.

use std::{path::PathBuf, time::Instant};

use anyhow::Context;
use mlr_ga::{
    Configuration, DescribedRobot, ExplainSettings, ExplanationReport, IdentifyOverrides, Model,
    atlas::Atlas, earlier_effects_of_json, explain_after, explanation_settings,
};
use pyo3::{FromPyObject, PyResult, Python, pyfunction};

use crate::{
    arguments::{Columns, ModelFiles, Named, search, seed},
    failure::blame,
    running::{Running, Steps},
};

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    search: Option<String>,
    seed: i64,
    start_s: Option<f64>,
    atlas: Option<PathBuf>,
    config: Option<PathBuf>,
    explanation: Option<PathBuf>,
    /// What was found in an earlier recording, as JSON.
    after: Option<String>,
}

/// The answer of `mlr-ga explain --json`.
#[pyfunction]
pub(crate) fn explain(
    py: Python<'_>,
    recording: Columns<'_>,
    options: Options,
    model: ModelFiles,
    running: Running,
) -> PyResult<String> {
    let started = Instant::now();
    let log = recording.copied();
    running.run(py, move |steps| {
        let report = options.answer(log, &model, started, steps)?;
        Ok(serde_json::to_string(&report)?)
    })
}

impl Options {
    fn answer(
        &self,
        log: Named,
        model: &ModelFiles,
        started: Instant,
        steps: &Steps,
    ) -> anyhow::Result<ExplanationReport> {
        let Configuration {
            identification,
            explanation,
            mounting,
            ..
        } = Configuration::read(self.config.as_deref(), None)?;
        let overrides = IdentifyOverrides {
            search: search(self.search.as_deref())?,
            seed: Some(seed(self.seed)?),
            start_s: self.start_s,
            ..IdentifyOverrides::default()
        };
        let settings = overrides.over(identification)?;
        let own = explanation_settings(self.explanation.as_deref())?;
        let explanation = own.unwrap_or(explanation);
        let described = DescribedRobot::read(model.robot.as_deref())?;
        let robot = &described.robot;
        let gait = described.gait(model.gait.first().map(PathBuf::as_path))?;
        settings.check_on(robot)?;
        let earlier = self.after.as_deref();
        let earlier = earlier.map(|text| earlier_effects_of_json(text, robot));
        let earlier = earlier.transpose().context("after")?;
        let name = log.log.clone();
        let recording = log.recording(&mounting)?;
        let atlas = self.atlas.as_ref();
        let atlas = atlas.map(|path| Atlas::open(path, robot, &gait, &settings));
        let atlas = atlas.transpose()?;
        let model = Model::new(robot, &gait).with_atlas(atlas.as_ref());
        let how = ExplainSettings {
            identify: &settings,
            explanation: &explanation,
        };
        let explained = explain_after(earlier.as_ref(), &recording, model, how, steps);
        let explained = explained.map_err(|error| blame(error, Some(&name)))?;
        let (seed, elapsed) = (settings.seed, started.elapsed());
        Ok(ExplanationReport::of(name, seed, explained, elapsed))
    }
}
