//! The calibration in use, the one before it, and the one that wear is told against.

use std::{sync::Arc, time::SystemTime};

use mlr_model::Robot;
use serde::{Deserialize, Serialize};

use super::{LearningSettings, Lesson, Wear, wear};

/// What is known of the robot, and what was known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrations {
    /// The robot as its make is described.
    pub(super) described: Arc<Robot>,
    pub(super) current: Option<LearnedRobot>,
    pub(super) before: Option<LearnedRobot>,
    /// Never overwritten: a slow decline shows against it.
    pub(super) reference: Option<LearnedRobot>,
}

/// A robot with parameters of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedRobot {
    /// The robot.
    pub robot: Arc<Robot>,
    /// Stretches of healthy walk that it was learned from.
    pub walks: u32,
    /// When it was learned, RFC 3339.
    pub time: String,
}

/// What is told of a calibration when the daemon starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KnownCalibration {
    /// When it was learned, RFC 3339.
    pub time: String,
    /// Stretches of healthy walk that it was learned from.
    pub walks: u32,
}

impl Calibrations {
    /// Nothing but the description is known.
    pub fn new(described: Arc<Robot>) -> Self {
        Self {
            described,
            current: None,
            before: None,
            reference: None,
        }
    }

    /// The robot as its make is described.
    pub fn described(&self) -> &Arc<Robot> {
        &self.described
    }

    /// The robot as it is known.
    pub fn robot(&self) -> &Arc<Robot> {
        let known = self.current.as_ref();
        known.map_or(&self.described, |current| &current.robot)
    }

    /// The robot as it was known before the last lesson; `None` where there was none.
    pub fn robot_before(&self) -> Option<&Arc<Robot>> {
        self.current.as_ref()?;
        let known = self.before.as_ref();
        Some(known.map_or(&self.described, |before| &before.robot))
    }

    /// What is told of it.
    pub fn known(&self) -> Option<KnownCalibration> {
        self.current.as_ref().map(|current| KnownCalibration {
            time: current.time.clone(),
            walks: current.walks,
        })
    }

    /// The calibration in use predicts worse than the one before it, which is used again.
    pub fn fall_back(&mut self) {
        self.current = self.before.take();
    }

    /// Uses what was learned at `now`, on top of a calibration that has just predicted a walk well;
    /// that becomes the reference if enough went into it.
    pub fn learn(&mut self, now: SystemTime, lesson: &Lesson, settings: &LearningSettings) {
        let walks = self.current.as_ref().map_or(0, |current| current.walks);
        if self.reference.is_none() && walks >= settings.reference_walks {
            self.reference.clone_from(&self.current);
        }
        self.before = self.current.replace(LearnedRobot {
            robot: Arc::new(lesson.robot.clone()),
            walks: walks.saturating_add(1),
            time: humantime::format_rfc3339_millis(now).to_string(),
        });
    }

    /// What has drifted since the reference.
    pub fn wear(&self, settings: &LearningSettings) -> Vec<Wear> {
        let known = |learned: &Option<LearnedRobot>| {
            let robot = learned.as_ref().map(|learned| Arc::clone(&learned.robot));
            robot.and_then(|robot| robot.calibration().cloned())
        };
        match (known(&self.reference), known(&self.current)) {
            (Some(reference), Some(current)) => {
                wear(&reference, &current, settings.wear_deviations)
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use mlr_ga::{Calibrated, CalibrationReport};
    use mlr_model::{Calibration, Gaussian, RobotParameter};
    use mlr_residual::walk::NuisanceSettings;
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// What a walk teaches of a robot whose sensor is mounted like this.
    pub(in crate::learning) fn lesson(roll_deg: f64) -> Lesson {
        let own = RobotParameter::ImuMounting(0);
        let robot = Robot::jethexa().with_added(own, roll_deg);
        let covariance = DMatrix::from_element(1, 1, 0.01);
        let physical = Gaussian {
            mean: DVector::from_element(1, roll_deg),
            covariance: covariance.clone(),
        };
        let known = Calibration::new(&robot, vec![own], covariance, physical).unwrap();
        let robot = robot.with_calibration(known);
        let calibrated = Calibrated {
            robot: robot.clone(),
            walks: Vec::new(),
        };
        let make = NuisanceSettings::default();
        Lesson {
            report: CalibrationReport::new(&Robot::jethexa(), &calibrated, &make, Vec::new()),
            robot,
            gain_nats: 1.0,
        }
    }

    fn roll_deg(robot: &Robot) -> f64 {
        RobotParameter::ImuMounting(0).coordinate(robot)
    }

    #[test]
    fn the_version_before_is_kept_and_the_reference_is_never_overwritten() {
        let settings = LearningSettings {
            reference_walks: 2,
            ..LearningSettings::default()
        };
        let mut known = Calibrations::new(Arc::new(Robot::jethexa()));
        assert_eq!(known.robot_before(), None);
        // The sensor comes loose slowly: a third of a deviation each time.
        for index in 0..12 {
            let now = SystemTime::UNIX_EPOCH;
            known.learn(now, &lesson(0.05 * f64::from(index)), &settings);
            assert!((roll_deg(known.robot()) - 0.05 * f64::from(index)).abs() < 1e-12);
        }
        assert_eq!(known.known().unwrap().walks, 12);
        assert!((roll_deg(known.robot_before().unwrap()) - 0.5).abs() < 1e-12);
        let told = known.wear(&settings);
        assert_eq!(told[0].parameter, "imu_roll");
        assert!(
            (told[0].reference - 0.05).abs() < 1e-12,
            "that of two walks"
        );
        assert!((told[0].change - 0.5).abs() < 1e-12);

        known.fall_back();
        assert!((roll_deg(known.robot()) - 0.5).abs() < 1e-12);
        // One version is kept; before it there is the description.
        known.fall_back();
        assert_eq!(known.robot(), known.described());
        assert!(known.wear(&settings).is_empty());
    }
}
