use std::collections::BTreeMap;

use mlr_model::bench::Bench;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::{
    Prior,
    servo::{ServoModel, ServoRecording},
};

/// The motor's torque follows its supply.
///
/// - `share`: change of the torque over that of the supply: 1 for a motor without a regulator.
/// - Prior: 0.5 ± 0.5. Bounds: 0 to 1.5. Needs `volts` in the recordings and `supply_v` of the bench.
#[derive(Debug)]
pub(super) struct SupplyVoltage;

impl ServoEffect for SupplyVoltage {
    fn kind(&self) -> &'static str {
        "supply_voltage"
    }

    fn signature(&self) -> &'static str {
        "the servo is weaker when the supply sags"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.5,
            deviation: 0.5,
        };
        vec![
            EffectParameter::new("share", prior)
                .bounds(0.0, 1.5)
                .neutral(0.0),
        ]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.supply_share = values[0];
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("share", values[0])])
    }

    fn shows_in(&self, bench: &Bench, recordings: &[ServoRecording]) -> bool {
        let recorded = recordings.iter().any(|one| !one.supply_v.is_empty());
        recorded && bench.reference.supply_v.is_some()
    }
}
