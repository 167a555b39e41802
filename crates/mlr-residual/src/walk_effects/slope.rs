use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// The ground is inclined, more or otherwise than described.
///
/// - `rise_ahead_deg`, `rise_left_deg`: how steeply the ground rises along the first heading and
///   to its left, in degrees, on top of the described slope. Uphill ahead pitches the body up,
///   which is a negative pitch; uphill to the left raises its left side, a positive roll. People
///   read `angle_deg` of the ground, and `uphill_deg` counter-clockwise from the first heading.
/// - Prior: 0 ± 4° each: ramps in buildings rise by up to 4.8° (1 in 12), paths by twice that.
/// - Bounds: ±20°: steeper ground throws the robot down.
#[derive(Debug)]
pub(super) struct Slope;

/// Steepest rise along either axis.
const STEEPEST_DEG: f64 = 20.0;

impl Slope {
    /// Angle of the slope and direction uphill, with the slope that the model has already.
    fn polar_deg(values: &[f64], model: &WalkModel) -> (f64, f64) {
        let described = &model.simulation.terrain;
        let (sin, cos) = libm::sincos(described.uphill_rad);
        let described_deg = described.slope_rad.to_degrees();
        let ahead_deg = values[0] + described_deg * cos;
        let left_deg = values[1] + described_deg * sin;
        let angle_deg = ahead_deg.hypot(left_deg);
        (angle_deg, libm::atan2(left_deg, ahead_deg).to_degrees())
    }
}

impl WalkEffect for Slope {
    fn kind(&self) -> &'static str {
        "slope"
    }

    fn signature(&self) -> &'static str {
        "roll and pitch as the ground's, turning with the heading; the body drifts downhill"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let rise = |name| {
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: 4.0,
            };
            EffectParameter::new(name, prior)
                .bounds(-STEEPEST_DEG, STEEPEST_DEG)
                .neutral(0.0)
        };
        vec![rise("rise_ahead_deg"), rise("rise_left_deg")]
    }

    /// As the standing robot leans, if its sensor sits straight.
    fn starts(&self, _: Place, _: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>> {
        let [roll_deg, pitch_deg] = record.mean_tilt_deg();
        vec![vec![-pitch_deg, roll_deg]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        let (angle_deg, uphill_deg) = Self::polar_deg(values, model);
        model.simulation.terrain.slope_rad = angle_deg.to_radians();
        model.simulation.terrain.uphill_rad = uphill_deg.to_radians();
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        let (angle_deg, uphill_deg) = Self::polar_deg(values, model);
        named([("angle_deg", angle_deg), ("uphill_deg", uphill_deg)])
    }
}
