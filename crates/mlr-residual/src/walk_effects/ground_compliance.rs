use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// The ground is compliant, as carpet and foam are.
///
/// - `compliance_mm_per_n`: how far it sinks under a standing foot, in millimetres per newton, on
///   top of the described contact. People read `stiffness_npm`, in N/m.
/// - Prior: 1.2 ± 1.0 mm/N: carpet and foam give way by 1 mm for every 0.3 to 3 N. Assumed, not
///   measured.
/// - Bounds: 0 to 8 mm/N.
#[derive(Debug)]
pub(super) struct GroundCompliance;

/// Mass that a contact feels over the robot's mass per leg: measured on the standing
/// model, which sinks as its weight on one spring per foot would.
const MASS_AT_FOOT: f64 = 1.25;
/// A soft contact is damped critically; the stiffer the ground, the closer to the described damping.
const DAMPING_RATIO: f64 = 1.0;

impl GroundCompliance {
    /// Stiffness of the ground under one standing foot.
    fn stiffness_npm(values: &[f64]) -> f64 {
        1000.0 / values[0].max(1e-3)
    }

    /// Stiffness of the described contact over that of the contact and the ground below it, of this
    /// compliance, one spring on the other.
    fn softening(compliance_mm_per_n: f64, model: &WalkModel) -> f64 {
        let legs = model.robot.legs();
        let links = legs.iter().flat_map(|leg| &leg.links);
        let mass_kg = model.robot.body().mass_kg + links.map(|link| link.mass_kg).sum::<f64>();
        let at_foot_kg = MASS_AT_FOOT * mass_kg / legs.len() as f64;
        let rate_radps = std::f64::consts::TAU * model.simulation.contact.natural_frequency_hz;
        let contact_npm = at_foot_kg * rate_radps * rate_radps;
        1.0 + contact_npm * compliance_mm_per_n / 1000.0
    }
}

/// Puts ground that gives way by so much under the feet.
fn add(compliance_mm_per_n: f64, model: &mut WalkModel) {
    let softening = GroundCompliance::softening(compliance_mm_per_n, model);
    let contact = &mut model.simulation.contact;
    contact.natural_frequency_hz /= softening.sqrt();
    let beyond_critical = contact.damping_ratio - DAMPING_RATIO;
    contact.damping_ratio = DAMPING_RATIO + beyond_critical / softening;
}

/// The same by its stiffness under one standing foot.
pub(super) fn soften(stiffness_npm: f64, model: &mut WalkModel) {
    add(1000.0 / stiffness_npm, model);
}

impl WalkEffect for GroundCompliance {
    fn kind(&self) -> &'static str {
        "ground_compliance"
    }

    fn signature(&self) -> &'static str {
        "the body sways with every change of the standing legs"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 1.2,
            deviation: 1.0,
        };
        vec![
            EffectParameter::new("compliance_mm_per_n", prior)
                .bounds(0.0, 8.0)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.7], vec![2.0]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        add(values[0], model);
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("stiffness_npm", Self::stiffness_npm(values))])
    }
}
