//! The search for hypotheses: it proposes, and evidence decides.

pub(crate) mod base;
mod bases;
pub(crate) mod earlier;
mod extrapolation;
mod first_steps;
mod neighbours;
mod other_robots;
pub(crate) mod prior;
mod promise;
mod proposals;
mod race;
mod robots_alike;
pub(crate) mod screening;
mod unfitted;
mod unscreened;
mod weighing;
mod whole;

use std::sync::Arc;

use mlr_filter::SettingError;
use mlr_model::Morphology;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use self::{
    base::{Base, Setting},
    earlier::EarlierEffects,
    prior::EffectPrior,
    proposals::sort,
    unfitted::Unfitted,
};
use super::{
    evidence::Fit,
    hypothesis::{Hypothesis, Placement, Walker},
    observation::Observation,
};
use crate::{Progress, posterior::ln_sum};

/// A morphology that the robot may have.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Which links are left.
    pub morphology: Morphology,
    /// Logarithm of its probability before the record is compared with its walk.
    pub ln_prior: f64,
}

/// What is known of a robot before its record is seen.
#[derive(Clone, Copy)]
pub struct Beforehand<'p> {
    /// Logarithm of the prior probability of any morphology.
    pub ln_morphology: &'p (dyn Fn(&Morphology) -> f64 + Sync),
    /// What another log of the same robot and day says of its effects.
    pub effects: Option<&'p EarlierEffects>,
}

impl Beforehand<'_> {
    /// What is added to the logarithm of the prior probability of these effects.
    fn ln_effects(&self, effects: &[Placement], prior: &EffectPrior, kinds: usize) -> f64 {
        let placed = effects.iter().map(|one| one.effect.kind());
        self.effects.map_or(0.0, |earlier| {
            earlier.ln_factor(placed.map(str::to_string).collect(), prior, kinds)
        })
    }
}

/// A hypothesis with its evidence.
#[derive(Debug, Clone)]
pub(crate) struct Judged<'a> {
    pub(crate) base: Arc<Base<'a>>,
    pub(crate) walker: Walker<'a>,
    pub(crate) fit: Fit,
    /// Logarithm of evidence times prior probability.
    pub(crate) ln_weight: f64,
    /// The same with and without something unknown together, where that was looked at: what decides how far a search
    /// goes on.
    ln_promise: f64,
    /// Logarithms of what its weight counts without and with something unknown, where that was weighed.
    pub(crate) ln_without_and_with_unknown: Option<[f64; 2]>,
}

impl Judged<'_> {
    fn hypothesis(&self) -> &Hypothesis {
        &self.walker.hypothesis
    }
}

/// What a search found.
pub(crate) struct Searched<'a> {
    /// Every hypothesis that was fitted over the whole stretch, in no order.
    pub(crate) fitted: Vec<Judged<'a>>,
    /// Those that were not worth a fit.
    pub(crate) unfitted: Vec<Unfitted<'a>>,
}

/// How much is tried. Each number bounds the effort and decides nothing: what is left out scored
/// lower before it was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Effort {
    /// Robots that are fitted without effects, beside the one identified and the whole robot: of four times as many,
    /// which promise most by single walks, the likeliest after a step.
    pub bases: usize,
    /// Sets of damaged legs on which every effect is screened.
    pub screened: usize,
    /// Hypotheses that are walked at all, of those whose linear models promise most.
    pub entrants: usize,
    /// Hypotheses with an effect more than the likeliest one that are walked over the whole stretch: half of
    /// them take a step from there, and a quarter are weighed, besides the likeliest by extrapolation.
    pub neighbours: usize,
    /// Hypotheses with effects beside which those that are not worth a walk are weighed.
    pub extended: usize,
    /// Effects at most.
    pub most_effects: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            bases: 3,
            screened: 3,
            entrants: 96,
            neighbours: 12,
            extended: 3,
            most_effects: 2,
        }
    }
}

impl Effort {
    /// Checks every number. No effects at all are valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, count) in [
            ("bases", self.bases),
            ("screened", self.screened),
            ("entrants", self.entrants),
            ("neighbours", self.neighbours),
            ("extended", self.extended),
            ("most_effects", self.most_effects),
        ] {
            SettingError::check(name, count, 0..=1000, "")?;
        }
        Ok(())
    }
}

/// Hypotheses without effects that are kept, else what robots differ by is put down to an effect.
const BARE: usize = 3;

/// Hypotheses that fall so far behind in the logarithm of the likelihood that no fit brings them back; its power is how
/// much of that counts.
const HOPELESS: f64 = 150.0;

