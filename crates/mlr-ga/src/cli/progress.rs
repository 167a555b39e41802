//! A progress bar for people.

use indicatif::{ProgressBar, ProgressStyle};
use mlr_ga::Progress;

use super::output;

/// A bar with remaining time on stderr; nothing when stderr is no terminal, or when told to be
/// quiet.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// A bar over the morphologies of a search.
    pub(super) fn new() -> Self {
        Self::over("morphologies")
    }

    /// A bar over the steps of an explanation.
    pub(super) fn of_steps() -> Self {
        Self::over("walks and fits")
    }

    /// A bar over the candidates of a motion.
    pub(super) fn of_motions() -> Self {
        Self::over("motions")
    }

    /// A bar over the stages of a search for a gait.
    pub(super) fn of_gaits() -> Self {
        Self::over("stages")
    }

    /// A bar over a directory of logs.
    pub(super) fn of_logs(logs: usize) -> Self {
        let bar = Self::over("logs");
        bar.0.set_length(logs as u64);
        bar
    }

    /// A bar over things of this name, of which none is expected so far.
    fn over(things: &str) -> Self {
        let template =
            format!("{{bar:40}} {{pos}}/{{len}} {things}, {{elapsed}} elapsed, {{eta}} to go");
        let style = ProgressStyle::with_template(&template)
            .expect("the template differs by a name alone, and a test renders it");
        let bar = match output::is_quiet() {
            true => ProgressBar::hidden(),
            false => ProgressBar::new(0),
        };
        Self(bar.with_style(style))
    }

    pub(super) fn next_log(&self) {
        self.0.inc(1);
    }

    pub(super) fn clear(&self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn expect(&self, candidates: usize) {
        self.0.set_length(candidates as u64);
    }

    fn expect_more(&self, candidates: usize) {
        self.0.inc_length(candidates as u64);
    }

    fn advance(&self) {
        self.0.inc(1);
    }
}

impl mlr_residual::Progress for Bar {
    fn expect_more(&self, steps: usize) {
        self.0.inc_length(steps as u64);
    }

    fn advance(&self) {
        self.0.inc(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_is_valid() {
        let bar = Bar::new();
        bar.expect(2);
        Progress::advance(&bar);
        assert_eq!(bar.0.position(), 1);
        let logs = Bar::of_logs(3);
        logs.next_log();
        mlr_residual::Progress::expect_more(&Bar::of_motions(), 3);
        let steps = Bar::of_steps();
        mlr_residual::Progress::expect_more(&steps, 3);
        assert_eq!(steps.0.length(), Some(3));
        assert_eq!(logs.0.position(), 1);
    }
}
