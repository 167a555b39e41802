//! Units, signs and axes of angles and rates, told from what they say of each other.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{Finding, FindingKind, Severity, rows::Rows};
use crate::Correction;

/// Turns are compared over this time: longer than the delay of a filter, shorter than half
/// a gait cycle.
const TURN_S: f64 = 0.1;
/// Turns that prove anything.
const FEWEST_TURNS: f64 = 30.0;
/// Roll and pitch up to which the rates about the body's axes are those of the angles, within a
/// third.
const LARGEST_TILT_RAD: f64 = 0.8;
/// Values within that time that make a turn.
const FEWEST_VALUES: f64 = 4.0;
/// Tilt from accelerations is smeared by the body's own, and compared over a longer time.
const TILT_S: f64 = 0.3;
/// Turns smaller than this (RMS) prove nothing: a sensor's own filter takes the
/// accelerations of a healthy robot for turns of 0.001 rad in that time.
const SMALLEST_TURN_RAD: f64 = 0.003;
const SMALLEST_TILT_RAD: f64 = 0.08;
/// Angles in degrees turn 57 times as far as rates in rad/s say; between, in the logarithm,
/// lies 7.6. Filters change turns by a third at most.
const UNIT_RATIO: f64 = 7.6;
/// Turns that belong together are correlated at least so well, and turns against each other
/// at least so badly.
const SAME: f64 = 0.3;
const OPPOSED: f64 = -0.7;
/// A walking body swings less, even when it falls on its belly, in radians of roll and pitch
/// together per second, averaged over the walk.
const TURNS_IN_A_SECOND_RAD: f64 = TAU;
/// Accelerations show at least this share of the turns that the rates say.
const SMALLEST_TILT_SHARE: f64 = 0.2;

/// The first contradiction. `value_rate_hz` says how often values change: turns of a sensor
/// that is too slow cannot be compared.
pub(super) fn finding(rows: &Rows<'_>, value_rate_hz: f64) -> Option<Finding> {
    let fast_enough = value_rate_hz * TURN_S >= FEWEST_VALUES;
    let units = match fast_enough.then(|| Turns::of(rows)).flatten() {
        Some(turns) => turns.contradiction(rows),
        // No raw samples vouch for the angles.
        None => beyond_a_turn(rows),
    };
    units.or_else(|| rates_against_gravity(rows))
}

fn in_degrees(rows: &Rows<'_>, reason: &str) -> Finding {
    let cure = rows.arguments(&["roll", "pitch", "yaw"], Correction::Unit("deg"));
    rows.finding(
        FindingKind::AngleUnit,
        Severity::Useless,
        format!("{reason}: the angles are in degrees"),
        Some(cure),
    )
}

/// Roll and pitch beyond a whole turn, or a yaw that spins, are no radians.
fn beyond_a_turn(rows: &Rows<'_>) -> Option<Finding> {
    let angles = rows.angles_rad?;
    for (name, values) in [("roll", &angles.roll), ("pitch", &angles.pitch)] {
        // Angles from 0 to 2π are as good as those from -π to π.
        let whole_turns = values
            .first()
            .map_or(0.0, |first| (first / TAU).round() * TAU);
        let largest = values
            .iter()
            .map(|value| (value - whole_turns).abs())
            .fold(0.0, f64::max);
        if largest > PI + 0.1 {
            return Some(in_degrees(
                rows,
                &format!("{name} reaches {largest:.1}, beyond ±π"),
            ));
        }
    }
    let walking = rows.walking();
    let (times_s, yaw) = (&rows.times_s[walking.clone()], &angles.yaw[walking]);
    let duration_s = times_s.last()? - times_s.first()?;
    let turned = (yaw.last()? - yaw.first()?).abs();
    (duration_s > 1.0 && turned / duration_s > TURNS_IN_A_SECOND_RAD).then(|| {
        in_degrees(
            rows,
            &format!("yaw turns by {:.1} a second", turned / duration_s),
        )
    })
}

