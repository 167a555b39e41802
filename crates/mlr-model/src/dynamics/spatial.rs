//! Twists, wrenches and inertias of rigid parts, all in one frame.
//!
//! A twist is the velocity of the point at the frame's origin, then the angular velocity; a wrench
//! is the force, then the moment about the origin. The product of the two is a power.

use nalgebra::{Matrix3, Matrix6, Point3, Vector3, Vector6};

use crate::rigid_mass::{RigidMass, shift};

/// Linear part first, then angular.
pub(super) fn joined(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

pub(super) fn linear(vector: &Vector6<f64>) -> Vector3<f64> {
    vector.fixed_rows::<3>(0).into()
}

pub(super) fn angular(vector: &Vector6<f64>) -> Vector3<f64> {
    vector.fixed_rows::<3>(3).into()
}

/// Twist of a turn with 1 rad/s about an axis through a point.
pub(super) fn turn_about(axis: &Vector3<f64>, through: &Vector3<f64>) -> Vector6<f64> {
    joined(through.cross(axis), *axis)
}

/// Velocity of a point that moves with this twist.
pub(super) fn velocity_at(twist: &Vector6<f64>, point: &Point3<f64>) -> Vector3<f64> {
    linear(twist) + angular(twist).cross(&point.coords)
}

/// Wrench of a force at a point.
pub(super) fn wrench_at(force: &Vector3<f64>, point: &Point3<f64>) -> Vector6<f64> {
    joined(*force, point.coords.cross(force))
}

/// Rate of a twist that is fixed in what moves with `by` (the Lie bracket ad_by of the twist).
pub(super) fn carried(by: &Vector6<f64>, twist: &Vector6<f64>) -> Vector6<f64> {
    let turn = angular(by);
    joined(
        turn.cross(&linear(twist)) + linear(by).cross(&angular(twist)),
        turn.cross(&angular(twist)),
    )
}

/// Rate of a wrench, or of a momentum, that is fixed in what moves with `by`: −ad_byᵀ of it.
pub(super) fn carried_wrench(by: &Vector6<f64>, wrench: &Vector6<f64>) -> Vector6<f64> {
    let turn = angular(by);
    joined(
        turn.cross(&linear(wrench)),
        turn.cross(&angular(wrench)) + linear(by).cross(&linear(wrench)),
    )
}

/// The matrix ad of a twist, for [`carried`].
pub(super) fn carrying_matrix(by: &Vector6<f64>) -> Matrix6<f64> {
    let (speed, turn) = (linear(by).cross_matrix(), angular(by).cross_matrix());
    blocks(&turn, &speed, &Matrix3::zeros(), &turn)
}

/// The skew-symmetric matrix that makes of a twist the rate of the momentum that moves with it:
/// −ad_Vᵀ h as a function of V.
pub(super) fn momentum_matrix(momentum: &Vector6<f64>) -> Matrix6<f64> {
    let linear = linear(momentum).cross_matrix();
    let angular = angular(momentum).cross_matrix();
    -blocks(&Matrix3::zeros(), &linear, &linear, &angular)
}

fn blocks(
    top_left: &Matrix3<f64>,
    top_right: &Matrix3<f64>,
    bottom_left: &Matrix3<f64>,
    bottom_right: &Matrix3<f64>,
) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(top_left);
    matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(top_right);
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(bottom_left);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(bottom_right);
    matrix
}

/// Inertia of one part or of several that are joined, about the frame's origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpatialInertia {
    pub(super) mass_kg: f64,
    /// Mass times centre of mass, kg m.
    pub(super) first_moment: Vector3<f64>,
    /// About the origin, kg m².
    second_moment: Matrix3<f64>,
}

impl SpatialInertia {
    /// Of a part in the frame in which `mass` is given.
    pub(super) fn of(mass: &RigidMass) -> Self {
        Self::about(
            mass.mass_kg(),
            mass.center_m().coords,
            *mass.inertia_kg_m2(),
        )
    }

    /// Of nothing.
    pub(super) fn none() -> Self {
        Self::about(0.0, Vector3::zeros(), Matrix3::zeros())
    }

    /// From the inertia about the centre of mass.
    pub(super) fn about(mass_kg: f64, center_m: Vector3<f64>, inertia: Matrix3<f64>) -> Self {
        // Turned inertias are symmetric but for rounding.
        let inertia = (inertia + inertia.transpose()) * 0.5;
        Self {
            mass_kg,
            first_moment: center_m * mass_kg,
            second_moment: inertia + shift(mass_kg, center_m),
        }
    }

    /// Of both, joined.
    pub(super) fn add(&mut self, other: &Self) {
        self.mass_kg += other.mass_kg;
        self.first_moment += other.first_moment;
        self.second_moment += other.second_moment;
    }

    /// Momentum of what moves with this twist; or its rate, of an acceleration.
    pub(super) fn momentum(&self, twist: &Vector6<f64>) -> Vector6<f64> {
        let (speed, turn) = (linear(twist), angular(twist));
        joined(
            speed * self.mass_kg + turn.cross(&self.first_moment),
            self.second_moment * turn + self.first_moment.cross(&speed),
        )
    }

    pub(super) fn matrix(&self) -> Matrix6<f64> {
        let moment = self.first_moment.cross_matrix();
        let mass = Matrix3::from_diagonal_element(self.mass_kg);
        blocks(&mass, &-moment, &moment, &self.second_moment)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn six() -> impl Strategy<Value = Vector6<f64>> {
        prop::array::uniform6(-2.0..2.0_f64).prop_map(Vector6::from)
    }

    proptest! {
        #[test]
        fn matrices_do_what_the_products_do(by in six(), of in six(), center in prop::array::uniform3(-1.0..1.0_f64)) {
            prop_assert!((carrying_matrix(&by) * of - carried(&by, &of)).norm() < 1e-12);
            prop_assert!((momentum_matrix(&of) * by - carried_wrench(&by, &of)).norm() < 1e-12);
            let skew = momentum_matrix(&of);
            prop_assert!((skew + skew.transpose()).norm() == 0.0);
            let inertia = SpatialInertia::about(1.3, center.into(), Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25)));
            prop_assert!((inertia.matrix() * of - inertia.momentum(&of)).norm() < 1e-12);
        }

        #[test]
        fn a_wrench_that_is_carried_along_keeps_its_power(by in six(), twist in six(), wrench in six()) {
            let rate = carried(&by, &twist).dot(&wrench) + twist.dot(&carried_wrench(&by, &wrench));
            prop_assert!(rate.abs() < 1e-12);
        }
    }
}
