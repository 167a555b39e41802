//! URDF: one link and one joint for each link that is left.
//!
//! What URDF has no word for stands in an element `<mlr>`, which other readers ignore; with it an
//! exported robot that is whole is read back as it was.

use mlr_model::{ContactShape, Imu, RigidMass};
use nalgebra::{Isometry3, Vector3};

use super::{BASE, ExportedRobot, IMU, NamedPart};
use crate::xml::{Writer, number, numbers};

/// Version of the element `<mlr>`.
const VERSION: &str = "1";

impl ExportedRobot<'_> {
    /// The robot as URDF.
    pub fn to_urdf(&self) -> String {
        let damage = self.morphology.describe();
        let mut xml = Writer::new(&format!(
            "{}: {damage}. Written by mlr-ga export. SI units; x forward, y left, z up; \
             joint angles as commanded.",
            self.robot.name()
        ));
        xml.open("robot", &[("name", self.robot.name().into())]);
        // MuJoCo would weld the body to the world and forget its mass.
        xml.open("mujoco", &[]);
        xml.empty("compiler", &[("fusestatic", "false".into())]);
        xml.close();
        self.write_body(&mut xml);
        for part in &self.parts {
            write_part(&mut xml, part);
        }
        for part in self.tips() {
            let tip = part.tip_name();
            let frame = Isometry3::translation(part.part.length_m, 0.0, 0.0);
            write_fixed(&mut xml, &tip, &part.name, &frame);
        }
        self.write_rest(&mut xml);
        xml.finish()
    }

    fn write_body(&self, xml: &mut Writer) {
        let size = [("size", numbers(&self.robot.body().size_m))];
        xml.open("link", &[("name", BASE.into())]);
        write_inertial(xml, &self.assembly.body);
        for use_of in ["visual", "collision"] {
            write_geometry(xml, use_of, &Isometry3::identity(), "box", &size);
        }
        xml.close();
        let [roll, pitch, yaw] = self.robot.imu().mounting_deg.map(f64::to_radians);
        let mounting = nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let frame = Isometry3::from_parts(Vector3::zeros().into(), mounting);
        write_fixed(xml, IMU, BASE, &frame);
    }

    /// What URDF has no word for.
    fn write_rest(&self, xml: &mut Writer) {
        let robot = self.robot;
        let mut attributes = vec![("version", VERSION.to_string())];
        if robot.clock() != 1.0 {
            attributes.push(("clock", number(robot.clock())));
        }
        if robot.imu().gyro_scale != Imu::default().gyro_scale {
            attributes.push(("gyro_scale", number(robot.imu().gyro_scale)));
        }
        xml.open("mlr", &attributes);
        let servo = serde_json::to_value(robot.servo()).unwrap_or_default();
        let plain = |value: &serde_json::Value| !value.is_object();
        xml.empty("servo", &json_attributes(&servo, plain));
        if robot.servo().drive != Default::default() {
            xml.empty("drive", &json_attributes(&servo["drive"], plain));
        }
        for (index, leg) in robot.legs().iter().enumerate() {
            // Stuck joints are none in a URDF.
            let moving = |part: &&NamedPart| part.leg == index && !part.is_stuck();
            let left: Vec<&NamedPart> = self.parts.iter().filter(moving).collect();
            if left.is_empty() {
                continue;
            }
            let foot = numbers(&leg.nominal_foot_m);
            xml.open(
                "leg",
                &[("name", leg.name.clone()), ("nominal_foot_m", foot)],
            );
            for part in left {
                let link = &leg.links[part.link];
                xml.empty(
                    "link",
                    &[
                        ("joint", part.name.clone()),
                        ("name", link.name.clone()),
                        ("posture_deg", number(link.posture_rad.to_degrees())),
                        ("locked_deg", number(link.locked_rad.to_degrees())),
                        ("zero_rad", number(leg.joint_zeros_rad[part.link])),
                    ],
                );
            }
            xml.close();
        }
        xml.close();
    }
}

fn json_attributes(
    object: &serde_json::Value,
    wanted: impl Fn(&serde_json::Value) -> bool,
) -> Vec<(&str, String)> {
    let fields = object.as_object().into_iter().flatten();
    let fields = fields.filter(|(_, value)| wanted(value));
    fields
        .map(|(key, value)| (key.as_str(), value.to_string()))
        .collect()
}

