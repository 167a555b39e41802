use mlr_filter::SettingError;
use mlr_model::Morphology;
use serde::{Deserialize, Serialize};

/// The prior over damage: legs are lost independently, and few at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct DamagePrior {
    /// Probability that a leg is damaged.
    pub leg_damaged: f64,
    /// Of a damaged leg, how much less probable each further remaining link makes
    /// its state: a leg that is hit is gone as a whole rather than in part.
    pub remaining_link: f64,
}

impl Default for DamagePrior {
    fn default() -> Self {
        Self {
            leg_damaged: 0.12,
            remaining_link: 0.8,
        }
    }
}

impl DamagePrior {
    /// Probability that of so many legs exactly these are damaged.
    pub fn of_legs(&self, damaged: usize, legs: usize) -> f64 {
        let whole = legs.saturating_sub(damaged);
        self.leg_damaged.powi(damaged as i32) * (1.0 - self.leg_damaged).powi(whole as i32)
    }

    /// Probability of each of a leg's links to be gone, from the body outward.
    pub fn link_loss(&self, links: usize) -> Vec<f64> {
        let states: f64 = (0..links).map(|state| self.weight(state)).sum();
        (0..links)
            .map(|link| {
                let gone: f64 = (0..=link).map(|state| self.weight(state)).sum();
                self.leg_damaged * gone / states
            })
            .collect()
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("leg_damaged", self.leg_damaged, 1e-9..=0.999, "")?;
        SettingError::check("remaining_link", self.remaining_link, 1e-6..=1e6, "")
    }

    /// Logarithm of the probability of a morphology.
    pub fn ln(&self, morphology: &Morphology) -> f64 {
        (0..morphology.legs())
            .map(|leg| {
                let (links, remaining) = (morphology.links(leg), morphology.remaining(leg));
                if remaining == links {
                    (1.0 - self.leg_damaged).ln()
                } else {
                    let states: f64 = (0..links).map(|state| self.weight(state)).sum();
                    (self.leg_damaged * self.weight(remaining) / states).ln()
                }
            })
            .sum()
    }

    fn weight(&self, remaining: usize) -> f64 {
        self.remaining_link.powi(remaining as i32)
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;

    use super::*;

    #[test]
    fn probabilities_of_all_morphologies_add_up_to_one() {
        for links in [vec![3; 6], vec![2, 1, 4]] {
            let layout = LegLayout::new(links).unwrap();
            let prior = DamagePrior::default();
            let total: f64 = layout.enumerate().map(|m| prior.ln(&m).exp()).sum();
            assert!((total - 1.0).abs() < 1e-9, "{total}");
        }
    }

    #[test]
    fn legs_and_links_are_as_probable_as_their_morphologies_together() {
        let layout = LegLayout::new([3, 3, 3, 3]).unwrap();
        let prior = DamagePrior::default();
        let sum = |condition: &dyn Fn(&Morphology) -> bool| -> f64 {
            let all = layout.enumerate().filter(|m| condition(m));
            all.map(|m| prior.ln(&m).exp()).sum()
        };
        let legs = sum(&|m| m.damaged_legs() == [2, 3]);
        assert!((prior.of_legs(2, 4) - legs).abs() < 1e-12);
        for (link, probability) in prior.link_loss(3).into_iter().enumerate() {
            let gone = sum(&|m| m.remaining(0) <= link);
            assert!((probability - gone).abs() < 1e-12, "link {link}");
        }
    }

    #[test]
    fn less_damage_is_more_probable() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let prior = DamagePrior::default();
        let ln = |legs| prior.ln(&Morphology::parse_legs_lost(legs, &layout).unwrap());
        assert!(prior.ln(&Morphology::healthy(&layout)) > ln("3"));
        assert!(ln("3") > ln("3,4") && ln("3,4") > ln("1,3,4"));
    }
}
