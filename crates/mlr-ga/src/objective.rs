//! The cost of a morphology: how its simulated walks fit the measured ones.

mod log_comparison;

use std::collections::BTreeMap;

use mlr_model::{LostLinks, Morphology};
use mlr_residual::{Posterior, ln_mean};
use serde::{Deserialize, Serialize};

use self::log_comparison::LogComparison;
use crate::{
    Evaluation, IdentifySettings, MeasuredWalk, Objective,
    belief::DamagePrior,
    evaluation::CaseFit,
    walks::{Case, WalkSource},
};

/// Lets candidates walk and compares them with the measured walks of one robot.
///
/// The cost is the error in degrees, averaged over the axes, that the candidate's
/// likelihood and prior probability amount to: `ln P = -n · ln(cost)`, with n the
/// number of independent errors. The nominal model decides it; what variations of
/// the model make of the leading candidates comes later.
///
/// Likelihoods of several logs multiply. What became of lost links is the same in all of them;
/// the variation of the model is averaged over in each for itself.
pub struct WalkObjective<'a> {
    logs: Vec<LogComparison<'a>>,
    lost_links: LossHypothesis,
    prior: DamagePrior,
}

/// What a lost link may have become.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

impl From<LostLinks> for LossHypothesis {
    /// What is known.
    fn from(known: LostLinks) -> Self {
        match known {
            LostLinks::Absent => Self::Absent,
            LostLinks::Locked => Self::Locked,
        }
    }
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

/// How many cases of a candidate were tried: in each log, with its lost links gone or locked.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tried(BTreeMap<(usize, LostLinks), usize>);

impl Tried {
    /// One case more of this log.
    pub fn add(&mut self, log: usize, lost_links: LostLinks) {
        *self.0.entry((log, lost_links)).or_default() += 1;
    }

    fn of(&self, log: usize, lost_links: LostLinks) -> usize {
        self.0.get(&(log, lost_links)).copied().unwrap_or(0)
    }

    fn all(&self) -> usize {
        self.0.values().sum()
    }
}

impl<'a> WalkObjective<'a> {
    /// The cost of morphologies for the `measured` walk.
    pub fn new(
        measured: &MeasuredWalk,
        walks: &'a dyn WalkSource,
        settings: &IdentifySettings,
    ) -> Self {
        Self::of_logs([(measured, walks)], settings)
    }

    /// The cost of morphologies for several measured walks of one robot, each with the walks of
    /// candidates that it is compared with.
    pub fn of_logs<'m>(
        logs: impl IntoIterator<Item = (&'m MeasuredWalk, &'a dyn WalkSource)>,
        settings: &IdentifySettings,
    ) -> Self {
        let logs = logs.into_iter().enumerate();
        Self {
            logs: logs
                .map(|(log, (measured, walks))| LogComparison::new(log, measured, walks, settings))
                .collect(),
            lost_links: settings.lost_links,
            prior: settings.prior,
        }
    }

    /// How many logs there are.
    pub fn logs(&self) -> usize {
        self.logs.len()
    }

    /// How far the body moves on each axis, as the walk of a fit is compared.
    pub fn motion_deg(&self, fit: &CaseFit) -> Option<[f64; 3]> {
        let log = self.logs.get(fit.log)?;
        Some(log.motion_deg(fit.misfit.alignment))
    }

    /// What a fit leaves of each axis, every frequency alike: root mean square.
    pub fn error_deg(&self, candidate: &Morphology, fit: &CaseFit) -> Option<[f64; 3]> {
        self.logs.get(fit.log)?.error_deg(candidate, fit)
    }

    /// Logarithm of likelihood times prior of a candidate, over the cases that it
    /// was tried in; those `tried` that are not among the fits were hopeless.
    pub fn ln_weight(&self, candidate: &Morphology, fits: &[CaseFit], tried: &Tried) -> f64 {
        let ln_likelihood = if self.logs.len() == 1 {
            // The same as below, in one sum.
            ln_mean(fits.iter().map(|fit| fit.ln_likelihood), tried.all())
        } else {
            let cases = self.lost_links(candidate);
            let each = cases.iter();
            let each = each.map(|&lost_links| self.ln_likelihood(lost_links, fits, tried));
            let each: Vec<f64> = each.collect();
            ln_mean(each.iter().copied(), cases.len())
        };
        if !ln_likelihood.is_finite() {
            return f64::NEG_INFINITY;
        }
        ln_likelihood + self.prior.ln(candidate)
    }

