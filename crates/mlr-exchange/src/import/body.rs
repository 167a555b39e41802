//! The body: mass, the box that can touch the ground, and where its origin is.

use mlr_model::RigidMass;
use nalgebra::{Isometry3, Vector3};

use super::{
    ImportError, Notes,
    parts::Part,
    urdf::{Form, Shape},
};

/// A body as a description has it.
pub(super) struct ImportedBody {
    pub(super) size_m: Vector3<f64>,
    /// Of the description in the URDF's link.
    pub(super) origin_m: Vector3<f64>,
    pub(super) mass: RigidMass,
}

/// Thickness of a body whose shape is not known, and least extent of any.
const THICKNESS_M: f64 = 0.05;
const LEAST_M: f64 = 1e-3;

impl ImportedBody {
    /// From the part that legs hang on at these hips.
    pub(super) fn new(
        part: &Part,
        hips_m: &[Vector3<f64>],
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let Some(mass) = part.mass else {
            let what = format!(
                "link {:?} has no mass, expected one of the body: <inertial> with <mass>",
                part.name
            );
            return Err(ImportError::of_file(what));
        };
        let shapes = if part.collisions.is_empty() {
            &part.visuals
        } else {
            &part.collisions
        };
        let boxed = shapes.iter().filter_map(upright_box);
        let largest = boxed.max_by(|a, b| a.0.product().total_cmp(&b.0.product()));
        let (size_m, origin_m) = largest.unwrap_or_else(|| {
            notes.assumed(format!(
                "the extent of the body, of which no box tells: as far as its hips, {:.0} mm thick",
                1e3 * THICKNESS_M
            ));
            let extent = |axis: usize| {
                let far = hips_m.iter().map(|hip| hip[axis].abs());
                2.0 * far.fold(THICKNESS_M / 2.0, f64::max)
            };
            (
                Vector3::new(extent(0), extent(1), THICKNESS_M),
                Vector3::zeros(),
            )
        });
        if shapes.len() > 1 {
            notes.left_out(format!(
                "{} of the body's shapes, beside its largest box",
                shapes.len() - 1
            ));
        }
        if origin_m.norm() > 1e-6 {
            notes.assumed(format!(
                "the body's origin in the middle of its box, at {:.1}, {:.1}, {:.1} mm of link {:?}",
                1e3 * origin_m.x, 1e3 * origin_m.y, 1e3 * origin_m.z, part.name
            ));
        }
        let mut centered = None;
        super::parts::join(&mut centered, &mass, &Isometry3::from(-origin_m));
        let mass = centered.unwrap_or(mass);
        let inertia = mass.inertia_kg_m2();
        let products = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| inertia[(i, j)].abs());
        let share = products.into_iter().fold(0.0, f64::max) / inertia.diagonal().amax().max(1e-30);
        if share > 0.02 {
            notes.left_out(format!(
                "products of inertia of the body, up to {:.0} % of its largest moment",
                100.0 * share
            ));
        }
        Ok(Self {
            size_m: size_m.map(|extent| extent.max(LEAST_M)),
            origin_m,
            mass,
        })
    }

    /// Moments about the centre of mass along x, y, z; those of the box where the file's are none.
    pub(super) fn moments(&self, notes: &mut Notes) -> [f64; 3] {
        let moments: [f64; 3] = self.mass.inertia_kg_m2().diagonal().into();
        let sum: f64 = moments.iter().sum();
        let physical = moments
            .iter()
            .all(|one| *one > 0.0 && 2.0 * one <= sum * (1.0 + 1e-6));
        if physical {
            return moments;
        }
        notes.assumed(
            "the inertia of a solid box for the body: the file's is none of a body".into(),
        );
        let square = self.size_m.component_mul(&self.size_m) * (self.mass.mass_kg() / 12.0);
        [
            square.y + square.z,
            square.x + square.z,
            square.x + square.y,
        ]
    }
}

/// Extent along x, y, z, and centre, of a box that stands parallel to the axes.
fn upright_box(shape: &Shape) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let Form::Box(size) = shape.form else {
        return None;
    };
    let turned = (shape.frame.rotation.to_rotation_matrix().matrix().abs()) * size;
    // Turned by quarters, or not at all: then the volume is the same.
    let parallel = turned.product() < 1.02 * size.product();
    parallel.then_some((turned, shape.frame.translation.vector))
}
