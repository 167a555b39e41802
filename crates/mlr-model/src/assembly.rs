//! What is left of a damaged robot: rigid parts and the joints between them.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::{
    JointAxis, Morphology, Payload, Robot,
    rigid_mass::RigidMass,
    robot::{Body, ContactShape, Leg},
    simulation::LostLinks,
};

/// The rigid parts of a damaged robot: its body, and chains of links that hang on it.
///
/// Lost links are no parts of it. Locked ones keep their mass on the part that they hang on, at
/// the angles at which they are locked, and touch nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    /// Of the body, in the body frame.
    pub body: RigidMass,
    /// One chain for each leg of the healthy robot, from the body outward; empty where the whole
    /// leg is lost.
    pub legs: Vec<Vec<LinkPart>>,
}

/// A link that is left. Its frame sits in its joint with x along the link.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkPart {
    /// The joint's frame in that of the part before it, with the joint at zero.
    pub frame: Isometry3<f64>,
    /// Which way the joint turns, in its frame.
    pub axis: JointAxis,
    /// From this joint to the outer end.
    pub length_m: f64,
    /// In the frame of the link.
    pub mass: RigidMass,
    /// How the link can touch the ground, if it can.
    pub contact: Option<ContactShape>,
}

impl Assembly {
    /// What is left of `robot`.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn new(robot: &Robot, morphology: &Morphology, lost_links: LostLinks) -> Self {
        assert_eq!(
            morphology.layout(),
            robot.layout(),
            "the morphology must have the robot's legs and links"
        );
        Self::of_parts(robot.body(), robot.legs(), morphology, lost_links)
    }

    /// The same with a mass on the body.
    #[must_use]
    pub fn carrying(mut self, payload: &Payload) -> Self {
        let point = RigidMass::new(payload.mass_kg, Vector3::zeros(), Matrix3::zeros());
        let [x, y, z] = payload.position_m;
        self.body.attach(&point, &Isometry3::translation(x, y, z));
        self
    }

    /// What is left of a body and its legs, leg 1 first.
    pub(crate) fn of_parts<'l>(
        body: &Body,
        legs: impl IntoIterator<Item = &'l Leg>,
        morphology: &Morphology,
        lost_links: LostLinks,
    ) -> Self {
        let locked = lost_links == LostLinks::Locked;
        let mut body = RigidMass::new(
            body.mass_kg,
            body.center_of_mass_m.coords,
            Matrix3::from_diagonal(&body.inertia_kg_m2),
        );
        let legs = legs.into_iter().enumerate().map(|(index, leg)| {
            let remaining = morphology.remaining(index);
            let (left, lost) = leg.links.split_at(remaining);
            let mut chain: Vec<LinkPart> = Vec::with_capacity(remaining);
            let mut frame = leg.hip_frame();
            for link in left {
                chain.push(LinkPart {
                    frame,
                    axis: link.joint,
                    length_m: link.length_m,
                    mass: RigidMass::of_link(link),
                    contact: link.contact,
                });
                frame = link.outer_end();
            }
            if locked {
                let carrier = chain.last_mut().map_or(&mut body, |part| &mut part.mass);
                carrier.attach_locked(lost, frame);
            }
            chain
        });
        let legs = legs.collect();
        Self { body, legs }
    }

    /// The joints that are left, as leg and link, both from 0: leg by leg from the body outward.
    pub fn joints(&self) -> impl Iterator<Item = (usize, usize)> {
        let legs = self.legs.iter().enumerate();
        legs.flat_map(|(leg, chain)| (0..chain.len()).map(move |link| (leg, link)))
    }

    /// Mass of all parts.
    pub fn mass_kg(&self) -> f64 {
        let links = self.legs.iter().flatten();
        self.body.mass_kg() + links.map(|part| part.mass.mass_kg()).sum::<f64>()
    }
}
