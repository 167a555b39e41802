use std::collections::BTreeMap;

use mlr_model::Fault;

use super::{
    Place, WalkEffect,
    effect::{around, named},
};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// Something pulls at the body: a tether, a cable, the wind.
#[derive(Debug)]
pub(super) struct ExternalForce;

/// Forces are tried in shares of the body's weight, so that any robot has its scale.
const GRAVITY_MPS2: f64 = 9.81;

impl WalkEffect for ExternalForce {
    fn kind(&self) -> &'static str {
        "external_force"
    }

    fn trace(&self) -> &'static str {
        "the body leans and drifts one way over the ground, whatever its heading"
    }

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<Parameter> {
        let weight_n = GRAVITY_MPS2 * model.robot.body().mass_kg;
        ["x_n", "y_n", "z_n"]
            .map(|name| {
                Parameter::new(name, 0.0)
                    .step(0.02 * weight_n)
                    .bounds(-weight_n, weight_n)
                    .neutral(0.0)
                    .usual(0.02 * weight_n)
            })
            .into()
    }

    fn starts(&self, _: Place, model: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let force_n = 0.15 * GRAVITY_MPS2 * model.robot.body().mass_kg;
        let pulls = around(8, force_n).into_iter();
        pulls.map(|[x, y]| vec![x, y, 0.0]).collect()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        let force_n = [values[0], values[1], values[2]];
        model
            .simulation
            .faults
            .push(Fault::ExternalForce { force_n });
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("x_n", values[0]), ("y_n", values[1]), ("z_n", values[2])])
    }
}
