//! The mass of a part that several links are rigidly joined to.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use crate::robot::{Link, rotation_about};

/// Mass, centre of mass and inertia of a rigid part, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMass {
    mass_kg: f64,
    center_m: Vector3<f64>,
    inertia_kg_m2: Matrix3<f64>,
}

impl RigidMass {
    /// With its inertia about the centre of mass, along the axes of the frame.
    pub fn new(mass_kg: f64, center_m: Vector3<f64>, inertia_kg_m2: Matrix3<f64>) -> Self {
        Self {
            mass_kg,
            center_m,
            inertia_kg_m2,
        }
    }

    pub(crate) fn of_link(link: &Link) -> Self {
        Self::new(
            link.mass_kg,
            Vector3::new(link.center_of_mass_m, 0.0, 0.0),
            Matrix3::from_diagonal(&link.inertia_kg_m2),
        )
    }

    /// Its mass.
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Its centre of mass.
    pub fn center_m(&self) -> Point3<f64> {
        self.center_m.into()
    }

    /// Its inertia about the centre of mass, along the axes of the frame.
    pub fn inertia_kg_m2(&self) -> &Matrix3<f64> {
        &self.inertia_kg_m2
    }

    /// Adds `links` rigidly, each at its locked angle, the first one's joint at
    /// `frame`.
    pub(crate) fn attach_locked(&mut self, links: &[Link], frame: Isometry3<f64>) {
        for (link, frame) in links.iter().zip(locked_frames(links, frame)) {
            self.attach(&Self::of_link(link), &frame);
        }
    }

    /// Adds `other`, whose frame sits at `frame` (parallel-axis theorem). One of both has a mass.
    pub fn attach(&mut self, other: &Self, frame: &Isometry3<f64>) {
        let other_center = (frame * Point3::from(other.center_m)).coords;
        let turn = frame.rotation.to_rotation_matrix();
        let other_inertia = turn * other.inertia_kg_m2 * turn.transpose();
        let mass_kg = self.mass_kg + other.mass_kg;
        let center_m = (self.center_m * self.mass_kg + other_center * other.mass_kg) / mass_kg;
        self.inertia_kg_m2 = self.inertia_kg_m2
            + shift(self.mass_kg, self.center_m - center_m)
            + other_inertia
            + shift(other.mass_kg, other_center - center_m);
        self.mass_kg = mass_kg;
        self.center_m = center_m;
    }
}

/// Frames of links that are locked, each at its own angle, the first one's joint at `frame`.
pub(crate) fn locked_frames(links: &[Link], frame: Isometry3<f64>) -> Vec<Isometry3<f64>> {
    let each = links.iter().scan(frame, |joint, link| {
        joint.rotation *= rotation_about(&link.joint.direction(), link.locked_rad);
        let frame = *joint;
        *joint *= link.outer_end();
        Some(frame)
    });
    each.collect()
}

/// Inertia of a point mass at `offset`.
pub(crate) fn shift(mass_kg: f64, offset: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * offset.norm_squared() - offset * offset.transpose()) * mass_kg
}
