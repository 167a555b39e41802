//! How well a robot walks.

use mlr_filter::{DamageDetector, DetectorSettings};
use mlr_model::{Fault, Trajectory};
use serde::Serialize;

use crate::possible_robot::PossibleRobot;

/// How one robot walks, or the mean over several.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Walking {
    /// Speed along its heading.
    pub speed_m_per_s: f64,
    /// Largest fluctuation of roll or pitch within the window of the damage detector.
    pub fluctuation_deg: f64,
    /// Change of its heading over its way, positive to the left.
    pub drift_deg_per_m: f64,
    /// Largest angle between the body's z axis and the vertical.
    pub tilt_deg: f64,
    /// Share of the time in which a servo needs all of its torque.
    pub saturated: f64,
    /// Largest torque of a servo over what it can give.
    pub torque_share: f64,
    /// Change of its heading in a cycle, to the left.
    #[serde(skip)]
    pub turn_rad_per_cycle: f64,
}

/// A robot that does not get this far in a second gets nowhere: its drift per metre means nothing.
const LEAST_SPEED_M_PER_S: f64 = 0.002;
/// A servo closer to its largest torque is at it.
const AT_LIMIT: f64 = 0.999;

impl Walking {
    /// A walk from gait time `from_s` on, whose cycles take `cycle_s`, as [`PossibleRobot::walk`]
    /// records it.
    pub fn of(
        robot: &PossibleRobot,
        walked: &Trajectory,
        from_s: f64,
        cycle_s: f64,
        detector: DetectorSettings,
    ) -> Self {
        let times_s = walked.orientation.times_s();
        let angles_rad = walked.orientation.angles_rad();
        let index = |time_s: f64| times_s.partition_point(|t| *t < time_s - 1e-6);
        let (first, end) = (index(from_s), times_s.len());
        let fluctuation_deg = fluctuation_deg(walked, first, detector);
        let tilts = (first..end)
            .map(|k| libm::acos(libm::cos(angles_rad.roll[k]) * libm::cos(angles_rad.pitch[k])));
        let tilt_deg = tilts.fold(0.0, f64::max).to_degrees();

        let positions = walked.position_m.as_deref().unwrap_or_default();
        let whole = ((times_s[end - 1] - from_s) / cycle_s + 1e-6)
            .floor()
            .max(1.0) as usize;
        let mut way_m = 0.0;
        let (mut last, mut cycles) = (first, 0);
        for cycle in 1..=whole {
            let next = index(from_s + cycle as f64 * cycle_s).min(end - 1);
            let (Some(a), Some(b)) = (positions.get(last), positions.get(next)) else {
                break;
            };
            let (sin, cos) = libm::sincos(angles_rad.yaw[last]);
            way_m += cos * (b[0] - a[0]) + sin * (b[1] - a[1]);
            (last, cycles) = (next, cycle);
        }
        let turned_rad = angles_rad.yaw[last] - angles_rad.yaw[first];
        let duration_s = (times_s[last] - times_s[first]).max(1e-9);
        let least_m = LEAST_SPEED_M_PER_S * duration_s;
        let limits_nm = limits_nm(robot);
        let torques = walked.torque_nm.as_deref().unwrap_or_default();
        let shares = torques[first.min(torques.len())..].iter().map(|row| {
            let each = row.iter().zip(&limits_nm);
            each.fold(0.0, |most: f64, (torque, limit)| {
                most.max(torque.abs() / limit)
            })
        });
        let shares: Vec<f64> = shares.collect();
        let at_limit = shares.iter().filter(|share| **share >= AT_LIMIT).count();
        Self {
            speed_m_per_s: way_m / duration_s,
            fluctuation_deg,
            drift_deg_per_m: turned_rad.to_degrees() / way_m.abs().max(least_m),
            tilt_deg,
            saturated: at_limit as f64 / shares.len().max(1) as f64,
            torque_share: shares.into_iter().fold(0.0, f64::max),
            turn_rad_per_cycle: turned_rad / cycles.max(1) as f64,
        }
    }

    /// The mean of each number, of drifts that of their size.
    pub fn mean(of: &[Self]) -> Self {
        let n = of.len().max(1) as f64;
        let mean = |of_one: fn(&Self) -> f64| of.iter().map(of_one).sum::<f64>() / n;
        Self {
            speed_m_per_s: mean(|one| one.speed_m_per_s),
            fluctuation_deg: mean(|one| one.fluctuation_deg),
            drift_deg_per_m: mean(|one| one.drift_deg_per_m.abs()),
            tilt_deg: mean(|one| one.tilt_deg),
            saturated: mean(|one| one.saturated),
            torque_share: mean(|one| one.torque_share),
            turn_rad_per_cycle: mean(|one| one.turn_rad_per_cycle),
        }
    }
}

/// The largest fluctuation that the damage detector sees from a sample on.
pub(crate) fn fluctuation_deg(
    walked: &Trajectory,
    first: usize,
    settings: DetectorSettings,
) -> f64 {
    let Ok(mut detector) = DamageDetector::new(settings) else {
        return f64::INFINITY;
    };
    let angles_rad = walked.orientation.angles_rad();
    let mut most_deg: f64 = 0.0;
    for (k, time_s) in walked.orientation.times_s().iter().enumerate().skip(first) {
        let seen = detector.push(*time_s, angles_rad.roll[k], angles_rad.pitch[k]);
        if let Ok(Some(assessment)) = seen {
            most_deg = most_deg.max(assessment.fluctuation_deg);
        }
    }
    most_deg
}

/// The largest torque of each joint that is there.
fn limits_nm(robot: &PossibleRobot) -> Vec<f64> {
    let limit_nm = robot.robot.servo().torque_limit_nm;
    let of_leg = |leg: usize| {
        let gains = robot.simulation.faults.iter().map(|fault| match *fault {
            Fault::WeakLeg { leg: one, gain } if one == leg + 1 => gain,
            _ => 1.0,
        });
        limit_nm * gains.product::<f64>()
    };
    (0..robot.morphology.legs())
        .flat_map(|leg| std::iter::repeat_n(of_leg(leg), robot.morphology.remaining(leg)))
        .collect()
}
