use std::collections::BTreeMap;

use mlr_model::Payload as Load;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// Something rides on the body that is in no description.
///
/// - `mass_kg`: its mass.
/// - `x_kg_m`, `y_kg_m`: its mass times the distance of its centre from the body's origin, forward
///   and to the left: the body leans in proportion to these, towards the load. People read the
///   distances `x_m` and `y_m`.
/// - Prior: mass 0.18 ± 0.11 of the body's, moments 0 ± 0.05 of the body's mass times its length or
///   width: a battery or an arm is about a fifth of the body's mass, as far out as half of the
///   half width. Assumed, not measured.
/// - Bounds: mass 0 to that of the body, moments ±0.3 of the body's mass times length or width.
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
        let place_m = [arm_m(values[1], half_m.x), arm_m(values[2], half_m.y)];
        on_deck(mass_kg, place_m, model)
    }
}

/// A load that stands on the body with its centre at this x and y.
pub(super) fn on_deck(mass_kg: f64, [x_m, y_m]: [f64; 2], model: &WalkModel) -> Load {
    let deck_m = model.robot.body().size_m.z / 2.0;
    Load {
        mass_kg,
        position_m: [x_m, y_m, deck_m + LOAD_HEIGHT_M],
    }
}

/// Lets the robot carry this as well.
pub(super) fn add(load: Load, model: &mut WalkModel) {
    model.simulation.payload = match model.simulation.payload {
        Some(described) if load.mass_kg > 0.0 => Some(together(&described, &load)),
        None if load.mass_kg > 0.0 => Some(load),
        described => described,
    };
}

/// Both loads as one.
fn together(a: &Load, b: &Load) -> Load {
    let mass_kg = a.mass_kg + b.mass_kg;
    let share = b.mass_kg / mass_kg;
    let [ax_m, ay_m, az_m] = a.position_m;
    let [bx_m, by_m, bz_m] = b.position_m;
    let between = |a_m: f64, b_m: f64| a_m + share * (b_m - a_m);
    Load {
        mass_kg,
        position_m: [
            between(ax_m, bx_m),
            between(ay_m, by_m),
            between(az_m, bz_m),
        ],
    }
}

impl WalkEffect for Payload {
    fn kind(&self) -> &'static str {
        "payload"
    }

    fn signature(&self) -> &'static str {
        "the body leans towards the load, and further when the leg under it swings"
    }

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<EffectParameter> {
        let body = model.robot.body();
        let moment = |name, length_m: f64| {
            let of_body_kg_m = body.mass_kg * length_m;
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: 0.05 * of_body_kg_m,
            };
            EffectParameter::new(name, prior)
                .bounds(-0.3 * of_body_kg_m, 0.3 * of_body_kg_m)
                .neutral(0.0)
        };
        let prior = Prior::Normal {
            mean: 0.18 * body.mass_kg,
            deviation: 0.11 * body.mass_kg,
        };
        let mass = EffectParameter::new("mass_kg", prior);
        vec![
            mass.bounds(0.0, body.mass_kg).neutral(0.0),
            moment("x_kg_m", body.size_m.x),
            moment("y_kg_m", body.size_m.y),
        ]
    }

    fn starts(&self, _: Place, model: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let body = model.robot.body();
        let mass_kg = 0.2 * body.mass_kg;
        vec![vec![mass_kg, 0.0, 0.0]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        add(Self::load(values, model), model);
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        [0, 1].map(Nuisance::CenterOfMass).into()
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        let Load {
            mass_kg,
            position_m: [x_m, y_m, _],
        } = Self::load(values, model);
        named([("mass_kg", mass_kg), ("x_m", x_m), ("y_m", y_m)])
    }
}
