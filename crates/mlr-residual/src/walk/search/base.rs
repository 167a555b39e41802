//! A robot without effects, and how sensitive its walk is.

use mlr_model::{LostLinks, Morphology};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

use super::extrapolation::Simulated;
use crate::walk::{
    NuisancePrior, Observation, WalkModel,
    discrepancy::{Compared, Spread},
    evidence::{Fit, ln_evidence},
    hypothesis::{Hypothesis, Placement, Walked, Walker},
    mean_walk::MeanWalks,
    observation::Whitening,
};

/// Steps from the robot as described, and from there on with slopes taken anew.
const FIRST_STEPS: usize = 2;
const REFERENCE_STEPS: usize = 3;
/// Steps once it is known how walks scatter.
const SCATTERED_STEPS: usize = 2;

/// What every hypothesis about a record has in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) observation: &'a Observation<'a>,
    pub(crate) nuisance: &'a NuisancePrior,
    pub(crate) nominal: &'a WalkModel,
}

/// A morphology with lost links gone or locked, as described and without effects: hypotheses on it
/// share its sensitivities.
#[derive(Debug)]
pub(crate) struct Base<'a> {
    pub(crate) setting: Setting<'a>,
    pub(crate) morphology: Morphology,
    pub(crate) lost_links: LostLinks,
    /// Logarithm of its prior probability.
    pub(crate) ln_prior: f64,
    /// Its most probable walk without effects: what effects are added to.
    pub(crate) reference: Walked,
    pub(crate) jacobian: DMatrix<f64>,
    pub(crate) whitening: Whitening,
    /// The reference, for effects that are added to it.
    pub(crate) simulated: Simulated,
}

impl<'a> Base<'a> {
    /// After a first step from the robot as described; `None` when it does not walk.
    pub(crate) fn new(
        setting: Setting<'a>,
        morphology: &Morphology,
        lost_links: LostLinks,
        ln_prior: f64,
    ) -> Option<Self> {
        let walker = setting.bare(morphology, lost_links);
        let described = walker.described(&[]);
        Self::begun(&walker, setting, described, FIRST_STEPS, ln_prior)
    }

    /// As described, on no step; `None` when it does not walk.
    pub(crate) fn as_described(
        setting: Setting<'a>,
        morphology: &Morphology,
        lost_links: LostLinks,
        ln_prior: f64,
    ) -> Option<Self> {
        let walker = setting.bare(morphology, lost_links);
        Self::begun(&walker, setting, walker.described(&[]), 0, ln_prior)
    }

    /// Whether it is the robot with these links, the lost ones gone or locked.
    pub(super) fn is_robot(&self, morphology: &Morphology, lost_links: LostLinks) -> bool {
        self.morphology == *morphology && self.lost_links == lost_links
    }

    /// The robot of `walker`, so many steps on from these parameters.
    fn begun(
        walker: &Walker<'a>,
        setting: Setting<'a>,
        z: DVector<f64>,
        steps: usize,
        ln_prior: f64,
    ) -> Option<Self> {
        let walked = walker.walk(z)?;
        let jacobian = walker.jacobian(&walked);
        let whitening = walker.whitening(&jacobian)?;
        let fit = walker.advanced(walked, jacobian, &whitening, steps);
        Some(Self {
            simulated: Simulated::new(&fit, &whitening),
            setting,
            morphology: walker.hypothesis.morphology.clone(),
            lost_links: walker.hypothesis.lost_links,
            ln_prior,
            reference: fit.walked,
            jacobian: fit.jacobian,
            whitening,
        })
    }

    /// The same at its most probable walk.
    pub(crate) fn settled(&self) -> Option<Self> {
        let walker = self.with(Vec::new());
        let jacobian = walker.jacobian(&self.reference);
        let reference = self.reference.clone();
        let fit = walker.advanced(reference, jacobian, &self.whitening, REFERENCE_STEPS);
        let whitening = walker.whitening(&fit.jacobian)?;
        Some(self.at(fit, whitening))
    }

    /// The same at another fit, for errors of another covariance.
    fn at(&self, fit: Fit, whitening: Whitening) -> Self {
        Self {
            setting: self.setting,
            morphology: self.morphology.clone(),
            lost_links: self.lost_links,
            ln_prior: self.ln_prior,
            simulated: Simulated::new(&fit, &whitening),
            reference: fit.walked,
            jacobian: fit.jacobian,
            whitening,
        }
    }

