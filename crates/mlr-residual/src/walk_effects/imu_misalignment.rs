use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The sensor is mounted at an angle to the body.
///
/// - `roll_deg`, `pitch_deg`: roll and pitch of the sensor on the level body, in degrees; the
///   sensor reports them on top of the body's.
/// - Prior: 0 ± 2.5° each: a sensor that was knocked, or remounted by eye. Assumed, not measured.
/// - Bounds: ±30°.
#[derive(Debug)]
pub(super) struct ImuMisalignment;

impl WalkEffect for ImuMisalignment {
    fn kind(&self) -> &'static str {
        "imu_misalignment"
    }

    fn signature(&self) -> &'static str {
        "the same offset of roll and pitch, standing and walking, whatever the heading"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let angle = |name| {
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: 2.5,
            };
            EffectParameter::new(name, prior)
                .bounds(-30.0, 30.0)
                .neutral(0.0)
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

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        [0, 1].map(Nuisance::Misalignment).into()
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(changes.to_vec())
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("roll_deg", values[0]), ("pitch_deg", values[1])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
