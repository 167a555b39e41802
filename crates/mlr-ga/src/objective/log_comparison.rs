use std::ops::ControlFlow;

use mlr_model::Morphology;

use super::Fit;
use crate::{
    IdentifySettings, MeasuredWalk,
    comparison::{
        AlignedMeasurement, Alignment, ComparableWalk, LikelihoodSettings, Misfit, SpectralSettings,
    },
    evaluation::CaseFit,
    walks::{Case, WalkSource, Walked},
};

/// One log that candidates are compared with: what belongs to its day, such as phase, clock, delay
/// and the zero of yaw, is fitted for each of them.
pub(super) struct LogComparison<'a> {
    /// Its place among the logs of the robot.
    log: usize,
    walks: &'a dyn WalkSource,
    whole: AlignedMeasurement,
    /// The first parts of the measured walk at which a candidate may be given up.
    parts: Vec<AlignedMeasurement>,
    /// Samples of a simulated walk that the first measured one is aligned with in turn.
    offsets: Vec<usize>,
    likelihood: LikelihoodSettings,
}

impl<'a> LogComparison<'a> {
    pub(super) fn new(
        log: usize,
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
            log,
            walks,
            whole: aligned(stretch.samples),
            parts: stretch.parts().into_iter().map(aligned).collect(),
            offsets: stretch.offsets.clone(),
            likelihood: settings.likelihood.of_samples(stretch.samples),
        }
    }

    /// Independent errors of the log over all axes.
    pub(super) fn errors(&self) -> f64 {
        self.likelihood.errors()
    }

    /// The greatest logarithm of a likelihood that any walk can have: that of no error at all.
    pub(super) fn ln_most(&self) -> f64 {
        self.likelihood.ln_likelihood(&Misfit {
            mean_square_deg2: [0.0; 3],
            alignment: Alignment::default(),
        })
    }

    /// How far the body moves on each axis, as a walk with this alignment is compared.
    pub(super) fn motion_deg(&self, alignment: Alignment) -> [f64; 3] {
        self.whole.motion_deg2(alignment).map(f64::sqrt)
    }

    /// What a fit leaves of each axis, every frequency alike: root mean square.
    pub(super) fn error_deg(&self, candidate: &Morphology, fit: &CaseFit) -> Option<[f64; 3]> {
        let go_on = &mut |_: &ComparableWalk| ControlFlow::Continue(());
        let Walked::Whole(walk) = self.walks.walk(candidate, fit.case, go_on) else {
            return None;
        };
        let alignment = fit.misfit.alignment;
        let error_deg2 = self.whole.error_deg2(&walk, fit.offset, alignment)?;
        Some(error_deg2.map(f64::sqrt))
    }

    /// How the candidate fits in one case, unless its likelihood turns out to be
    /// below `least_ln_likelihood`.
    pub(super) fn fit(&self, candidate: &Morphology, case: Case, least_ln_likelihood: f64) -> Fit {
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
                    log: self.log,
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
