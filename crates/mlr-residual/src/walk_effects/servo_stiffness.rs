use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The servos give way more or less than usual.
#[derive(Debug)]
pub(super) struct ServoStiffness;

impl ServoStiffness {
    fn stiffness(values: &[f64], model: &WalkModel) -> f64 {
        model.servo.stiffness_nm_per_rad * values[0].exp()
    }
}

impl WalkEffect for ServoStiffness {
    fn kind(&self) -> &'static str {
        "servo_stiffness"
    }

    fn trace(&self) -> &'static str {
        "every swing of the body is larger or smaller, and later"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let ratio = Parameter::new("ln_stiffness", 0.0);
        vec![ratio.step(0.06).bounds(-2.5, 1.5).neutral(0.0).usual(0.2)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.4, 0.65, 1.6].map(|share: f64| vec![share.ln()]).into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.stiffness_nm_per_rad = Self::stiffness(values, model);
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("stiffness", Self::stiffness(values, model))])
    }
}