    /// The same with errors of walks that scatter as those about its most probable one do: `of_means` has what
    /// their mean gets wrong, `generator` draws them.
    pub(crate) fn scattered(
        &self,
        of_means: &Observation<'_>,
        generator: &ChaCha8Rng,
    ) -> Option<Self> {
        let walker = self.with(Vec::new());
        let spread = self.spread();
        let fit = self.fit(&walker);
        let walks = self.mean_walks(of_means, generator);
        let scatter = walks.scatter(&walker, &fit);
        let compared = scatter.as_ref().map_or(Compared::Walk, Compared::WalkOf);
        let whitening = of_means.whitening(spread, compared)?;
        let fit = walker.advanced(fit.walked, fit.jacobian, &whitening, SCATTERED_STEPS);
        Some(self.at(fit, whitening))
    }

    /// For hypotheses on this robot: all take the same draws.
    pub(crate) fn mean_walks<'w>(
        &self,
        of_means: &'w Observation<'w>,
        generator: &ChaCha8Rng,
    ) -> MeanWalks<'w, 'a> {
        let (known, whitening) = (self.jacobian.clone(), self.whitening.clone());
        MeanWalks::new(known, self.spread(), whitening, of_means, generator.clone())
    }

    /// How far robots of one make spread in its walk.
    pub(crate) fn spread(&self) -> Spread {
        self.with(Vec::new()).spread(&self.jacobian)
    }

    /// The robot of `walker`, which has no effects, at its most probable walk, begun from these parameters.
    pub(crate) fn at_walk(
        walker: &Walker<'a>,
        setting: Setting<'a>,
        z: DVector<f64>,
        ln_prior: f64,
    ) -> Option<Self> {
        Self::begun(walker, setting, z, REFERENCE_STEPS, ln_prior)?.settled()
    }

    /// The same robot at its most probable walk over another stretch, begun from these parameters.
    pub(crate) fn continued(&self, setting: Setting<'a>, z: DVector<f64>) -> Option<Self> {
        let walker = setting.walker(self.with(Vec::new()).hypothesis);
        Self::at_walk(&walker, setting, z, self.ln_prior)
    }

    /// The same robot over another stretch, at these parameters.
    pub(crate) fn at_point(&self, setting: Setting<'a>, z: DVector<f64>) -> Option<Self> {
        let walker = setting.walker(self.with(Vec::new()).hypothesis);
        Self::begun(&walker, setting, z, 0, self.ln_prior)
    }

    /// Its fit as that of the hypothesis of `walker`, which has no effects.
    pub(crate) fn fit(&self, walker: &Walker<'_>) -> Fit {
        let (at, jacobian) = (self.reference.clone(), self.jacobian.clone());
        walker.integrated(at, jacobian, &self.whitening)
    }

    /// Logarithm of the evidence of this robot without effects.
    pub(crate) fn ln_evidence(&self) -> f64 {
        let Walked { residual, z, .. } = &self.reference;
        ln_evidence(&self.whitening, residual, z, &self.jacobian).0
    }

    /// The hypothesis that this robot has these effects.
    pub(crate) fn with(&self, effects: Vec<Placement>) -> Walker<'a> {
        self.setting.walker(Hypothesis {
            morphology: self.morphology.clone(),
            lost_links: self.lost_links,
            effects,
        })
    }

    /// The hypothesis of `known` with one effect more.
    pub(crate) fn with_added(&self, known: &Walker<'_>, added: Placement) -> Walker<'a> {
        let mut effects = known.hypothesis.effects.clone();
        effects.push(added);
        self.with(effects)
    }
}

impl<'a> Setting<'a> {
    /// The hypothesis that this robot has no effects.
    pub(super) fn bare(&self, morphology: &Morphology, lost_links: LostLinks) -> Walker<'a> {
        self.walker(Hypothesis {
            morphology: morphology.clone(),
            lost_links,
            effects: Vec::new(),
        })
    }

    pub(crate) fn walker(&self, hypothesis: Hypothesis) -> Walker<'a> {
        Walker::new(hypothesis, self.observation, self.nuisance, self.nominal)
    }
}
