//! Feet: where they are, how they move, and what a force on them does.

use nalgebra::{DMatrix, DVector, Point3, Vector3, Vector6};

use super::{
    BASE, Moving, Posed,
    spatial::{angular, linear, velocity_at, wrench_at},
};

/// A point of the outermost link that is left of a leg, for the robot that it was taken from: with
/// another robot's methods panic or answer for another leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    leg: usize,
    /// Where it is, in the body frame.
    pub point_m: Point3<f64>,
}

impl Foot {
    /// The leg, from 0.
    pub fn leg(&self) -> usize {
        self.leg
    }

    /// Another point of the same link, in the body frame: the lowest of a foot's sphere, where it
    /// touches the ground.
    #[must_use]
    pub fn at(self, point_m: Point3<f64>) -> Self {
        Self { point_m, ..self }
    }
}

impl Posed<'_> {
    /// The outer end of the outermost link that is left of leg `leg`, from 0; `None` where the
    /// whole leg is lost, or the robot never had it.
    pub fn foot(&self, leg: usize) -> Option<Foot> {
        let last = self.dynamics.legs.get(leg)?.links().next_back()?;
        let length_m = self.dynamics.links[last].length_m;
        let point_m = self.dynamics.placed[last].pose * Point3::new(length_m, 0.0, 0.0);
        Some(Foot { leg, point_m })
    }

    /// J, 3 × n: the velocity of the foot's point, along the axes of the body frame, is J ν.
    ///
    /// # Panics
    /// When `jacobian` is not 3 × n.
    pub fn foot_jacobian(&self, foot: &Foot, jacobian: &mut DMatrix<f64>) {
        let n = self.dynamics.freedoms();
        assert_eq!(jacobian.shape(), (3, n), "a matrix of 3 × n");
        jacobian.fill(0.0);
        for axis in 0..3 {
            jacobian[(axis, axis)] = 1.0;
        }
        let arm = foot.point_m.coords.cross_matrix();
        jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm);
        for index in self.dynamics.legs[foot.leg].links() {
            let velocity = velocity_at(&self.dynamics.placed[index].screw, &foot.point_m);
            jacobian.set_column(BASE + index, &velocity);
        }
    }

    /// Adds Jᵀ f to generalised forces, n rows: a force on the foot, N, along the axes of the body
    /// frame.
    ///
    /// # Panics
    /// When `forces` has not n rows.
    pub fn add_force(&self, foot: &Foot, force_n: &Vector3<f64>, forces: &mut DVector<f64>) {
        assert_eq!(forces.len(), self.dynamics.freedoms(), "a vector of n");
        let wrench = wrench_at(force_n, &foot.point_m);
        let mut body = forces.fixed_rows_mut::<BASE>(0);
        body += wrench;
        for index in self.dynamics.legs[foot.leg].links() {
            forces[BASE + index] += self.dynamics.placed[index].screw.dot(&wrench);
        }
    }
}

impl Moving<'_> {
    /// Velocity of the foot's point over the ground, J ν, along the axes of the body frame.
    pub fn foot_velocity_mps(&self, foot: &Foot) -> Vector3<f64> {
        velocity_at(&self.foot_twist(foot).0, &foot.point_m)
    }

    /// Acceleration of the foot's point at constant ν, along the axes of the body frame. With
    /// dν/dt it is J dν/dt more: what must be zero for a foot that stands.
    pub fn foot_drift_mps2(&self, foot: &Foot) -> Vector3<f64> {
        let (twist, drift) = self.foot_twist(foot);
        let velocity = velocity_at(&twist, &foot.point_m);
        linear(&drift)
            + angular(&drift).cross(&foot.point_m.coords)
            + angular(&twist).cross(&velocity)
    }

    /// Twist of the foot's link, and its acceleration at constant ν.
    fn foot_twist(&self, foot: &Foot) -> (Vector6<f64>, Vector6<f64>) {
        let dynamics = self.dynamics();
        let last = dynamics.legs[foot.leg].links().next_back();
        last.map_or((self.twist, Vector6::zeros()), |last| {
            let link = &dynamics.moving[last];
            (link.twist, link.drift)
        })
    }
}
