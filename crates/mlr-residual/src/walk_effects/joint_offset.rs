use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The zero of a joint has moved.
#[derive(Debug)]
pub(super) struct JointOffset;

/// By how much zeros usually move: a servo's horn that is one of 25 teeth off is off by
/// 0.25 rad.
pub(super) const USUAL_RAD: f64 = 0.2;

impl WalkEffect for JointOffset {
    fn kind(&self) -> &'static str {
        "joint_offset"
    }

    fn trace(&self) -> &'static str {
        "the body leans, at rest and while that leg stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::links(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        vec![
            Parameter::new("angle_rad", 0.0)
                .step(0.02)
                .bounds(-0.7, 0.7)
                .neutral(0.0)
                .usual(0.03),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-0.15], vec![0.15]]
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.faults.push(Fault::JointOffset {
            leg: place.leg(),
            joint: place.link(),
            angle_rad: values[0],
        });
    }

    fn rarity(&self, values: &[f64]) -> f64 {
        (values[0] / USUAL_RAD).powi(2)
    }

    fn report(&self, place: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("leg", place.leg() as f64),
            ("joint", place.link() as f64),
            ("angle_rad", values[0]),
        ])
    }
}
