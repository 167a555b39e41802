//! The cost of a morphology: how its simulated walks fit the measured one.

use std::ops::ControlFlow;

use mlr_model::{LostLinks, Morphology};
use serde::{Deserialize, Serialize};

use crate::{
    Evaluation, IdentifySettings, MeasuredWalk, Objective,
    belief::DamagePrior,
    comparison::{
        AlignedMeasurement, Alignment, ComparableWalk, LikelihoodSettings, SpectralSettings,
    },
    evaluation::CaseFit,
    walks::{Case, WalkSource, Walked},
};

/// What a lost link may have become.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LossHypothesis {
    /// Gone, with its mass.
    Absent,
    /// Locked clear of the ground, its mass still on the robot.
    Locked,
    /// Either of the two, the same for all lost links: a candidate is simulated
    /// both ways, and both count.
    #[default]
    Either,
}

impl LossHypothesis {
    /// What lost links are taken to be.
    pub fn cases(self) -> &'static [LostLinks] {
        match self {
            Self::Absent => &[LostLinks::Absent],
            Self::Locked => &[LostLinks::Locked],
            Self::Either => &[LostLinks::Absent, LostLinks::Locked],
        }
    }

    /// What the lost links of this candidate may be: without a lost link there is
    /// nothing to tell apart.
    pub fn cases_of(self, candidate: &Morphology) -> &'static [LostLinks] {
        let cases = self.cases();
        if candidate.is_healthy() {
            &cases[..1]
        } else {
            cases
        }
    }
}

/// Lets candidates walk and compares them with the measured walk.
///
/// The cost is the error in degrees, averaged over the axes, that the candidate's
/// likelihood and prior probability amount to: `ln P = -n · ln(cost)`, with n the
/// number of independent errors. The nominal model decides it; what variations of
/// the model make of the leading candidates comes later.
pub struct WalkObjective<'a> {
    walks: &'a dyn WalkSource,
    whole: AlignedMeasurement,
    /// The first parts of the measured walk at which a candidate may be given up.
    parts: Vec<AlignedMeasurement>,
    /// Samples of a simulated walk that the first measured one is aligned with in turn.
    offsets: Vec<usize>,
    lost_links: LossHypothesis,
    likelihood: LikelihoodSettings,
    prior: DamagePrior,
}

impl<'a> WalkObjective<'a> {
    /// The cost of morphologies for the `measured` walk.
    pub fn new(
        measured: &MeasuredWalk,
        walks: &'a dyn WalkSource,
        settings: &IdentifySettings,
    ) -> Self {
        let stretch = measured.stretch();
        let spectral = SpectralSettings {
            cutoff_hz: settings.filter.cutoff_hz,
            gait_period_s: stretch.gait_period_s,
            // A motion that repeats nothing has no harmonics: every frequency counts in full.
            between_harmonics: match stretch.cycle_s {
                Some(_) => settings.likelihood.between_harmonics,
                None => 1.0,
            },
        };
        let aligned = |samples| {
            AlignedMeasurement::new(measured.recording(), stretch.start_s, samples, spectral)
        };
        Self {
            walks,
            whole: aligned(stretch.samples),
            parts: stretch.parts().into_iter().map(aligned).collect(),
            offsets: stretch.offsets.clone(),
            lost_links: settings.lost_links,
            likelihood: LikelihoodSettings {
                independent_errors: settings
                    .likelihood
                    .independent_errors
                    .map(|n| n * stretch.samples as f64 / FIVE_SECONDS),
                ..settings.likelihood
            },
            prior: settings.prior,
        }
    }

    /// How far the body moves on each axis, as a walk with this alignment is compared.
    pub fn motion_deg(&self, alignment: Alignment) -> [f64; 3] {
        self.whole.motion_deg2(alignment).map(f64::sqrt)
    }

    /// What a fit leaves of each axis, every frequency alike: root mean square.
    pub fn error_deg(&self, candidate: &Morphology, fit: &CaseFit) -> Option<[f64; 3]> {
        let go_on = &mut |_: &ComparableWalk| ControlFlow::Continue(());
        let Walked::Whole(walk) = self.walks.walk(candidate, fit.case, go_on) else {
            return None;
        };
        let alignment = fit.misfit.alignment;
        let error_deg2 = self.whole.error_deg2(&walk, fit.offset, alignment)?;
        Some(error_deg2.map(f64::sqrt))
    }

