use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The zero of a joint has moved, as after its servo's horn was remounted or slipped.
///
/// - `angle_rad`: true angle less commanded angle, in radians; positive turns a yaw joint to the
///   left and lifts the link of a lift joint, so that the body's corner sinks.
/// - Prior: 0 ± 0.17 rad: half a tooth to one tooth of a horn with 25 teeth, 0.25 rad each.
/// - Bounds: ±0.7 rad.
#[derive(Debug)]
pub(super) struct JointOffset;

impl WalkEffect for JointOffset {
    fn kind(&self) -> &'static str {
        "joint_offset"
    }

    fn signature(&self) -> &'static str {
        "the body leans, at rest and while that leg stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::links(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 0.17,
        };
        vec![
            EffectParameter::new("angle_rad", prior)
                .bounds(-0.7, 0.7)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-0.12], vec![0.12]]
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.faults.push(Fault::JointOffset {
            leg: place.leg(),
            joint: place.link(),
            angle_rad: values[0],
        });
    }

    fn replaces(&self, place: Place) -> Vec<Nuisance> {
        vec![Nuisance::JointZero(place.leg() - 1, place.link() - 1)]
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(changes.to_vec())
    }

    fn report(&self, place: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("leg", place.leg() as f64),
            ("joint", place.link() as f64),
            ("angle_rad", values[0]),
        ])
    }
}
