use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Samples from which the period of the clock is taken.
const CLOCK_SAMPLES: usize = 1000;

/// Mean time between samples, lost ones counted.
fn steady_period_s(times_s: &[f64]) -> Option<f64> {
    let nominal_s = SensorSignals::new(times_s.to_vec(), Vec::new()).period_s();
    let span_s = times_s.last()? - times_s.first()?;
    let periods: f64 = times_s
        .windows(2)
        .map(|pair| ((pair[1] - pair[0]) / nominal_s).round())
        .sum();
    (nominal_s > 0.0 && periods > 0.0).then(|| span_s / periods)
}

/// Stamps are taken when a sample arrives, samples at the sensor's own steady clock:
/// times follow the stamps only by a share of the difference at each sample, and a gap
/// counts as the whole number of samples lost in it. A share of 1 is the stamps as
/// they are.
#[derive(Debug)]
pub(super) struct StampJitter;

impl SensorEffect for StampJitter {
    fn kind(&self) -> &'static str {
        "stamp_jitter"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "wanders with the jitter of the stamps"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        if fit_stretch.signals().period_s() <= 0.0 {
            return Err(Inapplicable("the samples have no period"));
        }
        Ok(vec![
            Parameter::new("share", 0.1)
                .step(1e-3)
                .bounds(0.005, 1.0)
                .neutral(1.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        // The clock's rate is taken from the start of the log alone.
        let first = &signals.times_s[..signals.len().min(CLOCK_SAMPLES)];
        let Some(period_s) = steady_period_s(first) else {
            return;
        };
        let mut now_s = first[0];
        for i in 1..signals.len() {
            let gap_s = signals.times_s[i] - signals.times_s[i - 1];
            let due_s = now_s + period_s * (gap_s / period_s).round();
            let shifted_s = due_s + values[0] * (signals.times_s[i] - due_s);
            // Time runs forward whatever the stamps do.
            now_s = shifted_s.max(now_s + 1e-6);
            track.times_s[i] = now_s;
        }
    }
}
