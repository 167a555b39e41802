//! URDFs read as robots: our own, others', and hostile ones.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_exchange::{ExportedRobot, ImportOptions, Imported, import_urdf};
use mlr_model::{
    ContactShape, FootMotion, Gait, JointAxis, Morphology, Motion, Outcome, Robot, RobotParameter,
    Servo, SimulationSettings, Simulator,
};
use proptest::prelude::*;

const OCTOPOD: &str = include_str!("../../../data/robot/octopod.toml");
const QUADRUPED: &str = include_str!("../../mlr-model/tests/quadruped.toml");
const DOG: &str = include_str!("data/dog.urdf");

fn urdf_of(robot: &Robot) -> String {
    let morphology = Morphology::healthy(&robot.layout());
    let settings = SimulationSettings::default();
    ExportedRobot::new(robot, &morphology, &settings)
        .unwrap()
        .to_urdf()
}

fn read(text: &str) -> Imported {
    import_urdf(text, &ImportOptions::default()).unwrap()
}

fn refused(text: &str) -> String {
    import_urdf(text, &ImportOptions::default())
        .unwrap_err()
        .to_string()
}

/// Every number of a robot, in one order for all robots of a make.
fn numbers(robot: &Robot) -> Vec<f64> {
    let body = robot.body();
    let mut numbers: Vec<f64> = body.size_m.iter().copied().collect();
    numbers.push(body.mass_kg);
    numbers.extend(&body.center_of_mass_m.coords);
    numbers.extend(&body.inertia_kg_m2);
    for leg in robot.legs() {
        numbers.extend(&leg.hip_m.coords);
        numbers.push(leg.hip_yaw_rad);
        numbers.extend(leg.nominal_foot_m);
        numbers.extend(&leg.joint_zeros_rad);
        for link in &leg.links {
            numbers.extend([link.length_m, link.mass_kg, link.center_of_mass_m]);
            numbers.extend(&link.inertia_kg_m2);
            numbers.extend([link.posture_rad, link.locked_rad]);
            numbers.push(match link.contact {
                None => 0.0,
                Some(ContactShape::Capsule { radius_m }) => 1.0 + radius_m,
                Some(ContactShape::Foot { radius_m }) => 2.0 + radius_m,
            });
        }
    }
    numbers.extend(robot.imu().mounting_deg);
    numbers.extend([robot.imu().gyro_scale, robot.clock()]);
    let servo = robot.servo();
    numbers.extend([servo.stiffness_nm_per_rad, servo.damping_nm_s_per_rad]);
    numbers
}

