//! A frame that keeps the robot's heading.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use crate::{Terrain, robot::rotation_about};

/// How the frame of the physics has turned about the ground's normal.
///
/// Rapier solves friction along two directions that are fixed in its world, each with its
/// own effective mass: a foot slides more easily along one than along the other. A robot that
/// turns would walk unlike itself with every heading, by a fifth of its rate of turning. On a
/// plane the physics can turn with the robot instead, gravity and pulls the other way.
#[derive(Debug, Clone)]
pub(super) struct HeadingFrame {
    /// Parallel to the plane that the robot starts on.
    inclination: UnitQuaternion<f64>,
    to_world: Isometry3<f64>,
    follows: bool,
}

/// The frame is turned when the heading in it has grown by so much.
const LEAST_TURN_RAD: f64 = 0.02;

impl HeadingFrame {
    /// A frame that follows the robot's heading where `follows` is set and the ground is a
    /// smooth plane, and else stays as it is.
    pub(super) fn new(terrain: &Terrain, follows: bool) -> Self {
        Self {
            inclination: terrain.inclination(),
            to_world: Isometry3::identity(),
            follows: follows && terrain.roughness.is_none(),
        }
    }

    /// From the frame of the physics to the world.
    pub(super) fn to_world(&self) -> Isometry3<f64> {
        self.to_world
    }

    /// A direction of the world in the frame of the physics.
    pub(super) fn in_frame(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.to_world.inverse_transform_vector(direction)
    }

    /// Turns with a body of this pose in the frame of the physics, about the normal through
    /// it: a robot that moved would lose hold of the ground. Returns the rotation that whatever
    /// is in the frame has to take, if the frame has turned.
    pub(super) fn follow(&mut self, body: &Isometry3<f64>) -> Option<UnitQuaternion<f64>> {
        if !self.follows {
            return None;
        }
        let (_, _, heading_rad) = (self.inclination.inverse() * body.rotation).euler_angles();
        if heading_rad.abs() < LEAST_TURN_RAD {
            return None;
        }
        let normal = self.inclination * Vector3::z_axis();
        let turned = rotation_about(&normal, heading_rad);
        let center = Point3::from(body.translation.vector);
        self.to_world *= Isometry3::rotation_wrt_point(turned, center);
        Some(turned.inverse())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope() -> Terrain {
        Terrain {
            slope_rad: 0.2,
            uphill_rad: 0.7,
            roughness: None,
        }
    }

    #[test]
    fn the_world_is_the_same_from_a_frame_that_has_turned() {
        let mut frame = HeadingFrame::new(&slope(), true);
        let attitude = slope().inclination() * UnitQuaternion::from_euler_angles(0.1, -0.05, 0.4);
        let before = Isometry3::from_parts([0.5, -0.2, 0.1].into(), attitude);
        let turned = frame.follow(&before).unwrap();
        let again = turned * attitude;
        let after = Isometry3::from_parts(before.translation, again);
        let seen = frame.to_world() * after;
        assert!(seen.rotation.angle_to(&attitude) < 1e-12);
        assert!((seen.translation.vector - before.translation.vector).norm() < 1e-12);
        let (_, _, heading_rad) = (slope().inclination().inverse() * again).euler_angles();
        assert!(heading_rad.abs() < 1e-12);
        let normal = slope().inclination() * Vector3::z();
        assert!((frame.in_frame(&normal) - normal).norm() < 1e-12);
        assert!(frame.follow(&after).is_none());
    }

    #[test]
    fn stays_where_it_is_not_wanted_or_the_ground_is_rough() {
        let turned = Isometry3::rotation(Vector3::z());
        assert!(HeadingFrame::new(&slope(), false).follow(&turned).is_none());
        let rough = Terrain {
            roughness: Some(crate::Roughness {
                height_m: 0.01,
                spacing_m: 0.05,
                seed: 1,
            }),
            ..slope()
        };
        assert!(HeadingFrame::new(&rough, true).follow(&turned).is_none());
    }
}
