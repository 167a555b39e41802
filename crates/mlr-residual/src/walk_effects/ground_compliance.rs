use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The ground gives way under the feet.
#[derive(Debug)]
pub(super) struct GroundCompliance;

/// Mass that a contact feels over the robot's mass per leg: measured on the standing
/// model, which sinks as its weight on one spring per foot would.
const MASS_AT_FOOT: f64 = 1.25;
/// A soft contact is damped as if critically.
const DAMPING_RATIO: f64 = 1.0;

impl GroundCompliance {
    /// Stiffness of the spring under one standing foot.
    fn stiffness_npm(values: &[f64]) -> f64 {
        1000.0 / values[0].max(1e-3)
    }

    fn frequency_hz(stiffness_npm: f64, model: &WalkModel) -> f64 {
        let legs = model.robot.legs();
        let links = legs.iter().flat_map(|leg| &leg.links);
        let mass_kg = model.robot.body().mass_kg + links.map(|link| link.mass_kg).sum::<f64>();
        let at_foot_kg = MASS_AT_FOOT * mass_kg / legs.len() as f64;
        (stiffness_npm / at_foot_kg).sqrt() / std::f64::consts::TAU
    }
}

impl WalkEffect for GroundCompliance {
    fn kind(&self) -> &'static str {
        "ground_compliance"
    }

    fn trace(&self) -> &'static str {
        "the body sways with every change of the standing legs"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let compliance = Parameter::new("compliance_mm_per_n", 0.0);
        vec![
            compliance
                .step(0.05)
                .bounds(0.1, 8.0)
                .neutral(0.1)
                .usual(0.1),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.6], vec![2.0]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        let frequency_hz = Self::frequency_hz(Self::stiffness_npm(values), model);
        let contact = &mut model.simulation.contact;
        contact.natural_frequency_hz = frequency_hz;
        contact.damping_ratio = DAMPING_RATIO;
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("stiffness_npm", Self::stiffness_npm(values))])
    }
}
