//! The ground under the robot.

use mlr_filter::SettingError;
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rapier3d::math::Vector;
use rapier3d::parry::utils::Array2;
use rapier3d::prelude::SharedShape;
use serde::{Deserialize, Serialize};

/// A plane of any inclination, smooth or covered with rubble.
///
/// The robot starts at the origin, parallel to the plane.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Terrain {
    /// Angle between the plane and the horizontal.
    pub slope_rad: f64,
    /// Direction in which the plane rises, counter-clockwise from the robot's
    /// initial x axis.
    pub uphill_rad: f64,
    /// Rubble on the plane, if any.
    pub roughness: Option<Roughness>,
}

/// Random heights on a square grid, with triangles between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Roughness {
    /// Heights are uniform between zero and this.
    pub height_m: f64,
    /// Distance between neighbouring grid points.
    pub spacing_m: f64,
    /// Chooses the heights.
    pub seed: u64,
}

impl Terrain {
    /// Half the side of the square that rubble covers.
    const ROUGH_HALF_WIDTH_M: f64 = 1.5;

    /// Steepest slope, in degrees, on which a walk is simulated.
    pub const STEEPEST_DEG: f64 = 68.0;

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("slope_rad", self.slope_rad, 0.0..=1.2, "rad")?;
        SettingError::check("uphill_rad", self.uphill_rad, -10.0..=10.0, "rad")?;
        let roughness = self.roughness.as_ref().map_or(Ok(()), Roughness::check);
        roughness.map_err(|error| error.under("roughness"))
    }

    /// Rotation from a horizontal plane to this one, without turning about the
    /// vertical.
    pub(crate) fn inclination(&self) -> UnitQuaternion<f64> {
        let (sin, cos) = libm::sincos(self.uphill_rad);
        let axis = UnitVector3::new_unchecked(Vector3::new(sin, -cos, 0.0));
        crate::robot::rotation_about(&axis, self.slope_rad)
    }

    /// How far the highest point of the ground can rise above the plane.
    pub(crate) fn highest_m(&self) -> f64 {
        self.roughness.map_or(0.0, |roughness| roughness.height_m)
    }

    /// The ground's shape, level, and the rotation that turns its up axis to z.
    pub(crate) fn level_shape(&self) -> (SharedShape, UnitQuaternion<f64>) {
        match &self.roughness {
            None => (
                SharedShape::halfspace(Vector::Z),
                UnitQuaternion::identity(),
            ),
            // A height field rises along its own y axis.
            Some(roughness) => (
                roughness.height_field(2.0 * Self::ROUGH_HALF_WIDTH_M),
                crate::robot::rotation_about(&Vector3::x(), std::f64::consts::FRAC_PI_2),
            ),
        }
    }
}

impl Roughness {
    fn check(&self) -> Result<(), SettingError> {
        SettingError::check("height_m", self.height_m, 0.0..=1.0, "m")?;
        SettingError::check("spacing_m", self.spacing_m, 0.005..=1.0, "m")
    }

    fn height_field(&self, width_m: f64) -> SharedShape {
        let points = libm::ceil(width_m / self.spacing_m) as usize + 1;
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        let heights = (0..points * points)
            .map(|_| {
                let uniform = f64::from(generator.next_u32()) / f64::from(u32::MAX);
                (uniform * self.height_m) as f32
            })
            .collect();
        SharedShape::heightfield(
            Array2::new(points, points, heights),
            Vector::new(width_m as f32, 1.0, width_m as f32),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uphill_rises_in_its_direction() {
        for uphill_deg in [0.0_f64, 20.0, 90.0, 200.0] {
            let terrain = Terrain {
                slope_rad: 0.1,
                uphill_rad: uphill_deg.to_radians(),
                roughness: None,
            };
            let forward = Vector3::new(terrain.uphill_rad.cos(), terrain.uphill_rad.sin(), 0.0);
            let along_slope = terrain.inclination() * forward;
            assert!(
                (along_slope.z - 0.1_f64.sin()).abs() < 1e-12,
                "{uphill_deg}"
            );
        }
    }

    #[test]
    fn rubble_depends_on_its_seed_and_stays_within_its_height() {
        let rubble = |seed| Roughness {
            height_m: 0.006,
            spacing_m: 0.05,
            seed,
        };
        let heights = |roughness: Roughness| {
            let shape = roughness.height_field(1.0);
            let field = shape.as_heightfield().unwrap().clone();
            field.heights().data().to_vec()
        };
        assert_eq!(heights(rubble(1)), heights(rubble(1)));
        assert_ne!(heights(rubble(1)), heights(rubble(2)));
        assert!(heights(rubble(1)).iter().all(|h| (0.0..=0.006).contains(h)));
    }
}
