//! What is left of a robot, written for other programs.

mod json;
mod mjcf;
mod stance;
mod urdf;

pub use json::ExportedJson;

use mlr_filter::SettingError;
use mlr_model::{
    Assembly, Drive, Fault, Gait, LinkPart, ModelError, Morphology, Obedience, Robot, Servo,
    SimulationSettings, dynamics::Dynamics,
};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

/// Name of the body's link.
pub(crate) const BASE: &str = "base_link";
/// Name of the link that stands for the IMU.
pub(crate) const IMU: &str = "imu_link";

/// A form in which a robot is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Unified Robot Description Format.
    Urdf,
    /// MuJoCo's model format.
    Mjcf,
    /// `mlr.robot/1`.
    Json,
}

/// A damaged, calibrated robot, to be written down.
///
/// A joint's coordinate is the angle that its controller commands: zeros that have moved are part
/// of the geometry. Lost links are missing; locked ones are part of what they hang on.
#[derive(Debug, Clone)]
pub struct ExportedRobot<'a> {
    robot: &'a Robot,
    morphology: &'a Morphology,
    settings: &'a SimulationSettings,
    assembly: Assembly,
    parts: Vec<NamedPart>,
}

/// A link that is left, with the joint at its inner end; both have the same name.
#[derive(Debug, Clone)]
pub(crate) struct NamedPart {
    pub(crate) leg: usize,
    pub(crate) link: usize,
    pub(crate) name: String,
    /// Name of the part that it hangs on.
    pub(crate) on: String,
    pub(crate) part: LinkPart,
    pub(crate) servo: Servo,
}

impl<'a> ExportedRobot<'a> {
    /// What `morphology` leaves of `robot`, with the lost links, the payload, the faults and the
    /// ground of `settings`.
    ///
    /// # Errors
    /// [`SettingError`] when the robot cannot have them.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn new(
        robot: &'a Robot,
        morphology: &'a Morphology,
        settings: &'a SimulationSettings,
    ) -> Result<Self, SettingError> {
        let assembly = Assembly::as_simulated(robot, morphology, settings)?;
        let mut names = robot.joint_names().into_iter();
        let mut parts = Vec::new();
        for (leg, left) in assembly.legs.iter().enumerate() {
            let of_leg: Vec<String> = names.by_ref().take(morphology.links(leg)).collect();
            let mut on = BASE.to_string();
            for (link, (part, name)) in left.links.iter().zip(of_leg).enumerate() {
                parts.push(NamedPart {
                    leg,
                    link,
                    name: name.clone(),
                    on: std::mem::replace(&mut on, name),
                    part: part.clone(),
                    servo: left.servo,
                });
            }
        }
        Ok(Self {
            robot,
            morphology,
            settings,
            assembly,
            parts,
        })
    }

    /// The robot as URDF, MJCF or JSON. The `gait` says how the robot of an MJCF stands.
    ///
    /// # Errors
    /// [`ModelError`] when the robot cannot follow the gait.
    pub fn written(&self, format: Format, gait: &Gait) -> Result<String, ModelError> {
        Ok(match format {
            Format::Urdf => self.to_urdf(),
            Format::Mjcf => self.to_mjcf(gait)?,
            Format::Json => self.to_json().to_string(),
        })
    }

    /// Rigid parts and joints.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Joints that obey commands.
    pub fn obeying_joints(&self) -> usize {
        self.parts.iter().filter(|part| !part.is_stuck()).count()
    }

    /// The centre of mass in the body's frame, all joints commanded to zero.
    pub fn center_of_mass_m(&self) -> Point3<f64> {
        let angles = self.parts.iter().map(|part| match part.part.obedience {
            Obedience::Shifted(angle_rad) | Obedience::Stuck(angle_rad) => angle_rad,
        });
        let angles_rad: Vec<f64> = angles.collect();
        let mut dynamics = Dynamics::of(&self.assembly);
        let posed = dynamics.at(&UnitQuaternion::identity(), &angles_rad);
        posed.center_of_mass_m()
    }

    /// What is known of the robot that a file of this format does not hold.
    pub fn left_out(&self, format: Format) -> Vec<String> {
        if format == Format::Json {
            return Vec::new();
        }
        let mut left_out: Vec<String> = Vec::new();
        let mut note = |text: &str| left_out.push(text.into());
        let drive = self.robot.servo().drive;
        let plain = Drive::default();
        if drive.backlash_rad > 0.0 {
            note("play of the gears");
        }
        if drive.dead_band_rad > 0.0 {
            note("the servos' dead band");
        }
        let load = [
            drive.stribeck_nm,
            drive.load_friction,
            drive.stribeck_load,
            drive.quadratic_load_per_nm,
        ];
        if load != [0.0; 4] {
            note("friction of the gears at rest and under load");
        }
        if drive.back_emf != plain.back_emf {
            note("back EMF: damping takes no torque away at the torque limit");
        }
        if format == Format::Urdf {
            note("stiffness, damping and timing of the servos, but in the element <mlr>");
            note("friction of the ground");
            if self.parts.iter().any(|part| part.is_stuck()) {
                note("the stiffness with which stuck joints are held: they are fixed");
            }
        } else {
            note("timing of the servos (command hold, latency, speed limit), but as <numeric>");
        }
        let pulls = |fault: &Fault| matches!(fault, Fault::ExternalForce { .. });
        if self.settings.faults.iter().any(pulls) {
            note("external forces");
        }
        if self.settings.terrain != Default::default() {
            note("slope and roughness of the ground");
        }
        left_out
    }

    /// The outermost part of each leg that has one.
    pub(crate) fn tips(&self) -> impl Iterator<Item = &NamedPart> {
        let inner = |part: &&NamedPart| part.link + 1 == self.assembly.legs[part.leg].links.len();
        self.parts.iter().filter(inner)
    }
}

impl NamedPart {
    /// The joint's frame in that of the part before it, with the joint commanded to 0, or where it
    /// is stuck.
    pub(crate) fn frame(&self) -> Isometry3<f64> {
        let (Obedience::Shifted(angle_rad) | Obedience::Stuck(angle_rad)) = self.part.obedience;
        let axis = nalgebra::Unit::new_unchecked(self.part.axis.direction());
        let mut frame = self.part.frame;
        frame.rotation *= UnitQuaternion::from_axis_angle(&axis, angle_rad);
        frame
    }

    pub(crate) fn is_stuck(&self) -> bool {
        matches!(self.part.obedience, Obedience::Stuck(_))
    }

    pub(crate) fn axis(&self) -> Vector3<f64> {
        self.part.axis.direction()
    }

    /// Name of the frame at its outer end.
    pub(crate) fn tip_name(&self) -> String {
        format!("leg{}_tip", self.leg + 1)
    }
}
