use mlr_filter::SettingError;
use nalgebra::{DMatrix, DVector};

use super::{Calibration, Gaussian, Robot, RobotParameter};

/// A number of a robot that somebody measured, such as the mass of a body on a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// What was measured.
    pub parameter: RobotParameter,
    /// In the unit of the parameter: kg, N m/rad, m, rad, degrees, or a ratio.
    pub value: f64,
    /// Standard deviation of the measurement, in the same unit.
    pub deviation: f64,
}

impl Measurement {
    /// Reads `NAME=VALUE+-DEVIATION`, as in `body_mass=1.412+-0.005`; `±` separates as well.
    ///
    /// # Errors
    /// [`SettingError`] naming what was expected.
    pub fn parse(text: &str) -> Result<Self, SettingError> {
        let refused = |expected: &str| SettingError::new("measured", text, expected);
        let form = "NAME=VALUE+-DEVIATION, as in body_mass=1.412+-0.005";
        let (name, rest) = text.split_once('=').ok_or_else(|| refused(form))?;
        let separated = rest.split_once("+-").or_else(|| rest.split_once('±'));
        let (value, deviation) = separated.ok_or_else(|| refused(form))?;
        let parameter = name.trim().parse().map_err(|_| {
            refused("a name such as body_mass, servo_stiffness or center_of_mass_x before the =")
        })?;
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| refused(form));
        let measurement = Self {
            parameter,
            value: number(value)?,
            deviation: number(deviation)?,
        };
        measurement.check()?;
        Ok(measurement)
    }

    /// Checks both numbers.
    ///
    /// # Errors
    /// [`SettingError`] saying what is wrong.
    pub fn check(&self) -> Result<(), SettingError> {
        let name = format!("measured.{}", self.parameter);
        let bounds = if self.parameter.is_logarithmic() {
            1e-9..=1e9
        } else {
            -1e9..=1e9
        };
        SettingError::check(&name, self.value, bounds, "")?;
        SettingError::check(format!("{name}.deviation"), self.deviation, 1e-12..=1e9, "")
    }

    /// In the coordinate of the parameter: what was measured, and the variance of it.
    fn in_coordinate(&self) -> (f64, f64) {
        if self.parameter.is_logarithmic() {
            (self.value.ln(), (self.deviation / self.value).powi(2))
        } else {
            (self.value, self.deviation.powi(2))
        }
    }
}

impl Robot {
    /// The same robot, of which this is known as well. `of_make` is the standard deviation of a
    /// parameter among robots of the make, in its coordinate, for a robot of which nothing else is known.
    ///
    /// # Errors
    /// [`SettingError`] when the measurement makes no sense, or is of no parameter of this robot.
    pub fn measured(
        self,
        measurement: &Measurement,
        of_make: impl Fn(RobotParameter) -> f64,
    ) -> Result<Self, SettingError> {
        measurement.check()?;
        let known = self.calibration.clone();
        let parameters = match &known {
            Some(calibration) => calibration.parameters().to_vec(),
            None => RobotParameter::all(&self),
        };
        let row = parameters
            .iter()
            .position(|one| *one == measurement.parameter);
        let row = row.ok_or_else(|| {
            let expected = format!("a parameter of {}", self.name);
            SettingError::new("measured", measurement.parameter, expected)
        })?;
        let mean = parameters.iter().map(|one| one.coordinate(&self));
        let mean = DVector::from_iterator(parameters.len(), mean);
        let (covariance, physical) = match known {
            Some(calibration) => (
                calibration.covariance().clone(),
                calibration.physical().clone(),
            ),
            None => {
                let variances = parameters.iter().map(|one| of_make(*one).powi(2));
                let variances = variances.map(|variance| variance.max(f64::MIN_POSITIVE));
                let variances = DVector::from_iterator(parameters.len(), variances);
                let covariance = DMatrix::from_diagonal(&variances);
                let physical = Gaussian {
                    mean: mean.clone(),
                    covariance: covariance.clone(),
                };
                (covariance, physical)
            }
        };
        let effective = Gaussian {
            mean: mean.clone(),
            covariance,
        };
        let (effective, physical) = (
            effective.measured(row, measurement.in_coordinate()),
            physical.measured(row, measurement.in_coordinate()),
        );
        let changes = (&effective.mean - mean).data.as_vec().clone();
        let mut robot = self;
        for (parameter, change) in parameters.iter().zip(changes) {
            robot = robot.with_added(*parameter, change);
        }
        let calibration = Calibration::new(&robot, parameters, effective.covariance, physical)?;
        Ok(robot.with_calibration(calibration))
    }
}

