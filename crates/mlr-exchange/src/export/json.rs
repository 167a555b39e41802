//! JSON, `mlr.robot/1`: parts, joints, servos and contacts as they are in the model.

use mlr_model::{
    AssembledLeg, ContactShape, Fault, GroundContact, JointAxis, LostLinks, Morphology, Obedience,
    Payload, RigidMass, Servo,
};
use nalgebra::Isometry3;
use serde::Serialize;

use super::{ExportedRobot, NamedPart};

/// Version of the form.
const SCHEMA: &str = "mlr.robot/1";

/// What is left of a robot, for programs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExportedJson {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// The robot's name.
    pub name: String,
    /// Which links are left.
    pub morphology: Morphology,
    /// The damage in words.
    pub description: String,
    /// What became of lost links.
    pub lost_links: LostLinks,
    /// Faults besides.
    pub faults: Vec<Fault>,
    /// What the body carries; its mass is part of the body's.
    pub payload: Option<Payload>,
    /// Mass of all parts.
    pub mass_kg: f64,
    /// The body.
    pub body: BodyJson,
    /// One for each leg of the healthy robot.
    pub legs: Vec<LegJson>,
    /// The ground.
    pub ground: GroundContact,
    /// Duration of the robot's gait over the nominal one.
    pub clock: f64,
}

/// The body.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BodyJson {
    /// Extent along x, y, z of the box, centred on the origin.
    pub size_m: [f64; 3],
    /// Mass and inertia.
    #[serde(flatten)]
    pub mass: MassJson,
}

/// What is left of a leg.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LegJson {
    /// The leg, from 1.
    pub number: usize,
    /// Its name.
    pub name: String,
    /// The servo in each of its joints.
    pub servo: Servo,
    /// Friction coefficient with the ground.
    pub friction: f64,
    /// From the body outward.
    pub links: Vec<LinkJson>,
}

/// A link with the joint at its inner end.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LinkJson {
    /// Of link and joint.
    pub name: String,
    /// Joint frame in the frame of the part before it, with the joint at zero.
    pub joint_position_m: [f64; 3],
    /// The same: w, x, y, z.
    pub joint_quaternion: [f64; 4],
    /// Which way the joint turns: `yaw` about z, `lift` about -y.
    pub axis: &'static str,
    /// True angle less commanded angle.
    pub zero_rad: f64,
    /// Where the joint stays, if it ignores commands.
    pub stuck_rad: Option<f64>,
    /// To the outer end, along x.
    pub length_m: f64,
    /// Mass and inertia.
    #[serde(flatten)]
    pub mass: MassJson,
    /// `capsule` around its axis or `foot`, a sphere whose outermost point is the outer end.
    pub contact: Option<&'static str>,
    /// Of the contact.
    pub contact_radius_m: Option<f64>,
}

/// A rigid mass in the frame of its part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MassJson {
    /// Mass.
    pub mass_kg: f64,
    /// Centre of mass.
    pub center_of_mass_m: [f64; 3],
    /// About the centre of mass, row by row.
    pub inertia_kg_m2: [[f64; 3]; 3],
}

impl ExportedRobot<'_> {
    /// The robot for programs.
    pub fn to_json(&self) -> ExportedJson {
        let legs = self.assembly.legs.iter().enumerate();
        ExportedJson {
            schema: SCHEMA,
            name: self.robot.name().into(),
            morphology: self.morphology.clone(),
            description: self.morphology.describe(),
            lost_links: self.settings.lost_links,
            faults: self.settings.faults.clone(),
            payload: self.settings.payload,
            mass_kg: self.assembly.mass_kg(),
            body: BodyJson {
                size_m: self.robot.body().size_m.into(),
                mass: MassJson::new(&self.assembly.body),
            },
            legs: legs.map(|(index, left)| self.leg(index, left)).collect(),
            ground: self.settings.contact,
            clock: self.robot.clock(),
        }
    }

    fn leg(&self, index: usize, left: &AssembledLeg) -> LegJson {
        let parts = self.parts.iter().filter(|part| part.leg == index);
        LegJson {
            number: index + 1,
            name: self.robot.legs()[index].name.clone(),
            servo: left.servo,
            friction: left.friction.unwrap_or(self.settings.contact.friction),
            links: parts.map(LinkJson::new).collect(),
        }
    }
}

impl std::fmt::Display for ExportedJson {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = serde_json::to_string(self).map_err(|_| std::fmt::Error)?;
        writeln!(f, "{text}")
    }
}

impl LinkJson {
    fn new(named: &NamedPart) -> Self {
        let part = &named.part;
        let Isometry3 {
            rotation,
            translation,
        } = part.frame;
        let [x, y, z, w] = rotation.coords.into();
        let (zero_rad, stuck_rad) = match part.obedience {
            Obedience::Shifted(zero_rad) => (zero_rad, None),
            Obedience::Stuck(angle_rad) => (0.0, Some(angle_rad)),
        };
        let (contact, contact_radius_m) = match part.contact {
            None => (None, None),
            Some(ContactShape::Capsule { radius_m }) => (Some("capsule"), Some(radius_m)),
            Some(ContactShape::Foot { radius_m }) => (Some("foot"), Some(radius_m)),
        };
        Self {
            name: named.name.clone(),
            joint_position_m: translation.vector.into(),
            joint_quaternion: [w, x, y, z],
            axis: match part.axis {
                JointAxis::Yaw => "yaw",
                JointAxis::Lift => "lift",
            },
            zero_rad,
            stuck_rad,
            length_m: part.length_m,
            mass: MassJson::new(&part.mass),
            contact,
            contact_radius_m,
        }
    }
}

impl MassJson {
    fn new(mass: &RigidMass) -> Self {
        let rows = mass.inertia_kg_m2().transpose();
        Self {
            mass_kg: mass.mass_kg(),
            center_of_mass_m: mass.center_m().into(),
            inertia_kg_m2: rows.data.0,
        }
    }
}
