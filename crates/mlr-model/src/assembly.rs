//! What is left of a damaged robot: rigid parts and the joints between them.

use nalgebra::{Isometry3, Matrix3, Vector3};

use mlr_filter::SettingError;

use crate::{
    JointAxis, Morphology, Obedience, Payload, Robot, Servo, SimulationSettings,
    rigid_mass::{RigidMass, locked_frames},
    robot::{Body, ContactShape, Link},
    simulation::{LostLinks, leg_state::LegState},
};

/// The rigid parts of a damaged robot: its body, and chains of links that hang on it.
///
/// Lost links are no parts of it. Locked ones keep their mass on the part that they hang on, at
/// the angles at which they are locked. Their outer end can touch the ground where a joint
/// moves that part up and down; else they stay clear of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    /// Of the body, in the body frame.
    pub body: RigidMass,
    /// One for each leg of the healthy robot.
    pub legs: Vec<AssembledLeg>,
}

/// What is left of a leg.
#[derive(Debug, Clone, PartialEq)]
pub struct AssembledLeg {
    /// From the body outward; empty where the whole leg is lost.
    pub links: Vec<LinkPart>,
    /// The servo in each of its joints.
    pub servo: Servo,
    /// Friction coefficient between this leg and the ground, where it is not the ground's own.
    pub friction: Option<f64>,
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
    /// How the joint takes its commands.
    pub obedience: Obedience,
    /// What can touch the ground of the locked links that hang on it.
    pub locked: Option<LockedContact>,
}

/// A link that can touch the ground although its servo holds it at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LockedContact {
    /// The link's frame in that of the part which carries it, x along the link.
    pub frame: Isometry3<f64>,
    /// From its joint to its outer end.
    pub length_m: f64,
    /// How it touches the ground.
    pub shape: ContactShape,
}

impl Assembly {
    /// What is left of `robot`.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn new(robot: &Robot, morphology: &Morphology, lost_links: LostLinks) -> Self {
        assert_fits(morphology, robot);
        let legs = faulty_legs(robot, &SimulationSettings::default());
        Self::of_parts(robot.body(), &legs, morphology, lost_links)
    }

    /// What is left of `robot` with the lost links, the payload and the faults of a simulation.
    ///
    /// # Errors
    /// [`SettingError`] when the robot cannot have them.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn as_simulated(
        robot: &Robot,
        morphology: &Morphology,
        settings: &SimulationSettings,
    ) -> Result<Self, SettingError> {
        assert_fits(morphology, robot);
        settings.check_on(robot)?;
        let legs = faulty_legs(robot, settings);
        let left = Self::of_parts(robot.body(), &legs, morphology, settings.lost_links);
        Ok(match &settings.payload {
            Some(payload) => left.carrying(payload),
            None => left,
        })
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
    pub(crate) fn of_parts(
        body: &Body,
        legs: &[LegState<'_>],
        morphology: &Morphology,
        lost_links: LostLinks,
    ) -> Self {
        let locked = lost_links == LostLinks::Locked;
        let mut body = RigidMass::new(
            body.mass_kg,
            body.center_of_mass_m.coords,
            Matrix3::from_diagonal(&body.inertia_kg_m2),
        );
        let legs = legs.iter().enumerate().map(|(index, state)| {
            let leg = state.description();
            let remaining = morphology.remaining(index);
            let (left, lost) = leg.links.split_at(remaining);
            let mut links: Vec<LinkPart> = Vec::with_capacity(remaining);
            let mut frame = leg.hip_frame();
            for (number, link) in left.iter().enumerate() {
                links.push(LinkPart {
                    frame,
                    axis: link.joint,
                    length_m: link.length_m,
                    mass: RigidMass::of_link(link),
                    contact: link.contact,
                    obedience: state.obedience(number),
                    locked: None,
                });
                frame = link.outer_end();
            }
            if locked {
                match links.last_mut() {
                    Some(part) => {
                        part.mass.attach_locked(lost, frame);
                        if part.axis == JointAxis::Lift {
                            part.locked = locked_contact(lost, frame);
                        }
                    }
                    None => body.attach_locked(lost, frame),
                }
            }
            AssembledLeg {
                links,
                servo: *state.servo(),
                friction: state.friction,
            }
        });
        let legs = legs.collect();
        Self { body, legs }
    }

    /// The joints that are left, as leg and link, both from 0: leg by leg from the body outward.
    pub fn joints(&self) -> impl Iterator<Item = (usize, usize)> {
        let legs = self.legs.iter().enumerate();
        legs.flat_map(|(leg, left)| (0..left.links.len()).map(move |link| (leg, link)))
    }

    /// Mass of all parts.
    pub fn mass_kg(&self) -> f64 {
        let links = self.legs.iter().flat_map(|leg| &leg.links);
        self.body.mass_kg() + links.map(|part| part.mass.mass_kg()).sum::<f64>()
    }
}

/// The outer end of locked `links`, the first one's joint at `frame`, if it can touch the ground. Those
/// further in lie in their brackets.
fn locked_contact(links: &[Link], frame: Isometry3<f64>) -> Option<LockedContact> {
    let last = links.last()?;
    Some(LockedContact {
        frame: locked_frames(links, frame).last().copied()?,
        length_m: last.length_m,
        shape: last.contact?,
    })
}

fn assert_fits(morphology: &Morphology, robot: &Robot) {
    assert_eq!(
        morphology.layout(),
        robot.layout(),
        "the morphology must have the robot's legs and links"
    );
}

fn faulty_legs<'r>(robot: &'r Robot, settings: &SimulationSettings) -> Vec<LegState<'r>> {
    let legs = 0..robot.legs().len();
    legs.map(|leg| LegState::new(robot, leg, &settings.faults))
        .collect()
}
