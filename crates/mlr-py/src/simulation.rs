//! `mlr.simulate`.

use std::path::PathBuf;

use mlr_filter::OrientationSeries;
use mlr_ga::{DescribedRobot, LogSimulation, SimulationReport};
use mlr_model::{LegLayout, LostLinks, ModelError, Morphology};
use numpy::{IntoPyArray, PyArray1};
use pyo3::{Bound, FromPyObject, PyResult, Python, pyfunction};

use crate::{
    arguments::{ModelFiles, named, seed},
    running::Running,
};

#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    /// Numbers of legs, as in `3,4`.
    legs_lost: Option<String>,
    /// The existence numbers, as in `111 000`.
    morphology: Option<String>,
    lost_links: String,
    stand_s: f64,
    walk_s: f64,
    time_step_s: f64,
    friction: Option<f64>,
    joint_friction_nm: f64,
    backlash_rad: f64,
    slope_deg: f64,
    uphill_deg: f64,
    rubble_m: Option<f64>,
    seed: i64,
}

/// What `mlr-ga simulate --json` prints of a log that went to no file, and the log: time in seconds,
/// roll, pitch and yaw in rad.
type Simulated<'py> = (String, [Bound<'py, PyArray1<f64>>; 4]);

#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    options: Options,
    model: ModelFiles,
    running: Running,
) -> PyResult<Simulated<'py>> {
    let (report, log) = running.run(py, move |_| {
        let (report, log) = options.log(&model)?;
        Ok((serde_json::to_string(&report)?, log))
    })?;
    let angles = log.angles_rad();
    let columns = [log.times_s(), &angles.roll, &angles.pitch, &angles.yaw];
    Ok((
        report,
        columns.map(|column| column.to_vec().into_pyarray(py)),
    ))
}

impl Options {
    fn log(&self, model: &ModelFiles) -> anyhow::Result<(SimulationReport, OrientationSeries)> {
        let lost_links: Option<LostLinks> =
            named("lost_links", Some(&self.lost_links), "absent or locked")?;
        let usual = LogSimulation::default();
        let simulation = LogSimulation {
            lost_links: lost_links.unwrap_or(usual.lost_links),
            stand_s: self.stand_s,
            walk_s: self.walk_s,
            time_step_s: self.time_step_s,
            friction: self.friction.unwrap_or(usual.friction),
            joint_friction_nm: self.joint_friction_nm,
            backlash_rad: self.backlash_rad,
            slope_deg: self.slope_deg,
            uphill_deg: self.uphill_deg,
            rubble_m: self.rubble_m,
            seed: seed(self.seed)?,
        };
        simulation.check()?;
        let described = DescribedRobot::read(model.robot.as_deref())?;
        let gait = described.gait(model.gait.first().map(PathBuf::as_path))?;
        let robot = simulation.robot(described.robot)?;
        let morphology = self.morphology(&robot.layout())?;
        let log = simulation.log(&robot, &gait, &morphology)?;
        Ok((SimulationReport::new(&simulation, &morphology, &log), log))
    }

    fn morphology(&self, layout: &LegLayout) -> Result<Morphology, ModelError> {
        match (&self.morphology, &self.legs_lost) {
            (Some(text), _) => Morphology::parse(text, layout),
            (None, Some(legs)) => Morphology::parse_legs_lost(legs, layout),
            (None, None) => Ok(Morphology::healthy(layout)),
        }
    }
}
