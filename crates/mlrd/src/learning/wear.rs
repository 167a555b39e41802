//! What has drifted since the robot was first known.

use mlr_model::Calibration;
use serde::Serialize;

/// A parameter of the robot that is no longer what it was.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Wear {
    /// Its name.
    pub parameter: String,
    /// What the numbers are in: `ln` for the logarithm of a positive number.
    pub unit: &'static str,
    /// The robot's own value when it was first known, most probably.
    pub reference: f64,
    /// What it is now.
    pub now: f64,
    /// How far it has drifted.
    pub change: f64,
    /// The same in standard deviations of what both calibrations leave open.
    pub deviations: f64,
}

/// The parameters that have drifted by so many standard deviations or more, those that drifted most
/// first. The robot's own values are compared, which are less sure than those that the model walks
/// with: what an engine gets wrong on one day is no wear.
pub fn wear(reference: &Calibration, now: &Calibration, least_deviations: f64) -> Vec<Wear> {
    let (was, is) = (reference.physical(), now.physical());
    let each = now.parameters().iter().enumerate();
    let mut drifted: Vec<Wear> = each
        .filter_map(|(row, parameter)| {
            let row_then = reference.row(*parameter)?;
            let open = was.covariance[(row_then, row_then)] + is.covariance[(row, row)];
            let (reference, now) = (was.mean[row_then], is.mean[row]);
            let change = now - reference;
            Some(Wear {
                parameter: parameter.to_string(),
                unit: parameter.unit(),
                reference,
                now,
                change,
                deviations: change.abs() / open.sqrt(),
            })
        })
        .filter(|one| one.deviations >= least_deviations)
        .collect();
    drifted.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    drifted
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gaussian, Robot, RobotParameter};
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn known(means: [f64; 2]) -> Calibration {
        let own = vec![
            RobotParameter::ImuMounting(1),
            RobotParameter::ServoStiffness,
        ];
        let covariance = DMatrix::from_row_slice(2, 2, &[0.04, 0.0, 0.0, 0.0025]);
        let physical = Gaussian {
            mean: DVector::from_vec(means.into()),
            covariance: covariance.clone(),
        };
        Calibration::new(&Robot::jethexa(), own, covariance, physical).unwrap()
    }

    #[test]
    fn what_drifts_further_than_is_open_is_told_with_its_size() {
        let reference = known([0.1, 3.4]);
        assert!(wear(&reference, &reference, 1.0).is_empty());
        // Deviations of both together are 0.283° and 0.0707.
        let told = wear(&reference, &known([0.3, 3.1]), 3.0);
        let [stiffness] = told.as_slice() else {
            panic!("{told:?}");
        };
        assert_eq!(
            (stiffness.parameter.as_str(), stiffness.unit),
            ("servo_stiffness", "ln")
        );
        assert!((stiffness.change + 0.3).abs() < 1e-12);
        assert!((stiffness.deviations - 0.3 / 0.005_f64.sqrt()).abs() < 1e-9);
        let both = wear(&reference, &known([1.4, 3.1]), 3.0);
        assert_eq!(both[0].parameter, "imu_pitch");
        assert_eq!(both.len(), 2);
    }
}
