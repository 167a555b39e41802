//! What the linear models of screened effects promise.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Search, base::Base, screening::Start};
use crate::walk::hypothesis::Placement;

/// A start on a base, with what it promises.
pub(super) struct Proposal {
    pub(super) base: usize,
    /// Starts of the base that it combines.
    pub(super) starts: Vec<usize>,
    pub(super) ln_weight: f64,
}

/// The starts of every effect on a robot.
pub(super) struct Screened<'a> {
    pub(super) base: Arc<Base<'a>>,
    pub(super) starts: Vec<Start>,
}

impl<'a> Search<'a, '_> {
    pub(super) fn singles(&self, screened: &[Screened<'a>]) -> Vec<Proposal> {
        let each = screened
            .iter()
            .enumerate()
            .flat_map(|(base, on)| (0..on.starts.len()).map(move |k| (base, k)));
        let each: Vec<(usize, usize)> = each.collect();
        let mut proposals: Vec<Proposal> = each
            .into_par_iter()
            .map(|(base, start)| self.proposal(&screened[base], base, vec![start]))
            .collect();
        sort(&mut proposals);
        proposals
    }

    /// Two effects at once, of those that promise most alone and of the most promising of each kind.
    pub(super) fn pairs(&self, screened: &[Screened<'a>], singles: &[Proposal]) -> Vec<Proposal> {
        let mut chosen: Vec<&Proposal> = Vec::new();
        for proposal in singles {
            let start = |p: &Proposal| (p.base, screened[p.base].starts[p.starts[0]].placement);
            if !chosen.iter().any(|c| start(c) == start(proposal)) && chosen.len() < 40 {
                chosen.push(proposal);
            }
        }
        let pairs: Vec<(usize, usize, usize)> = chosen
            .iter()
            .enumerate()
            .flat_map(|(k, a)| {
                let others = chosen[k + 1..].iter().filter(|b| b.base == a.base);
                others
                    .map(|b| (a.base, a.starts[0], b.starts[0]))
                    .collect::<Vec<_>>()
            })
            .collect();
        pairs
            .into_par_iter()
            .map(|(base, a, b)| self.proposal(&screened[base], base, vec![a, b]))
            .collect()
    }

    pub(super) fn proposal(&self, on: &Screened<'a>, base: usize, starts: Vec<usize>) -> Proposal {
        let combined: Vec<&Start> = starts.iter().map(|k| &on.starts[*k]).collect();
        let effects: Vec<Placement> = combined.iter().map(|start| start.placement).collect();
        let walker = on.base.with(effects);
        let whitening = &on.base.whitening;
        let linear = on.base.simulated.with(&combined, &walker, true);
        Proposal {
            base,
            starts,
            ln_weight: linear.ln_evidence(whitening).0 + self.ln_prior(on.base.ln_prior, &walker),
        }
    }
}

pub(super) fn sort(proposals: &mut [Proposal]) {
    proposals.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
}
