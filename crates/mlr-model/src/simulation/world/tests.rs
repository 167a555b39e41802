//! Rapier's accelerations in free flight are those of the equations of motion.

use nalgebra::DVector;

use super::*;
use crate::{Gait, LostLinks, Robot, Servo, SimulationSettings, dynamics::Dynamics};

/// Near the smallest at which single precision still resolves the change of a velocity.
const STEP_S: f64 = 2e-4;

/// How the robot moves: of the body's centre of mass and turn in the world, and of the joints.
fn motion(world: &World<'_>) -> (Vector3<f64>, Vector3<f64>, Vec<f64>) {
    let body = &world.physics.bodies[world.body];
    let (linear, angular) = (body.linvel(), body.angvel());
    let multibody = world.physics.multibody().unwrap();
    let speeds = (0..world.joints.len()).map(|joint| {
        let freedom = multibody.link(joint + 1).unwrap().assembly_id();
        f64::from(multibody.generalized_velocity()[freedom])
    });
    (
        Vector3::new(linear.x, linear.y, linear.z).cast(),
        Vector3::new(angular.x, angular.y, angular.z).cast(),
        speeds.collect(),
    )
}

fn angles_rad(world: &World<'_>) -> Vec<f64> {
    let multibody = world.physics.multibody().unwrap();
    let joints = 0..world.joints.len();
    let angle = |joint: usize| multibody.link(joint + 1).unwrap().joint.coords();
    joints
        .map(|joint| f64::from(angle(joint)[super::super::servo_state::HINGE_AXIS]))
        .collect()
}

/// Accelerations by rapier and by the equations of motion, with joints that turn at about so many
/// rad/s: of the centre of mass of the body, of its turn (both in the world), of the joints.
fn accelerations(lost: &str, lost_links: LostLinks, speed: f64) -> [DVector<f64>; 2] {
    let robot = Robot::jethexa();
    let servo = Servo {
        stiffness_nm_per_rad: 1e-9,
        damping_nm_s_per_rad: 0.0,
        ..*robot.servo()
    };
    let robot = robot.with_servo(servo).unwrap();
    let morphology = Morphology::parse(lost, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        start_clearance_m: 10.0,
        time_step_s: STEP_S,
        lost_links,
        ..Default::default()
    };
    let simulator = Simulator::new(robot.clone(), &Gait::tripod(), settings).unwrap();
    let mut world = World::new(&simulator, &morphology);
    let mut dynamics = Dynamics::new(&robot, &morphology, lost_links);
    let n = dynamics.freedoms();
    assert_eq!(n, 6 + world.joints.len());
    let multibody = world.physics.multibody_mut().unwrap();
    let mut velocity = multibody.generalized_velocity_mut();
    for k in 0..n {
        velocity[k] = (speed * (1.3 * k as f64 + 0.4).sin()) as f32;
    }
    world.physics.move_parts();
    let gravity = GRAVITY_MPS2 * Vector3::z();
    // After a first step all parts have their velocities.
    world.physics.step(&gravity);

    let (center_mps, turn, speeds) = motion(&world);
    let attitude = world.pose().rotation;
    let center = Assembly::new(&robot, &morphology, lost_links)
        .body
        .center_m();
    let back = attitude.inverse();
    let (turn, center_mps) = (back * turn, back * center_mps);
    let origin_mps = center_mps - turn.cross(&center.coords);
    let nu = [origin_mps, turn].into_iter().flat_map(|v| [v.x, v.y, v.z]);
    let nu = DVector::from_iterator(n, nu.chain(speeds.iter().copied()));
    let mut rates = DVector::zeros(n);
    let posed = dynamics.at(&attitude, &angles_rad(&world));
    posed.moving(&nu).forward(&DVector::zeros(n), &mut rates);
    let [origin_rate, turn_rate] = [0, 3].map(|first| Vector3::from(rates.fixed_rows::<3>(first)));
    let of_center = origin_rate
        + turn.cross(&origin_mps)
        + turn_rate.cross(&center.coords)
        + turn.cross(&turn.cross(&center.coords));
    let [of_center, of_turn] = [of_center, turn_rate].map(|v| attitude * v);
    let ours = [of_center, of_turn]
        .into_iter()
        .flat_map(|v| [v.x, v.y, v.z]);
    let ours = ours.chain(rates.iter().skip(6).copied());
    let ours = DVector::from_iterator(n, ours);

    let before = motion(&world);
    world.physics.step(&gravity);
    let after = motion(&world);
    let changes = [after.0 - before.0, after.1 - before.1];
    let changes = changes.into_iter().flat_map(|v| [v.x, v.y, v.z]);
    let joints = after.2.iter().zip(&before.2).map(|(a, b)| a - b);
    let theirs = DVector::from_iterator(n, changes.chain(joints)) / STEP_S;
    [theirs, ours]
}

#[test]
fn in_free_flight_rapier_accelerates_as_the_equations_of_motion_have_it() {
    for (lost, lost_links) in [
        ("111 111 111 111 111 111", LostLinks::Absent),
        ("111 110 000 111 100 111", LostLinks::Absent),
        ("111 110 000 111 100 111", LostLinks::Locked),
    ] {
        let [theirs, ours] = accelerations(lost, lost_links, 3.0);
        // Centre of mass, turn, and joints each for themselves.
        for rows in [0..3, 3..6, 6..ours.len()] {
            let of = |all: &DVector<f64>| all.rows(rows.start, rows.len()).into_owned();
            let (theirs, ours) = (of(&theirs), of(&ours));
            let apart = (&theirs - &ours).amax() / ours.amax();
            assert!(
                apart < 0.005,
                "{lost} {lost_links:?}: {apart} {theirs} {ours}"
            );
        }
        // The control: a robot of which nothing moves falls, and nothing else.
        let [still, _] = accelerations(lost, lost_links, 0.0);
        assert!((&still - &ours).amax() / ours.amax() > 0.3);
    }
}
