//! Removal of the drift that a biased gyroscope causes.

use crate::{Axes, OrientationSeries, line::Line};

/// An angle that is a straight line for this long drifts; it does not move.
const STRAIGHT_S: f64 = 0.5;
/// Time between two estimates of the drift rate, which a sensor's own filter changes slowly.
const RENEWED_S: f64 = 0.1;

/// The angles of a recording in degrees without their drift. Its rate is estimated wherever
/// an angle is a straight line to within `tolerance_deg` (RMS), as on a standing robot with a
/// biased gyroscope, and is held while the robot walks.
pub(crate) fn without_steady_drift_deg(
    recording: &OrientationSeries,
    tolerance_deg: f64,
) -> Axes<Vec<f64>> {
    let times_s = recording.times_s();
    recording.angles_rad().as_ref().map(|_, angles_rad| {
        let angles_deg: Vec<f64> = angles_rad.iter().map(|angle| angle.to_degrees()).collect();
        without_drift(times_s, angles_deg, tolerance_deg)
    })
}

fn without_drift(times_s: &[f64], mut angles_deg: Vec<f64>, tolerance_deg: f64) -> Vec<f64> {
    let Some(&first_s) = times_s.first() else {
        return angles_deg;
    };
    let measured_deg = angles_deg.clone();
    let mut rate_dps = 0.0;
    let mut drifted_deg = 0.0;
    let mut before_s = first_s;
    let mut renew_s = first_s;
    for (index, &time_s) in times_s.iter().enumerate() {
        if time_s >= renew_s {
            // The first estimate looks ahead: there is none before it.
            let end_s = time_s.max(first_s + STRAIGHT_S);
            let line_from = |begin_s: f64, end_s: f64| {
                let begin = times_s.partition_point(|t| *t < begin_s);
                let stretch = begin..times_s.partition_point(|t| *t <= end_s);
                let line = Line::through(&times_s[stretch.clone()], &measured_deg[stretch]);
                (line.error < tolerance_deg).then_some(line.slope)
            };
            let straight = line_from(end_s - STRAIGHT_S, end_s);
            // The drift rate changes most while the sensor's filter converges.
            let middle_s = end_s - STRAIGHT_S / 2.0;
            let in_halves = || {
                let first = line_from(end_s - STRAIGHT_S, middle_s)?;
                let last = line_from(middle_s, end_s)?;
                Some(if index == 0 { first } else { last })
            };
            let rate = straight.or_else(in_halves);
            rate_dps = rate.unwrap_or(rate_dps);
            renew_s = end_s.max(renew_s + RENEWED_S);
        }
        drifted_deg += rate_dps * (time_s - before_s);
        before_s = time_s;
        angles_deg[index] -= drifted_deg;
    }
    angles_deg
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn times_s() -> Vec<f64> {
        (0..500).map(|i| f64::from(i) * 0.01).collect()
    }

    /// Within 0.04 s.
    fn largest_step(angles_deg: &[f64]) -> f64 {
        let steps = angles_deg.windows(5).map(|w| (w[4] - w[0]).abs());
        steps.fold(0.0, f64::max)
    }

    #[test]
    fn a_drift_is_gone_and_what_moves_stays() {
        let moved = |t: f64| {
            if t < 2.0 {
                0.0
            } else {
                (6.0 * (t - 2.0)).sin()
            }
        };
        let drifting = times_s().iter().map(|t| 4.0 * t + moved(*t)).collect();
        let without = without_drift(&times_s(), drifting, 0.02);
        for (time_s, angle_deg) in times_s().iter().zip(without) {
            assert!(
                (angle_deg - moved(*time_s)).abs() < 0.1,
                "{time_s} {angle_deg}"
            );
        }
    }

    #[test]
    fn a_drift_that_bends_is_followed() {
        let bent = times_s().iter().map(|t| 1.2 * t * t).collect();
        let without = without_drift(&times_s(), bent, 0.05);
        let steepest = largest_step(&without);
        assert!(steepest < 0.05, "{steepest}");
    }

    #[test]
    fn a_drift_that_a_filter_bends_from_its_first_sample_on_is_followed() {
        // A bias of 5 °/s in a filter that trusts the gyroscope for 1.9 s.
        let bent = |t: &f64| 5.0 * 1.9 * (1.0 - (-t / 1.9).exp());
        let bent = times_s().iter().map(bent).collect();
        let without = without_drift(&times_s(), bent, 0.02);
        let steepest = largest_step(&without);
        assert!(steepest < 0.04, "{steepest}");
    }

    #[test]
    fn a_walk_from_the_first_sample_on_is_left_alone() {
        let walk: Vec<f64> = times_s().iter().map(|t| (6.0 * t).sin()).collect();
        assert_eq!(without_drift(&times_s(), walk.clone(), 0.02), walk);
    }

    proptest! {
        #[test]
        fn a_straight_line_of_any_length_is_nothing(
            first_s in -1e6..1e6_f64,
            steps_s in prop::collection::vec(1e-3..0.3_f64, 0..200),
            rate_dps in -20.0..20.0_f64,
        ) {
            let mut times_s = vec![first_s];
            for step_s in steps_s {
                times_s.push(times_s[times_s.len() - 1] + step_s);
            }
            let line = times_s.iter().map(|t| rate_dps * (t - first_s)).collect();
            let without = without_drift(&times_s, line, 0.02);
            let enough = times_s.iter().filter(|t| **t <= first_s + STRAIGHT_S).count() >= 3;
            let moved = without.iter().any(|angle_deg| angle_deg.abs() > 1e-3);
            prop_assert!(!enough || !moved, "{without:?}");
        }
    }
}
