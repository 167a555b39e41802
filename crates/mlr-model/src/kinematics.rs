//! Forward and inverse kinematics of one leg, for any chain of links.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use crate::robot::{ContactShape, Leg};

/// A target counts as reached within this distance.
pub const REACH_TOLERANCE_M: f64 = 1e-6;

/// A target that the leg's foot tip cannot reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfReach {
    /// Distance between the target and the nearest point found.
    pub miss_m: f64,
}

/// Position of the foot tip in the body frame, with the joints at `angles_rad`
/// (from the hip outward).
pub fn foot_tip(leg: &Leg, angles_rad: &[f64]) -> Point3<f64> {
    outer_end(leg, &chain(leg, angles_rad))
}

/// Where the last of these links ends; the hip of a leg without links.
fn outer_end(leg: &Leg, tips: &[Isometry3<f64>]) -> Point3<f64> {
    let tip = tips.last().map(|tip| tip.translation.vector);
    tip.unwrap_or(leg.hip_m.coords).into()
}

/// Mass of the leg's innermost links, as many as there are angles, and its first moment about the
/// body's origin in kg m, body frame.
pub fn mass_moment(leg: &Leg, angles_rad: &[f64]) -> (f64, Vector3<f64>) {
    let links = leg.links.iter().zip(chain(leg, angles_rad));
    links.fold((0.0, Vector3::zeros()), |(mass_kg, moment), (link, tip)| {
        let back_m = link.center_of_mass_m - link.length_m;
        let center = tip * Point3::new(back_m, 0.0, 0.0);
        (
            mass_kg + link.mass_kg,
            moment + link.mass_kg * center.coords,
        )
    })
}

/// Height over the body's origin of the lowest point with which the leg can touch the ground,
/// with the joints at `angles_rad`; `None` for a leg without contacts.
pub fn lowest_contact_m(leg: &Leg, angles_rad: &[f64]) -> Option<f64> {
    let lowest = leg.links.iter().zip(chain(leg, angles_rad));
    lowest
        .filter_map(|(link, tip)| {
            let height_m = |back_m: f64| (tip * Point3::new(-back_m, 0.0, 0.0)).z;
            link.contact.map(|contact| match contact {
                ContactShape::Capsule { radius_m } => {
                    height_m(0.0).min(height_m(link.length_m)) - radius_m
                }
                ContactShape::Foot { radius_m } => height_m(radius_m) - radius_m,
            })
        })
        .min_by(f64::total_cmp)
}

/// Poses of the links' outer ends in the body frame, from the hip outward.
fn chain(leg: &Leg, angles_rad: &[f64]) -> Vec<Isometry3<f64>> {
    leg.links
        .iter()
        .zip(angles_rad)
        .scan(leg.hip_frame(), |frame, (link, angle_rad)| {
            *frame *= link.tip_frame(*angle_rad);
            Some(*frame)
        })
        .collect()
}

/// Joint angles (from the hip outward) that bring the foot tip to `target`, in
/// the body frame.
///
/// Levenberg-Marquardt from the leg's posture, so the branch of the solution is
/// the posture's (knee down for the JetHexa), and chains with fewer or more than
/// three joints are solved as well, as far as they can reach the target.
///
/// # Errors
/// [`OutOfReach`] when no angles bring the tip within [`REACH_TOLERANCE_M`].
pub fn inverse(leg: &Leg, target: Point3<f64>) -> Result<Vec<f64>, OutOfReach> {
    const MAX_ITERATIONS: usize = 100;
    const CONVERGED_M: f64 = 1e-12;
    const LEAST_DAMPING_M2: f64 = 1e-15;

    let mut angles_rad: Vec<f64> = leg.links.iter().map(|link| link.posture_rad).collect();
    let mut tips = chain(leg, &angles_rad);
    let mut miss = target - outer_end(leg, &tips);
    let mut damping_m2 = 1e-4;
    for _ in 0..MAX_ITERATIONS {
        if miss.norm() < CONVERGED_M {
            break;
        }
        let columns = jacobian(leg, &tips);
        let normal = columns
            .iter()
            .fold(Matrix3::identity() * damping_m2, |sum, column| {
                sum + column * column.transpose()
            });
        let Some(weighted_miss) = normal.cholesky().map(|factor| factor.solve(&miss)) else {
            break;
        };
        let stepped: Vec<f64> = angles_rad
            .iter()
            .zip(&columns)
            .map(|(angle_rad, column)| angle_rad + column.dot(&weighted_miss))
            .collect();
        let new_tips = chain(leg, &stepped);
        let new_miss = target - outer_end(leg, &new_tips);
        if new_miss.norm() < miss.norm() {
            (angles_rad, tips, miss) = (stepped, new_tips, new_miss);
            damping_m2 = (damping_m2 * 0.1).max(LEAST_DAMPING_M2);
        } else {
            damping_m2 *= 10.0;
        }
    }
    let miss_m = miss.norm();
    if miss_m <= REACH_TOLERANCE_M {
        Ok(angles_rad)
    } else {
        Err(OutOfReach { miss_m })
    }
}