/// Short turns of roll, pitch and yaw beside those that the rates say.
struct Turns {
    by_axis: [Agreement; 3],
    all: Agreement,
}

impl Turns {
    /// `None` where there is nothing to compare.
    fn of(rows: &Rows<'_>) -> Option<Self> {
        let angles = rows.angles_rad?;
        let rates = &rows.raw?.angular_rates_radps;
        let tilted = |index: usize| {
            angles.roll[index].abs().max(angles.pitch[index].abs()) > LARGEST_TILT_RAD
        };
        let mut by_axis = [Agreement::default(); 3];
        for (from, to) in steps_of(rows, TURN_S) {
            // Further tilted, roll, pitch and yaw do not turn as the body's axes.
            if tilted(from) || tilted(to) {
                continue;
            }
            let turned: [f64; 3] = std::array::from_fn(|axis| {
                (from..to)
                    .map(|i| rates[i][axis] * (rows.times_s[i + 1] - rows.times_s[i]))
                    .sum()
            });
            let channels = [&angles.roll, &angles.pitch, &angles.yaw];
            for ((agreement, values), turned) in by_axis.iter_mut().zip(channels).zip(turned) {
                agreement.add(turned, values[to] - values[from]);
            }
        }
        let all = by_axis
            .into_iter()
            .fold(Agreement::default(), Agreement::joined);
        let enough = all.count >= FEWEST_TURNS && all.largest_deviation() >= SMALLEST_TURN_RAD;
        enough.then_some(Self { by_axis, all })
    }

    /// What the turns say against each other.
    fn contradiction(&self, rows: &Rows<'_>) -> Option<Finding> {
        let ratio = self.all.ratio();
        if ratio > UNIT_RATIO {
            return Some(in_degrees(
                rows,
                &format!("the angles turn {ratio:.0} times as far as the rates say"),
            ));
        }
        if ratio < 1.0 / UNIT_RATIO {
            return Some(rates_in_degrees(
                rows,
                &format!(
                    "the rates say turns {:.0} times as large as the angles",
                    1.0 / ratio
                ),
            ));
        }
        let opposed = self.opposed();
        if !opposed.is_empty() {
            let cure = rows.arguments(&opposed, Correction::Sign);
            return Some(rows.finding(
                FindingKind::Contradiction,
                Severity::Useless,
                format!(
                    "{} turns against the rates: angles and raw samples have different axes (NED \
                     has y right and z down)",
                    opposed.join(" and ")
                ),
                Some(format!("{cure} if the raw samples are right")),
            ));
        }
        let correlation = self.all.correlation();
        let unrelated = self.all.smallest_deviation() > SMALLEST_TURN_RAD && correlation < SAME;
        unrelated.then(|| {
            rows.finding(
                FindingKind::Contradiction,
                Severity::Useless,
                format!(
                    "angles and rates do not belong together (their turns correlate by \
                     {correlation:.2})"
                ),
                None,
            )
        })
    }

    /// Angles that turn against their rates.
    fn opposed(&self) -> Vec<&'static str> {
        ["roll", "pitch", "yaw"]
            .into_iter()
            .zip(&self.by_axis)
            .filter(|(_, axis)| {
                axis.smallest_deviation() > SMALLEST_TURN_RAD && axis.correlation() < OPPOSED
            })
            .map(|(angle, _)| angle)
            .collect()
    }
}

fn rates_in_degrees(rows: &Rows<'_>, reason: &str) -> Finding {
    let cure = rows.arguments(&["gx", "gy", "gz"], Correction::Unit("dps"));
    rows.finding(
        FindingKind::RateUnit,
        Severity::Useless,
        format!("{reason}: the rates are in degrees per second"),
        Some(cure),
    )
}

