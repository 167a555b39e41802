//! What a fit may change.

/// A parameter of a sensor effect: name with unit, where a fit starts, and its bounds.
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