/// The largest difference between the numbers of two robots; names and servos must be the same.
fn difference(a: &Robot, b: &Robot) -> f64 {
    assert_eq!(a.name(), b.name());
    let rest = |robot: &Robot| Servo {
        stiffness_nm_per_rad: 1.0,
        damping_nm_s_per_rad: 1.0,
        ..*robot.servo()
    };
    assert_eq!(rest(a), rest(b));
    let names = |robot: &Robot| -> Vec<String> {
        let legs = robot.legs().iter();
        let names = legs.map(|leg| leg.name.clone());
        names.chain(robot.joint_names()).collect()
    };
    assert_eq!(names(a), names(b));
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(&b)
        .fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn a_robot_comes_back_the_same() {
    for text in [Robot::JETHEXA_TOML, OCTOPOD, QUADRUPED] {
        let robot = Robot::from_toml(text).unwrap();
        let back = read(&urdf_of(&robot));
        let apart = difference(&robot, &back.robot);
        assert!(apart < 1e-6, "{}: {apart}", robot.name());
        assert!(back.foot_error_m < 1e-9);
        assert_eq!(back.left_out, [""; 0]);
        assert_eq!(back.assumed, [""; 0]);
        let plain =
            |joint: &mlr_exchange::JointMap| joint.sign == 1.0 && joint.offset_rad.abs() < 1e-9;
        assert!(back.joints.iter().all(plain), "{:?}", back.joints);
        // The control: another robot is not the same.
        let heavier = robot.with_added(RobotParameter::BodyMass, 0.01);
        assert!(difference(&heavier, &back.robot) > 1e-3);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Calibrated robots too, moved zeros of joints and all, and links of different legs.
    #[test]
    fn a_calibrated_robot_comes_back_the_same(
        which in 0_usize..3,
        changes in prop::collection::vec(-0.2..0.2_f64, 64),
        drive in any::<bool>(),
    ) {
        let text = [Robot::JETHEXA_TOML, OCTOPOD, QUADRUPED][which];
        let robot = Robot::from_toml(text).unwrap();
        let parameters = RobotParameter::all(&robot).into_iter().zip(changes);
        let mut robot = parameters.fold(robot, |robot, (one, more)| robot.with_added(one, more));
        if drive {
            let mut servo = *robot.servo();
            servo.drive.coulomb_nm = 0.05;
            servo.drive.back_emf = true;
            robot = robot.with_servo(servo).unwrap();
        }
        let back = read(&urdf_of(&robot));
        let apart = difference(&robot, &back.robot);
        prop_assert!(apart < 1e-6, "{apart}");
    }
}

/// A hexapod of others: the same without what exports say besides, its legs in another order.
#[test]
fn a_hexapod_without_our_element_has_the_same_legs() {
    let robot = Robot::jethexa();
    let text = urdf_of(&robot);
    let (before, rest) = text.split_once("  <mlr").unwrap();
    let (_, after) = rest.split_once("</mlr>").unwrap();
    let back = read(&format!("{before}{after}"));
    assert!(!back.assumed.is_empty());
    for (leg, own) in back.robot.legs().iter().zip(robot.legs()) {
        assert!((leg.hip_m - own.hip_m).norm() < 1e-9, "{}", leg.name);
        assert!((leg.hip_yaw_rad - own.hip_yaw_rad).abs() < 1e-9);
        for (link, own) in leg.links.iter().zip(&own.links) {
            assert_eq!((link.joint, link.contact), (own.joint, own.contact));
            assert!((link.length_m - own.length_m).abs() < 1e-9);
            assert!((link.mass_kg - own.mass_kg).abs() < 1e-9);
        }
    }
    assert_eq!(back.robot.joint_names()[0], "leg1_coxa");
    // Without knowing anything of its servos, it walks the tripod as the robot that it is.
    let walked = |robot: Robot| {
        let healthy = Morphology::healthy(&robot.layout());
        let settings = SimulationSettings {
            duration_s: 2.0,
            ..Default::default()
        };
        let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
        assert!(matches!(simulator.simulate(&healthy), Outcome::Walked(_)));
    };
    walked(back.robot);
}

#[test]
fn a_dog_is_held_as_far_as_it_can_be() {
    // The tail turns about an axis that is none of a leg's.
    let message = refused(DOG);
    assert!(
        message.contains("\"tail_joint\"") && message.contains("--fixed"),
        "{message}"
    );
    let options = ImportOptions {
        fixed_joints: vec!["tail_joint".into()],
    };
    let dog = import_urdf(DOG, &options).unwrap();
    let robot = &dog.robot;
    assert_eq!(robot.name(), "test dog");
    let names: Vec<&str> = robot.legs().iter().map(|leg| leg.name.as_str()).collect();
    assert_eq!(names, ["FL", "FR", "RL", "RR"]);
    assert_eq!(
        robot.joint_names()[..3],
        ["leg1_hip", "leg1_thigh", "leg1_calf"]
    );
    // All masses are there, camera, tail and feet too.
    let total_kg = 5.2 + 0.1 + 0.05 + 4.0 * (0.59 + 0.92 + 0.13 + 0.06);
    assert!(
        (robot.mass_kg() - total_kg).abs() < 1e-9,
        "{}",
        robot.mass_kg()
    );
    let leg = &robot.legs()[0];
    let axes: Vec<JointAxis> = leg.links.iter().map(|link| link.joint).collect();
    assert_eq!(axes, [JointAxis::Lift, JointAxis::Yaw, JointAxis::Yaw]);
    assert!((leg.links[1].length_m - 0.213).abs() < 1e-9);
    // The foot's sphere ends 20 mm below the calf's end.
    assert!((leg.links[2].length_m - 0.233).abs() < 1e-9);
    assert_eq!(
        leg.links[2].contact,
        Some(ContactShape::Foot { radius_m: 0.02 })
    );
    assert_eq!(robot.servo().torque_limit_nm, 23.7);
    assert_eq!(robot.servo().speed_limit_rad_per_s, 20.1);
    // The offset between abduction and thigh, 80 mm, cannot be held; it shows when legs spread.
    assert!(
        dog.foot_error_m > 0.01 && dog.foot_error_m < 0.05,
        "{}",
        dog.foot_error_m
    );
    let all = dog.left_out.join("; ");
    for told in ["<transmission>", "torque limit of up to 35.5"] {
        assert!(all.contains(told), "{told}: {all}");
    }
    assert!(
        dog.assumed
            .iter()
            .any(|what| what.contains("no URDF tells"))
    );
    // It stands and trots.
    let gait = Gait {
        name: "trot".into(),
        period_s: 0.6,
        motion: Motion::Feet(FootMotion {
            stride_m: 0.06,
            lift_m: 0.04,
            body_height_m: 0.3,
            swing_fraction: 0.5,
            ramp_s: 0.6,
            phase_offsets: vec![0.0, 0.5, 0.5, 0.0],
        }),
    };
    let settings = SimulationSettings {
        duration_s: 2.0,
        time_step_s: 0.002,
        ..Default::default()
    };
    let healthy = Morphology::healthy(&robot.layout());
    let simulator = Simulator::new(robot.clone(), &gait, settings).unwrap();
    let Outcome::Walked(walk) = simulator.simulate(&healthy) else {
        panic!("the dog diverged");
    };
    let roll = &walk.orientation.angles_rad().roll;
    assert!(
        roll.iter().all(|roll_rad| roll_rad.abs() < 0.5),
        "the dog fell"
    );
}

#[test]
fn hostile_files_end_in_messages() {
    let robot = |inner: &str| format!("<robot name=\"r\">\n{inner}\n</robot>");
    let mass = "<inertial><mass value=\"1\"/></inertial>";
    let leg = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 0 1\"/></joint>"
        )
    };
    let body = format!("<link name=\"a\">{mass}</link><link name=\"b\">{mass}</link>");
    let entity = "<!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;\">]><robot>&b;</robot>";
    let cases = [
        (String::new(), "expected URDF"),
        ("<robot".into(), "line 1"),
        ("no XML at all".into(), "expected URDF"),
        (entity.into(), "DTD"),
        ("<mujoco/>".into(), "this is MJCF"),
        (robot(""), "no <link>"),
        (robot("<link/>"), "line 2: <link> without a name"),
        (
            robot("<link name=\"a\"/><link name=\"a\"/>"),
            "a second time",
        ),
        (
            robot(&leg("j", "a", "b")),
            "line 2: joint \"j\" has the parent \"a\"",
        ),
        (
            robot("<link name=\"a\"/><joint name=\"j\"/>"),
            "joint \"j\" without parent",
        ),
        (robot(&body), "hangs on nothing"),
        (
            robot(&format!(
                "{body}{}{}",
                leg("j", "a", "b"),
                leg("k", "b", "a")
            )),
            "in a circle",
        ),
        (
            robot(&format!(
                "{body}<link name=\"c\"/>{}{}",
                leg("j", "a", "b"),
                leg("k", "b", "a")
            )),
            "in a circle",
        ),
        (
            robot(&format!(
                "{body}{}{}",
                leg("j", "a", "b"),
                leg("k", "a", "b")
            )),
            "expected one: a robot is a tree",
        ),
        (
            robot("<link name=\"a\"><inertial><mass value=\"1e999\"/></inertial></link>"),
            "value=\"1e999\" of <mass>",
        ),
        (
            robot("<link name=\"a\"><inertial><mass value=\"-1\"/></inertial></link>"),
            "expected a mass",
        ),
        (
            robot("<link name=\"a\"><inertial><mass value=\"nan\"/></inertial></link>"),
            "expected a mass",
        ),
        (
            robot("<link name=\"a\"><inertial><origin xyz=\"1e300 0 0\"/></inertial></link>"),
            "-1000 to 1000 m",
        ),
        (
            robot("<link name=\"a\"><inertial><origin xyz=\"1 2\"/></inertial></link>"),
            "xyz=\"1 2\"",
        ),
        (
            robot(&format!(
                "{body}{}",
                leg("j", "a", "b").replace("0 0 1", "0 0 0")
            )),
            "axis of joint \"j\" is zero",
        ),
        (
            robot(&format!(
                "{body}{}",
                leg("j", "a", "b").replace("0 0 1", "0 1 1")
            )),
            "to the upright",
        ),
        (robot("<link name=\"a\"/>"), "no joint that turns"),
        (
            robot(&format!("{body}{}", leg("j", "a", "b")).replacen(mass, "", 1)),
            "has no mass",
        ),
        (
            "<robot xmlns:xacro=\"x\"><xacro:include/></robot>".into(),
            "run xacro",
        ),
    ];
    for (text, told) in cases {
        let message = refused(&text);
        assert!(message.contains(told), "{told}: {message}");
    }
}

