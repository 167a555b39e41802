use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The sensor is mounted at an angle.
#[derive(Debug)]
pub(super) struct ImuMisalignment;

/// How far a sensor usually sits off, where it sits off.
pub(super) const USUAL_TILT_DEG: f64 = 2.5;
/// The standing robot shows a tilt, whatever models get wrong of its walk: on six undisturbed
/// robots (seed 1 of the plant) tilted sensors and slopes gained 3 at most on a stretch, where
/// others gained 6.
pub(super) const TILT_CHANCE_SHARE: f64 = 1.0 / 3.0;

impl WalkEffect for ImuMisalignment {
    fn kind(&self) -> &'static str {
        "imu_misalignment"
    }

    fn trace(&self) -> &'static str {
        "the same offset of roll and pitch, standing and walking, whatever the heading"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let angle = |name| {
            Parameter::new(name, 0.0)
                .step(0.2)
                .bounds(-30.0, 30.0)
                .neutral(0.0)
                .usual(0.75)
        };
        vec![angle("roll_deg"), angle("pitch_deg")]
    }

    fn starts(&self, _: Place, _: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>> {
        vec![record.mean_tilt_deg().into()]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        for (angle_deg, value) in model.sensing.misalignment_deg.iter_mut().zip(values) {
            *angle_deg += value;
        }
    }

    fn rarity(&self, values: &[f64]) -> f64 {
        (values[0].hypot(values[1]) / USUAL_TILT_DEG).powi(2)
    }

    fn chance_share(&self) -> f64 {
        TILT_CHANCE_SHARE
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("roll_deg", values[0]), ("pitch_deg", values[1])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