/// A link with the joint that it hangs on.
fn write_part(xml: &mut Writer, part: &NamedPart) {
    xml.open("link", &[("name", part.name.clone())]);
    write_inertial(xml, &part.part.mass);
    write_shape(xml, part);
    xml.close();
    let kind = if part.is_stuck() { "fixed" } else { "revolute" };
    xml.open(
        "joint",
        &[("name", part.name.clone()), ("type", kind.into())],
    );
    xml.empty("parent", &[("link", part.on.clone())]);
    xml.empty("child", &[("link", part.name.clone())]);
    write_origin(xml, &part.frame());
    if !part.is_stuck() {
        let servo = &part.servo;
        xml.empty("axis", &[("xyz", numbers(&part.axis()))]);
        xml.empty(
            "limit",
            &[
                ("lower", number(-std::f64::consts::PI)),
                ("upper", number(std::f64::consts::PI)),
                ("effort", number(servo.torque_limit_nm)),
                ("velocity", number(servo.speed_limit_rad_per_s)),
            ],
        );
        xml.empty(
            "dynamics",
            &[
                ("damping", number(servo.drive.viscous_nm_s_per_rad)),
                ("friction", number(servo.drive.coulomb_nm)),
            ],
        );
    }
    xml.close();
}

/// What is seen of a link, and what of it can touch the ground. URDF has no capsules: one is a
/// cylinder and two spheres.
fn write_shape(xml: &mut Writer, part: &NamedPart) {
    let length_m = part.part.length_m;
    let sphere_at = |xml: &mut Writer, use_of, at_m: f64, radius_m: f64| {
        let radius = [("radius", number(radius_m))];
        write_geometry(
            xml,
            use_of,
            &Isometry3::translation(at_m, 0.0, 0.0),
            "sphere",
            &radius,
        );
    };
    let rod = |xml: &mut Writer, use_of, radius_m: f64| {
        let along_x =
            nalgebra::UnitQuaternion::from_euler_angles(0.0, std::f64::consts::FRAC_PI_2, 0.0);
        let middle = Isometry3::from_parts(Vector3::new(length_m / 2.0, 0.0, 0.0).into(), along_x);
        let size = [("radius", number(radius_m)), ("length", number(length_m))];
        write_geometry(xml, use_of, &middle, "cylinder", &size);
    };
    match part.part.contact {
        None => rod(xml, "visual", THIN_M),
        Some(ContactShape::Capsule { radius_m }) => {
            for use_of in ["visual", "collision"] {
                rod(xml, use_of, radius_m);
                sphere_at(xml, use_of, 0.0, radius_m);
                sphere_at(xml, use_of, length_m, radius_m);
            }
        }
        Some(ContactShape::Foot { radius_m }) => {
            rod(xml, "visual", THIN_M.min(radius_m));
            for use_of in ["visual", "collision"] {
                sphere_at(xml, use_of, length_m - radius_m, radius_m);
            }
        }
    }
}

/// Radius at which links are shown that touch nothing.
const THIN_M: f64 = 0.008;

fn write_fixed(xml: &mut Writer, name: &str, on: &str, frame: &Isometry3<f64>) {
    xml.empty("link", &[("name", name.into())]);
    xml.open("joint", &[("name", name.into()), ("type", "fixed".into())]);
    xml.empty("parent", &[("link", on.into())]);
    xml.empty("child", &[("link", name.into())]);
    write_origin(xml, frame);
    xml.close();
}

fn write_geometry(
    xml: &mut Writer,
    use_of: &'static str,
    frame: &Isometry3<f64>,
    shape: &'static str,
    size: &[(&str, String)],
) {
    xml.open(use_of, &[]);
    write_origin(xml, frame);
    xml.open("geometry", &[]);
    xml.empty(shape, size);
    xml.close();
    xml.close();
}

fn write_inertial(xml: &mut Writer, mass: &RigidMass) {
    let inertia = mass.inertia_kg_m2();
    xml.open("inertial", &[]);
    write_origin(xml, &Isometry3::from(mass.center_m().coords));
    xml.empty("mass", &[("value", number(mass.mass_kg()))]);
    let moments = [
        ("ixx", 0, 0),
        ("ixy", 0, 1),
        ("ixz", 0, 2),
        ("iyy", 1, 1),
        ("iyz", 1, 2),
        ("izz", 2, 2),
    ];
    let moments = moments.map(|(name, i, j)| (name, number(inertia[(i, j)])));
    xml.empty("inertia", &moments);
    xml.close();
}

fn write_origin(xml: &mut Writer, frame: &Isometry3<f64>) {
    let (roll, pitch, yaw) = frame.rotation.euler_angles();
    xml.empty(
        "origin",
        &[
            ("xyz", numbers(&frame.translation.vector)),
            ("rpy", numbers(&[roll, pitch, yaw])),
        ],
    );
}
