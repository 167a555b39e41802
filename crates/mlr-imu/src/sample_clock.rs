//! When a sample was taken, from when it arrived.

use std::collections::VecDeque;

/// Gives samples the time at which they were taken, counted from the first one.
///
/// A serial line delivers in bursts: the arrival of a sample says only that it
/// was not taken later. Where the frame carries the device's clock, that is the
/// time. Otherwise the sampling is taken to be even, and a straight line is laid
/// over the samples' numbers through the promptest arrivals of the last seconds;
/// the stamps follow it without jumping.
#[derive(Debug, Clone, Default)]
pub struct SampleClock {
    last: Option<Stamped>,
    /// Promptest arrival of each block, oldest first; the last one still grows.
    blocks: VecDeque<Block>,
    /// Arrival time minus stamp, on the line.
    offset_s: Option<f64>,
}

/// The sample stamped last.
#[derive(Debug, Clone, Copy)]
struct Stamped {
    number: u64,
    stamp_s: f64,
    arrival_s: f64,
    device_time_us: Option<u32>,
}

/// The sample of a stretch of time that came most promptly.
#[derive(Debug, Clone, Copy)]
struct Block {
    begin: Arrival,
    promptest: Arrival,
}

#[derive(Debug, Clone, Copy)]
struct Arrival {
    number: u64,
    arrival_s: f64,
}

/// Even sampling: sample `number` was taken at `origin_s + number · period_s`,
/// in arrival time.
#[derive(Debug, Clone, Copy)]
struct Line {
    origin_s: f64,
    period_s: f64,
}

impl Line {
    fn at(&self, number: u64) -> f64 {
        self.origin_s + self.period_s * number as f64
    }
}

/// Length of a block: longer than the bursts of a line.
const BLOCK_S: f64 = 0.5;
/// Blocks that the line is laid through, at least and at most.
const BLOCKS: std::ops::RangeInclusive<usize> = 4..=40;
/// Share of the sampling period by which a step may differ from it.
const SLEW: f64 = 0.2;
/// A device clock that jumps by more than this has been reset.
const RESET_US: u32 = 10_000_000;
/// A pause in arrivals after which the line is laid anew.
const PAUSE_S: f64 = 2.0;
/// The least step between two stamps.
const LEAST_STEP_S: f64 = 1e-6;

impl SampleClock {
    /// Stamps a sample that arrived at `arrival_s` (any monotonic clock), with
    /// `lost` samples between it and the one stamped before. Stamps strictly
    /// increase.
    pub fn stamp(&mut self, arrival_s: f64, device_time_us: Option<u32>, lost: u64) -> f64 {
        let (number, stamp_s) = match self.last {
            None => (0, 0.0),
            Some(last) => {
                let number = last.number + 1 + lost;
                let step_s = self.step_s(&last, number, arrival_s, device_time_us);
                (number, last.stamp_s + step_s.max(LEAST_STEP_S))
            }
        };
        self.add_arrival(Arrival { number, arrival_s });
        self.last = Some(Stamped {
            number,
            stamp_s,
            arrival_s,
            device_time_us,
        });
        stamp_s
    }

    /// The line was interrupted: what arrives next has not been waiting in a
    /// buffer, and the pause in arrivals is one in the samples.
    pub fn interrupted(&mut self) {
        self.blocks.clear();
    }

    fn step_s(
        &mut self,
        last: &Stamped,
        number: u64,
        arrival_s: f64,
        device_time_us: Option<u32>,
    ) -> f64 {
        let arrivals_apart_s = arrival_s - last.arrival_s;
        if let Some(step_s) = device_step_s(last.device_time_us, device_time_us) {
            return step_s;
        }
        if arrivals_apart_s > PAUSE_S {
            self.interrupted();
        }
        let Some(line) = self.line() else {
            self.offset_s = None;
            return arrivals_apart_s;
        };
        // The stamps go on where they are when the line begins to lead them.
        let offset_s = *self
            .offset_s
            .get_or_insert(line.at(last.number) - last.stamp_s);
        let steps = (number - last.number) as f64;
        let wanted_s = line.at(number) - offset_s - last.stamp_s;
        wanted_s.clamp(
            (steps - SLEW) * line.period_s,
            (steps + SLEW) * line.period_s,
        )
    }

