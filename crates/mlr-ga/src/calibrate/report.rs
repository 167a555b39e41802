//! What a calibration says: as JSON, and as the section of a robot's description.

use std::{collections::BTreeMap, fmt::Write as _};

use mlr_model::{Measurement, ModelError, Robot, RobotParameter};
use mlr_residual::walk::{NuisanceSettings, StretchErrors};
use nalgebra::DMatrix;
use serde::Serialize;
use toml::Value;

use super::{Calibrated, unusual};

/// Version of the JSON form.
const SCHEMA: &str = "mlr.calibration/1";
/// A parameter whose deviation is still this share of that among robots of the make is not told by
/// the walks.
const NOT_TOLD: f64 = 0.8;

/// The lower triangle of a matrix, row by row.
fn lower(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let row = |i: usize| (0..=i).map(|j| matrix[(i, j)]).collect();
    (0..matrix.nrows()).map(row).collect()
}

/// Where a walk came from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WalkOrigin {
    /// The log: a file, or a port.
    pub log: String,
    /// SHA-256 of its bytes, hexadecimal; empty where it is no file.
    pub sha256: String,
    /// Name of the gait.
    pub gait: String,
}

/// A calibration with all that is needed to judge it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibrationReport {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Name and version of the program.
    pub program: String,
    /// The robot's parameters.
    pub parameters: Vec<ParameterReport>,
    /// What was measured on a bench, beside the walks.
    pub measured: Vec<MeasuredReport>,
    /// The walks, in their order.
    pub walks: Vec<WalkReport>,
    /// Covariance of the parameters' coordinates in the description: the lower triangle, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// The same of the robot's own parameters.
    pub physical_covariance: Vec<Vec<f64>>,
    /// What else to know.
    pub warnings: Vec<String>,
}

/// One parameter of the robot, in its coordinate.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ParameterReport {
    /// Its name.
    pub name: String,
    /// What the numbers are in: `ln` for the logarithm of a positive number.
    pub unit: &'static str,
    /// As the description had it.
    pub described: f64,
    /// With which the model walks most like the robot.
    pub fitted: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The robot's own, most probable.
    pub physical: f64,
    /// Standard deviation among robots of the make.
    pub make_deviation: f64,
    /// Standard deviation of the robot's own after each of the walks.
    pub physical_deviations: Vec<f64>,
    /// Whether the walks tell it: more than the make does.
    pub is_told: bool,
}

/// What was measured of the robot on a bench, in the unit of the description.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasuredReport {
    /// Name of the parameter.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard deviation of the measurement.
    pub deviation: f64,
}

/// What one walk added.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WalkReport {
    /// Where it came from.
    #[serde(flatten)]
    pub origin: WalkOrigin,
    /// What belongs to its day, in standard deviations of the prior.
    pub day: BTreeMap<String, f64>,
    /// Share of healthy robots that differ as much from what was known of this one before.
    pub tail_probability: f64,
    /// Errors of the robot as it was known before.
    pub error_before: StretchErrors,
    /// Errors of the robot as calibrated.
    pub error_after: StretchErrors,
}

impl CalibrationReport {
    /// The report of a calibration of a robot that was known as `before`, by walks from these
    /// origins.
    pub fn new(
        before: &Robot,
        calibrated: &Calibrated,
        make: &NuisanceSettings,
        origins: Vec<WalkOrigin>,
    ) -> Self {
        let calibration = calibrated.robot.calibration();
        let own = calibration.map_or(&[][..], |calibration| calibration.parameters());
        let parameters: Vec<ParameterReport> = own
            .iter()
            .map(|parameter| {
                let make_deviation = make.of_make(*parameter);
                let deviation =
                    |covariance: &DMatrix<f64>, row: usize| covariance[(row, row)].sqrt();
                let known = |robot: &Robot| -> Option<(f64, f64, f64)> {
                    let known = robot.calibration()?;
                    let row = known.row(*parameter)?;
                    let physical = known.physical();
                    Some((
                        deviation(known.covariance(), row),
                        physical.mean[row],
                        deviation(&physical.covariance, row),
                    ))
                };
                let after = calibrated
                    .walks
                    .iter()
                    .filter_map(|walk| known(&walk.robot));
                let physical_deviations: Vec<f64> =
                    after.map(|(_, _, physical)| physical).collect();
                let (deviation, physical, last) = known(&calibrated.robot).unwrap_or((
                    make_deviation,
                    parameter.coordinate(before),
                    make_deviation,
                ));
                ParameterReport {
                    deviation,
                    physical,
                    physical_deviations,
                    name: parameter.to_string(),
                    unit: parameter.unit(),
                    described: parameter.coordinate(before),
                    fitted: parameter.coordinate(&calibrated.robot),
                    make_deviation,
                    is_told: last < NOT_TOLD * make_deviation,
                }
            })
            .collect();
        let untold = parameters.iter().filter(|one| !one.is_told);
        let untold: Vec<&str> = untold.map(|one| one.name.as_str()).collect();
        let mut warnings = Vec::new();
        if !untold.is_empty() {
            warnings.push(format!("the walks do not tell {}", untold.join(", ")));
        }
        for (walk, origin) in calibrated.walks.iter().zip(&origins) {
            if let Some(error) = unusual(walk) {
                warnings.push(format!("{}: {error}", origin.log));
            }
        }
        let covariance = calibration.map(|calibration| lower(calibration.covariance()));
        let physical = calibration.map(|calibration| lower(&calibration.physical().covariance));
        let walks = calibrated.walks.iter().zip(origins);
        Self {
            schema: SCHEMA,
            program: format!("mlr {}", env!("CARGO_PKG_VERSION")),
            parameters,
            measured: Vec::new(),
            walks: walks
                .map(|(walk, origin)| WalkReport {
                    origin,
                    day: walk.day.clone(),
                    tail_probability: walk.tail_probability,
                    error_before: walk.error_before,
                    error_after: walk.error_after,
                })
                .collect(),
            covariance: covariance.unwrap_or_default(),
            physical_covariance: physical.unwrap_or_default(),
            warnings,
        }
    }

