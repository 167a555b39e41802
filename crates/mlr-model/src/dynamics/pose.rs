//! What the pose alone decides: mass matrix, gravity, centre of mass.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, UnitQuaternion, Vector3, Vector6};

use super::{
    BASE, Dynamics,
    spatial::{SpatialInertia, joined, turn_about},
};
use crate::{robot::rotation_about, simulation::physics::GRAVITY_MPS2};

/// A robot in a pose. All matrices and vectors that are written to are the caller's, so that
/// nothing is allocated.
#[derive(Debug)]
pub struct Posed<'d> {
    pub(super) dynamics: &'d mut Dynamics,
    /// In the body frame.
    pub(super) gravity_mps2: Vector3<f64>,
}

/// A link in its pose; everything in the body frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedLink {
    pub(super) pose: Isometry3<f64>,
    /// Twist of the link per unit speed of its joint.
    pub(super) screw: Vector6<f64>,
    pub(super) inertia: SpatialInertia,
}

impl Default for PlacedLink {
    fn default() -> Self {
        Self {
            pose: Isometry3::identity(),
            screw: Vector6::zeros(),
            inertia: SpatialInertia::none(),
        }
    }
}

impl Dynamics {
    /// The robot with its body turned by `attitude` (body frame to world, z up) and its joints at
    /// these angles, in the order of [`joints`](Self::joints).
    ///
    /// # Panics
    /// When there is not one angle for each joint.
    pub fn at(&mut self, attitude: &UnitQuaternion<f64>, joints_rad: &[f64]) -> Posed<'_> {
        assert_eq!(
            joints_rad.len(),
            self.links.len(),
            "one angle for each joint"
        );
        for leg in &self.legs {
            let mut parent = Isometry3::identity();
            for index in leg.links() {
                let link = &self.links[index];
                let mut pose = parent * link.frame;
                let axis = pose.rotation * link.axis;
                let screw = turn_about(&axis, &pose.translation.vector);
                pose.rotation *= rotation_about(&link.axis, joints_rad[index]);
                let turn = pose.rotation.to_rotation_matrix();
                self.placed[index] = PlacedLink {
                    pose,
                    screw,
                    inertia: SpatialInertia::about(
                        link.mass_kg,
                        pose.translation.vector + turn * link.center_m,
                        turn * link.inertia_kg_m2 * turn.transpose(),
                    ),
                };
                parent = pose;
            }
        }
        Posed {
            gravity_mps2: attitude.inverse() * (GRAVITY_MPS2 * Vector3::z()),
            dynamics: self,
        }
    }
}

impl Posed<'_> {
    /// M, n × n, symmetric and positive definite.
    ///
    /// # Panics
    /// When `mass` is not n × n.
    pub fn mass_matrix(&self, mass: &mut DMatrix<f64>) {
        let Dynamics {
            body, legs, placed, ..
        } = &*self.dynamics;
        let n = self.dynamics.freedoms();
        assert_eq!(mass.shape(), (n, n), "a matrix of n × n");
        mass.fill(0.0);
        let mut whole = *body;
        for leg in legs {
            let mut beyond = SpatialInertia::none();
            for outer in leg.links().rev() {
                beyond.add(&placed[outer].inertia);
                // The momentum of all from here on outward, per speed of this joint.
                let momentum = beyond.momentum(&placed[outer].screw);
                let column = BASE + outer;
                for (row, entry) in momentum.iter().enumerate() {
                    mass[(row, column)] = *entry;
                    mass[(column, row)] = *entry;
                }
                for inner in leg.first..=outer {
                    let entry = placed[inner].screw.dot(&momentum);
                    mass[(BASE + inner, column)] = entry;
                    mass[(column, BASE + inner)] = entry;
                }
            }
            whole.add(&beyond);
        }
        mass.fixed_view_mut::<BASE, BASE>(0, 0)
            .copy_from(&whole.matrix());
    }

    /// g: what must be applied, n rows, for gravity to move nothing.
    ///
    /// # Panics
    /// When `forces` has not n rows.
    pub fn gravity_forces(&self, forces: &mut DVector<f64>) {
        let Dynamics {
            body, legs, placed, ..
        } = &*self.dynamics;
        assert_eq!(forces.len(), self.dynamics.freedoms(), "a vector of n");
        let weight = |inertia: &SpatialInertia| {
            let moment = inertia.first_moment.cross(&self.gravity_mps2);
            joined(self.gravity_mps2 * inertia.mass_kg, moment)
        };
        let mut whole = *body;
        for leg in legs {
            let mut beyond = SpatialInertia::none();
            for index in leg.links().rev() {
                beyond.add(&placed[index].inertia);
                forces[BASE + index] = -placed[index].screw.dot(&weight(&beyond));
            }
            whole.add(&beyond);
        }
        forces.fixed_rows_mut::<BASE>(0).copy_from(&-weight(&whole));
    }

    /// The centre of mass of all that is left, in the body frame.
    pub fn center_of_mass_m(&self) -> Point3<f64> {
        let mut whole = self.dynamics.body;
        for link in &self.dynamics.placed {
            whole.add(&link.inertia);
        }
        Point3::from(whole.first_moment / whole.mass_kg)
    }

    /// The robot to which this pose belongs.
    pub fn dynamics(&self) -> &Dynamics {
        self.dynamics
    }
}
