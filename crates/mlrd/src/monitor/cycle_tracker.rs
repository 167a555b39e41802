//! Where in the gait a robot is, long after its first step.

use std::collections::VecDeque;

use mlr_filter::Axes;
use mlr_model::Gait;

use crate::attitude::Attitude;

/// Follows the cycles of a healthy walk whose start was seen.
///
/// The clock of a controller is off by up to some per cent: after a minute, the time since the first
/// step says nothing about the phase of the gait. The first steady cycles of the walk, whose phase
/// that time does tell, are the template; the lag at which later cycles correlate best with it is
/// what the clock has gained or lost since. The robot's own walk is the reference, so that what it
/// differs by from any model does not matter.
#[derive(Debug)]
pub(super) struct CycleTracker {
    /// Nominal duration of a cycle; `None` of a motion that ends, which has none.
    cycle_s: Option<f64>,
    /// Gait time from which cycles are alike.
    steady_s: f64,
    walk: Option<Walk>,
}

/// The walk that is followed.
#[derive(Debug)]
struct Walk {
    start_s: f64,
    bins: VecDeque<Bin>,
    template: Option<Template>,
    next_look_s: f64,
    /// What was known, and of which stretch up to when; the newest last.
    known: VecDeque<(f64, Cycles)>,
}

/// Means over [`BIN_S`].
#[derive(Debug, Clone, Copy)]
struct Bin {
    number: i64,
    samples: f64,
    sum_deg: [f64; 3],
}

/// One cycle of roll, pitch and yaw, and how many cycles after the start it was taken.
#[derive(Debug)]
struct Template {
    cycle_deg: Vec<[f64; 3]>,
    after_cycles: f64,
}

/// Every cycle of the gait begins a whole number of periods from one time.
#[derive(Debug, Clone, Copy)]
struct Cycles {
    one_s: f64,
    period_s: f64,
}

/// Resolution of a cycle: swings of a walk are slower than 10 Hz.
const BIN_S: f64 = 0.02;
/// Cycles that are averaged.
const AVERAGED: f64 = 4.0;
/// Cycles between two looks.
const EVERY: f64 = 2.0;
/// Lag beyond which it is not looked for, of a cycle: half a cycle later a walk of two groups of
/// legs is its own mirror image.
const MOST_LAG: f64 = 0.25;
/// Least correlation at the lag.
const ALIKE: f64 = 0.6;
/// Share of the bins that must have samples.
const COVERED: f64 = 0.9;
/// Looks that are remembered: damage is flagged some seconds after it strikes.
const REMEMBERED: usize = 8;
/// After so many cycles without a look the phase is unknown.
const MOST_BLIND: f64 = 120.0;

impl CycleTracker {
    pub(super) fn new(gait: &Gait) -> Self {
        let cycle_s = gait.cycle_s();
        Self {
            cycle_s,
            steady_s: gait.steady_from_s() + cycle_s.unwrap_or(0.0),
            walk: None,
        }
    }

    /// A walk started at this time.
    pub(super) fn begin(&mut self, start_s: f64) {
        self.walk = Some(Walk {
            start_s,
            bins: VecDeque::new(),
            template: None,
            next_look_s: start_s,
            known: VecDeque::new(),
        });
    }

    /// The walk is over, or nothing is known of its phase any more.
    pub(super) fn forget(&mut self) {
        self.walk = None;
    }

    /// Takes an orientation of the healthy walk.
    pub(super) fn push(&mut self, attitude: &Attitude) {
        let (Some(walk), Some(cycle_s)) = (&mut self.walk, self.cycle_s) else {
            return;
        };
        walk.push(attitude, AVERAGED * cycle_s * 1.5);
        if attitude.time_s >= walk.next_look_s {
            walk.next_look_s = attitude.time_s + EVERY * cycle_s;
            walk.look(attitude.time_s, cycle_s, self.steady_s);
        }
    }

    /// What the robot has walked since then is not like its healthy walk.
    pub(super) fn doubt_since(&mut self, time_s: f64) {
        if let Some(walk) = &mut self.walk {
            walk.known.retain(|(to_s, _)| *to_s <= time_s);
            walk.bins.clear();
        }
    }

    /// The last time up to `before_s` at which a cycle of the gait began.
    pub(super) fn cycle_start_s(&self, before_s: f64) -> Option<f64> {
        let (walk, cycle_s) = (self.walk.as_ref()?, self.cycle_s?);
        let (known_s, cycles) = walk.known.back()?;
        (before_s - known_s <= MOST_BLIND * cycle_s).then(|| cycles.last_up_to(before_s))
    }
}

impl Cycles {
    fn last_up_to(&self, time_s: f64) -> f64 {
        self.one_s + ((time_s - self.one_s) / self.period_s).floor() * self.period_s
    }
}

