//! How surely the parameters of a robot are known.

use mlr_filter::SettingError;
use nalgebra::{DMatrix, DVector};

use super::{Robot, RobotParameter};

/// What healthy walks of a robot left open of its own parameters.
///
/// Two things are known of each: the value with which this model walks as the robot does, which is
/// the one in the robot's description, and what that says of the robot itself. The second is less
/// sure: what a physics engine gets wrong of a robot passes for parameters of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    parameters: Vec<RobotParameter>,
    covariance: DMatrix<f64>,
    physical: Gaussian,
}

/// A normal distribution of the coordinates of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    /// Means.
    pub mean: DVector<f64>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
}

impl Calibration {
    /// `covariance` is that of the values in the description, `physical` the distribution of the
    /// robot's own; both have a row for each of the parameters, in their coordinates.
    ///
    /// # Errors
    /// [`SettingError`] where a parameter occurs twice or is not of this robot, and where a matrix is
    /// no covariance of so many.
    pub fn new(
        robot: &Robot,
        parameters: Vec<RobotParameter>,
        covariance: DMatrix<f64>,
        physical: Gaussian,
    ) -> Result<Self, SettingError> {
        for (index, parameter) in parameters.iter().enumerate() {
            let name = || format!("parameters[{index}]");
            if !parameter.is_of(robot) {
                let expected = format!("a parameter of {}", robot.name());
                return Err(SettingError::new(name(), parameter, expected));
            }
            if parameters[..index].contains(parameter) {
                return Err(SettingError::new(name(), parameter, "each parameter once"));
            }
        }
        let n = parameters.len();
        check_covariance("covariance", &covariance, n)?;
        check_covariance("physical_covariance", &physical.covariance, n)?;
        if physical.mean.len() != n || !physical.mean.iter().all(|mean| mean.is_finite()) {
            let found = format!("{} means", physical.mean.len());
            return Err(SettingError::new(
                "physical",
                found,
                "a finite number for each parameter",
            ));
        }
        Ok(Self {
            parameters,
            covariance,
            physical,
        })
    }

    /// The parameters, in the order of rows and columns.
    pub fn parameters(&self) -> &[RobotParameter] {
        &self.parameters
    }

    /// Covariance of the coordinates in the description.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// What is known of the robot's own parameters.
    pub fn physical(&self) -> &Gaussian {
        &self.physical
    }

    /// The row of a parameter; `None` where nothing is known of it.
    pub fn row(&self, parameter: RobotParameter) -> Option<usize> {
        self.parameters.iter().position(|one| *one == parameter)
    }
}

/// Whether a matrix is the covariance of so many numbers.
fn check_covariance(name: &str, covariance: &DMatrix<f64>, n: usize) -> Result<(), SettingError> {
    let refused = |found: String, expected: &str| Err(SettingError::new(name, found, expected));
    if covariance.shape() != (n, n) {
        let (rows, columns) = covariance.shape();
        let expected = "a row and a column for each parameter";
        return refused(format!("{rows} by {columns} numbers"), expected);
    }
    let asymmetry = (covariance - covariance.transpose()).amax();
    if !covariance.iter().all(|x| x.is_finite()) || asymmetry > 1e-9 * covariance.amax() {
        return refused(
            "what is given".into(),
            "a symmetric matrix of finite numbers",
        );
    }
    if covariance.clone().cholesky().is_none() {
        return refused("what is given".into(), "a positive definite matrix");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parameters: &[RobotParameter], covariance: DMatrix<f64>) -> Result<Calibration, String> {
        let physical = Gaussian {
            mean: DVector::zeros(parameters.len()),
            covariance: covariance.clone(),
        };
        Calibration::new(&Robot::jethexa(), parameters.to_vec(), covariance, physical)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn only_a_covariance_of_its_parameters_is_taken() {
        let both = [
            RobotParameter::ServoStiffness,
            RobotParameter::ImuMounting(0),
        ];
        let good = DMatrix::from_row_slice(2, 2, &[0.04, 0.01, 0.01, 0.09]);
        let calibration = of(&both, good.clone()).unwrap();
        assert_eq!(calibration.row(RobotParameter::ImuMounting(0)), Some(1));
        assert_eq!(calibration.row(RobotParameter::Clock), None);
        let indefinite = DMatrix::from_row_slice(2, 2, &[0.04, 0.1, 0.1, 0.09]);
        assert!(
            of(&both, indefinite)
                .unwrap_err()
                .contains("positive definite")
        );
        let lopsided = DMatrix::from_row_slice(2, 2, &[0.04, 0.01, 0.02, 0.09]);
        assert!(of(&both, lopsided).unwrap_err().contains("symmetric"));
        assert!(of(&both[..1], good.clone()).unwrap_err().contains("2 by 2"));
        assert!(
            of(&[both[0], both[0]], good.clone())
                .unwrap_err()
                .contains("once")
        );
        let strange = RobotParameter::JointZero { leg: 7, joint: 0 };
        assert!(
            of(&[both[0], strange], good)
                .unwrap_err()
                .contains("Hiwonder")
        );
    }
}
