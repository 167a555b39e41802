//! What is fitted of an effect of a walk or of a servo.

use std::collections::BTreeMap;

use crate::Prior;

/// A parameter of an effect. Its name ends in its unit; a ratio or a logarithm has none.
///
/// Unlike a parameter of a sensor effect it always has a prior. A fit moves its coordinate: its
/// distance from the mean of the prior, in standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name with the unit, as in `delay_s`.
    pub name: &'static str,
    /// What is known of it before a record is seen, where the effect is present.
    pub prior: Prior,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// The value at which the effect is absent, if there is one.
    pub neutral: Option<f64>,
}

impl EffectParameter {
    /// An unbounded parameter.
    pub(crate) fn new(name: &'static str, prior: Prior) -> Self {
        Self {
            name,
            prior,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            neutral: None,
        }
    }

    /// One whose logarithm is normal about that of `median`, with this deviation.
    pub(crate) fn ln(name: &'static str, median: f64, deviation: f64) -> Self {
        let mean = median.ln();
        Self::new(name, Prior::Normal { mean, deviation })
    }

    /// A delay beyond the described one: 0.05 ± 0.03 s, from 0 to 0.5 s.
    pub(crate) fn delay() -> Self {
        let prior = Prior::Normal {
            mean: 0.05,
            deviation: 0.03,
        };
        Self::new("delay_s", prior).bounds(0.0, 0.5).neutral(0.0)
    }

    /// Sets the bounds.
    pub(crate) fn bounds(self, lower: f64, upper: f64) -> Self {
        Self {
            lower,
            upper,
            ..self
        }
    }

    /// Sets the value at which the effect is absent.
    pub(crate) fn neutral(self, value: f64) -> Self {
        Self {
            neutral: Some(value),
            ..self
        }
    }

    /// The value at a coordinate, moved inside the bounds.
    pub(crate) fn value(&self, coordinate: f64) -> f64 {
        let Prior::Normal { mean, deviation } = self.prior;
        (mean + deviation * coordinate)
            .max(self.lower)
            .min(self.upper)
    }

    /// The coordinate of a value.
    pub(crate) fn coordinate(&self, value: f64) -> f64 {
        let Prior::Normal { mean, deviation } = self.prior;
        (value - mean) / deviation
    }

    /// A coordinate moved inside the bounds.
    pub(crate) fn within_bounds(&self, coordinate: f64) -> f64 {
        let [lower, upper] = [self.lower, self.upper].map(|bound| self.coordinate(bound));
        coordinate.max(lower).min(upper)
    }

    /// What the bounds add to the logarithm of the prior density: they cut the normal
    /// distribution, and what is left has to integrate to one.
    pub(crate) fn ln_truncation(&self) -> f64 {
        -self.prior.ln_mass_within(self.lower, self.upper)
    }

    /// Whether a value lies at one of the bounds.
    pub fn is_at_bound(&self, value: f64) -> bool {
        let Prior::Normal { deviation, .. } = self.prior;
        [self.lower, self.upper]
            .iter()
            .any(|bound| (value - bound).abs() <= 1e-9 * deviation)
    }
}

/// A report of these names and values.
pub(crate) fn named<'n>(values: impl IntoIterator<Item = (&'n str, f64)>) -> BTreeMap<String, f64> {
    let owned = |(name, value): (&str, f64)| (name.to_string(), value);
    values.into_iter().map(owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weak() -> EffectParameter {
        let prior = Prior::Normal {
            mean: -1.0,
            deviation: 0.5,
        };
        EffectParameter::new("ln_gain", prior).bounds(-3.0, 0.0)
    }

    #[test]
    fn a_coordinate_is_the_distance_from_the_mean_in_deviations() {
        assert_eq!(weak().coordinate(-2.0), -2.0);
        assert_eq!(weak().value(-2.0), -2.0);
        assert_eq!(weak().value(1.0), -0.5);
        // Beyond a bound there is nothing.
        assert_eq!(weak().value(4.0), 0.0);
        assert_eq!(weak().within_bounds(4.0), 2.0);
        assert_eq!(weak().within_bounds(-1.5), -1.5);
    }

    #[test]
    fn values_at_a_bound_are_told_from_those_near_it() {
        assert!(weak().is_at_bound(0.0) && weak().is_at_bound(weak().value(9.0)));
        assert!(!weak().is_at_bound(-1e-6) && !weak().is_at_bound(-1.0));
    }

    #[test]
    fn bounds_raise_the_density_of_what_they_leave() {
        // Of the normal distribution, bounds at -4 and 2 deviations leave 0.977 218.
        assert!((weak().ln_truncation() + 0.977_218_f64.ln()).abs() < 1e-6);
        let at_the_mean = weak().bounds(-1.0, f64::INFINITY);
        assert!((at_the_mean.ln_truncation() - std::f64::consts::LN_2).abs() < 1e-12);
        let unbounded = EffectParameter::new("ln_gain", weak().prior);
        assert_eq!(unbounded.ln_truncation(), 0.0);
    }
}