/// The search: over the beginning of the walk first, where walks differ smoothly from each other, then
/// over the whole stretch.
pub(crate) struct Search<'a, 'p> {
    pub(crate) setting: Setting<'a>,
    /// The same with the beginning of the walk alone.
    pub(crate) beginning: Setting<'a>,
    /// Both with what means of walks get wrong.
    pub(crate) of_means: &'a Observation<'a>,
    pub(crate) beginning_of_means: &'a Observation<'a>,
    pub(crate) prior: EffectPrior,
    pub(crate) effort: Effort,
    pub(crate) kinds: usize,
    pub(crate) progress: &'p dyn Progress,
    pub(crate) known: Beforehand<'p>,
    /// Draws the walks that means are taken of.
    pub(crate) generator: &'p ChaCha8Rng,
}

impl<'a> Search<'a, '_> {
    /// Proposes hypotheses, and fits those that promise most.
    pub(crate) fn run(&self, suspects: &[Suspect]) -> Searched<'a> {
        let bases = self.bases(suspects);
        let bare = self.without_effects(&bases.settled);
        if self.effort.most_effects == 0 {
            return Searched {
                fitted: self.weighed(self.over_the_whole_stretch(&bare)).all(),
                unfitted: Vec::new(),
            };
        }
        let screened = self.screened(&bare, &bases);
        let mut proposals = self.singles(&screened);
        if self.effort.most_effects > 1 {
            proposals.extend(self.pairs(&screened, &proposals));
        }
        sort(&mut proposals);
        let best = proposals.first().map_or(0.0, |one| one.ln_weight);
        let entrants = self.entrants(&screened, proposals, self.effort.entrants);
        let on_other_robots = self.on_unscreened_robots(&bases.begun, &screened, best);
        let bare = kept_bare(bare.iter().map(Judged::hypothesis))
            .into_iter()
            .map(|k| bare[k].clone());
        let entrants = entrants.into_iter().chain(on_other_robots);
        let ranked = self.race(entrants.chain(bare).collect());
        let weighed = self.weighed(self.over_the_whole_stretch(&ranked));
        let weighed = match self.effort.neighbours {
            0 => weighed,
            _ => {
                let weighed = self.with_effects_on_other_robots(weighed);
                let weighed = self.with_effects_on_robots_alike(weighed);
                let weighed = self.with_neighbours(self.with_fewer_than_the_likeliest(weighed));
                self.with_fewer_than_the_likeliest(weighed)
            }
        };
        let fitted = self.on_equal_terms(weighed).all();
        Searched {
            unfitted: self.unfitted(&screened, &ranked, &fitted),
            fitted,
        }
    }

    /// What turns the logarithm of a hypothesis' evidence, whose parameters have standard normal
    /// priors, into that of its weight.
    fn ln_prior(&self, ln_morphology: f64, walker: &Walker<'_>) -> f64 {
        let Hypothesis {
            morphology,
            lost_links,
            effects,
        } = &walker.hypothesis;
        ln_morphology
            + self.prior.ln_lost_links(morphology, *lost_links)
            + self
                .prior
                .ln_effects(effects, self.kinds, self.setting.nominal, morphology)
            + self.known.ln_effects(effects, &self.prior, self.kinds)
            + walker.ln_truncation()
    }

    /// Hypotheses whose logarithm of the weight falls so far behind are hopeless.
    fn hopeless(&self) -> f64 {
        HOPELESS * self.setting.observation.power()
    }

    /// What a hypothesis beside these has to promise not to be hopeless. That something unknown makes one of them
    /// likelier says nothing against the others, with which it may be as well.
    fn least_ln_promise(&self, judged: &[Judged<'_>]) -> f64 {
        let weights = judged.iter().map(|one| one.ln_weight);
        weights.fold(f64::NEG_INFINITY, f64::max) - self.hopeless()
    }

    /// A robot without effects promises as much as with something unknown, too: else a sure one that something unknown
    /// acts on falls behind one that may walk in any way.
    fn judge(&self, base: &Arc<Base<'a>>, walker: Walker<'a>, fit: Fit) -> Judged<'a> {
        let usual = &base.whitening;
        let by_unknown = walker.hypothesis.is_bare().then(|| {
            let observation = base.setting.observation;
            let ln_gain = fit.ln_gain_of_unknown(usual, &observation.with_unknown(usual));
            let missed_share = observation.missed_share(base.spread());
            self.prior
                .ln_without_and_with_unknown(ln_gain, missed_share)
        });
        Judged {
            ln_without_and_with_unknown: None,
            ..self.judged(base, walker, fit, by_unknown)
        }
    }

    fn judged(
        &self,
        base: &Arc<Base<'a>>,
        walker: Walker<'a>,
        fit: Fit,
        ln_without_and_with_unknown: Option<[f64; 2]>,
    ) -> Judged<'a> {
        let ln_weight = fit.ln_evidence + self.ln_prior(base.ln_prior, &walker);
        // What cannot be weighed is not in question.
        let ln_weight = if ln_weight.is_nan() {
            f64::NEG_INFINITY
        } else {
            ln_weight
        };
        let ln_without = (1.0 - self.prior.unknown).ln();
        let ln_both =
            ln_without_and_with_unknown.map_or(0.0, |both| ln_sum(both.into_iter()) - ln_without);
        Judged {
            base: Arc::clone(base),
            walker,
            fit,
            ln_weight,
            ln_promise: ln_weight + ln_both,
            ln_without_and_with_unknown,
        }
    }
}

