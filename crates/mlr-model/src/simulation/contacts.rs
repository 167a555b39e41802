//! What of the robot can touch the ground.

use nalgebra::{Isometry3, Vector3};
use rapier3d::prelude::*;

use super::{GroundContact, Impacts, physics::to_pose};
use crate::{
    assembly::{LinkPart, LockedContact},
    robot::{Body, ContactShape},
};

/// Times that compliant contacts are solved: nothing corrects afterwards what one pass has left.
const COMPLIANT_PASSES: usize = 2;

/// Parameters of steps in which contacts act like this.
pub(super) fn solved(
    contact: &GroundContact,
    parameters: IntegrationParameters,
) -> IntegrationParameters {
    let parameters = IntegrationParameters {
        static_contact_softness: SpringCoefficients::new(
            contact.natural_frequency_hz as f32,
            contact.damping_ratio as f32,
        ),
        ..parameters
    };
    match contact.impacts {
        Impacts::Rigid => parameters,
        Impacts::Compliant => IntegrationParameters {
            num_internal_pgs_iterations: COMPLIANT_PASSES,
            num_internal_stabilization_iterations: 0,
            ..parameters
        },
    }
}

/// The robot's parts never touch each other: each only meets the ground.
const ROBOT: Group = Group::GROUP_1;
const GROUND: Group = Group::GROUP_2;

pub(super) fn ground(shape: SharedShape, pose: Pose, contact: &GroundContact) -> Collider {
    surface(ColliderBuilder::new(shape), contact)
        .position(pose)
        .collision_groups(InteractionGroups::new(
            GROUND,
            ROBOT,
            InteractionTestMode::And,
        ))
        .build()
}

pub(super) fn body(body: &Body, contact: &GroundContact) -> Collider {
    let half: Vector3<f32> = (body.size_m / 2.0).cast();
    robot_part(ColliderBuilder::cuboid(half.x, half.y, half.z), contact).build()
}

/// The colliders of a link and of the locked ones that hang on it, which may grip otherwise than the
/// ground says.
pub(super) fn links(
    link: &LinkPart,
    contact: &GroundContact,
    own_friction: Option<f64>,
) -> Vec<Collider> {
    let own = link.contact.map(|shape| LockedContact {
        frame: Isometry3::identity(),
        length_m: link.length_m,
        shape,
    });
    own.iter()
        .chain(&link.locked)
        .map(|part| {
            let builder = robot_part(placed_shape(part), contact);
            match own_friction {
                // The ground multiplies what is left of its own friction.
                Some(friction) => builder
                    .friction((friction / contact.friction.max(f64::MIN_POSITIVE)) as f32)
                    .friction_combine_rule(CoefficientCombineRule::Multiply)
                    .build(),
                None => builder.build(),
            }
        })
        .collect()
}

fn placed_shape(part: &LockedContact) -> ColliderBuilder {
    let length_m = part.length_m as f32;
    let frame = to_pose(&part.frame);
    match part.shape {
        ContactShape::Capsule { radius_m } => ColliderBuilder::capsule_from_endpoints(
            Vector::ZERO,
            Vector::new(length_m, 0.0, 0.0),
            radius_m as f32,
        )
        .position(frame),
        ContactShape::Foot { radius_m } => {
            let center = Vector::new(length_m - radius_m as f32, 0.0, 0.0);
            ColliderBuilder::ball(radius_m as f32).position(frame * Pose::from_translation(center))
        }
    }
}
fn robot_part(builder: ColliderBuilder, contact: &GroundContact) -> ColliderBuilder {
    surface(builder, contact).collision_groups(InteractionGroups::new(
        ROBOT,
        GROUND,
        InteractionTestMode::And,
    ))
}

/// Massless (the links carry the masses), with the friction of the pair on both
/// sides so that rapier's average is that friction.
fn surface(builder: ColliderBuilder, contact: &GroundContact) -> ColliderBuilder {
    builder.density(0.0).friction(contact.friction as f32)
}