    /// Logarithm of likelihood times prior of a candidate, over the cases that it
    /// was tried in; those `tried` that are not among the fits were hopeless.
    pub fn ln_weight(&self, candidate: &Morphology, fits: &[CaseFit], tried: usize) -> f64 {
        let best = fits
            .iter()
            .map(|fit| fit.ln_likelihood)
            .fold(f64::NEG_INFINITY, f64::max);
        if !best.is_finite() {
            return f64::NEG_INFINITY;
        }
        let sum: f64 = fits
            .iter()
            .map(|fit| (fit.ln_likelihood - best).exp())
            .sum();
        best + (sum / tried as f64).ln() + self.prior.ln(candidate)
    }

    /// The logarithm of likelihood times prior that a cost stands for.
    pub fn ln_weight_of_cost(&self, cost_deg: f64) -> f64 {
        -self.likelihood.errors() * cost_deg.ln()
    }

    /// The cost that a logarithm of likelihood times prior amounts to.
    pub fn cost_of_ln_weight(&self, ln_weight: f64) -> f64 {
        (-ln_weight / self.likelihood.errors()).exp()
    }

    /// Logarithm of the prior probability of a candidate.
    pub fn ln_prior(&self, candidate: &Morphology) -> f64 {
        self.prior.ln(candidate)
    }

    /// What lost links of the candidate may be.
    pub fn lost_links(&self, candidate: &Morphology) -> &'static [LostLinks] {
        self.lost_links.cases_of(candidate)
    }

    /// How the candidate fits in one case, unless its likelihood turns out to be
    /// below `least_ln_likelihood`.
    pub fn fit(&self, candidate: &Morphology, case: Case, least_ln_likelihood: f64) -> Fit {
        let mut parts = self.parts.iter();
        let walked = self
            .walks
            .walk(candidate, case, &mut |so_far| match parts.next() {
                Some(part) if self.ln_bound(part, so_far) < least_ln_likelihood => {
                    ControlFlow::Break(())
                }
                _ => ControlFlow::Continue(()),
            });
        match walked {
            Walked::Whole(walk) => self.judge(case, &walk).map_or(Fit::Hopeless, Fit::Fits),
            Walked::Stopped => Fit::Hopeless,
            Walked::Unknown => Fit::Unknown,
            Walked::Diverged => Fit::Diverged,
        }
    }

    fn judge(&self, case: Case, walk: &ComparableWalk) -> Option<CaseFit> {
        self.offsets
            .iter()
            .filter_map(|&offset| {
                let misfit = self.whole.misfit(walk, offset, &self.likelihood)?;
                Some(CaseFit {
                    case,
                    offset,
                    misfit,
                    ln_likelihood: self.likelihood.ln_likelihood(&misfit),
                })
            })
            .max_by(|a, b| a.ln_likelihood.total_cmp(&b.ln_likelihood))
    }

    /// What the likelihood can still become. A walk too short to tell may become
    /// anything.
    fn ln_bound(&self, part: &AlignedMeasurement, so_far: &ComparableWalk) -> f64 {
        let share = part.samples() as f64 / self.whole.samples() as f64;
        self.offsets
            .iter()
            .map(|&offset| {
                part.ln_bound(so_far, offset, share, &self.likelihood)
                    .unwrap_or(f64::INFINITY)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Samples of the paper's window, for which the numbers of independent errors are
/// stated.
const FIVE_SECONDS: f64 = 5.0 * ComparableWalk::RATE_HZ;

/// What a case of a candidate came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fit {
    /// The walk was compared.
    Fits(CaseFit),
    /// It was given up.
    Hopeless,
    /// There is no such walk.
    Unknown,
    /// It diverged.
    Diverged,
}

impl Objective for WalkObjective<'_> {
    fn evaluate(&self, candidate: &Morphology, limit_deg: f64) -> Evaluation {
        let least = self.ln_weight_of_cost(limit_deg) - self.prior.ln(candidate);
        let mut evaluation = Evaluation {
            cost_deg: f64::INFINITY,
            fits: Vec::new(),
            abandoned: false,
            diverged: 0,
        };
        let cases = self.lost_links(candidate);
        for &lost_links in cases {
            let nominal = Case {
                lost_links,
                variation: 0,
            };
            match self.fit(candidate, nominal, least) {
                Fit::Fits(fit) => evaluation.fits.push(fit),
                Fit::Hopeless => evaluation.abandoned = true,
                Fit::Diverged => evaluation.diverged += 1,
                Fit::Unknown => {}
            }
        }
        let ln_weight = self.ln_weight(candidate, &evaluation.fits, cases.len());
        evaluation.cost_deg = self.cost_of_ln_weight(ln_weight);
        evaluation
    }
}
