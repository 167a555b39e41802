//! How many samples come per second.

/// Counts samples against their own time.
#[derive(Debug, Clone, Copy, Default)]
pub struct SampleRate {
    /// Time of the sample that counting began with.
    since_s: Option<f64>,
    last_s: f64,
    count: u32,
}

impl SampleRate {
    /// Takes the time of the next sample.
    pub fn count(&mut self, time_s: f64) {
        match self.since_s {
            Some(_) => self.count += 1,
            None => self.since_s = Some(time_s),
        }
        self.last_s = time_s;
    }

    /// Samples per second since this was last asked, if there were any.
    pub fn take_hz(&mut self) -> Option<f64> {
        let since_s = self.since_s?;
        if self.count == 0 {
            // What comes after a silence is not measured across it.
            *self = Self::default();
            return None;
        }
        let rate_hz = f64::from(self.count) / (self.last_s - since_s);
        *self = Self {
            since_s: Some(self.last_s),
            last_s: self.last_s,
            count: 0,
        };
        rate_hz.is_finite().then_some(rate_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(rate: &mut SampleRate, from_s: f64, hz: u32, samples: u32) {
        for index in 0..samples {
            rate.count(from_s + f64::from(index) / f64::from(hz));
        }
    }

    #[test]
    fn the_rate_is_that_of_the_last_stretch() {
        let mut rate = SampleRate::default();
        assert_eq!(rate.take_hz(), None);
        count(&mut rate, 0.0, 500, 5000);
        assert!((rate.take_hz().unwrap() - 500.0).abs() < 1e-6);
        count(&mut rate, 10.0, 200, 2000);
        let slower_hz = rate.take_hz().unwrap();
        assert!((slower_hz - 200.0).abs() < 1.0, "{slower_hz}");
    }

    #[test]
    fn a_silence_has_no_rate_and_leaves_no_trace() {
        let mut rate = SampleRate::default();
        count(&mut rate, 0.0, 500, 100);
        rate.take_hz();
        assert_eq!(rate.take_hz(), None);
        count(&mut rate, 1000.0, 500, 100);
        assert!((rate.take_hz().unwrap() - 500.0).abs() < 1e-6);
    }
}