/// Velocity of the foot tip per unit speed of each joint, body frame, with links that end there.
fn jacobian(leg: &Leg, tips: &[Isometry3<f64>]) -> Vec<Vector3<f64>> {
    let foot = outer_end(leg, tips).coords;
    let joints = std::iter::once(leg.hip_frame()).chain(tips.iter().copied());
    leg.links
        .iter()
        .zip(joints)
        .map(|(link, joint)| {
            let axis = joint.rotation * link.joint.direction();
            axis.cross(&(foot - joint.translation.vector))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Gait, Robot};

    /// The textbook solution for a yaw-lift-lift leg, knee down.
    fn closed_form(leg: &Leg, target: Point3<f64>) -> [f64; 3] {
        let local = leg.hip_frame().inverse_transform_point(&target);
        let yaw_rad = local.y.atan2(local.x);
        let reach = local.x.hypot(local.y) - leg.links[0].length_m;
        let (femur, tibia) = (leg.links[1].length_m, leg.links[2].length_m);
        let distance_sq = reach * reach + local.z * local.z;
        let knee = ((distance_sq - femur * femur - tibia * tibia) / (2.0 * femur * tibia)).acos();
        let lift = local.z.atan2(reach) + (tibia * knee.sin()).atan2(femur + tibia * knee.cos());
        [yaw_rad, lift, -knee]
    }

    #[test]
    fn all_angles_zero_is_straight_out() {
        for leg in Robot::jethexa().legs() {
            let reach: f64 = leg.links.iter().map(|link| link.length_m).sum();
            let expected = leg.hip_frame() * Point3::new(reach, 0.0, 0.0);
            assert!((foot_tip(leg, &[0.0; 3]) - expected).norm() < 1e-12);
        }
    }

    #[test]
    fn positive_angles_turn_left_and_lift() {
        let robot = Robot::jethexa();
        let leg = &robot.legs()[0];
        let local = |angles: [f64; 3]| {
            leg.hip_frame()
                .inverse_transform_point(&foot_tip(leg, &angles))
        };
        assert!(local([0.1, 0.0, 0.0]).y > 0.0);
        assert!(local([0.0, 0.1, 0.0]).z > 0.0);
        assert!(local([0.0, 0.0, 0.1]).z > 0.0);
    }

    #[test]
    fn a_target_beyond_the_leg_is_out_of_reach() {
        let robot = Robot::jethexa();
        let leg = &robot.legs()[0];
        let too_far = leg.hip_frame() * Point3::new(0.30, 0.0, 0.0);
        let miss_m = inverse(leg, too_far).unwrap_err().miss_m;
        let reach: f64 = leg.links.iter().map(|link| link.length_m).sum();
        assert!((miss_m - (0.30 - reach)).abs() < 1e-3, "{miss_m}");
    }

    proptest! {
        #[test]
        fn agrees_with_the_closed_form_over_the_gait(time_s in 0.0..4.0_f64, leg in 0_usize..6) {
            let (robot, gait) = (Robot::jethexa(), Gait::tripod());
            let target = gait.foot_target(leg, &robot.legs()[leg], time_s).unwrap();
            let angles = inverse(&robot.legs()[leg], target).unwrap();
            for (numeric, exact) in angles.iter().zip(closed_form(&robot.legs()[leg], target)) {
                prop_assert!((numeric - exact).abs() < 1e-8, "{angles:?}");
            }
        }

        #[test]
        fn inverts_forward_kinematics_near_the_posture(
            leg in 0_usize..6,
            offsets in prop::array::uniform3(-0.4..0.4_f64),
        ) {
            let robot = Robot::jethexa();
            let leg = &robot.legs()[leg];
            let angles: Vec<f64> = leg.links.iter().zip(offsets).map(|(l, o)| l.posture_rad + o).collect();
            let target = foot_tip(leg, &angles);
            let found = inverse(leg, target).unwrap();
            prop_assert!((foot_tip(leg, &found) - target).norm() < REACH_TOLERANCE_M);
        }
    }
}
