//! Properties of the equations of motion, each with a control that lacks it.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod free_motion;

use free_motion::State;
use mlr_model::{Assembly, LostLinks, Morphology, Payload, Robot, dynamics::Dynamics, kinematics};
use nalgebra::{DMatrix, DVector, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;

const OCTOPOD: &str = include_str!("../../../data/robot/octopod.toml");
const QUADRUPED: &str = include_str!("quadruped.toml");

/// Robots of six, eight and four legs; the last one's have two or three links.
fn robots() -> [Robot; 3] {
    [Robot::JETHEXA_TOML, OCTOPOD, QUADRUPED].map(|text| Robot::from_toml(text).unwrap())
}

/// A robot with some of its links, and numbers to make a state of.
#[derive(Debug, Clone)]
struct Case {
    robot: Robot,
    morphology: Morphology,
    lost_links: LostLinks,
    numbers: Vec<f64>,
}

impl Case {
    fn dynamics(&self) -> Dynamics {
        Dynamics::new(&self.robot, &self.morphology, self.lost_links)
    }

    fn state(&self) -> State {
        let joints = self.dynamics().freedoms() - 6;
        State::from_numbers(&self.numbers, joints)
    }

    /// So many numbers that the state has nothing to do with.
    fn others(&self, count: usize) -> DVector<f64> {
        DVector::from_fn(count, |k, _| self.numbers[self.numbers.len() - 1 - k])
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let vectors = prop::collection::vec(0_usize..=3, 8);
    let numbers = prop::collection::vec(-1.0..1.0_f64, 100);
    (0_usize..3, vectors, any::<bool>(), numbers).prop_map(|(robot, left, locked, numbers)| {
        let robot = robots()[robot].clone();
        let healthy = Morphology::healthy(&robot.layout());
        let morphology = (0..robot.legs().len()).fold(healthy, |one, leg| {
            // Half of the legs whole.
            one.with_remaining(leg, if left[leg] == 0 { 3 } else { left[leg] - 1 })
        });
        let lost_links = if locked {
            LostLinks::Locked
        } else {
            LostLinks::Absent
        };
        Case {
            robot,
            morphology,
            lost_links,
            numbers,
        }
    })
}

fn mass(dynamics: &mut Dynamics, state: &State) -> DMatrix<f64> {
    let n = dynamics.freedoms();
    let mut mass = DMatrix::zeros(n, n);
    state.posed(dynamics).mass_matrix(&mut mass);
    mass
}

fn coriolis(dynamics: &mut Dynamics, state: &State) -> DMatrix<f64> {
    let n = dynamics.freedoms();
    let mut coriolis = DMatrix::zeros(n, n);
    state.moving(dynamics).coriolis_matrix(&mut coriolis);
    coriolis
}

/// By central differences along the motion, in the sixth order.
fn rate<T>(at: impl Fn(f64) -> T) -> T
where
    T: std::ops::Sub<Output = T> + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    const STEP_S: f64 = 0.01;
    let pair = |k: f64| at(k * STEP_S) - at(-k * STEP_S);
    (pair(1.0) * 45.0 - pair(2.0) * 9.0 + pair(3.0)) * (1.0 / (60.0 * STEP_S))
}

proptest! {
    #[test]
    fn mass_is_symmetric_positive_definite_and_that_of_the_kinetic_energy(case in cases()) {
        let mut dynamics = case.dynamics();
        let state = case.state();
        let mass = mass(&mut dynamics, &state);
        prop_assert!((&mass - mass.transpose()).amax() == 0.0);
        prop_assert!(mass.clone().cholesky().is_some());
        let energy_j = 0.5 * state.velocities.dot(&(&mass * &state.velocities));
        let of_parts_j = state.moving(&mut dynamics).kinetic_energy_j();
        prop_assert!((energy_j - of_parts_j).abs() < 1e-12 * (1.0 + of_parts_j));
        // The control: turned around one entry it is neither.
        let mut other = mass;
        other[(0, 0)] *= -1.0;
        prop_assert!(other.cholesky().is_none());
    }

    #[test]
    fn the_rate_of_mass_less_two_coriolis_is_skew_symmetric(case in cases()) {
        let dynamics = case.dynamics();
        let state = case.state();
        let mass_rate = rate(|time_s| mass(&mut dynamics.clone(), &state.carried_on(time_s)));
        let coriolis = coriolis(&mut dynamics.clone(), &state);
        let skewness = |coriolis: &DMatrix<f64>| {
            let difference = &mass_rate - coriolis * 2.0;
            (&difference + difference.transpose()).amax() / mass_rate.amax()
        };
        // Below what the differences leave.
        let ours = skewness(&coriolis);
        prop_assert!(mass_rate.amax() == 0.0 || ours < 1e-7, "{ours}");
        // The control: another matrix that makes the same forces.
        let speed = &state.velocities;
        let forces = &coriolis * speed;
        let other = &forces * speed.transpose() / speed.norm_squared();
        prop_assert!((&other * speed - forces).amax() < 1e-9);
        prop_assert!(mass_rate.amax() < 1e-3 || skewness(&other) > 1e-3);
    }

    #[test]
    fn both_ways_to_the_coriolis_forces_agree(case in cases()) {
        let mut dynamics = case.dynamics();
        let state = case.state();
        let n = dynamics.freedoms();
        let of_matrix = coriolis(&mut dynamics, &state) * &state.velocities;
        let mut forces = DVector::zeros(n);
        state.moving(&mut dynamics).coriolis_forces(&mut forces);
        prop_assert!((&of_matrix - &forces).amax() < 1e-12 * (1.0 + forces.amax()));
        // With gravity they are the bias.
        let (mut bias, mut gravity) = (DVector::zeros(n), DVector::zeros(n));
        state.posed(&mut dynamics).gravity_forces(&mut gravity);
        state.moving(&mut dynamics).bias_forces(&mut bias);
        prop_assert!((&bias - (&gravity + &forces)).amax() < 1e-12 * (1.0 + bias.amax()));
        // The control: gravity is no small part of it.
        prop_assert!((&bias - &forces).amax() > 1.0);
    }

    #[test]
    fn forward_and_inverse_dynamics_are_inverse_and_those_of_the_matrices(case in cases()) {
        let mut dynamics = case.dynamics();
        let state = case.state();
        let n = dynamics.freedoms();
        let acceleration = case.others(n) * 20.0;
        let (mut forces, mut bias) = (DVector::zeros(n), DVector::zeros(n));
        let mass = mass(&mut dynamics, &state);
        let mut moving = state.moving(&mut dynamics);
        moving.inverse(&acceleration, &mut forces);
        moving.bias_forces(&mut bias);
        let of_matrices = mass * &acceleration + bias;
        prop_assert!((&forces - &of_matrices).amax() < 1e-11 * (1.0 + forces.amax()));
        let mut back = DVector::zeros(n);
        moving.forward(&forces, &mut back);
        prop_assert!((&back - &acceleration).amax() < 1e-7 * (1.0 + acceleration.amax()));
        // The control: a torque of a thousandth more is seen.
        forces[n - 1] += 1e-3;
        moving.forward(&forces, &mut back);
        prop_assert!((&back - &acceleration).amax() > 1e-5);
    }

    #[test]
    fn gravity_is_the_gradient_of_the_potential_energy(case in cases()) {
        let dynamics = case.dynamics();
        let state = case.state();
        let weight_n = Assembly::new(&case.robot, &case.morphology, case.lost_links).mass_kg() * 9.81;
        let height_m = |time_s: f64| {
            let later = state.carried_on(time_s);
            let mut dynamics = dynamics.clone();
            later.height_m(&later.posed(&mut dynamics).center_of_mass_m())
        };
        let mut forces = DVector::zeros(dynamics.freedoms());
        state.posed(&mut dynamics.clone()).gravity_forces(&mut forces);
        let power_w = weight_n * rate(height_m);
        prop_assert!((power_w - forces.dot(&state.velocities)).abs() < 1e-6 * (1.0 + power_w.abs()));
    }

    #[test]
    fn the_jacobian_of_a_foot_moves_it_and_carries_forces_back(case in cases()) {
        let mut dynamics = case.dynamics();
        let state = case.state();
        let n = dynamics.freedoms();
        let force_n = Vector3::new(case.numbers[90], case.numbers[91], case.numbers[92]);
        for (index, leg) in case.robot.legs().iter().enumerate() {
            let Some(foot) = state.posed(&mut dynamics).foot(index) else {
                prop_assert_eq!(case.morphology.remaining(index), 0);
                continue;
            };
            // An independent way to the foot.
            let angles_rad: Vec<f64> = dynamics
                .joints()
                .zip(&state.joints_rad)
                .filter_map(|((leg, _), angle_rad)| (leg == index).then_some(*angle_rad))
                .collect();
            let tip_m = kinematics::foot_tip(leg, &angles_rad);
            prop_assert!((foot.point_m - tip_m).norm() < 1e-12);
            let mut jacobian = DMatrix::zeros(3, n);
            state.posed(&mut dynamics).foot_jacobian(&foot, &mut jacobian);
            let velocity = &jacobian * &state.velocities;
            let moving = state.moving(&mut dynamics);
            prop_assert!((&velocity - moving.foot_velocity_mps(&foot)).amax() < 1e-12);
            let drift = state.attitude * moving.foot_drift_mps2(&foot);
            // In the world, along the motion at constant velocities.
            let in_world = |time_s: f64| {
                let later = state.carried_on(time_s);
                let mut dynamics = dynamics.clone();
                let foot = later.posed(&mut dynamics).foot(index).unwrap();
                later.position_m + later.attitude * foot.point_m.coords
            };
            let seen = state.attitude.inverse() * rate(in_world);
            prop_assert!((&velocity - seen).amax() < 1e-6, "{velocity} {seen}");
            let in_world = |time_s: f64| {
                let later = state.carried_on(time_s);
                let mut dynamics = dynamics.clone();
                let moving = later.moving(&mut dynamics);
                let foot = moving.foot(index).unwrap();
                later.attitude * moving.foot_velocity_mps(&foot)
            };
            let seen = rate(in_world);
            prop_assert!((drift - seen).amax() < 1e-5, "{drift} {seen}");
            // Power in is power out, at another point of the link too.
            let other = foot.at(foot.point_m + Vector3::new(0.0, 0.01, -0.02));
            for foot in [foot, other] {
                let mut forces = DVector::zeros(n);
                let posed = state.posed(&mut dynamics);
                posed.add_force(&foot, &force_n, &mut forces);
                posed.foot_jacobian(&foot, &mut jacobian);
                prop_assert!((forces - jacobian.tr_mul(&force_n)).amax() < 1e-12);
            }
        }
    }

    /// Locked links are links whose joints do not move: M and C of the healthy robot, seen from
    /// the joints that are left. The control: links that are gone are not.
    #[test]
    fn locked_links_are_joints_that_stand_still(case in cases()) {
        let healthy = Morphology::healthy(&case.robot.layout());
        let mut whole = Dynamics::new(&case.robot, &healthy, LostLinks::Absent);
        let links: Vec<_> = whole.joints().collect();
        let state = case.state();
        let rows: Vec<usize> = (0..6)
            .chain((6..).zip(&links).filter_map(|(row, (leg, link))| {
                case.morphology.exists(*leg, *link).then_some(row)
            }))
            .collect();
        let full = state.with_joints(
            links.iter().map(|(leg, link)| case.robot.legs()[*leg].links[*link].locked_rad),
            &rows,
        );
        let (full_mass, full_coriolis) = (mass(&mut whole, &full), coriolis(&mut whole, &full));
        let seen = |full: &DMatrix<f64>| full.select_rows(&rows).select_columns(&rows);
        let (seen_mass, seen_coriolis) = (seen(&full_mass), seen(&full_coriolis));
        let of = |lost_links| {
            let mut dynamics = Dynamics::new(&case.robot, &case.morphology, lost_links);
            let mass = mass(&mut dynamics, &state);
            let apart = (&mass - &seen_mass).amax();
            apart.max((coriolis(&mut dynamics, &state) - &seen_coriolis).amax())
        };
        prop_assert!(of(LostLinks::Locked) < 1e-12);
        prop_assert_eq!(of(LostLinks::Absent) > 1e-3, !case.morphology.is_healthy());
    }
}

/// Total energy in 1 s of flight, at most this far from what it was, as a share of the kinetic.
const CONSERVED: f64 = 1e-9;

#[test]
fn a_limp_robot_in_flight_keeps_its_energy_and_momentum() {
    for (robot, lost) in robots().into_iter().zip(["3", "1,4,8", "2"]) {
        let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
        let assembly = Assembly::new(&robot, &morphology, LostLinks::Absent);
        let mut dynamics = Dynamics::of(&assembly);
        let n = dynamics.freedoms();
        let numbers: Vec<f64> = (0..100).map(|k| (0.9 * f64::from(k)).sin()).collect();
        let start = State::from_numbers(&numbers, n - 6);
        let energy_j = |state: &State, dynamics: &mut Dynamics| {
            let moving = state.moving(dynamics);
            let height_m = state.height_m(&moving.center_of_mass_m());
            (
                moving.kinetic_energy_j(),
                assembly.mass_kg() * 9.81 * height_m,
            )
        };
        let momentum = |state: &State, dynamics: &mut Dynamics| {
            let momentum = mass(dynamics, state) * &state.velocities;
            state.attitude * Vector3::from(momentum.fixed_rows::<3>(0))
        };
        let before = energy_j(&start, &mut dynamics);
        let first_momentum = momentum(&start, &mut dynamics);
        for damping_nm_s_per_rad in [0.0, 1e-3] {
            let torque_nm = |speed_rad_per_s: f64| -damping_nm_s_per_rad * speed_rad_per_s;
            let end = start.flown(&mut dynamics, torque_nm, 1.0, 0.000_5);
            let after = energy_j(&end, &mut dynamics);
            let lost_j = before.0 + before.1 - after.0 - after.1;
            let gained = momentum(&end, &mut dynamics) - first_momentum;
            let by_gravity = Vector3::new(0.0, 0.0, -9.81 * assembly.mass_kg());
            assert!((gained - by_gravity).norm() < 1e-8, "{gained}");
            // The control: joints with friction.
            if damping_nm_s_per_rad == 0.0 {
                assert!(
                    lost_j.abs() < CONSERVED * before.0,
                    "{lost_j} of {before:?} J"
                );
            } else {
                assert!(lost_j > 1e-3 * before.0, "{lost_j} of {before:?} J");
            }
        }
    }
}

/// Swings with its body held, from the rows of the joints of M, C and g alone.
#[test]
fn legs_that_swing_from_a_body_that_is_held_keep_their_energy() {
    const STEP_S: f64 = 0.000_5;
    let robot = Robot::jethexa();
    let morphology = Morphology::parse("111 110 000 111 100 111", &robot.layout()).unwrap();
    let assembly = Assembly::new(&robot, &morphology, LostLinks::Absent);
    let mut dynamics = Dynamics::of(&assembly);
    let n = dynamics.freedoms();
    let joints = n - 6;
    let mut start = State::from_numbers(&vec![0.2; 100], joints);
    start.velocities.fill(0.0);
    let energy_j = |state: &State, dynamics: &mut Dynamics| {
        let moving = state.moving(dynamics);
        let height_m = state.height_m(&moving.center_of_mass_m());
        moving.kinetic_energy_j() + assembly.mass_kg() * 9.81 * height_m
    };
    let mut swing = |with_coriolis: bool| {
        let mut state = start.clone();
        let first_j = energy_j(&state, &mut dynamics);
        let mut fastest = 0.0_f64;
        for _ in 0..(1.0 / STEP_S) as usize {
            let rates = |state: &State, dynamics: &mut Dynamics| {
                let mass = mass(dynamics, state);
                let coriolis = coriolis(dynamics, state);
                let mut forces = DVector::zeros(n);
                state.posed(dynamics).gravity_forces(&mut forces);
                if with_coriolis {
                    forces += coriolis * &state.velocities;
                }
                let held = mass.view((6, 6), (joints, joints)).into_owned();
                let of_joints = held.cholesky().unwrap().solve(&-forces.rows(6, joints));
                DVector::from_fn(n, |k, _| if k < 6 { 0.0 } else { of_joints[k - 6] })
            };
            state = state.stepped(STEP_S, |state| rates(state, &mut dynamics));
            fastest = fastest.max(state.velocities.amax());
        }
        assert!(fastest > 5.0, "{fastest} rad/s");
        (energy_j(&state, &mut dynamics) - first_j).abs()
    };
    let (apart_j, without_j) = (swing(true), swing(false));
    assert!(apart_j < 1e-7, "{apart_j} J");
    // The control: without Coriolis and centrifugal terms.
    assert!(without_j > 1e-3, "{without_j} J");
}

#[test]
fn a_payload_is_a_mass_on_the_body() {
    let robot = Robot::jethexa();
    let healthy = Morphology::healthy(&robot.layout());
    let bare = Assembly::new(&robot, &healthy, LostLinks::Absent);
    let payload = Payload {
        mass_kg: 0.4,
        position_m: [0.05, 0.02, 0.03],
    };
    let mut carrying = Dynamics::of(&bare.clone().carrying(&payload));
    let mut bare = Dynamics::of(&bare);
    let state = State::from_numbers(&[0.1; 100], 18);
    let difference = mass(&mut carrying, &state) - mass(&mut bare, &state);
    let point = Point3::from(payload.position_m);
    let arm = point.coords.cross_matrix();
    let mut expected = DMatrix::zeros(24, 24);
    expected.view_mut((0, 0), (3, 3)).fill_diagonal(0.4);
    expected.view_mut((0, 3), (3, 3)).copy_from(&(-arm * 0.4));
    expected.view_mut((3, 0), (3, 3)).copy_from(&(arm * 0.4));
    expected
        .view_mut((3, 3), (3, 3))
        .copy_from(&(-arm * arm * 0.4));
    assert!((difference - expected).amax() < 1e-12);
}

#[test]
fn nothing_is_allocated_after_construction() {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost("3", &robot.layout()).unwrap();
    let mut dynamics = Dynamics::new(&robot, &morphology, LostLinks::Absent);
    let n = dynamics.freedoms();
    let state = State::from_numbers(&[0.3; 100], n - 6);
    let (mut matrix, mut jacobian) = (DMatrix::zeros(n, n), DMatrix::zeros(3, n));
    let (mut forces, mut rates) = (DVector::zeros(n), DVector::zeros(n));
    let attitude = UnitQuaternion::identity();
    let counted = allocation_counter::measure(|| {
        let posed = dynamics.at(&attitude, &state.joints_rad);
        posed.mass_matrix(&mut matrix);
        posed.gravity_forces(&mut forces);
        let foot = posed.foot(0).unwrap();
        posed.foot_jacobian(&foot, &mut jacobian);
        posed.add_force(&foot, &Vector3::z(), &mut forces);
        let mut moving = posed.moving(&state.velocities);
        moving.coriolis_matrix(&mut matrix);
        moving.coriolis_forces(&mut rates);
        moving.bias_forces(&mut rates);
        moving.inverse(&state.velocities, &mut rates);
        moving.forward(&forces, &mut rates);
    });
    assert_eq!(counted.count_total, 0);
    // The control.
    let counted = allocation_counter::measure(|| drop(dynamics.clone()));
    assert!(counted.count_total > 0);
}
