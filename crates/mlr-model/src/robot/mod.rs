//! What the robot is made of when nothing is missing.

mod calibration;
mod edit;
mod file;
mod imu;
mod measurement;
mod parameter;
mod servo;

pub use calibration::{Calibration, Gaussian};
pub use imu::Imu;
pub use measurement::Measurement;
pub use parameter::RobotParameter;
pub use servo::{Drive, Servo};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::{ModelError, morphology::LegLayout, setting_place::located};

/// A legged robot in full health: a body, N legs, n_i links in leg i.
///
/// Frames follow REP-103 (x forward, y left, z up). Lengths are in metres,
/// masses in kilograms, angles in radians.
///
/// Read one from TOML with [`Robot::from_toml`]; [`Robot::jethexa`] is the
/// description that ships with the crate.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    name: String,
    body: Body,
    servo: Servo,
    legs: Vec<Leg>,
    imu: Imu,
    clock: f64,
    calibration: Option<Calibration>,
}

impl Robot {
    /// The embedded description of the Hiwonder JetHexa, `data/robot/jethexa.toml`.
    pub const JETHEXA_TOML: &str = include_str!("../../../../data/robot/jethexa.toml");

    /// The Hiwonder JetHexa.
    pub fn jethexa() -> Self {
        Self::from_toml(Self::JETHEXA_TOML).expect("the embedded description is checked by a test")
    }

    /// Reads and checks a robot description.
    ///
    /// # Errors
    /// [`ModelError::Syntax`] with line and column when the text is not TOML of
    /// the expected form, [`ModelError::Setting`] when a value makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        file::parse(text).map_err(|error| match error {
            ModelError::Setting(error) => located(error, text).into(),
            error => error,
        })
    }

    /// The robot's name, for people.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The body that carries the legs and the IMU.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The servo in every joint.
    pub fn servo(&self) -> &Servo {
        &self.servo
    }

    /// The same robot with other servos.
    ///
    /// # Errors
    /// [`ModelError::Setting`] when a parameter of the servo makes no sense.
    pub fn with_servo(mut self, servo: Servo) -> Result<Self, ModelError> {
        servo.check().map_err(|error| error.under("servo"))?;
        self.servo = servo;
        Ok(self)
    }

    /// The same robot with so much added to the [coordinate](RobotParameter::coordinate) of a
    /// parameter.
    #[must_use]
    pub fn with_added(mut self, parameter: RobotParameter, more: f64) -> Self {
        parameter.add(&mut self, more);
        self
    }

    /// The IMU on the body.
    pub fn imu(&self) -> &Imu {
        &self.imu
    }

    /// Duration of this robot's gait over the nominal one: what its clock is off by.
    pub fn clock(&self) -> f64 {
        self.clock
    }

    /// How surely this robot's own parameters are known; `None` for a robot as its make is
    /// described.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref()
    }

    /// The same robot, of which so much is known.
    #[must_use]
    pub fn with_calibration(mut self, calibration: Calibration) -> Self {
        self.calibration = Some(calibration);
        self
    }

    /// Mass of the whole robot.
    pub fn mass_kg(&self) -> f64 {
        let links = self.legs.iter().flat_map(|leg| &leg.links);
        self.body.mass_kg + links.map(|link| link.mass_kg).sum::<f64>()
    }

    /// The legs, leg 1 first.
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// A leg for people: its number, from 1, and what the description calls it, as in
    /// "4 (middle right)".
    pub fn numbered_name(&self, number: usize) -> String {
        let leg = number.checked_sub(1).and_then(|leg| self.legs.get(leg));
        match leg {
            Some(leg) if !leg.name.is_empty() => format!("{number} ({})", leg.name),
            _ => number.to_string(),
        }
    }

    /// Names of all joints, leg by leg from the body outward, as in `leg1_coxa`: letters, digits
    /// and underscores. Links of a leg that share a name are numbered, as in `leg1_femur_2`.
    pub fn joint_names(&self) -> Vec<String> {
        let plain = |name: &str| name.replace(|c: char| !c.is_alphanumeric(), "_");
        let mut names = Vec::with_capacity(self.layout().total_links());
        for (leg_number, leg) in (1..).zip(&self.legs) {
            let of_leg: Vec<String> = leg.links.iter().map(|link| plain(&link.name)).collect();
            for (number, name) in (1..).zip(&of_leg) {
                let shared = of_leg.iter().filter(|other| *other == name).count() > 1;
                let number = if shared {
                    format!("_{number}")
                } else {
                    String::new()
                };
                names.push(format!("leg{leg_number}_{name}{number}"));
            }
        }
        names
    }

    /// The number of links of each leg: the shape of its morphology vectors.
    pub fn layout(&self) -> LegLayout {
        LegLayout::new(self.legs.iter().map(|leg| leg.links.len()))
            .expect("a robot's legs were counted when it was read")
    }
}

