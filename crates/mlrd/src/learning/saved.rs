//! What is kept of calibrations beyond the daemon's end.

use std::sync::Arc;

use mlr_filter::SettingError;
use mlr_model::{Calibration, Gaussian, Robot, RobotParameter};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Calibrations, LearnedRobot};
use crate::saved_state::Kept;

/// The calibration in use, the one before it and the reference, as JSON in one file: whenever power
/// fails, they belong together.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SavedCalibrations {
    /// Version of the file.
    schema: Schema,
    current: Option<SavedCalibration>,
    before: Option<SavedCalibration>,
    reference: Option<SavedCalibration>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
enum Schema {
    #[default]
    #[serde(rename = "mlr.learned/1")]
    First,
}

impl Kept for SavedCalibrations {
    const NAME: &'static str = "calibration.json";
}

/// One calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedCalibration {
    time: String,
    walks: u32,
    parameters: Vec<SavedParameter>,
    /// Lower triangles, row by row.
    covariance: Vec<Vec<f64>>,
    physical_covariance: Vec<Vec<f64>>,
}

/// A parameter's coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SavedParameter {
    name: String,
    /// In the robot's description.
    described: f64,
    /// With which the model walks most like the robot.
    fitted: f64,
    /// The robot's own, most probably.
    physical: f64,
}

/// Why a saved calibration is of no use.
#[derive(Debug, Error)]
pub enum CalibrationMismatch {
    /// There is no such parameter.
    #[error("{0:?} is no parameter of a robot")]
    UnknownParameter(String),
    /// It belongs to a robot that was described otherwise.
    #[error(
        "{name} is {now} in the robot's description, {then} when the calibration was learned: \
         it belongs to another description"
    )]
    OtherDescription {
        /// The parameter.
        name: String,
        /// Its coordinate now.
        now: f64,
        /// Its coordinate then.
        then: f64,
    },
    /// The numbers are no calibration.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

/// Coordinates that differ by less are the same.
const SAME: f64 = 1e-9;

impl SavedCalibrations {
    /// What is to be kept.
    pub fn of(known: &Calibrations) -> Self {
        let described = known.described();
        let saved = |learned: &Option<LearnedRobot>| {
            let learned = learned.as_ref()?;
            SavedCalibration::of(learned, described)
        };
        Self {
            schema: Schema::First,
            current: saved(&known.current),
            before: saved(&known.before),
            reference: saved(&known.reference),
        }
    }

    /// The same as calibrations of a robot.
    ///
    /// # Errors
    /// [`CalibrationMismatch`] where they are not of this robot.
    pub fn calibrations(&self, described: Arc<Robot>) -> Result<Calibrations, CalibrationMismatch> {
        let learned = |saved: &Option<SavedCalibration>| {
            let saved = saved.as_ref();
            saved.map(|saved| saved.learned(&described)).transpose()
        };
        Ok(Calibrations {
            current: learned(&self.current)?,
            before: learned(&self.before)?,
            reference: learned(&self.reference)?,
            described,
        })
    }
}

impl SavedCalibration {
    fn of(learned: &LearnedRobot, described: &Robot) -> Option<Self> {
        let known = learned.robot.calibration()?;
        let physical = known.physical();
        let each = known.parameters().iter().zip(physical.mean.iter());
        Some(Self {
            time: learned.time.clone(),
            walks: learned.walks,
            parameters: each
                .map(|(parameter, physical)| SavedParameter {
                    name: parameter.to_string(),
                    described: parameter.coordinate(described),
                    fitted: parameter.coordinate(&learned.robot),
                    physical: *physical,
                })
                .collect(),
            covariance: lower(known.covariance()),
            physical_covariance: lower(&physical.covariance),
        })
    }

