use std::collections::BTreeMap;

use mlr_model::Fault;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// A constant force pulls at the body's centre of mass: a tether, a cable, the wind.
///
/// - `x_n`, `y_n`, `z_n`: the force in the ground's frame, in newtons: x along the first heading,
///   y to its left, z up.
/// - Prior: 0 ± 0.13 of the body's weight along x and y and 0 ± 0.08 along z: a cable drags with
///   about a tenth of a small robot's weight, and lifts or presses with less. Assumed, not measured.
/// - Bounds: ± the body's weight.
#[derive(Debug)]
pub(super) struct ExternalForce;

/// Standard gravity: forces are in proportion to the body's weight, so that they fit any robot.
const GRAVITY_MPS2: f64 = 9.81;

impl WalkEffect for ExternalForce {
    fn kind(&self) -> &'static str {
        "external_force"
    }

    fn signature(&self) -> &'static str {
        "the body leans and drifts one way over the ground, whatever its heading"
    }

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<EffectParameter> {
        let weight_n = GRAVITY_MPS2 * model.robot.body().mass_kg;
        let force = |name, share: f64| {
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: share * weight_n,
            };
            EffectParameter::new(name, prior)
                .bounds(-weight_n, weight_n)
                .neutral(0.0)
        };
        vec![force("x_n", 0.13), force("y_n", 0.13), force("z_n", 0.08)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.0; 3]]
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
