//! Values that repeat bit for bit.

/// Follows how long values stay the same.
#[derive(Debug, Clone, Default)]
pub(super) struct HeldValues<V> {
    run: Option<Run<V>>,
    /// Mean time from one change to the next, of the last changes.
    period_s: Option<f64>,
}

#[derive(Debug, Clone)]
struct Run<V> {
    values: V,
    since_s: f64,
    samples: usize,
}

/// How long the last values have stayed the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Time of the first sample that had them.
    pub(super) since_s: f64,
    duration_s: f64,
    samples: usize,
    period_s: f64,
}

/// The mean period forgets within about so many changes.
const MEMORY: f64 = 20.0;
/// A sensor that is read faster than it measures repeats each value for its own period. It
/// may miss some measurements without being frozen.
const PERIODS: f64 = 5.0;
/// Fewer repetitions prove nothing.
const FEWEST_SAMPLES: usize = 8;

impl Held {
    /// As if the values had not been seen before `begin_s`.
    pub(super) fn since(self, begin_s: f64) -> Self {
        let later_s = (begin_s - self.since_s).max(0.0);
        Self {
            duration_s: self.duration_s - later_s,
            ..self
        }
    }

    /// Whether the values have been held for longer than `patience_s`, and than the
    /// sensor's own period can explain.
    pub(super) fn is_frozen(self, patience_s: f64) -> bool {
        self.samples >= FEWEST_SAMPLES
            && self.duration_s > patience_s
            && self.duration_s > PERIODS * self.period_s
    }
}

impl<V: PartialEq> HeldValues<V> {
    /// Takes the values at `time_s`.
    pub(super) fn take(&mut self, time_s: f64, values: V) -> Held {
        match &mut self.run {
            Some(run) if run.values == values => run.samples += 1,
            run => {
                if let Some(ended) = run.as_ref() {
                    let lasted_s = time_s - ended.since_s;
                    let mean_s = self.period_s.unwrap_or(lasted_s);
                    // One long run, as of a sensor that froze for a while, is no period.
                    let lasted_s = lasted_s.min(PERIODS * mean_s);
                    self.period_s = Some(mean_s + (lasted_s - mean_s) / MEMORY);
                }
                *run = Some(Run {
                    values,
                    since_s: time_s,
                    samples: 1,
                });
            }
        }
        let (since_s, samples) = self
            .run
            .as_ref()
            .map_or((time_s, 1), |run| (run.since_s, run.samples));
        Held {
            since_s,
            duration_s: time_s - since_s,
            samples,
            period_s: self.period_s.unwrap_or(0.0),
        }
    }
}
