use std::collections::BTreeMap;

use super::{
    Place, WalkEffect,
    effect::{around, named},
    imu_misalignment::{TILT_CHANCE_SHARE, USUAL_TILT_DEG},
};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The ground is inclined.
#[derive(Debug)]
pub(super) struct Slope;

/// How steep ground usually is, and how large a tilt of the sensor: a slope can be told
/// from a tilted sensor only as far as the robot turns, and where it does not, the usual
/// sizes decide.
const USUAL_DEG: f64 = 6.0;
/// Steeper ground than this would throw the robot down.
const STEEPEST_DEG: f64 = 20.0;

impl Slope {
    /// Angle of the slope and direction uphill.
    fn polar_deg(values: &[f64]) -> (f64, f64) {
        let angle_deg = values[0].hypot(values[1]);
        (angle_deg, libm::atan2(values[1], values[0]).to_degrees())
    }
}

impl WalkEffect for Slope {
    fn kind(&self) -> &'static str {
        "slope"
    }

    fn trace(&self) -> &'static str {
        "roll and pitch as the ground's, turning with the heading; the body drifts downhill"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        ["rise_ahead_deg", "rise_left_deg"]
            .map(|name| {
                Parameter::new(name, 0.0)
                    .step(0.3)
                    .bounds(-STEEPEST_DEG, STEEPEST_DEG)
                    .neutral(0.0)
                    .usual(0.5)
            })
            .into()
    }

    /// As the standing robot leans, if its sensor sits straight; and all around.
    fn starts(&self, _: Place, _: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>> {
        let [roll_deg, pitch_deg] = record.mean_tilt_deg();
        let mut starts = vec![vec![-pitch_deg, roll_deg]];
        starts.extend(around(4, 4.0).into_iter().map(Vec::from));
        starts
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        let (angle_deg, uphill_deg) = Self::polar_deg(values);
        model.simulation.terrain.slope_rad = angle_deg.to_radians();
        model.simulation.terrain.uphill_rad = uphill_deg.to_radians();
    }

    fn rarity(&self, values: &[f64]) -> f64 {
        let (angle_deg, _) = Self::polar_deg(values);
        (angle_deg / USUAL_DEG).powi(2) + 4.0 * (USUAL_DEG / USUAL_TILT_DEG).ln()
    }

    /// As of a tilted sensor.
    fn chance_share(&self) -> f64 {
        TILT_CHANCE_SHARE
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        let (angle_deg, uphill_deg) = Self::polar_deg(values);
        named([("angle_deg", angle_deg), ("uphill_deg", uphill_deg)])
    }
}
