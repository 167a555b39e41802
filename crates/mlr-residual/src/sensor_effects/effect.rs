use std::fmt::Debug;

use thiserror::Error;

use crate::{SensorRecord, SensorSignals, Track};

/// A parameter of an effect: name with unit, where a fit starts, and its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name ending in the unit, as in `delay_s`.
    pub name: String,
    /// Where a fit starts.
    pub start: f64,
    /// Small change, for slopes.
    pub step: f64,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// The value at which the effect is absent, if there is one.
    pub neutral: Option<f64>,
}

impl Parameter {
    /// An unbounded parameter with a step of a thousandth.
    pub fn new(name: impl Into<String>, start: f64) -> Self {
        Self {
            name: name.into(),
            start,
            step: 1e-3,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            neutral: None,
        }
    }

    /// Sets the change over which slopes are taken.
    #[must_use]
    pub fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// Sets the bounds.
    #[must_use]
    pub fn bounds(self, lower: f64, upper: f64) -> Self {
        Self {
            lower,
            upper,
            ..self
        }
    }

    /// Sets the value at which the effect is absent.
    #[must_use]
    pub fn neutral(self, value: f64) -> Self {
        Self {
            neutral: Some(value),
            ..self
        }
    }

    /// The starting value, moved inside the bounds.
    pub fn start_within_bounds(&self) -> f64 {
        self.start.clamp(self.lower, self.upper)
    }

    /// A parameter that is known beforehand and not fitted together with others.
    #[must_use]
    pub fn fixed(self) -> Self {
        let value = self.start;
        self.bounds(value, value)
    }

    /// Whether it is known beforehand.
    pub fn is_fixed(&self) -> bool {
        self.lower >= self.upper
    }

    /// Whether a value lies at one of the bounds.
    pub fn is_at_bound(&self, value: f64) -> bool {
        let near =
            |bound: f64| bound.is_finite() && (value - bound).abs() <= 1e-9 * bound.abs().max(1e-3);
        !self.is_fixed() && (near(self.lower) || near(self.upper))
    }
}

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

    /// The trace that it leaves in the residual, for people.
    fn trace(&self) -> &'static str;

    /// The parameters, started from what the half of the record used for fitting
    /// shows.
    ///
    /// # Errors
    /// [`Inapplicable`] when the record has no trace that could be told.
    fn parameters(&self, fit_half: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable>;

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

    /// Whether it brings knowledge of the angle itself or of the bias, beyond the
    /// rate, so that drift stays bounded. Drift that one effect removes by chance
    /// and another by observation look the same; see
    /// [`explain_sensor()`](crate::explain_sensor()).
    fn observes_drift(&self) -> bool {
        false
    }

    /// Whether it speaks of the motion rather than of the sensor. Such effects are
    /// tried only when asked for.
    fn is_about_motion(&self) -> bool {
        false
    }
}
