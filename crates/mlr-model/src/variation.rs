//! How a real robot may differ from its description.

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use crate::{GroundContact, ModelError, Robot, Servo, SimulationSettings, Terrain};

/// A mass that rides on the body and is in no description.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Its mass.
    pub mass_kg: f64,
    /// Where it sits, in the body frame; it has no extent.
    pub position_m: [f64; 3],
}

impl Payload {
    pub(crate) fn check(&self) -> Result<(), SettingError> {
        SettingError::check("mass_kg", self.mass_kg, 0.0..=1e6, "kg")?;
        SettingError::check_each("position_m", &self.position_m, -1e3..=1e3, "m")
    }
}

/// One way in which a robot on its ground may differ from the description: what
/// nobody measured, within what is usual. Relative to the nominal model, so that
/// it fits any robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Variation {
    /// Friction of the ground over the nominal one.
    pub friction: f64,
    /// Stiffness of the servos over the nominal one.
    pub stiffness: f64,
    /// Mass of a payload over that of the body.
    pub payload: f64,
    /// Where it sits: x and y over half the body's length and width.
    pub payload_at: [f64; 2],
    /// Slope of the ground.
    pub slope_deg: f64,
    /// Where it rises, counter-clockwise from the robot's first heading.
    pub uphill_deg: f64,
}

impl Default for Variation {
    /// The nominal model.
    fn default() -> Self {
        Self {
            friction: 1.0,
            stiffness: 1.0,
            payload: 0.0,
            payload_at: [0.0; 2],
            slope_deg: 0.0,
            uphill_deg: 0.0,
        }
    }
}

impl Variation {
    /// Checks every number. Ground without friction is valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("friction", self.friction, 0.0..=100.0, "")?;
        check("stiffness", self.stiffness, 0.001..=1000.0, "")?;
        check("payload", self.payload, 0.0..=10.0, "")?;
        SettingError::check_each("payload_at", &self.payload_at, -10.0..=10.0, "")?;
        check(
            "slope_deg",
            self.slope_deg,
            0.0..=Terrain::STEEPEST_DEG,
            "degrees",
        )?;
        check("uphill_deg", self.uphill_deg, -360.0..=360.0, "degrees")
    }

    /// Robot and settings as varied. What is varied beyond the bounds of a setting stays at
    /// them: a ground that grips ever more changes nothing.
    ///
    /// # Errors
    /// [`ModelError::Setting`] when a parameter makes no sense.
    pub fn apply(
        &self,
        robot: &Robot,
        settings: &SimulationSettings,
    ) -> Result<(Robot, SimulationSettings), ModelError> {
        self.check()?;
        let mut servo = *robot.servo();
        servo.stiffness_nm_per_rad =
            (servo.stiffness_nm_per_rad * self.stiffness).clamp(Servo::SOFTEST, Servo::STIFFEST);
        let mut settings = settings.clone();
        settings.contact.friction =
            (settings.contact.friction * self.friction).min(GroundContact::LARGEST_FRICTION);
        if self.payload != 0.0 {
            let body = robot.body();
            let half_m = body.size_m / 2.0;
            settings.payload = Some(Payload {
                mass_kg: self.payload * body.mass_kg,
                position_m: [
                    self.payload_at[0] * half_m.x,
                    self.payload_at[1] * half_m.y,
                    half_m.z,
                ],
            });
        }
        if self.slope_deg != 0.0 {
            settings.terrain = Terrain {
                slope_rad: self.slope_deg.to_radians(),
                uphill_rad: self.uphill_deg.to_radians(),
                ..settings.terrain
            };
        }
        Ok((robot.clone().with_servo(servo)?, settings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gait, Morphology, Outcome, Simulator};

    fn walk(variation: Variation) -> mlr_filter::OrientationSeries {
        let settings = SimulationSettings {
            duration_s: 2.0,
            ..Default::default()
        };
        let (robot, settings) = variation.apply(&Robot::jethexa(), &settings).unwrap();
        let healthy = Morphology::healthy(&robot.layout());
        let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
        let Outcome::Walked(walk) = simulator.simulate(&healthy) else {
            panic!("diverged");
        };
        walk.orientation
    }

    #[test]
    fn no_variation_changes_nothing() {
        let settings = SimulationSettings::default();
        let (robot, varied) = Variation::default()
            .apply(&Robot::jethexa(), &settings)
            .unwrap();
        assert_eq!((robot, varied), (Robot::jethexa(), settings));
    }

    #[test]
    fn a_payload_leans_the_robot_to_its_side() {
        let mean_roll = |payload_at| {
            let walk = walk(Variation {
                payload: 0.3,
                payload_at,
                ..Variation::default()
            });
            let roll = &walk.angles_rad().roll;
            roll.iter().sum::<f64>() / roll.len() as f64
        };
        let (left, middle, right) = (
            mean_roll([0.0, 0.8]),
            mean_roll([0.0; 2]),
            mean_roll([0.0, -0.8]),
        );
        // Positive roll lowers the right side.
        assert!(left < middle && middle < right, "{left} {middle} {right}");
        assert!((left + right - 2.0 * middle).abs() < 0.2 * (right - left));
    }

    #[test]
    fn a_slope_is_the_terrains() {
        let walk = walk(Variation {
            slope_deg: 6.0,
            ..Variation::default()
        });
        // Uphill is ahead: the front is raised.
        let pitch_deg = walk.angles_rad().pitch[0].to_degrees();
        assert!((pitch_deg + 6.0).abs() < 1.0, "{pitch_deg}");
    }

    #[test]
    fn nonsense_is_refused() {
        let softer_than_nothing = Variation {
            stiffness: -1.0,
            ..Variation::default()
        };
        let settings = SimulationSettings::default();
        assert!(
            softer_than_nothing
                .apply(&Robot::jethexa(), &settings)
                .is_err()
        );
    }
}