/// The body: a rigid box that can touch the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Extent along x, y, z of the box, centred on the body's origin.
    pub size_m: Vector3<f64>,
    /// Mass.
    pub mass_kg: f64,
    /// Centre of mass in the body frame.
    pub center_of_mass_m: Point3<f64>,
    /// Moments of inertia about the centre of mass, along x, y, z.
    pub inertia_kg_m2: Vector3<f64>,
}

impl Body {
    /// Makes it heavier or lighter, its inertia in proportion.
    fn scale_mass(&mut self, by: f64) {
        self.mass_kg *= by;
        self.inertia_kg_m2 *= by;
    }
}

/// A serial chain of links from a hip on the body to a foot.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Name for people, as in "front left".
    pub name: String,
    /// First joint, body frame.
    pub hip_m: Point3<f64>,
    /// Direction of the leg's plane seen from above, counter-clockwise from x.
    pub hip_yaw_rad: f64,
    /// Where the foot tip stands, seen from above, body frame.
    pub nominal_foot_m: [f64; 2],
    /// From the body outward.
    pub links: Vec<Link>,
    /// True angle less commanded angle of each joint.
    pub joint_zeros_rad: Vec<f64>,
}

impl Leg {
    /// The hip's frame in the body frame: x along the leg's plane, z up.
    pub fn hip_frame(&self) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::from(self.hip_m),
            rotation_about(&Vector3::z(), self.hip_yaw_rad),
        )
    }
}

/// One rigid link. Its frame sits in its joint with x along the link.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name for people, as in "femur".
    pub name: String,
    /// Which way the joint at its inner end turns.
    pub joint: JointAxis,
    /// From this joint to the next, or to the foot tip.
    pub length_m: f64,
    /// Mass.
    pub mass_kg: f64,
    /// Distance of the centre of mass from the joint, along the link.
    pub center_of_mass_m: f64,
    /// Principal moments of inertia about the centre of mass: along the link
    /// and across it twice.
    pub inertia_kg_m2: Vector3<f64>,
    /// Joint angle of the usual posture; picks the branch (knee down) of the
    /// inverse kinematics.
    pub posture_rad: f64,
    /// Joint angle at which a locked link is held clear of the ground.
    pub locked_rad: f64,
    /// How the link can touch the ground, if it can.
    pub contact: Option<ContactShape>,
}

impl Link {
    /// Cuts off the outer end: what is left is as heavy, and turns as heavily, as its
    /// share of the length.
    pub(crate) fn shorten(&mut self, by_m: f64) {
        let kept = (self.length_m - by_m) / self.length_m;
        self.length_m *= kept;
        self.mass_kg *= kept;
        self.center_of_mass_m *= kept;
        self.inertia_kg_m2 *= kept;
    }

    /// From the link's joint to its outer end, where the next one hangs.
    pub(crate) fn outer_end(&self) -> Isometry3<f64> {
        Isometry3::translation(self.length_m, 0.0, 0.0)
    }

    /// Pose of this link's outer end in the frame of its inner neighbour, with
    /// the joint at `angle_rad`.
    pub fn tip_frame(&self, angle_rad: f64) -> Isometry3<f64> {
        let rotation = rotation_about(&self.joint.direction(), angle_rad);
        Isometry3::from_parts(
            Translation3::from(rotation * Vector3::new(self.length_m, 0.0, 0.0)),
            rotation,
        )
    }
}

/// The axis of a revolute joint, in the frame of the link before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointAxis {
    /// Turns about z: a positive angle turns the link to the left.
    Yaw,
    /// Turns about the leg plane's normal: a positive angle lifts the link.
    Lift,
}

impl JointAxis {
    /// Unit vector of the axis. A right-handed turn about -y takes x towards z.
    pub fn direction(self) -> Vector3<f64> {
        match self {
            Self::Yaw => Vector3::z(),
            Self::Lift => -Vector3::y(),
        }
    }
}

/// How a link can touch the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactShape {
    /// Anywhere along its length.
    Capsule {
        /// Radius of the capsule around the link's axis.
        radius_m: f64,
    },
    /// With a sphere whose outermost point is the foot tip.
    Foot {
        /// Radius of the sphere.
        radius_m: f64,
    },
}

/// Rotation by `angle_rad` about the unit vector `axis`, with the same bits on
/// every platform.
pub(crate) fn rotation_about(axis: &Vector3<f64>, angle_rad: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = libm::sincos(angle_rad / 2.0);
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::from_parts(cos, axis * sin))
}