impl Gaussian {
    /// After one of its coordinates was measured (Kalman's update).
    fn measured(mut self, row: usize, (value, variance): (f64, f64)) -> Self {
        let column: DVector<f64> = self.covariance.column(row).into();
        let gain = &column / (column[row] + variance);
        self.mean += &gain * (value - self.mean[row]);
        self.covariance -= &gain * column.transpose();
        // Rounding must not make it asymmetric.
        self.covariance = 0.5 * (&self.covariance + self.covariance.transpose());
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAKE: f64 = 0.02;

    fn weighed(robot: Robot, text: &str) -> Robot {
        let measurement = Measurement::parse(text).unwrap();
        robot.measured(&measurement, |_| MAKE).unwrap()
    }

    fn known(robot: &Robot, parameter: RobotParameter) -> (f64, f64) {
        let calibration = robot.calibration().unwrap();
        let row = calibration.row(parameter).unwrap();
        let mass = parameter.coordinate(robot);
        (mass.exp(), calibration.covariance()[(row, row)].sqrt())
    }

    #[test]
    fn a_weighed_body_weighs_what_the_scale_says_and_nothing_else_changes() {
        let mass = RobotParameter::BodyMass;
        let sure = weighed(Robot::jethexa(), "body_mass=1.42+-0.001");
        let (value, deviation) = known(&sure, mass);
        assert!(
            (value - 1.42).abs() < 2e-3 && deviation < 0.001,
            "{value} {deviation}"
        );
        for other in RobotParameter::all(&sure)
            .into_iter()
            .filter(|one| *one != mass)
        {
            assert_eq!(other.coordinate(&sure), other.coordinate(&Robot::jethexa()));
            assert!((known(&sure, other).1 - MAKE).abs() < 1e-12);
        }
        // As sure as the make: half way between, with half of the variance.
        let described = mass.coordinate(&Robot::jethexa()).exp();
        let text = format!("body_mass={}±{}", 1.1 * described, 1.1 * described * MAKE);
        let (value, deviation) = known(&weighed(Robot::jethexa(), &text), mass);
        assert!((value / described - 1.1_f64.sqrt()).abs() < 1e-9);
        assert!((deviation / MAKE - 0.5_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn two_measurements_in_either_order_say_the_same() {
        let texts = ["body_mass=1.42+-0.02", "center_of_mass_x=0.004+-0.002"];
        let [one, other] = [[0, 1], [1, 0]].map(|order| {
            let robot = order.into_iter().map(|k| texts[k]);
            robot.fold(Robot::jethexa(), weighed)
        });
        for parameter in [RobotParameter::BodyMass, RobotParameter::CenterOfMass(0)] {
            let (one, other) = (known(&one, parameter), known(&other, parameter));
            assert!((one.0 - other.0).abs() < 1e-12 && (one.1 - other.1).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_measurement_is_said() {
        for (text, expected) in [
            ("body_mass", "NAME=VALUE+-DEVIATION"),
            ("body_mass=1.4", "NAME=VALUE+-DEVIATION"),
            ("weight=1.4+-0.1", "a name such as body_mass"),
            ("body_mass=-1+-0.1", "measured.body_mass"),
            ("body_mass=1+-0", "measured.body_mass.deviation"),
            ("body_mass=NaN+-1", "measured.body_mass"),
        ] {
            let message = Measurement::parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
        let strange = Measurement::parse("joint_zero_leg9_1=0.1+-0.1").unwrap();
        assert!(Robot::jethexa().measured(&strange, |_| MAKE).is_err());
    }
}