#[test]
fn files_of_great_depth_and_length_end_in_messages() {
    let deep = format!(
        "<robot>{}{}</robot>",
        "<a>".repeat(200_000),
        "</a>".repeat(200_000)
    );
    // Either answer is one: what must not happen is that the stack ends.
    assert!(import_urdf(&deep, &ImportOptions::default()).is_err());
    let many = format!("<robot>{}</robot>", "<a/>".repeat(600_000));
    assert!(refused(&many).contains("nodes"), "{}", refused(&many));
    let chain = |joints: usize, kind: &str| {
        let link = |k: usize| {
            format!("<link name=\"{k}\"><inertial><mass value=\"1\"/></inertial></link>")
        };
        let joint = |k: usize| {
            let on = k - 1;
            format!(
                "<joint name=\"{k}\" type=\"{kind}\"><origin xyz=\"0.1 0 0\"/><parent link=\"{on}\"/><child link=\"{k}\"/><axis xyz=\"0 0 1\"/></joint>"
            )
        };
        let links: String = (0..=joints).map(link).collect();
        let joints: String = (1..=joints).map(joint).collect();
        format!("<robot>{links}{joints}</robot>")
    };
    let message = refused(&chain(10_000, "revolute"));
    assert!(message.contains("10000 joints that turn"), "{message}");
    let message = refused(&chain(300, "revolute"));
    assert!(message.contains("1 to 255 links"), "{message}");
    let message = refused(&chain(20_000, "prismatic"));
    assert!(message.contains("no joint that turns"), "{message}");
}

proptest! {
    /// Whatever is done to a file, there is an answer.
    #[test]
    fn broken_files_never_panic(at in any::<prop::sample::Index>(), length in 0_usize..200, put in "\\PC{0,12}") {
        let start = at.index(DOG.len());
        let end = (start + length).min(DOG.len());
        let broken = format!("{}{put}{}", &DOG[..start], &DOG[end..]);
        let options = ImportOptions { fixed_joints: vec!["tail_joint".into()] };
        let _ = import_urdf(&broken, &options);
    }

    #[test]
    fn wild_numbers_never_panic(which in any::<prop::sample::Index>(), value in prop::num::f64::ANY) {
        let quoted: Vec<(usize, &str)> = DOG.match_indices("value=\"").chain(DOG.match_indices("xyz=\"")).collect();
        let (at, key) = quoted[which.index(quoted.len())];
        let start = at + key.len();
        let end = start + DOG[start..].find('"').unwrap();
        let put = if key.starts_with('v') { value.to_string() } else { format!("{value} 0 {value}") };
        let broken = format!("{}{put}{}", &DOG[..start], &DOG[end..]);
        let options = ImportOptions { fixed_joints: vec!["tail_joint".into()] };
        let _ = import_urdf(&broken, &options);
    }
}