    /// Probability that the lost links of a candidate are locked, over the cases that it was tried
    /// in; `None` where it has none, or no case fits.
    pub fn locked_probability(
        &self,
        candidate: &Morphology,
        fits: &[CaseFit],
        tried: &Tried,
    ) -> Option<f64> {
        if candidate.is_healthy() {
            return None;
        }
        let cases = self.lost_links(candidate).iter();
        let cases =
            Posterior::new(cases.map(|&case| (case, self.ln_likelihood(case, fits, tried))));
        cases.ranked().first()?;
        Some(cases.sum(|case| *case == LostLinks::Locked))
    }

    /// Logarithm of the likelihood of a candidate whose lost links are so, in all logs together.
    fn ln_likelihood(&self, lost_links: LostLinks, fits: &[CaseFit], tried: &Tried) -> f64 {
        let of_log = |log: usize| {
            let is_of = |fit: &&CaseFit| fit.log == log && fit.case.lost_links == lost_links;
            let fits = fits.iter().filter(is_of).map(|fit| fit.ln_likelihood);
            ln_mean(fits, tried.of(log, lost_links))
        };
        (0..self.logs.len()).map(of_log).sum()
    }

    /// The logarithm of likelihood times prior that a cost stands for.
    pub fn ln_weight_of_cost(&self, cost_deg: f64) -> f64 {
        -self.errors() * cost_deg.ln()
    }

    /// The cost that a logarithm of likelihood times prior amounts to.
    pub fn cost_of_ln_weight(&self, ln_weight: f64) -> f64 {
        (-ln_weight / self.errors()).exp()
    }

    /// Independent errors over all logs and axes.
    fn errors(&self) -> f64 {
        self.logs.iter().map(LogComparison::errors).sum()
    }

    /// Logarithm of the prior probability of a candidate.
    pub fn ln_prior(&self, candidate: &Morphology) -> f64 {
        self.prior.ln(candidate)
    }

    /// What lost links of the candidate may be.
    pub fn lost_links(&self, candidate: &Morphology) -> &'static [LostLinks] {
        self.lost_links.cases_of(candidate)
    }

    /// The cases of a candidate on the nominal model, one for each log and each thing that its lost
    /// links may be.
    pub fn tried_nominal(&self, candidate: &Morphology) -> Tried {
        let mut tried = Tried::default();
        for &lost_links in self.lost_links(candidate) {
            for log in 0..self.logs.len() {
                tried.add(log, lost_links);
            }
        }
        tried
    }

    /// How the candidate fits a log in one case, unless it turns out that its logarithm of
    /// likelihood times prior stays below `least_ln_weight` whatever the other logs say.
    pub fn fit(&self, candidate: &Morphology, log: usize, case: Case, least_ln_weight: f64) -> Fit {
        let logs = self.logs.iter().enumerate();
        let others = logs.filter(|(other, _)| *other != log);
        let ln_others: f64 = others.map(|(_, other)| other.ln_most()).sum();
        let least = least_ln_weight - self.prior.ln(candidate) - ln_others;
        match self.logs.get(log) {
            Some(log) => log.fit(candidate, case, least),
            None => Fit::Unknown,
        }
    }

    /// How the candidate fits all logs on the nominal model, one after the other until those so
    /// far leave no hope that the logarithm of likelihood times prior exceeds `least_ln_weight`.
    fn nominal_fits(
        &self,
        candidate: &Morphology,
        lost_links: LostLinks,
        least_ln_weight: f64,
        evaluation: &mut Evaluation,
    ) {
        let nominal = Case {
            lost_links,
            variation: 0,
        };
        let mut ln_rest: f64 = self.logs.iter().skip(1).map(LogComparison::ln_most).sum();
        let mut least = least_ln_weight - self.prior.ln(candidate);
        for (index, log) in self.logs.iter().enumerate() {
            match log.fit(candidate, nominal, least - ln_rest) {
                Fit::Fits(fit) => {
                    evaluation.fits.push(fit);
                    least -= fit.ln_likelihood;
                }
                Fit::Hopeless => {
                    evaluation.abandoned = true;
                    return;
                }
                Fit::Diverged => {
                    evaluation.diverged += 1;
                    return;
                }
                Fit::Unknown => return,
            }
            ln_rest -= self.logs.get(index + 1).map_or(0.0, LogComparison::ln_most);
        }
    }
}

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
        let least = self.ln_weight_of_cost(limit_deg);
        let mut evaluation = Evaluation {
            cost_deg: f64::INFINITY,
            fits: Vec::new(),
            abandoned: false,
            diverged: 0,
        };
        for &lost_links in self.lost_links(candidate) {
            self.nominal_fits(candidate, lost_links, least, &mut evaluation);
        }
        let tried = self.tried_nominal(candidate);
        let ln_weight = self.ln_weight(candidate, &evaluation.fits, &tried);
        evaluation.cost_deg = self.cost_of_ln_weight(ln_weight);
        evaluation
    }
}
