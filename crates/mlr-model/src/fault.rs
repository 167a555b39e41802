//! What may be wrong with a robot besides lost links.

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use crate::Robot;

/// Something about one robot that its description does not know and that is no lost
/// link. Faults are written in files, so that legs, joints and links are numbered
/// from 1, from the body outward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        match self {
            Self::FootFriction { mu, .. } => check("mu", *mu, 0.0..=10.0, ""),
            Self::WeakLeg { gain, .. } => check("gain", *gain, 0.001..=10.0, ""),
            Self::StuckJoint { angle_rad, .. } | Self::JointOffset { angle_rad, .. } => {
                check("angle_rad", *angle_rad, -3.2..=3.2, "rad")
            }
            Self::ShortLink { length_lost_m, .. } => {
                check("length_lost_m", *length_lost_m, 0.0..=1e3, "m")
            }
            Self::ExternalForce { force_n } => {
                SettingError::check_each("force_n", force_n, -1e4..=1e4, "N")
            }
        }
    }

    /// Whether this robot can have this fault.
    pub(crate) fn check_on(&self, robot: &Robot) -> Result<(), SettingError> {
        self.check()?;
        match *self {
            Self::FootFriction { leg, .. } | Self::WeakLeg { leg, .. } => {
                leg_of(robot, leg).map(|_| ())
            }
            Self::StuckJoint { leg, joint, .. } | Self::JointOffset { leg, joint, .. } => {
                link_of(robot, leg, "joint", joint).map(|_| ())
            }
            Self::ShortLink {
                leg,
                link,
                length_lost_m,
            } => {
                let most_m = 0.9 * link_of(robot, leg, "link", link)?;
                SettingError::check("length_lost_m", length_lost_m, 0.0..=most_m, "m")
            }
            Self::ExternalForce { .. } => Ok(()),
        }
    }
}

fn leg_of(robot: &Robot, leg: usize) -> Result<&crate::Leg, SettingError> {
    let legs = robot.legs();
    leg.checked_sub(1)
        .and_then(|index| legs.get(index))
        .ok_or_else(|| SettingError::new("leg", leg, format!("1 to {}", legs.len())))
}

/// The length of a link, which the fault calls `name`.
fn link_of(robot: &Robot, leg: usize, name: &str, link: usize) -> Result<f64, SettingError> {
    let links = &leg_of(robot, leg)?.links;
    link.checked_sub(1)
        .and_then(|index| links.get(index))
        .map(|link| link.length_m)
        .ok_or_else(|| SettingError::new(name, link, format!("1 to {}", links.len())))
}
