//! A device whose clock stands still while its frames go on.

/// Watches the device's clock against arrival.
///
/// A bridge that repeats its last frame, clock and all, would otherwise pass for a sensor
/// that says very much within a moment.
#[derive(Debug, Clone, Default)]
pub struct StoppedClock {
    run: Option<Run>,
}

/// Samples with the same device time.
#[derive(Debug, Clone, Copy)]
struct Run {
    device_time_us: u32,
    since_s: f64,
    samples: u32,
}

/// Arrival time after which a clock that shows the same has stopped: bursts and a busy
/// computer delay frames by less.
const PATIENCE_S: f64 = 0.2;
/// A frame may come twice or thrice.
const FEWEST_SAMPLES: u32 = 8;

impl StoppedClock {
    /// Takes a sample's arrival and its time by the device, where it tells; returns whether
    /// the clock stands still.
    pub fn take(&mut self, arrival_s: f64, device_time_us: Option<u32>) -> bool {
        let Some(device_time_us) = device_time_us else {
            self.run = None;
            return false;
        };
        match &mut self.run {
            Some(run) if run.device_time_us == device_time_us => {
                run.samples += 1;
                run.samples >= FEWEST_SAMPLES && arrival_s - run.since_s > PATIENCE_S
            }
            run => {
                *run = Some(Run {
                    device_time_us,
                    since_s: arrival_s,
                    samples: 1,
                });
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_shows_the_same_for_long_has_stopped() {
        let mut clock = StoppedClock::default();
        let mut stopped = |from: u32, to: u32, time_us: fn(u32) -> Option<u32>| {
            (from..to)
                .filter(|i| clock.take(f64::from(*i) * 0.01, time_us(*i)))
                .count()
        };
        assert_eq!(stopped(0, 100, |i| Some(i * 10_000)), 0);
        assert_eq!(stopped(100, 200, |_| Some(7)), 79);
        assert_eq!(stopped(200, 300, |i| Some(i * 10_000)), 0);
        assert_eq!(stopped(300, 400, |_| None), 0, "a device without a clock");
    }

    #[test]
    fn a_frame_repeated_within_a_burst_is_no_stopped_clock() {
        let mut clock = StoppedClock::default();
        assert!((0..1000).all(|_| !clock.take(5.0, Some(7))));
    }
}
