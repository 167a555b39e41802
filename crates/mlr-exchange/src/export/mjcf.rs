//! MJCF: bodies, position actuators with the servos' gains, contacts and level ground.

use mlr_model::{ContactShape, Gait, ModelError, Obedience, RigidMass};
use nalgebra::Isometry3;

use super::{BASE, ExportedRobot, IMU, NamedPart, stance::Stance};
use crate::xml::{Writer, number, numbers};

/// Finer than MuJoCo needs for a tenth of a degree of roll (`docs/convergence.md`).
const TIME_STEP_S: f64 = 0.001;
/// Friction against turning and rolling on the spot, m: next to none, as here.
const OTHER_FRICTION: &str = "0.0001 0.0001";
/// Time constant and damping ratio of contacts: the stiffest that MuJoCo takes at a step of 2 ms.
/// Contacts here do not give way either; with MuJoCo's default of 20 ms roll and pitch of damaged
/// robots are three to five times as far from the walk here (`docs/export.md`).
const CONTACT: &str = "0.004 1";
/// The robot's parts touch the ground and never each other.
const OF_ROBOT: [(&str, &str); 2] = [("contype", "1"), ("conaffinity", "2")];

impl ExportedRobot<'_> {
    /// The robot as MJCF, with the ground that it walks on and a keyframe `stance` in which it
    /// stands as it does before it walks this gait.
    ///
    /// # Errors
    /// [`ModelError`] when the robot cannot follow the gait.
    pub fn to_mjcf(&self, gait: &Gait) -> Result<String, ModelError> {
        let stance = self.stance(gait)?;
        let damage = self.morphology.describe();
        let mut xml = Writer::new(&format!(
            "{}: {damage}. Written by mlr-ga export. SI units; x forward, y left, z up; \
             controls are joint angles as commanded.",
            self.robot.name()
        ));
        xml.open("mujoco", &[("model", self.robot.name().into())]);
        xml.empty(
            "compiler",
            &[("angle", "radian".into()), ("autolimits", "true".into())],
        );
        xml.empty(
            "option",
            &[
                ("timestep", number(TIME_STEP_S)),
                ("integrator", "implicitfast".into()),
                ("cone", "elliptic".into()),
                ("impratio", "10".into()),
                ("gravity", "0 0 -9.81".into()),
            ],
        );
        self.write_defaults(&mut xml);
        self.write_timing(&mut xml);
        self.write_world(&mut xml, &stance);
        self.write_actuators(&mut xml);
        self.write_sensors(&mut xml);
        self.write_keyframe(&mut xml, &stance);
        Ok(xml.finish())
    }

    fn write_defaults(&self, xml: &mut Writer) {
        xml.open("default", &[]);
        let friction = friction(self.settings.contact.friction);
        let mut geom = vec![
            ("friction", friction),
            ("solref", CONTACT.into()),
            ("density", "0".into()),
        ];
        geom.extend(OF_ROBOT.map(|(key, value)| (key, value.to_string())));
        xml.empty("geom", &geom);
        xml.close();
    }

    /// What a controller adds: MuJoCo's actuators have no such thing.
    fn write_timing(&self, xml: &mut Writer) {
        let servo = self.robot.servo();
        xml.open("custom", &[]);
        for (name, value) in [
            ("command_hold_s", servo.command_hold_s),
            ("latency_s", servo.latency_s),
            ("speed_limit_rad_per_s", servo.speed_limit_rad_per_s),
        ] {
            xml.empty("numeric", &[("name", name.into()), ("data", number(value))]);
        }
        xml.close();
    }

    fn write_world(&self, xml: &mut Writer, stance: &Stance) {
        xml.open("worldbody", &[]);
        xml.empty(
            "light",
            &[("pos", "0 0 3".into()), ("dir", "0 0 -1".into())],
        );
        // The larger friction of two that touch counts in MuJoCo: that of the robot's part.
        xml.empty(
            "geom",
            &[
                ("name", "ground".into()),
                ("type", "plane".into()),
                ("size", "0 0 0.1".into()),
                ("friction", "0 0 0".into()),
                ("contype", "2".into()),
                ("conaffinity", "1".into()),
            ],
        );
        let height = numbers(&[0.0, 0.0, stance.height_m]);
        xml.open("body", &[("name", BASE.into()), ("pos", height)]);
        xml.empty("freejoint", &[("name", BASE.into())]);
        write_inertial(xml, &self.assembly.body);
        let half = numbers(&(self.robot.body().size_m / 2.0));
        xml.empty(
            "geom",
            &[
                ("name", BASE.into()),
                ("type", "box".into()),
                ("size", half),
            ],
        );
        let [roll, pitch, yaw] = self.robot.imu().mounting_deg.map(f64::to_radians);
        let mounting = nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        xml.empty(
            "site",
            &[("name", IMU.into()), ("quat", quaternion(&mounting))],
        );
        for part in &self.parts {
            self.write_part(xml, part);
            let outermost = part.link + 1 == self.assembly.legs[part.leg].links.len();
            if outermost {
                let tip = numbers(&[part.part.length_m, 0.0, 0.0]);
                xml.empty("site", &[("name", part.tip_name()), ("pos", tip)]);
                // The leg's bodies are inside each other.
                for _ in 0..=part.link {
                    xml.close();
                }
            }
        }
        xml.close();
        xml.close();
    }

    /// A link, left open for the next one.
    fn write_part(&self, xml: &mut Writer, part: &NamedPart) {
        let frame = match part.part.obedience {
            Obedience::Shifted(_) => part.frame(),
            // Its coordinate is the true angle: the spring below holds it there.
            Obedience::Stuck(_) => part.part.frame,
        };
        xml.open(
            "body",
            &[
                ("name", part.name.clone()),
                ("pos", numbers(&frame.translation.vector)),
                ("quat", quaternion(&frame.rotation)),
            ],
        );
        let (servo, drive) = (&part.servo, &part.servo.drive);
        let mut damping = drive.viscous_nm_s_per_rad;
        let mut joint = vec![
            ("name", part.name.clone()),
            ("type", "hinge".into()),
            ("axis", numbers(&part.axis())),
        ];
        if let Obedience::Stuck(angle_rad) = part.part.obedience {
            damping += servo.damping_nm_s_per_rad;
            joint.push(("stiffness", number(servo.stiffness_nm_per_rad)));
            joint.push(("springref", number(angle_rad)));
        }
        for (name, value) in [
            ("damping", damping),
            ("armature", drive.armature_kg_m2),
            ("frictionloss", drive.coulomb_nm),
        ] {
            if value > 0.0 {
                joint.push((name, number(value)));
            }
        }
        xml.empty("joint", &joint);
        write_inertial(xml, &part.part.mass);
        let length_m = part.part.length_m;
        let mut geom = match part.part.contact {
            None => return,
            Some(ContactShape::Capsule { radius_m }) => vec![
                ("type", "capsule".to_string()),
                ("size", number(radius_m)),
                ("fromto", format!("0 0 0 {} 0 0", number(length_m))),
            ],
            Some(ContactShape::Foot { radius_m }) => vec![
                ("type", "sphere".to_string()),
                ("size", number(radius_m)),
                ("pos", numbers(&[length_m - radius_m, 0.0, 0.0])),
            ],
        };
        geom.insert(0, ("name", part.name.clone()));
        if let Some(own) = self.assembly.legs[part.leg].friction {
            geom.push(("friction", friction(own)));
        }
        xml.empty("geom", &geom);
    }

    fn write_actuators(&self, xml: &mut Writer) {
        xml.open("actuator", &[]);
        for part in self.parts.iter().filter(|part| !part.is_stuck()) {
            let limit_nm = part.servo.torque_limit_nm;
            xml.empty(
                "position",
                &[
                    ("name", part.name.clone()),
                    ("joint", part.name.clone()),
                    ("kp", number(part.servo.stiffness_nm_per_rad)),
                    ("kv", number(part.servo.damping_nm_s_per_rad)),
                    ("forcerange", numbers(&[-limit_nm, limit_nm])),
                ],
            );
        }
        xml.close();
    }

    fn write_sensors(&self, xml: &mut Writer) {
        xml.open("sensor", &[]);
        let at = [("site", IMU.to_string())];
        for kind in ["gyro", "accelerometer"] {
            let mut attributes = vec![("name", format!("imu_{kind}"))];
            attributes.extend(at.clone());
            xml.empty(kind, &attributes);
        }
        xml.empty(
            "framequat",
            &[
                ("name", "imu_orientation".into()),
                ("objtype", "site".into()),
                ("objname", IMU.into()),
            ],
        );
        xml.close();
    }

    fn write_keyframe(&self, xml: &mut Writer, stance: &Stance) {
        let joints = self.parts.iter().zip(&stance.commands_rad);
        let angles = joints
            .clone()
            .map(|(part, command_rad)| match part.part.obedience {
                Obedience::Shifted(_) => *command_rad,
                Obedience::Stuck(angle_rad) => angle_rad,
            });
        let mut qpos = vec![0.0, 0.0, stance.height_m, 1.0, 0.0, 0.0, 0.0];
        qpos.extend(angles);
        let obeying = joints.filter(|(part, _)| !part.is_stuck());
        let ctrl: Vec<f64> = obeying.map(|(_, command_rad)| *command_rad).collect();
        xml.open("keyframe", &[]);
        let mut key = vec![("name", "stance".to_string()), ("qpos", numbers(&qpos))];
        if !ctrl.is_empty() {
            key.push(("ctrl", numbers(&ctrl)));
        }
        xml.empty("key", &key);
        xml.close();
    }
}

fn friction(sliding: f64) -> String {
    format!("{} {OTHER_FRICTION}", number(sliding))
}

fn quaternion(rotation: &nalgebra::UnitQuaternion<f64>) -> String {
    let [x, y, z, w] = rotation.coords.into();
    numbers(&[w, x, y, z])
}

fn write_inertial(xml: &mut Writer, mass: &RigidMass) {
    let inertia = mass.inertia_kg_m2();
    let order = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let moments = order.map(|(i, j)| inertia[(i, j)]);
    let inertia = match moments[3..].iter().all(|product| product.abs() < 1e-15) {
        true => ("diaginertia", numbers(&moments[..3])),
        false => ("fullinertia", numbers(&moments)),
    };
    let place = Isometry3::from(mass.center_m().coords).translation.vector;
    xml.empty(
        "inertial",
        &[
            ("pos", numbers(&place)),
            ("mass", number(mass.mass_kg())),
            inertia,
        ],
    );
}