impl Walk {
    fn push(&mut self, attitude: &Attitude, keep_s: f64) {
        let number = (attitude.time_s / BIN_S).floor() as i64;
        let angles = attitude.angles_rad.map(|_, angle| angle.to_degrees());
        let Axes { roll, pitch, yaw } = angles;
        match self.bins.back_mut().filter(|bin| bin.number == number) {
            Some(bin) => {
                bin.samples += 1.0;
                for (sum, angle) in bin.sum_deg.iter_mut().zip([roll, pitch, yaw]) {
                    *sum += angle;
                }
            }
            None => self.bins.push_back(Bin {
                number,
                samples: 1.0,
                sum_deg: [roll, pitch, yaw],
            }),
        }
        let oldest = number - (keep_s / BIN_S) as i64;
        while self.bins.front().is_some_and(|bin| bin.number < oldest) {
            self.bins.pop_front();
        }
    }

    fn look(&mut self, now_s: f64, cycle_s: f64, steady_s: f64) {
        let (from_s, to_s) = (now_s - AVERAGED * cycle_s, now_s);
        let middle_s = f64::midpoint(from_s, to_s);
        let Some(template) = &self.template else {
            let from_start = Cycles {
                one_s: self.start_s,
                period_s: cycle_s,
            };
            if from_s < self.start_s + steady_s {
                return;
            }
            if let Some(cycle_deg) = self.folded(from_s, to_s, from_start) {
                let after_cycles = (middle_s - self.start_s) / cycle_s;
                self.template = Some(Template {
                    cycle_deg,
                    after_cycles,
                });
                self.known.push_back((to_s, from_start));
            }
            return;
        };
        let Some((_, expected)) = self.known.back().copied() else {
            return;
        };
        let Some(cycle_deg) = self.folded(from_s, to_s, expected) else {
            return;
        };
        let Some(lag) = lag_of(&template.cycle_deg, &cycle_deg) else {
            return;
        };
        // When the gait was where it was in the middle of the template, whole cycles before.
        let template_s = self.start_s + template.after_cycles * cycle_s;
        let phase_s = template.after_cycles.fract() * expected.period_s;
        let met_s = expected.last_up_to(middle_s - phase_s) + phase_s + lag * expected.period_s;
        let passed = ((met_s - template_s) / expected.period_s).round();
        if passed < 1.0 {
            return;
        }
        let cycles = Cycles {
            one_s: self.start_s,
            period_s: (met_s - template_s) / passed,
        };
        self.known.push_back((to_s, cycles));
        if self.known.len() > REMEMBERED {
            self.known.pop_front();
        }
    }

    /// The mean cycle of a stretch, without mean and trend; `None` where samples are missing.
    fn folded(&self, from_s: f64, to_s: f64, cycles: Cycles) -> Option<Vec<[f64; 3]>> {
        let of_stretch: Vec<(f64, [f64; 3])> = self
            .bins
            .iter()
            .map(|bin| {
                let time_s = (bin.number as f64 + 0.5) * BIN_S;
                (time_s, bin.sum_deg.map(|sum| sum / bin.samples))
            })
            .filter(|(time_s, _)| (from_s..to_s).contains(time_s))
            .collect();
        if (of_stretch.len() as f64) < COVERED * (to_s - from_s) / BIN_S {
            return None;
        }
        let lines = [0, 1, 2].map(|axis| line(of_stretch.iter().map(|(t, a)| (*t, a[axis]))));
        let count = (cycles.period_s / BIN_S).round().max(4.0) as usize;
        let mut sums = vec![([0.0; 3], 0.0); count];
        for (time_s, angles_deg) in of_stretch {
            let phase = ((time_s - cycles.one_s) / cycles.period_s).rem_euclid(1.0);
            let (sum, samples) = &mut sums[(phase * count as f64) as usize % count];
            for axis in 0..3 {
                let (mean, slope, middle_s) = lines[axis];
                sum[axis] += angles_deg[axis] - mean - slope * (time_s - middle_s);
            }
            *samples += 1.0;
        }
        let mean = |(sum, samples): ([f64; 3], f64)| sum.map(|sum| sum / f64::max(samples, 1.0));
        Some(sums.into_iter().map(mean).collect())
    }
}

/// Mean, slope and middle of the straight line through points.
fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64, f64) {
    let count = points.clone().count().max(1) as f64;
    let middle = points.clone().map(|(x, _)| x).sum::<f64>() / count;
    let mean = points.clone().map(|(_, y)| y).sum::<f64>() / count;
    let along: f64 = points.clone().map(|(x, y)| (x - middle) * (y - mean)).sum();
    let lever: f64 = points.map(|(x, _)| (x - middle).powi(2)).sum();
    (mean, along / lever.max(f64::MIN_POSITIVE), middle)
}

