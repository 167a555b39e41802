//! How a record is divided in time.

use std::ops::Range;

use serde::Serialize;

use super::SensorRecord;

/// Share of the record that parameters are fitted on while effects are selected.
const FIT_SHARE: f64 = 0.4;
/// Share that selects effects.
const SELECTION_SHARE: f64 = 0.3;

/// The three stretches of a record, each from and to a time of the log in s: the first 40 %,
/// the next 30 % and the last 30 %. The fit gets the longest, because it must tell a bias from
/// a scale; selection and test are equally long, so that the error of the one predicts that of
/// the other. At the last 0.3 s of what a step sees no error is measured, because the angle of a
/// late sensor is not known there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Stretches {
    /// Parameters are fitted here while effects are selected.
    pub fit: [f64; 2],
    /// Effects are selected here; the final parameters are fitted here and on `fit`.
    pub selection: [f64; 2],
    /// Neither fit nor selection sees this.
    pub test: [f64; 2],
}

impl Stretches {
    pub(super) fn of(times_s: &[f64]) -> Self {
        let first_s = times_s.first().copied().unwrap_or(0.0);
        let last_s = times_s.last().copied().unwrap_or(0.0);
        let at = |share: f64| first_s + share * (last_s - first_s);
        let (selection_s, test_s) = (at(FIT_SHARE), at(FIT_SHARE + SELECTION_SHARE));
        Self {
            fit: [first_s, selection_s],
            selection: [selection_s, test_s],
            test: [test_s, last_s],
        }
    }

    /// Indices of the samples of fit, selection and test. A sample on a border belongs to the
    /// later stretch.
    pub(crate) fn samples(&self, times_s: &[f64]) -> [Range<usize>; 3] {
        let first_from = |begin_s: f64| times_s.partition_point(|time| *time < begin_s);
        let (selection, test) = (first_from(self.selection[0]), first_from(self.test[0]));
        [0..selection, selection..test, test..times_s.len()]
    }

    /// Values of a record's samples, which may end before the record does, on fit, selection and
    /// test.
    pub(crate) fn divide<'v>(&self, record: &SensorRecord, values: &'v [f64]) -> [&'v [f64]; 3] {
        let samples = self.samples(&record.signals().times_s);
        samples.map(|range| {
            let end = range.end.min(values.len());
            values.get(range.start..end).unwrap_or_default()
        })
    }
}

impl SensorRecord {
    /// How the record is divided.
    pub fn stretches(&self) -> Stretches {
        Stretches::of(&self.signals().times_s)
    }

    /// The stretch that parameters are fitted on, as if the log ended after it.
    pub fn fit_stretch(&self) -> Self {
        let [fit, ..] = self.stretches().samples(&self.signals().times_s);
        self.truncated(fit.end)
    }

    /// Fit and selection, as if the log ended before the test stretch: all that may decide
    /// anything.
    pub fn before_test(&self) -> Self {
        let [.., test] = self.stretches().samples(&self.signals().times_s);
        self.truncated(test.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stretches_cover_the_record_in_log_time_and_share_no_sample() {
        let times_s: Vec<f64> = (0..=1000).map(|i| 200.0 + f64::from(i) * 0.1).collect();
        let stretches = Stretches::of(&times_s);
        for (found, expected) in [
            (stretches.fit, [200.0, 240.0]),
            (stretches.selection, [240.0, 270.0]),
            (stretches.test, [270.0, 300.0]),
        ] {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{stretches:?}");
            }
        }
        let [fit, selection, test] = stretches.samples(&times_s);
        assert_eq!((fit.start, test.end), (0, times_s.len()));
        assert_eq!((fit.end, selection.end), (selection.start, test.start));
        assert!(times_s[test.start] >= stretches.test[0]);
        assert!(times_s[test.start - 1] < stretches.test[0]);
    }
}
