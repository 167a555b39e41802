use std::{collections::BTreeMap, fmt::Debug};

use mlr_model::bench::Bench;

pub(super) use crate::effect_parameter::named;
use crate::{
    EffectParameter,
    servo::{ServoModel, ServoRecording},
};

/// Something that a servo has and its data sheet lacks.
///
/// `values` are those of the parameters, in the order of [`parameters()`](ServoEffect::parameters):
/// logarithms where a number is positive by nature. What people read comes from
/// [`report()`](ServoEffect::report).
pub trait ServoEffect: Sync + Debug {
    /// Name in reports.
    fn kind(&self) -> &'static str;

    /// What it leaves in the residual, in words.
    fn signature(&self) -> &'static str;

    /// What is fitted, with priors and bounds.
    fn parameters(&self, described: &ServoModel) -> Vec<EffectParameter>;

    /// Coordinates of all its parameters from which it is fitted; the best counts. By default the mean of
    /// the prior, and one and two deviations less, where an effect of a positive size is nearly absent.
    fn start_coordinates(&self) -> &'static [f64] {
        &[0.0, -1.0, -2.0]
    }

    /// Adds the effect to the model.
    fn apply(&self, values: &[f64], model: &mut ServoModel);

    /// The parameters that people read, in the units of their names.
    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64>;

    /// The kind of effect without which this one makes no sense.
    fn builds_on(&self) -> Option<&'static str> {
        None
    }

    /// Whether recordings of this bench can show it at all.
    fn shows_in(&self, bench: &Bench, recordings: &[ServoRecording]) -> bool {
        let _ = (bench, recordings);
        true
    }
}
