//! Exported robots, read by others: `urdf-rs` for URDF, a reader of nested bodies for MJCF. MuJoCo
//! itself reads both in `tools/export`.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::HashMap;

use mlr_exchange::{ExportedRobot, Format};
use mlr_model::{
    Assembly, Fault, Gait, LostLinks, Morphology, Payload, Robot, RobotParameter,
    SimulationSettings, dynamics::Dynamics,
};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

const OCTOPOD: &str = include_str!("../../../data/robot/octopod.toml");

/// Mass, and its centre in the body's frame, all joints at zero.
type Weight = (f64, Point3<f64>);

fn weight_of(masses: impl IntoIterator<Item = (f64, Point3<f64>)>) -> Weight {
    let (mass_kg, moment) = masses.into_iter().fold(
        (0.0, Vector3::zeros()),
        |(mass_kg, moment), (own_kg, at)| (mass_kg + own_kg, moment + at.coords * own_kg),
    );
    (mass_kg, Point3::from(moment / mass_kg))
}

/// What the equations of motion have, whose joint angles are true ones.
fn weight_here(assembly: &Assembly, commands_rad: f64) -> Weight {
    let joints = assembly.legs.iter().flat_map(|leg| &leg.links);
    let true_rad: Vec<f64> = joints
        .map(|link| match link.obedience {
            mlr_model::Obedience::Shifted(zero_rad) => commands_rad + zero_rad,
            mlr_model::Obedience::Stuck(angle_rad) => angle_rad,
        })
        .collect();
    let mut dynamics = Dynamics::of(assembly);
    let posed = dynamics.at(&UnitQuaternion::identity(), &true_rad);
    (assembly.mass_kg(), posed.center_of_mass_m())
}

fn weight_in_urdf(text: &str, commands_rad: f64) -> Weight {
    let robot = urdf_rs::read_from_string(text).unwrap();
    let pose = |pose: &urdf_rs::Pose| {
        let [roll, pitch, yaw] = *pose.rpy;
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Isometry3::from_parts(Translation3::from(Vector3::from(*pose.xyz)), turn)
    };
    let mut frames = HashMap::from([("base_link".to_string(), Isometry3::identity())]);
    // Joints are written from the body outward.
    for joint in &robot.joints {
        let mut frame = frames[&joint.parent.link] * pose(&joint.origin);
        if joint.joint_type == urdf_rs::JointType::Revolute {
            let axis = nalgebra::Unit::new_normalize(Vector3::from(*joint.axis.xyz));
            frame.rotation *= UnitQuaternion::from_axis_angle(&axis, commands_rad);
        }
        frames.insert(joint.child.link.clone(), frame);
    }
    weight_of(robot.links.iter().map(|link| {
        let frame = frames[&link.name] * pose(&link.inertial.origin);
        (link.inertial.mass.value, frame.translation.vector.into())
    }))
}

fn weight_in_mjcf(text: &str, commands_rad: f64) -> Weight {
    fn numbers(node: &roxmltree::Node<'_, '_>, name: &str) -> Vec<f64> {
        let text = node.attribute(name).unwrap_or_default();
        text.split_whitespace()
            .map(|one| one.parse().unwrap())
            .collect()
    }
    fn point(numbers: &[f64]) -> Vector3<f64> {
        Vector3::from_row_slice(if numbers.is_empty() {
            &[0.0; 3]
        } else {
            numbers
        })
    }
    let document = roxmltree::Document::parse(text).unwrap();
    let named = |name: &str| {
        document
            .descendants()
            .find(|node| node.has_tag_name(name))
            .unwrap()
    };
    let base = named("worldbody")
        .children()
        .find(|node| node.has_tag_name("body"))
        .unwrap();
    let mut masses = Vec::new();
    let mut open = vec![(base, Isometry3::identity())];
    while let Some((body, frame)) = open.pop() {
        for child in body.children() {
            match child.tag_name().name() {
                "inertial" => {
                    let at = frame * Point3::from(point(&numbers(&child, "pos")));
                    masses.push((numbers(&child, "mass")[0], at));
                }
                "body" => {
                    let quat = numbers(&child, "quat");
                    let turn = Quaternion::new(quat[0], quat[1], quat[2], quat[3]);
                    let mut frame = frame
                        * Isometry3::from_parts(
                            point(&numbers(&child, "pos")).into(),
                            UnitQuaternion::from_quaternion(turn),
                        );
                    let joint = child
                        .children()
                        .find(|node| node.has_tag_name("joint"))
                        .unwrap();
                    let axis = nalgebra::Unit::new_normalize(point(&numbers(&joint, "axis")));
                    let held = numbers(&joint, "springref");
                    let angle_rad = held.first().copied().unwrap_or(commands_rad);
                    frame.rotation *= UnitQuaternion::from_axis_angle(&axis, angle_rad);
                    open.push((child, frame));
                }
                _ => {}
            }
        }
    }
    weight_of(masses)
}

