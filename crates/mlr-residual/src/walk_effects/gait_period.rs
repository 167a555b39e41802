use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The controller's clock runs slow or fast, so that the whole gait takes longer or shorter.
///
/// - `scale_less_1`: duration of a gait cycle over the described one, less 1; positive is slower.
///   People read `scale`.
/// - Prior: 0 ± 0.05: controllers without a hardware timer run off by some percent under load.
///   Assumed, not measured.
/// - Bounds: ±0.3.
#[derive(Debug)]
pub(super) struct GaitPeriod;

impl WalkEffect for GaitPeriod {
    fn kind(&self) -> &'static str {
        "gait_period"
    }

    fn signature(&self) -> &'static str {
        "every swing comes later, or earlier, than the one before"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 0.05,
        };
        vec![
            EffectParameter::new("scale_less_1", prior)
                .bounds(-0.3, 0.3)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let scales = [-0.06, -0.02, 0.02, 0.06];
        scales.map(|scale| vec![scale]).into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.gait.slow_down(1.0 + values[0]);
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Clock]
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(vec![changes.first()?.exp_m1()])
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("scale", 1.0 + values[0])])
    }
}
