//! How probable hypotheses are before the record is seen.

use mlr_filter::SettingError;
use mlr_model::{LostLinks, Morphology};
use serde::{Deserialize, Serialize};

use crate::{
    posterior::ln_sum,
    walk::{WalkModel, hypothesis::Placement},
};

/// Prior probabilities of hypotheses besides those of morphologies. Kinds of effects are equally
/// probable, and so are the places of a kind: nobody has counted them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct EffectPrior {
    /// Probability that a robot has any effect: whoever asks for an explanation expects one as
    /// likely as not.
    pub any: f64,
    /// Probability of one more, where there is one.
    pub another: f64,
    /// Probability of something that no effect of the library makes.
    pub unknown: f64,
    /// Probability that lost links hang on, where there are any.
    pub locked: f64,
}

impl Default for EffectPrior {
    fn default() -> Self {
        Self {
            any: 0.5,
            another: 0.15,
            unknown: 0.1,
            locked: 0.5,
        }
    }
}

impl EffectPrior {
    /// Checks every probability.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that is none.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, probability) in [
            ("any", self.any),
            ("another", self.another),
            ("unknown", self.unknown),
            ("locked", self.locked),
        ] {
            SettingError::check(name, probability, 1e-6..=1.0 - 1e-6, "")?;
        }
        Ok(())
    }

    /// Logarithms of what the evidence of a hypothesis counts where nothing unknown acts, and where something does.
    /// `ln_gain` is the logarithm of the factor by which errors as something unknown makes them raise it; that share of
    /// robots the engine misses by such errors.
    pub(crate) fn ln_without_and_with_unknown(&self, ln_gain: f64, missed_share: f64) -> [f64; 2] {
        let either = [(1.0 - missed_share).ln(), missed_share.ln() + ln_gain];
        [
            (1.0 - self.unknown).ln() + ln_sum(either.into_iter()),
            self.unknown.ln() + ln_gain,
        ]
    }

    /// Logarithm of the probability that lost links are gone, or hang on.
    pub(crate) fn ln_lost_links(&self, morphology: &Morphology, lost_links: LostLinks) -> f64 {
        match (morphology.is_healthy(), lost_links) {
            (true, _) => 0.0,
            (false, LostLinks::Locked) => self.locked.ln(),
            (false, LostLinks::Absent) => (1.0 - self.locked).ln(),
        }
    }

    /// Logarithm of the probability of so many effects.
    pub(crate) fn ln_number(&self, effects: usize) -> f64 {
        match effects {
            0 => (1.0 - self.any).ln(),
            n => self.any.ln() + (n - 1) as f64 * self.another.ln() + (1.0 - self.another).ln(),
        }
    }

    /// Logarithm of the probability of exactly these effects, of so many kinds in question.
    pub(crate) fn ln_effects(
        &self,
        effects: &[Placement],
        kinds: usize,
        model: &WalkModel,
        morphology: &Morphology,
    ) -> f64 {
        let of_number = self.ln_number(effects.len());
        let each = effects.iter().map(|placed| {
            let places = placed.effect.places(&model.robot, morphology).len().max(1);
            -((kinds * places) as f64).ln()
        });
        // Which of several came first makes no difference.
        let orders: f64 = (1..=effects.len()).map(|k| (k as f64).ln()).sum();
        of_number + each.sum::<f64>() + orders
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, Robot, SimulationSettings};

    use super::*;
    use crate::walk::{
        record::tests::level_record,
        search::{base::Base, tests::with_search},
    };
    use crate::walk_effects::{LIBRARY, Place, find};

    #[test]
    fn errors_as_something_unknown_makes_them_may_be_those_of_the_engine() {
        let prior = EffectPrior {
            unknown: 0.1,
            ..EffectPrior::default()
        };
        let unknown_by = |missed_share: f64, ln_gain: f64| {
            let [without, with] = prior.ln_without_and_with_unknown(ln_gain, missed_share);
            1.0 / (1.0 + (without - with).exp())
        };
        assert!((unknown_by(0.05, 0.0) - 0.1).abs() < 1e-12);
        // However much they raise the evidence, the ratio of both is what it was.
        let most = 0.1 / (0.1 + 0.9 * 0.05);
        for ln_gain in [30.0, 3000.0] {
            assert!((unknown_by(0.05, ln_gain) - most).abs() < 1e-9);
        }
        // The control: an engine that never errs so.
        assert!(unknown_by(0.0, 30.0) > 0.9999);
    }

    #[test]
    fn the_weight_of_a_hypothesis_counts_what_bounds_cut_off_its_prior() {
        let robot = Robot::jethexa();
        let morphology = Morphology::healthy(&robot.layout());
        let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
        let record = level_record();
        with_search(&record, &nominal, |search| {
            let base = Base::new(search.setting, &morphology, LostLinks::Absent, -0.5);
            let base = base.unwrap();
            let beyond_counting = |kind: &str, place: Place| {
                let effect = find(kind).unwrap();
                let effects = vec![Placement { effect, place }];
                let counted = search.prior.ln_effects(&effects, 10, &nominal, &morphology);
                search.ln_prior(base.ln_prior, &base.with(effects)) - base.ln_prior - counted
            };
            // Bounds at -3.43 and 1.57 standard deviations leave 0.9417 of the distribution.
            let weak = beyond_counting("weak_leg", Place::Leg(2));
            assert!((weak + 0.9417_f64.ln()).abs() < 1e-3, "{weak}");
            // Control: bounds at five standard deviations cut nothing off.
            let slope = beyond_counting("slope", Place::Robot);
            assert!((0.0..1e-5).contains(&slope), "{slope}");
        });
    }

    #[test]
    fn the_sets_of_at_most_two_effects_have_the_probability_of_their_number() {
        let robot = Robot::jethexa();
        let healthy = Morphology::healthy(&robot.layout());
        let model = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
        let each = LIBRARY.iter().flat_map(|effect| {
            let places = effect.places(&model.robot, &healthy).into_iter();
            places.map(|place| Placement {
                effect: *effect,
                place,
            })
        });
        let each: Vec<Placement> = each.collect();
        let prior = EffectPrior::default();
        let of = |effects: &[Placement]| {
            prior
                .ln_effects(effects, LIBRARY.len(), &model, &healthy)
                .exp()
        };
        let singles: f64 = each.iter().map(|one| of(&[*one])).sum();
        assert!(
            (singles - prior.any * (1.0 - prior.another)).abs() < 1e-9,
            "{singles}"
        );
        let mut pairs = 0.0;
        for (k, one) in each.iter().enumerate() {
            pairs += each[k + 1..]
                .iter()
                .map(|other| of(&[*one, *other]))
                .sum::<f64>();
        }
        // But for an effect twice at one place, which is none.
        let of_two = prior.any * prior.another * (1.0 - prior.another);
        assert!(pairs < of_two && pairs > 0.9 * of_two, "{pairs} {of_two}");
        assert!((of(&[]) - (1.0 - prior.any)).abs() < 1e-12);
    }
}
