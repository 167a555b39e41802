use std::fmt::Debug;

use thiserror::Error;

use crate::{Parameter, SensorRecord, SensorSignals, Track};

/// How common an effect is, most common first. Rarer ones are added only when none
/// of the more common ones helps: a dead band can imitate a delay, and an asymmetry a
/// bias, where the shaft swings at a steady rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Commonness {
    /// Every gyroscope has it, within the tolerances of its data sheet.
    Always,
    /// Usual for sensors of this kind and their logs.
    Usual,
    /// Seen now and then.
    Rare,
}

/// Why an effect cannot be tried on a record.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Inapplicable(pub &'static str);

/// Something that the data sheet's model lacks.
///
/// `values` are those of the parameters, in the order of
/// [`parameters()`](SensorEffect::parameters). Corrections see the sensor's signals
/// and never the reference angle, and sample i depends on signals up to i only,
/// except in [`SensorDelay`](crate::sensor_effects), which waits for as long as it
/// is late.
pub trait SensorEffect: Sync + Debug {
    /// Name in reports.
    fn kind(&self) -> &'static str;

    /// What it leaves in the residual, in words.
    fn signature(&self) -> &'static str;

    /// The parameters, started from what the stretch that they are fitted on shows.
    ///
    /// # Errors
    /// [`Inapplicable`] when nothing in that stretch could tell them.
    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable>;

    /// Corrects time stamps and rate, before the integration.
    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let _ = (values, signals, track);
    }

    /// Corrects the integrated angle.
    fn correct_angle(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let _ = (values, signals, track);
    }

    /// How common it is.
    fn commonness(&self) -> Commonness {
        Commonness::Rare
    }

    /// Whether it measures the angle itself or the bias, beyond the rate, so that drift
    /// stays bounded. A smaller drift alone does not show which effects do; see
    /// [`explain_sensor()`](crate::explain_sensor()).
    fn observes_drift(&self) -> bool {
        false
    }

    /// Whether it is an effect of the motion rather than of the sensor. Such effects are
    /// tried only when asked for.
    fn is_about_motion(&self) -> bool {
        false
    }
}
