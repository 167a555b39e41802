use std::collections::BTreeMap;

use mlr_model::Payload as Load;

use super::{
    Place, WalkEffect,
    effect::{around, named},
};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// Something heavy rides on the body.
#[derive(Debug)]
pub(super) struct Payload;

/// A load hangs over the body's edge by at most this share of its half width.
const OVERHANG: f64 = 1.3;
/// Height of a load's centre over the deck that it stands on.
const LOAD_HEIGHT_M: f64 = 0.03;
/// Below this share of the body's mass, where a load sits means nothing.
const LEAST_SHARE: f64 = 0.01;

impl Payload {
    fn load(values: &[f64], model: &WalkModel) -> Load {
        let body = model.robot.body();
        let half_m = body.size_m / 2.0;
        let mass_kg = values[0].max(0.0);
        let arm_m = |moment_kg_m: f64, half_m: f64| {
            let arm_m = moment_kg_m / mass_kg.max(LEAST_SHARE * body.mass_kg);
            arm_m.clamp(-OVERHANG * half_m, OVERHANG * half_m)
        };
        Load {
            mass_kg,
            position_m: [
                arm_m(values[1], half_m.x),
                arm_m(values[2], half_m.y),
                half_m.z + LOAD_HEIGHT_M,
            ],
        }
    }
}

impl WalkEffect for Payload {
    fn kind(&self) -> &'static str {
        "payload"
    }

    fn trace(&self) -> &'static str {
        "the body leans towards the load, and further when the leg under it swings"
    }

    /// Mass, and the moments that its weight has about the body's origin: the lean
    /// grows with these.
    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<Parameter> {
        let body = model.robot.body();
        let moment = |name: &str, length_m: f64| {
            let largest = 0.3 * body.mass_kg * length_m;
            Parameter::new(name, 0.0)
                .step(0.02 * largest)
                .bounds(-largest, largest)
                .neutral(0.0)
                .usual(f64::INFINITY)
        };
        vec![
            Parameter::new("mass_kg", 0.0)
                .step(0.02 * body.mass_kg)
                .bounds(0.0, body.mass_kg)
                .neutral(0.0)
                .usual(0.03 * body.mass_kg),
            moment("x_kg_m", body.size_m.x),
            moment("y_kg_m", body.size_m.y),
        ]
    }

    fn starts(&self, _: Place, model: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let body = model.robot.body();
        let mass_kg = 0.2 * body.mass_kg;
        let mut starts = vec![vec![mass_kg, 0.0, 0.0]];
        starts.extend(
            around(8, 0.7 * mass_kg)
                .into_iter()
                .map(|[x, y]| vec![mass_kg, x * body.size_m.x / 2.0, y * body.size_m.y / 2.0]),
        );
        starts
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.payload = Some(Self::load(values, model));
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        let Load {
            mass_kg,
            position_m: [x_m, y_m, _],
        } = Self::load(values, model);
        named([("mass_kg", mass_kg), ("x_m", x_m), ("y_m", y_m)])
    }
}
