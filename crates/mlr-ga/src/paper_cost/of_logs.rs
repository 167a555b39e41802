use mlr_model::{LostLinks, Morphology};

use super::{PaperCost, PaperFit};
use crate::{Evaluation, Objective, mean_error_deg};

/// F over all logs of one robot: the sum of their Fs, what became of lost links being the same in
/// all of them.
#[derive(Debug)]
pub(crate) struct PaperCosts(Vec<PaperCost>);

/// The walks of a candidate that F compares with the measured ones, log by log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PaperFits(Vec<PaperFit>);

impl PaperCosts {
    pub(crate) fn new(costs: Vec<PaperCost>) -> Self {
        Self(costs)
    }

    /// The walks of a candidate. `None` when one diverged, or when `lost_links` is no case of the
    /// hypothesis.
    pub(crate) fn of(&self, candidate: &Morphology, lost_links: LostLinks) -> Option<PaperFits> {
        let fits = self.0.iter().map(|cost| cost.of(candidate, lost_links));
        fits.collect::<Option<Vec<_>>>().map(PaperFits)
    }

    /// The walks with the least F among those that the lost links of the candidate allow. `None`
    /// when every walk diverged.
    pub(crate) fn least(&self, candidate: &Morphology) -> Option<PaperFits> {
        let cases = self.0.first()?.lost_links.cases_of(candidate);
        cases
            .iter()
            .filter_map(|&lost_links| self.of(candidate, lost_links))
            .min_by(|a, b| a.cost_rad().total_cmp(&b.cost_rad()))
    }
}

impl PaperFits {
    /// F, summed over the logs.
    pub(crate) fn cost_rad(&self) -> f64 {
        self.0.iter().map(|fit| fit.cost_rad).sum()
    }

    /// F per sample and axis, in degrees.
    pub(crate) fn mean_error_deg(&self) -> f64 {
        let samples = self.0.iter().map(|fit| fit.simulated.roll.len()).sum();
        mean_error_deg(self.cost_rad(), samples)
    }

    /// Log by log.
    pub(crate) fn into_logs(self) -> Vec<PaperFit> {
        self.0
    }
}

impl Objective for PaperCosts {
    /// The cost is F per sample and axis, in degrees.
    fn evaluate(&self, candidate: &Morphology, _limit_deg: f64) -> Evaluation {
        let least = self.least(candidate);
        Evaluation {
            cost_deg: least
                .as_ref()
                .map_or(f64::INFINITY, PaperFits::mean_error_deg),
            fits: Vec::new(),
            abandoned: false,
            diverged: usize::from(least.is_none()),
        }
    }
}