fn settings_with(faults: Vec<Fault>, locked: bool, payload: bool) -> SimulationSettings {
    SimulationSettings {
        lost_links: if locked {
            LostLinks::Locked
        } else {
            LostLinks::Absent
        },
        payload: payload.then_some(Payload {
            mass_kg: 0.4,
            position_m: [0.05, -0.02, 0.05],
        }),
        faults,
        ..SimulationSettings::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn urdf_and_mjcf_have_the_mass_of_the_robot_in_every_pose(
        octopod in any::<bool>(),
        left in prop::collection::vec(0_usize..=3, 8),
        locked in any::<bool>(),
        payload in any::<bool>(),
        commands_rad in -1.0..1.0_f64,
        zero_rad in -0.3..0.3_f64,
        stuck_rad in -2.0..2.0_f64,
    ) {
        let robot = if octopod { Robot::from_toml(OCTOPOD).unwrap() } else { Robot::jethexa() };
        let robot = robot.with_added(RobotParameter::JointZero { leg: 1, joint: 2 }, zero_rad);
        let gait = if octopod {
            Gait::from_toml(include_str!("../../../data/gait/octopod.toml")).unwrap()
        } else {
            Gait::tripod()
        };
        let healthy = Morphology::healthy(&robot.layout());
        let morphology = (0..robot.legs().len())
            .fold(healthy, |one, leg| one.with_remaining(leg, left[leg]));
        let faults = vec![
            Fault::StuckJoint { leg: 1, joint: 2, angle_rad: stuck_rad },
            Fault::ShortLink { leg: 4, link: 3, length_lost_m: 0.03 },
            Fault::WeakLeg { leg: 5, gain: 0.5 },
        ];
        let settings = settings_with(faults, locked, payload);
        let exported = ExportedRobot::new(&robot, &morphology, &settings).unwrap();
        let here = weight_here(exported.assembly(), commands_rad);
        let straight = weight_here(exported.assembly(), 0.0);
        prop_assert!((exported.center_of_mass_m() - straight.1).norm() < 1e-12);
        let urdf = exported.written(Format::Urdf, &gait).unwrap();
        let mjcf = exported.written(Format::Mjcf, &gait).unwrap();
        for there in [weight_in_urdf(&urdf, commands_rad), weight_in_mjcf(&mjcf, commands_rad)] {
            prop_assert!((there.0 - here.0).abs() < 1e-12);
            prop_assert!((there.1 - here.1).norm() < 1e-9, "{there:?} {here:?}");
        }
        // In another pose too. Coxas of opposite legs may turn without moving the centre of mass.
        let elsewhere_rad = commands_rad + 0.5;
        let elsewhere = weight_here(exported.assembly(), elsewhere_rad);
        prop_assert!((weight_in_urdf(&urdf, elsewhere_rad).1 - elsewhere.1).norm() < 1e-9);
    }
}

/// The control of the test above: the centre of mass is elsewhere in another pose.
#[test]
fn the_center_of_mass_moves_with_the_joints() {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse("111 110 111 111 111 111", &robot.layout()).unwrap();
    let settings = SimulationSettings::default();
    let exported = ExportedRobot::new(&robot, &morphology, &settings).unwrap();
    let urdf = exported.written(Format::Urdf, &Gait::tripod()).unwrap();
    let moved = weight_in_urdf(&urdf, 0.0).1 - weight_in_urdf(&urdf, 0.5).1;
    assert!(moved.norm() > 1e-3, "{moved:?}");
}

#[test]
fn actuators_are_the_servos_and_weak_legs_are_weak() {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse("111 111 000 111 111 110", &robot.layout()).unwrap();
    let weak = Fault::WeakLeg { leg: 2, gain: 0.5 };
    let stuck = Fault::StuckJoint {
        leg: 4,
        joint: 1,
        angle_rad: 0.2,
    };
    let slippery = Fault::FootFriction { leg: 5, mu: 0.2 };
    let settings = settings_with(vec![weak, stuck, slippery], false, false);
    let exported = ExportedRobot::new(&robot, &morphology, &settings).unwrap();
    let mjcf = exported.to_mjcf(&Gait::tripod()).unwrap();
    let document = roxmltree::Document::parse(&mjcf).unwrap();
    let of = |tag: &'static str| {
        document
            .descendants()
            .filter(move |node| node.has_tag_name(tag))
    };
    let actuators: HashMap<_, _> = of("position")
        .map(|node| (node.attribute("joint").unwrap(), node))
        .collect();
    assert_eq!(actuators.len(), 14 - 1);
    assert_eq!(actuators["leg1_femur"].attribute("kp"), Some("30"));
    assert_eq!(actuators["leg1_femur"].attribute("kv"), Some("0.6"));
    assert_eq!(
        actuators["leg1_femur"].attribute("forcerange"),
        Some("-3.4 3.4")
    );
    assert_eq!(actuators["leg2_tibia"].attribute("kp"), Some("15"));
    assert_eq!(
        actuators["leg2_tibia"].attribute("forcerange"),
        Some("-1.7 1.7")
    );
    assert!(!actuators.contains_key("leg4_coxa"));
    let geoms: HashMap<_, _> = of("geom")
        .filter_map(|node| Some((node.attribute("name")?, node)))
        .collect();
    assert!(!geoms.contains_key("leg6_tibia"));
    assert_eq!(geoms["leg1_tibia"].attribute("friction"), None);
    assert_eq!(
        geoms["leg5_tibia"].attribute("friction"),
        Some("0.2 0.0001 0.0001")
    );
    // As many coordinates as the file's joints have, and the feet on the ground.
    let key = of("key").next().unwrap();
    let count = |name: &str| key.attribute(name).unwrap().split(' ').count();
    assert_eq!((count("qpos"), count("ctrl")), (7 + 14, 13));
    let height_m: f64 = key
        .attribute("qpos")
        .unwrap()
        .split(' ')
        .nth(2)
        .unwrap()
        .parse()
        .unwrap();
    assert!((0.085..0.105).contains(&height_m), "{height_m}");
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let text = Robot::JETHEXA_TOML.replace(
        "[links.coxa]",
        "[servo.drive]\nbacklash_rad = 0.01\ncoulomb_nm = 0.1\n[links.coxa]",
    );
    let robot = Robot::from_toml(&text).unwrap();
    let morphology = Morphology::healthy(&robot.layout());
    let settings = SimulationSettings::default();
    let exported = ExportedRobot::new(&robot, &morphology, &settings).unwrap();
    let said = |format| exported.left_out(format).join("; ");
    assert!(
        said(Format::Urdf).contains("play"),
        "{}",
        said(Format::Urdf)
    );
    assert!(said(Format::Urdf).contains("friction of the ground"));
    assert!(said(Format::Mjcf).contains("play"));
    assert!(!said(Format::Mjcf).contains("friction of the ground"));
    assert_eq!(said(Format::Json), "");
}

#[test]
fn odd_names_stay_readable() {
    let text = Robot::JETHEXA_TOML.replace("Hiwonder JetHexa", "a <\\\"b\\\"> & -- c");
    let robot = Robot::from_toml(&text).unwrap();
    let morphology = Morphology::healthy(&robot.layout());
    let settings = SimulationSettings::default();
    let exported = ExportedRobot::new(&robot, &morphology, &settings).unwrap();
    assert_eq!(
        urdf_rs::read_from_string(&exported.to_urdf()).unwrap().name,
        robot.name()
    );
    let json = exported.to_json().to_string();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["schema"], "mlr.robot/1");
    assert_eq!(json["legs"].as_array().unwrap().len(), 6);
}