/// A body that turns as far as the rates say is seen to do so by the accelerometer.
fn rates_against_gravity(rows: &Rows<'_>) -> Option<Finding> {
    let raw = rows.raw?;
    let (mut by_rates, mut by_gravity) = (0.0, 0.0);
    let steps = steps_of(rows, TILT_S);
    for pair in steps.windows(2) {
        let [(from, middle), (_, to)] = [pair[0], pair[1]];
        let mean = |range: std::ops::Range<usize>| {
            let count = range.len().max(1) as f64;
            raw.accelerations_mps2[range].iter().sum::<Vector3<f64>>() / count
        };
        let (before, after) = (mean(from..middle), mean(middle..to));
        let tilt = |force: Vector3<f64>| [force.y.atan2(force.z), (-force.x).atan2(force.z)];
        let (before, after) = (tilt(before), tilt(after));
        // Mean angles of two neighbouring stretches are as far apart as their middles.
        let half = |stretch: std::ops::Range<usize>| stretch.start.midpoint(stretch.end);
        for (axis, (first, second)) in before.into_iter().zip(after).enumerate() {
            let turned: f64 = (half(from..middle)..half(middle..to))
                .map(|i| raw.angular_rates_radps[i][axis] * (rows.times_s[i + 1] - rows.times_s[i]))
                .sum();
            by_rates += turned * turned;
            by_gravity += (second - first).powi(2);
        }
    }
    let count = (2 * steps.len().saturating_sub(1)).max(1) as f64;
    let (by_rates, by_gravity) = ((by_rates / count).sqrt(), (by_gravity / count).sqrt());
    (by_rates > SMALLEST_TILT_RAD && by_gravity < SMALLEST_TILT_SHARE * by_rates).then(|| {
        rates_in_degrees(
            rows,
            &format!(
                "the rates say turns of {:.0}°, gravity moves by {:.1}°",
                by_rates.to_degrees(),
                by_gravity.to_degrees()
            ),
        )
    })
}

/// Neighbouring stretches of the walk, each of `step_s`: indices of their first and last
/// sample.
fn steps_of(rows: &Rows<'_>, step_s: f64) -> Vec<(usize, usize)> {
    let walking = rows.walking();
    let times_s = rows.times_s;
    let mut steps = Vec::new();
    let mut from = walking.start;
    while from < walking.end {
        let to = times_s
            .partition_point(|t| *t < times_s[from] + step_s)
            .max(from + 1);
        if to >= walking.end {
            break;
        }
        // A gap is no step.
        if times_s[to] - times_s[from] < 2.0 * step_s {
            steps.push((from, to));
        }
        from = to;
    }
    steps
}

/// Turns of angles beside those of rates, without their means.
#[derive(Debug, Clone, Copy, Default)]
struct Agreement {
    count: f64,
    rates: f64,
    angles: f64,
    rates2: f64,
    angles2: f64,
    product: f64,
}

impl Agreement {
    fn add(&mut self, by_rates: f64, by_angles: f64) {
        self.count += 1.0;
        self.rates += by_rates;
        self.angles += by_angles;
        self.rates2 += by_rates * by_rates;
        self.angles2 += by_angles * by_angles;
        self.product += by_rates * by_angles;
    }

    fn joined(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            rates: self.rates + other.rates,
            angles: self.angles + other.angles,
            rates2: self.rates2 + other.rates2,
            angles2: self.angles2 + other.angles2,
            product: self.product + other.product,
        }
    }

    /// Root mean square of the larger turns.
    fn largest_deviation(&self) -> f64 {
        (self.rates2.max(self.angles2) / self.count.max(1.0)).sqrt()
    }

    /// Root mean square of the smaller turns.
    fn smallest_deviation(&self) -> f64 {
        (self.rates2.min(self.angles2) / self.count.max(1.0)).sqrt()
    }

    /// How many times as far the angles turn.
    fn ratio(&self) -> f64 {
        (self.angles2 / self.rates2.max(1e-30)).sqrt()
    }

    fn correlation(&self) -> f64 {
        self.product / (self.angles2 * self.rates2).sqrt().max(1e-30)
    }
}