    fn add_arrival(&mut self, arrival: Arrival) {
        let fresh = Block {
            begin: arrival,
            promptest: arrival,
        };
        let Some(current) = self.blocks.back().copied() else {
            self.blocks.push_back(fresh);
            return;
        };
        if arrival.arrival_s - current.begin.arrival_s >= BLOCK_S {
            self.blocks.push_back(fresh);
            if self.blocks.len() > *BLOCKS.end() {
                self.blocks.pop_front();
            }
            return;
        }
        // Delays are told apart by the pace of the block so far, or of all blocks.
        let first = self
            .blocks
            .front()
            .map_or(current.begin, |block| block.begin);
        let samples = arrival.number.saturating_sub(first.number).max(1) as f64;
        let pace_s = (arrival.arrival_s - first.arrival_s) / samples;
        let ahead = arrival.number.saturating_sub(current.promptest.number) as f64;
        let is_prompter = arrival.arrival_s - current.promptest.arrival_s <= ahead * pace_s;
        if let (true, Some(block)) = (is_prompter, self.blocks.back_mut()) {
            block.promptest = arrival;
        }
    }

    /// Least squares through the complete blocks.
    fn line(&self) -> Option<Line> {
        let complete = self.blocks.len().checked_sub(1)?;
        if complete < *BLOCKS.start() {
            return None;
        }
        let points = || {
            self.blocks
                .iter()
                .take(complete)
                .map(|block| block.promptest)
        };
        let first = points().next()?;
        let count = complete as f64;
        let x = |point: Arrival| (point.number - first.number) as f64;
        let y = |point: Arrival| point.arrival_s - first.arrival_s;
        let (mean_x, mean_y) = (
            points().map(x).sum::<f64>() / count,
            points().map(y).sum::<f64>() / count,
        );
        let spread: f64 = points().map(|p| (x(p) - mean_x).powi(2)).sum();
        let slope: f64 = points()
            .map(|p| (x(p) - mean_x) * (y(p) - mean_y))
            .sum::<f64>()
            / spread;
        (slope.is_finite() && slope > 0.0).then_some(Line {
            period_s: slope,
            origin_s: first.arrival_s + mean_y - slope * (mean_x + first.number as f64),
        })
    }
}