/// Indices of the hypotheses without effects that are kept of these, the most promising first: the first, the same robot
/// with its lost links gone in place of locked, or the other way, and those that promise most of the rest.
fn kept_bare<'h>(ranked: impl Iterator<Item = &'h Hypothesis>) -> Vec<usize> {
    let bare = ranked.enumerate().filter(|(_, one)| one.is_bare());
    let mut bare: Vec<(usize, &Hypothesis)> = bare.collect();
    let differs_in_lost_links = |(_, one): &(usize, &Hypothesis)| {
        let first = bare[0].1;
        one.morphology == first.morphology && one.lost_links != first.lost_links
    };
    if let Some(other) = bare.iter().position(differs_in_lost_links) {
        bare[1..=other].rotate_right(1);
    }
    bare.into_iter().take(BARE).map(|(k, _)| k).collect()
}

fn sort_judged(judged: &mut [Judged<'_>]) {
    judged.sort_by(|a, b| b.ln_promise.total_cmp(&a.ln_promise));
}

#[cfg(test)]
mod tests {
    use mlr_filter::OrientationSeries;
    use mlr_model::{LegLayout, LostLinks};
    use rand::SeedableRng as _;

    use super::*;
    use crate::walk::{
        Discrepancy, NuisancePrior, NuisanceSettings, WalkModel, WalkRecord,
        record::tests::level_record,
    };
    use crate::walk_effects::{Place, find};

    #[test]
    fn the_likeliest_robot_stays_beside_itself_with_its_lost_links_in_the_other_state() {
        let layout = LegLayout::new(vec![3; 6]).unwrap();
        let with = |legs: &str, lost_links, effects| Hypothesis {
            morphology: Morphology::parse_legs_lost(legs, &layout).unwrap(),
            lost_links,
            effects,
        };
        let bare = |legs, lost_links| with(legs, lost_links, Vec::new());
        let slope = Placement {
            effect: find("slope").unwrap(),
            place: Place::Robot,
        };
        use LostLinks::{Absent, Locked};
        let ranked = [
            with("4,5", Absent, vec![slope]),
            bare("4,5", Absent),
            bare("5", Locked),
            bare("5", Absent),
            bare("4", Absent),
            bare("4,5", Locked),
        ];
        assert_eq!(kept_bare(ranked.iter()), [1, 5, 2]);
        // The control: where it is not there, those that promise most.
        assert_eq!(kept_bare(ranked[..5].iter()), [1, 2, 3]);
        assert!(kept_bare(ranked[..1].iter()).is_empty());
    }

    /// What the sensor of a robot shows that stands for a second and walks for three.
    pub(super) fn record_of(model: &WalkModel, morphology: &Morphology) -> WalkRecord {
        let level = level_record();
        let samples = level.times_s().len();
        let body = model.walk(morphology, &level, samples).unwrap().unwrap();
        let stood = (0..100).map(|index| f64::from(index) * 0.01);
        let walked = body.times_s().iter().map(|time_s| time_s + 1.0);
        let angles_rad = body.angles_rad().as_ref().map(|_, angle| {
            let stood = std::iter::repeat_n(angle[0], 100);
            stood.chain(angle.iter().copied()).collect()
        });
        let recording = OrientationSeries::new(stood.chain(walked).collect(), angles_rad).unwrap();
        WalkRecord::new(&recording, 1.0, true, 1.0, None).unwrap()
    }

    /// What `of` makes of a search that looks at this record of a robot, whose damage is as probable as any other.
    pub(super) fn with_search<T>(
        record: &WalkRecord,
        nominal: &WalkModel,
        of: impl FnOnce(&Search<'_, '_>) -> T,
    ) -> T {
        let discrepancy = Discrepancy::default();
        let observation = Observation::new(record, &discrepancy, nominal.gait.period_s);
        let nuisance = NuisancePrior::new(&NuisanceSettings::default(), nominal);
        let setting = Setting {
            observation: &observation,
            nuisance: &nuisance,
            nominal,
        };
        of(&Search {
            setting,
            beginning: setting,
            of_means: &observation,
            beginning_of_means: &observation,
            prior: EffectPrior::default(),
            effort: Effort::default(),
            kinds: 10,
            progress: &(),
            generator: &ChaCha8Rng::seed_from_u64(0),
            known: Beforehand {
                ln_morphology: &|_| 0.0,
                effects: None,
            },
        })
    }
}
