//! The last seconds of orientation.

use std::collections::VecDeque;

use mlr_filter::{Axes, OrientationSeries};

use crate::attitude::Attitude;

/// Orientations, none older than some seconds.
#[derive(Debug)]
pub(super) struct Recent {
    keep_s: f64,
    attitudes: VecDeque<Attitude>,
}

/// A pause in the samples that spoils a stretch.
pub(super) const PAUSE_S: f64 = 0.2;

impl Recent {
    pub(super) fn new(keep_s: f64) -> Self {
        Self {
            keep_s,
            attitudes: VecDeque::new(),
        }
    }

    /// Takes the next one; says whether there was a pause before it.
    pub(super) fn push(&mut self, attitude: Attitude) -> bool {
        let now_s = attitude.time_s;
        let paused = self
            .attitudes
            .back()
            .is_some_and(|last| now_s - last.time_s > PAUSE_S);
        self.attitudes.push_back(attitude);
        while self
            .attitudes
            .front()
            .is_some_and(|first| first.time_s < now_s - self.keep_s)
        {
            self.attitudes.pop_front();
        }
        paused
    }

    /// Whether something is kept from so early on.
    pub(super) fn reaches_back_to(&self, time_s: f64) -> bool {
        self.attitudes
            .front()
            .is_some_and(|first| first.time_s <= time_s)
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.attitudes.clear();
    }

    /// Forgets what is older.
    pub(super) fn forget_before(&mut self, time_s: f64) {
        self.attitudes.retain(|past| past.time_s >= time_s);
    }

    /// What is kept from `from_s` on.
    pub(super) fn recording(&self, from_s: f64) -> Option<OrientationSeries> {
        let mut times_s = Vec::new();
        let mut angles_rad = Axes::<Vec<f64>>::default();
        for attitude in self.attitudes.iter().filter(|a| a.time_s >= from_s) {
            times_s.push(attitude.time_s);
            angles_rad.push(attitude.angles_rad);
        }
        OrientationSeries::new(times_s, angles_rad).ok()
    }
}