fn device_step_s(before: Option<u32>, now: Option<u32>) -> Option<f64> {
    let step_us = now?.wrapping_sub(before?);
    (step_us < RESET_US).then(|| f64::from(step_us) * 1e-6)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Times of evenly taken samples, and of their arrival in bursts.
    fn bursty(rate_hz: f64, burst_s: f64, duration_s: f64) -> Vec<(f64, f64)> {
        (0..(rate_hz * duration_s) as u32)
            .map(|i| {
                let taken_s = f64::from(i) / rate_hz;
                let delivered_s = (taken_s / burst_s).floor() * burst_s + burst_s;
                // The line adds a little of its own.
                (taken_s, delivered_s + f64::from((i * 7919) % 97) * 1e-5)
            })
            .collect()
    }

    /// Largest deviation of the stamps from the truth, up to a constant, after
    /// the line has been found.
    fn worst_s(stamps_s: &[f64], taken_s: &[f64], settled_s: f64) -> f64 {
        let pairs: Vec<(f64, f64)> = stamps_s
            .iter()
            .copied()
            .zip(taken_s.iter().copied())
            .filter(|(_, taken)| *taken > settled_s)
            .collect();
        let shift = pairs.iter().map(|(s, t)| s - t).sum::<f64>() / pairs.len() as f64;
        pairs
            .iter()
            .map(|(s, t)| (s - t - shift).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn bursts_are_spread_evenly() {
        for (rate_hz, burst_s) in [(820.0, 0.016), (200.0, 0.016), (1000.0, 0.05), (100.0, 0.1)] {
            let samples = bursty(rate_hz, burst_s, 30.0);
            let mut clock = SampleClock::default();
            let stamps: Vec<f64> = samples
                .iter()
                .map(|(_, at)| clock.stamp(*at, None, 0))
                .collect();
            let taken: Vec<f64> = samples.iter().map(|(taken, _)| *taken).collect();
            let arrivals: Vec<f64> = samples.iter().map(|(_, arrived)| *arrived).collect();
            assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
            let ours = worst_s(&stamps, &taken, 10.0);
            let control = worst_s(&arrivals, &taken, 10.0);
            assert!(ours < 0.25 * burst_s, "{rate_hz} Hz, {burst_s} s: {ours} s");
            assert!(control > 0.4 * burst_s, "control: {control} s");
        }
    }

    #[test]
    fn lost_samples_leave_their_room() {
        let samples = bursty(500.0, 0.02, 20.0);
        let mut clock = SampleClock::default();
        let (mut stamps, mut taken) = (Vec::new(), Vec::new());
        let mut lost = 0;
        for (i, (at, arrived)) in samples.iter().enumerate() {
            if i % 10 == 3 || (6000..6100).contains(&i) {
                lost += 1;
                continue;
            }
            stamps.push(clock.stamp(*arrived, None, lost));
            taken.push(*at);
            lost = 0;
        }
        assert!(worst_s(&stamps, &taken, 10.0) < 0.006);
    }

    #[test]
    fn device_time_is_taken_as_it_is_and_may_wrap() {
        let mut clock = SampleClock::default();
        let start = u32::MAX - 2500;
        let stamps: Vec<f64> = (0..6_u32)
            .map(|i| clock.stamp(7.0, Some(start.wrapping_add(i * 1000)), 0))
            .collect();
        for (i, stamp) in stamps.iter().enumerate() {
            assert!((stamp - i as f64 * 0.001).abs() < 1e-12);
        }
    }

    #[test]
    fn a_device_that_starts_anew_does_not_stop_time() {
        let mut clock = SampleClock::default();
        clock.stamp(0.0, Some(50_000_000), 0);
        let stamp = clock.stamp(3.0, Some(1_000), 0);
        assert!((stamp - 3.0).abs() < 1e-9, "{stamp}");
    }

    #[test]
    fn a_short_interruption_leaves_its_gap_when_it_is_told() {
        let after_gap = |told: bool| {
            let mut clock = SampleClock::default();
            let mut last = 0.0;
            for (_, arrived) in bursty(500.0, 0.02, 10.0) {
                last = clock.stamp(arrived, None, 0);
            }
            if told {
                clock.interrupted();
            }
            clock.stamp(11.5, None, 0) - last
        };
        assert!((after_gap(true) - 1.5).abs() < 0.05);
        assert!(
            after_gap(false) < 0.01,
            "control: a stall of the reader is no gap"
        );
    }

    #[test]
    fn an_unplugged_line_leaves_a_gap() {
        let mut clock = SampleClock::default();
        let mut last = 0.0;
        for (_, arrived) in bursty(500.0, 0.02, 10.0) {
            last = clock.stamp(arrived, None, 0);
        }
        let after = clock.stamp(40.0, None, 0);
        assert!((after - last - 30.0).abs() < 0.1, "{}", after - last);
    }

    proptest! {
        #[test]
        fn stamps_increase_whatever_arrives(
            arrivals in prop::collection::vec((-1.0..1.0_f64, prop::option::of(any::<u32>()), 0_u64..5), 1..300),
        ) {
            let mut clock = SampleClock::default();
            let mut last = f64::NEG_INFINITY;
            let mut now = 0.0;
            for (step_s, device_time_us, lost) in arrivals {
                now += step_s;
                let stamp = clock.stamp(now, device_time_us, lost);
                prop_assert!(stamp > last && stamp.is_finite());
                last = stamp;
            }
        }
    }
}