    /// The same, of a robot of which this was measured before.
    #[must_use]
    pub fn with_measured(mut self, measured: &[Measurement]) -> Self {
        let report = |one: &Measurement| MeasuredReport {
            name: one.parameter.to_string(),
            value: one.value,
            deviation: one.deviation,
        };
        self.measured = measured.iter().map(report).collect();
        self
    }

    /// The description of the robot: `text` with its numbers in place, and this report as its
    /// section `[calibration]`.
    ///
    /// # Errors
    /// [`ModelError`] when the text is no description of this robot.
    pub fn description(&self, text: &str, robot: &Robot) -> Result<String, ModelError> {
        let described = robot.written_into(text)?;
        Ok(format!(
            "{}\n{}",
            described.trim_end().to_owned() + "\n",
            self.section()
        ))
    }

    fn section(&self) -> String {
        let quoted = |text: &str| Value::from(text).to_string();
        let row = |numbers: &[f64]| {
            let each = numbers.iter().map(|number| format!("{number:.5e}"));
            format!("[{}]", each.collect::<Vec<_>>().join(", "))
        };
        let mut text = String::from(
            "# What walks in which nothing was wrong tell of this robot, in the coordinates that `unit` names:\n\
             # `fitted`, with which the model walks most like it, is the value in the sections above;\n\
             # `physical` is what that says of the robot itself, as far as a physics engine can tell.\n\
             [calibration]\n",
        );
        // Writing to a string does not fail.
        let _ = writeln!(text, "program = {}", quoted(&self.program));
        text += "parameters = [\n";
        for one in &self.parameters {
            let physical_deviation = one.physical_deviations.last().copied();
            let physical_deviation = physical_deviation.unwrap_or(one.make_deviation);
            let _ = writeln!(
                text,
                "  {{ name = {}, unit = {}, described = {:.6}, fitted = {:.6}, deviation = {:.6}, physical = {:.6}, physical_deviation = {physical_deviation:.6}, make_deviation = {:.6}, is_told = {} }},",
                quoted(&one.name),
                quoted(one.unit),
                one.described,
                one.fitted,
                one.deviation,
                one.physical,
                one.make_deviation,
                one.is_told
            );
        }
        text += "]\nmeasured = [\n";
        for one in &self.measured {
            let name = quoted(&one.name);
            let (value, deviation) = (one.value, one.deviation);
            let _ = writeln!(
                text,
                "  {{ name = {name}, value = {value:?}, deviation = {deviation:?} }},"
            );
        }
        text += "]\nwalks = [\n";
        for walk in &self.walks {
            let origin = &walk.origin;
            let _ = writeln!(
                text,
                "  {{ log = {}, sha256 = {}, gait = {}, unseen_error_before_deg = {}, unseen_error_after_deg = {} }},",
                quoted(&origin.log),
                quoted(&origin.sha256),
                quoted(&origin.gait),
                row(&walk.error_before.validation_axes_deg),
                row(&walk.error_after.validation_axes_deg),
            );
        }
        text += "]\n# Lower triangles, row by row.\n";
        for (name, covariance) in [
            ("covariance", &self.covariance),
            ("physical_covariance", &self.physical_covariance),
        ] {
            let _ = writeln!(text, "{name} = [");
            for numbers in covariance {
                let _ = writeln!(text, "  {},", row(numbers));
            }
            text += "]\n";
        }
        text
    }

    /// The parameters of one robot by their names.
    pub fn parameter(&self, parameter: RobotParameter) -> Option<&ParameterReport> {
        let name = parameter.to_string();
        self.parameters.iter().find(|one| one.name == name)
    }
}
