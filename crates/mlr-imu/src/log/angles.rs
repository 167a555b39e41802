//! Roll, pitch and yaw as they are logged: as quaternions, or turned back at a border.

use std::f64::consts::TAU;

use mlr_filter::{Axes, unwrapped_rad};
use nalgebra::{Quaternion, UnitQuaternion};

/// How far the norm of a quaternion may be off 1.
const NORM_TOLERANCE: f64 = 0.02;
/// How far beyond a turn an angle that is kept within one may lie, for rounding.
const TURN_TOLERANCE_RAD: f64 = 0.05;

/// The norm of w, x, y, z if it is too far from 1 for an orientation.
pub(super) fn wrong_norm(elements: [f64; 4]) -> Option<f64> {
    let norm = elements.into_iter().map(|x| x * x).sum::<f64>().sqrt();
    ((norm - 1.0).abs() > NORM_TOLERANCE || norm.is_nan()).then_some(norm)
}

/// Roll, pitch and yaw in rad of the rotations w, x, y, z from body to world,
/// R = Rz(yaw) Ry(pitch) Rx(roll), each kept within a turn.
pub(super) fn of_quaternions([w, x, y, z]: [Vec<f64>; 4]) -> Axes<Vec<f64>> {
    let mut angles = Axes::from_fn(|_| Vec::with_capacity(w.len()));
    let vectors = x.into_iter().zip(y).zip(z);
    for (w, ((x, y), z)) in w.into_iter().zip(vectors) {
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let (roll, pitch, yaw) = rotation.euler_angles();
        angles.roll.push(roll);
        angles.pitch.push(pitch);
        angles.yaw.push(yaw);
    }
    angles
}

/// Angles without the jumps of a turn that come from keeping them within -π to π or 0 to 2π.
/// An axis that is not kept within a turn stays as it is: it is unwrapped already, or not in
/// radians.
pub(crate) fn unwrapped(mut angles_rad: Axes<Vec<f64>>) -> Axes<Vec<f64>> {
    let Axes { roll, pitch, yaw } = &mut angles_rad;
    for angles in [roll, pitch, yaw] {
        if is_kept_within_a_turn(angles) {
            unwrap(angles);
        }
    }
    angles_rad
}

fn is_kept_within_a_turn(angles_rad: &[f64]) -> bool {
    let wide = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = angles_rad
        .iter()
        .fold(wide, |(low, high), &x| (low.min(x), high.max(x)));
    let most = TAU + TURN_TOLERANCE_RAD;
    low >= -most && high <= most && high - low <= most
}

fn unwrap(angles_rad: &mut [f64]) {
    let mut before = angles_rad.first().copied().unwrap_or_default();
    for angle in angles_rad {
        *angle = unwrapped_rad(before, *angle);
        before = *angle;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    fn of_yaw(yaw: Vec<f64>) -> Axes<Vec<f64>> {
        Axes {
            roll: vec![0.0; yaw.len()],
            pitch: vec![0.0; yaw.len()],
            yaw,
        }
    }

    fn turning() -> Vec<f64> {
        (0..400).map(|i| 6.0 - 0.05 * f64::from(i)).collect()
    }

    #[test]
    fn a_turning_body_is_unwrapped_from_either_convention() {
        for low in [-PI, 0.0] {
            let whole = turning();
            let wrapped: Vec<f64> = whole
                .iter()
                .map(|x| (x - low).rem_euclid(TAU) + low)
                .collect();
            assert!(
                wrapped
                    .windows(2)
                    .any(|pair| (pair[1] - pair[0]).abs() > 3.0)
            );
            let offset = wrapped[0] - whole[0];
            for (ours, true_rad) in unwrapped(of_yaw(wrapped)).yaw.iter().zip(&whole) {
                assert!((ours - true_rad - offset).abs() < 1e-9, "{ours} {true_rad}");
            }
        }
    }

    #[test]
    fn what_is_no_wrapped_angle_stays() {
        for yaw in [
            turning(),
            // Degrees that are called radians jump at 180.
            vec![170.0, 179.0, -179.0, -170.0],
            vec![0.1, -0.2, 0.3],
            vec![],
        ] {
            assert_eq!(unwrapped(of_yaw(yaw.clone())).yaw, yaw);
        }
    }

    #[test]
    fn only_unit_quaternions_are_orientations() {
        assert_eq!(wrong_norm([0.5, -0.5, 0.5, -0.5]), None);
        assert_eq!(wrong_norm([1.019, 0.0, 0.0, 0.0]), None);
        assert_eq!(wrong_norm([0.0; 4]), Some(0.0));
        assert_eq!(wrong_norm([0.0, 2.0, 0.0, 0.0]), Some(2.0));
        assert!(wrong_norm([f64::MAX; 4]).is_some());
    }

    proptest! {
        #[test]
        fn a_rotation_gives_the_angles_that_it_is_made_of(
            roll in -3.0..3.0_f64, pitch in -1.5..1.5_f64, yaw in -3.0..3.0_f64, length in 0.99..1.01_f64
        ) {
            let q = UnitQuaternion::from_euler_angles(roll, pitch, yaw).into_inner() * length;
            let angles = of_quaternions([q.w, q.i, q.j, q.k].map(|x| vec![x]));
            for (ours, meant) in [(&angles.roll, roll), (&angles.pitch, pitch), (&angles.yaw, yaw)] {
                prop_assert!((ours[0] - meant).abs() < 1e-9, "{} {meant}", ours[0]);
            }
        }
    }
}
