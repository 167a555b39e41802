//! What a fit may change.

use crate::Prior;

/// A parameter of an effect: name with unit, where a fit starts, its bounds and its prior.
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
    /// How far from there it is on things that nothing is wrong with.
    pub usual: f64,
    /// What is known of it before a record is seen, in its own unit.
    pub prior: Option<Prior>,
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
            usual: 0.0,
            prior: None,
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

    /// Sets how far from its neutral value it usually is.
    #[must_use]
    pub fn usual(self, usual: f64) -> Self {
        Self { usual, ..self }
    }

    /// Sets what is known of it before a record is seen.
    #[must_use]
    pub fn prior(self, prior: Prior) -> Self {
        Self {
            prior: Some(prior),
            ..self
        }
    }

    /// Natural logarithm of the prior density at a value, normalised over the bounds: negative
    /// infinity outside them. None without a prior, and where the parameter is known beforehand.
    pub fn ln_prior_density(&self, value: f64) -> Option<f64> {
        let prior = self.prior.filter(|_| !self.is_fixed())?;
        Some(prior.ln_density_within(value, self.lower, self.upper))
    }

    /// Whether a value is no more than what is usual.
    pub fn is_usual(&self, value: f64) -> bool {
        self.neutral
            .is_some_and(|neutral| (value - neutral).abs() <= self.usual)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_prior_is_normalised_over_the_bounds_of_the_parameter() {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 1.0,
        };
        let free = Parameter::new("bias_dps", 0.0).prior(prior);
        let bounded = free.clone().bounds(0.0, f64::INFINITY);
        let density = |parameter: &Parameter, value| parameter.ln_prior_density(value).unwrap();
        assert_eq!(density(&free, 0.3), prior.ln_density(0.3));
        // Half of the line is cut off, so that the density on the other half doubles.
        let doubled = density(&bounded, 0.3) - density(&free, 0.3);
        assert!((doubled - std::f64::consts::LN_2).abs() < 1e-12);
        assert_eq!(density(&bounded, -0.3), f64::NEG_INFINITY);
        assert_eq!(free.clone().fixed().ln_prior_density(0.0), None);
        assert_eq!(Parameter::new("mu", 0.7).ln_prior_density(0.7), None);
    }

    #[test]
    fn what_is_usual_lies_around_the_neutral_value() {
        let ratio = Parameter::new("ln_friction", 0.0).neutral(0.0).usual(0.25);
        assert!(ratio.is_usual(-0.25) && !ratio.is_usual(0.3));
        let exact = Parameter::new("mass_kg", 0.0).neutral(0.0);
        assert!(exact.is_usual(0.0) && !exact.is_usual(1e-6));
        // A joint that is stuck is stuck, wherever that is.
        assert!(!Parameter::new("angle_rad", 0.0).is_usual(0.0));
    }
}