/// How much later a cycle is than the template, as a share of the cycle; `None` where they are not
/// alike within [`MOST_LAG`].
fn lag_of(template: &[[f64; 3]], cycle: &[[f64; 3]]) -> Option<f64> {
    let count = template.len();
    if cycle.len() != count {
        // A period that was found to differ by more than a bin.
        let resampled: Vec<[f64; 3]> = (0..count).map(|k| cycle[k * cycle.len() / count]).collect();
        return lag_of(template, &resampled);
    }
    let square = |cycle: &[[f64; 3]]| -> f64 { cycle.iter().flatten().map(|a| a * a).sum() };
    let scale = (square(template) * square(cycle)).sqrt();
    let correlation = |lag: i64| -> f64 {
        let each = (0..count).map(|k| {
            let later = (k as i64 + lag).rem_euclid(count as i64) as usize;
            let both = template[k].iter().zip(&cycle[later]);
            both.map(|(a, b)| a * b).sum::<f64>()
        });
        each.sum::<f64>() / scale.max(f64::MIN_POSITIVE)
    };
    let most = (MOST_LAG * count as f64) as i64;
    let best = (-most..=most).max_by(|a, b| correlation(*a).total_cmp(&correlation(*b)))?;
    let (before, at, after) = (
        correlation(best - 1),
        correlation(best),
        correlation(best + 1),
    );
    if at < ALIKE || before > at || after > at {
        return None;
    }
    // The top of the parabola through the three.
    let bend = before - 2.0 * at + after;
    let top = match bend < 0.0 {
        true => 0.5 * (before - after) / bend,
        false => 0.0,
    };
    Some((best as f64 + top) / count as f64)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A robot that starts to walk at 2 s with a clock that is slow by this share, seen at this
    /// gait time.
    fn walk(gait_s: f64, clock: f64) -> Attitude {
        let phase = TAU * gait_s.max(0.0);
        let wave = |deg: f64, angle: f64| f64::to_radians(deg) * angle.sin();
        Attitude {
            time_s: 2.0 + gait_s * clock,
            angles_rad: Axes {
                roll: wave(0.5, phase) + wave(0.2, 4.0 * phase + 0.3),
                pitch: wave(0.3, 2.0 * phase + 1.0),
                yaw: wave(0.4, phase + 0.7) + 0.03 * gait_s,
            },
        }
    }

    /// The tracker after so much gait time.
    fn after(gait_s: f64, clock: f64) -> CycleTracker {
        let mut tracker = CycleTracker::new(&Gait::tripod());
        tracker.begin(2.0);
        for i in 150..(gait_s * 100.0) as u32 {
            tracker.push(&walk(f64::from(i) / 100.0, clock));
        }
        tracker
    }

    /// How far a start of a cycle is from the true one, which may be any.
    fn off_s(start_s: f64, clock: f64) -> f64 {
        let cycles = (start_s - 2.0) / clock;
        (cycles - cycles.round()) * clock
    }

    #[test]
    fn the_phase_is_known_minutes_after_the_first_step_whatever_the_clock() {
        for clock in [1.0, 1.003, 0.997, 1.03, 0.97] {
            let tracker = after(200.0, clock);
            let end_s = 2.0 + 200.0 * clock;
            let start_s = tracker.cycle_start_s(end_s).unwrap();
            assert!((0.0..1.1).contains(&(end_s - start_s)));
            let off_s = off_s(start_s, clock);
            assert!(off_s.abs() < 0.012, "{clock}: {off_s}");
            // A control: the time since the first step alone tells nothing by then.
            let by_the_clock_s = 2.0 + (end_s - 2.0).floor();
            if (clock - 1.0).abs() == 0.003 {
                assert!(self::off_s(by_the_clock_s, clock).abs() > 0.2);
            }
        }
    }

    #[test]
    fn damage_does_not_spoil_what_was_known_before() {
        let clock = 1.004;
        let mut tracker = after(60.0, clock);
        // Rocks otherwise, a third of a cycle late.
        for i in 6000..6600 {
            let mut rocking = walk(f64::from(i) / 100.0 + 0.33, clock);
            rocking.time_s -= 0.33 * clock;
            rocking.angles_rad.roll *= 8.0;
            tracker.push(&rocking);
        }
        let struck_s = 2.0 + 60.0 * clock;
        tracker.doubt_since(struck_s);
        let start_s = tracker.cycle_start_s(struck_s + 6.0).unwrap();
        assert!(off_s(start_s, clock).abs() < 0.012);
        assert_eq!(tracker.cycle_start_s(struck_s + 500.0), None);
    }

    #[test]
    fn another_motion_is_not_followed() {
        let mut tracker = after(20.0, 1.0);
        let known = tracker.walk.as_ref().unwrap().known.len();
        for i in 2000..4000 {
            let time_s = 2.0 + f64::from(i) / 100.0;
            let angles_rad = Axes {
                roll: 0.01 * (TAU * 0.37 * time_s).sin(),
                pitch: 0.0,
                yaw: 0.0,
            };
            tracker.push(&Attitude { time_s, angles_rad });
        }
        let after = tracker.walk.as_ref().unwrap().known.len();
        // The window held the walk's last cycles at first.
        assert!(after <= known + 2, "{known} {after}");
    }
}
