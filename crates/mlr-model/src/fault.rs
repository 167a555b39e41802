//! What may be wrong with a robot besides lost links.

use serde::{Deserialize, Serialize};

use crate::{ModelError, Robot};

/// Something about one robot that its description does not know and that is no lost
/// link. Faults are written in files, so that legs, joints and links are numbered
/// from 1, from the body outward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// A foot grips otherwise than the others.
    FootFriction {
        /// Number of the leg.
        leg: usize,
        /// Friction coefficient between this leg and the ground.
        mu: f64,
    },
    /// The servos of a leg have lost strength.
    WeakLeg {
        /// Number of the leg.
        leg: usize,
        /// What is left of their stiffness and torque limit, as a share.
        gain: f64,
    },
    /// A joint ignores its commands.
    StuckJoint {
        /// Number of the leg.
        leg: usize,
        /// Number of the joint.
        joint: usize,
        /// Where its servo holds it.
        angle_rad: f64,
    },
    /// A joint's zero has moved, as after a servo horn was remounted.
    JointOffset {
        /// Number of the leg.
        leg: usize,
        /// Number of the joint.
        joint: usize,
        /// True angle less commanded angle.
        angle_rad: f64,
    },
    /// A link has lost its outer end, with its share of the mass.
    ShortLink {
        /// Number of the leg.
        leg: usize,
        /// Number of the link.
        link: usize,
        /// What is missing.
        length_lost_m: f64,
    },
    /// Something pulls at the body's centre of mass.
    ExternalForce {
        /// Force in the ground's frame: x along the first heading, z up.
        force_n: [f64; 3],
    },
}

impl Fault {
    /// Whether the robot can have this fault.
    pub(crate) fn check(&self, robot: &Robot) -> Result<(), ModelError> {
        let range = ModelError::check_range;
        match *self {
            Self::FootFriction { leg, mu } => {
                leg_of(robot, leg)?;
                range("fault.mu", mu, 0.0, 10.0, "0 to 10")
            }
            Self::WeakLeg { leg, gain } => {
                leg_of(robot, leg)?;
                range("fault.gain", gain, 1e-3, 10.0, "0.001 to 10")
            }
            Self::StuckJoint {
                leg,
                joint,
                angle_rad,
            }
            | Self::JointOffset {
                leg,
                joint,
                angle_rad,
            } => {
                link_of(robot, leg, joint)?;
                range("fault.angle_rad", angle_rad, -3.2, 3.2, "-3.2 to 3.2 rad")
            }
            Self::ShortLink {
                leg,
                link,
                length_lost_m,
            } => {
                let length_m = link_of(robot, leg, link)?;
                range(
                    "fault.length_lost_m",
                    length_lost_m,
                    0.0,
                    0.9 * length_m,
                    "0 to nine tenths of the link",
                )
            }
            Self::ExternalForce { force_n } => force_n
                .iter()
                .try_for_each(|force| range("fault.force_n", *force, -1e4, 1e4, "-10 to 10 kN")),
        }
    }
}

fn leg_of(robot: &Robot, leg: usize) -> Result<&crate::Leg, ModelError> {
    leg.checked_sub(1)
        .and_then(|index| robot.legs().get(index))
        .ok_or_else(|| ModelError::value("fault.leg", leg, "the number of a leg of the robot"))
}

/// The length of a link.
fn link_of(robot: &Robot, leg: usize, link: usize) -> Result<f64, ModelError> {
    let links = &leg_of(robot, leg)?.links;
    link.checked_sub(1)
        .and_then(|index| links.get(index))
        .map(|link| link.length_m)
        .ok_or_else(|| ModelError::value("fault.link", link, "the number of a link of the leg"))
}
