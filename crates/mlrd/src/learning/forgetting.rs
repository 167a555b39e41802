//! What is known of a robot grows old.

use mlr_filter::SettingError;
use mlr_model::{Calibration, Gaussian, Robot};
use mlr_residual::walk::NuisanceSettings;
use nalgebra::DMatrix;

/// The robot with what is known of it made less sure: a share of the covariance is replaced by that
/// of the make. Parameters drift, and a calibration that only ever grew surer would not follow.
///
/// # Errors
/// [`SettingError`] never, for a share from 0 to 1 and deviations above 0.
pub(super) fn aged(
    robot: &Robot,
    make: &NuisanceSettings,
    share: f64,
) -> Result<Robot, SettingError> {
    let Some(known) = robot.calibration() else {
        return Ok(robot.clone());
    };
    let parameters = known.parameters();
    let variances = parameters.iter().map(|one| make.of_make(*one).powi(2));
    let of_make = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(
        parameters.len(),
        variances,
    ));
    let older = |covariance: &DMatrix<f64>| covariance * (1.0 - share) + &of_make * share;
    let physical = known.physical();
    let aged = Calibration::new(
        robot,
        parameters.to_vec(),
        older(known.covariance()),
        Gaussian {
            mean: physical.mean.clone(),
            covariance: older(&physical.covariance),
        },
    )?;
    Ok(robot.clone().with_calibration(aged))
}

#[cfg(test)]
mod tests {
    use mlr_model::RobotParameter;
    use nalgebra::DVector;

    use super::*;

    #[test]
    fn knowledge_tends_to_that_of_the_make_and_values_stay() {
        let make = NuisanceSettings::default();
        let own = vec![RobotParameter::ImuMounting(0), RobotParameter::Clock];
        let covariance = DMatrix::from_row_slice(2, 2, &[0.01, 1e-5, 1e-5, 1e-6]);
        let physical = Gaussian {
            mean: DVector::from_vec(vec![1.2, 0.001]),
            covariance: covariance.clone(),
        };
        let robot = Robot::jethexa().with_added(own[0], 1.0);
        let known = Calibration::new(&robot, own.clone(), covariance, physical).unwrap();
        let mut robot = robot.with_calibration(known);
        let deviation = |robot: &Robot| robot.calibration().unwrap().covariance()[(0, 0)].sqrt();
        let mut before = deviation(&robot);
        for _ in 0..60 {
            robot = aged(&robot, &make, 0.1).unwrap();
            assert!(deviation(&robot) > before);
            before = deviation(&robot);
        }
        assert!((before - make.misalignment_deg).abs() < 0.01, "{before}");
        assert!((own[0].coordinate(&robot) - 1.0).abs() < 1e-12);
        assert_eq!(robot.calibration().unwrap().physical().mean[0], 1.2);
        // A control: of a robot as its make is described nothing can be forgotten.
        let described = Robot::jethexa();
        assert_eq!(aged(&described, &make, 0.1).unwrap(), described);
    }
}