    fn learned(&self, described: &Robot) -> Result<LearnedRobot, CalibrationMismatch> {
        let mut robot = described.clone();
        let mut parameters = Vec::with_capacity(self.parameters.len());
        for saved in &self.parameters {
            let parameter: RobotParameter = saved
                .name
                .parse()
                .map_err(|_| CalibrationMismatch::UnknownParameter(saved.name.clone()))?;
            let now = parameter.coordinate(described);
            if (now - saved.described).abs() > SAME {
                return Err(CalibrationMismatch::OtherDescription {
                    name: saved.name.clone(),
                    now,
                    then: saved.described,
                });
            }
            robot = robot.with_added(parameter, saved.fitted - now);
            parameters.push(parameter);
        }
        let n = parameters.len();
        let means = self.parameters.iter().map(|saved| saved.physical);
        let physical = Gaussian {
            mean: DVector::from_iterator(n, means),
            covariance: symmetric("physical_covariance", &self.physical_covariance, n)?,
        };
        let covariance = symmetric("covariance", &self.covariance, n)?;
        let known = Calibration::new(&robot, parameters, covariance, physical)?;
        Ok(LearnedRobot {
            robot: Arc::new(robot.with_calibration(known)),
            walks: self.walks,
            time: self.time.clone(),
        })
    }
}

fn lower(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let row = |i: usize| (0..=i).map(|j| matrix[(i, j)]).collect();
    (0..matrix.nrows()).map(row).collect()
}

fn symmetric(name: &str, lower: &[Vec<f64>], n: usize) -> Result<DMatrix<f64>, SettingError> {
    let is_triangle =
        lower.len() == n && lower.iter().zip(1..).all(|(row, many)| row.len() == many);
    if !is_triangle {
        let expected = format!("the lower triangle of {n} rows");
        return Err(SettingError::new(
            name,
            format!("{} rows", lower.len()),
            expected,
        ));
    }
    Ok(DMatrix::from_fn(n, n, |i, j| lower[i.max(j)][i.min(j)]))
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;
    use crate::{
        learning::{LearningSettings, calibrations::tests::lesson},
        saved_state::StateFile,
    };

    fn known() -> Calibrations {
        let mut known = Calibrations::new(Arc::new(Robot::jethexa()));
        let settings = LearningSettings {
            reference_walks: 1,
            ..LearningSettings::default()
        };
        for roll_deg in [0.4, 0.6, -0.3] {
            known.learn(SystemTime::UNIX_EPOCH, &lesson(roll_deg), &settings);
        }
        known
    }

    #[test]
    fn all_three_are_known_again_after_a_restart() {
        let folder = tempfile::tempdir().unwrap();
        let file = StateFile::<SavedCalibrations>::new(folder.path()).unwrap();
        let described = Arc::new(Robot::jethexa());
        let (nothing, notice) = file.load().unwrap();
        assert_eq!(notice, None);
        assert_eq!(
            nothing.calibrations(Arc::clone(&described)).unwrap(),
            Calibrations::new(Arc::clone(&described))
        );
        file.save(&SavedCalibrations::of(&known())).unwrap();
        let (saved, _) = file.load().unwrap();
        assert_eq!(saved.calibrations(described).unwrap(), known());
        let saved = SavedCalibrations::of(&known());
        assert!(saved.before.is_some() && saved.reference.is_some());
        assert_ne!(saved.before, saved.reference);
    }

    #[test]
    fn a_calibration_of_another_description_or_none_at_all_is_refused() {
        let saved = SavedCalibrations::of(&known());
        let other = Robot::jethexa().with_added(RobotParameter::ImuMounting(0), 0.1);
        let refused = |saved: &SavedCalibrations, robot| {
            let refused = saved.calibrations(Arc::new(robot)).unwrap_err();
            refused.to_string()
        };
        assert!(refused(&saved, other).contains("another description"));
        let mut torn = saved.clone();
        torn.current.as_mut().unwrap().covariance.pop();
        assert!(refused(&torn, Robot::jethexa()).contains("covariance"));
        let mut strange = saved;
        strange.current.as_mut().unwrap().parameters[0].name = "spirit".into();
        assert!(refused(&strange, Robot::jethexa()).contains("spirit"));
    }
}
