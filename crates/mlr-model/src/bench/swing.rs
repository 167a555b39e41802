//! The bench as a rapier multibody of one joint.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rapier3d::prelude::RigidBodyBuilder;

use super::{Arm, Bench};
use crate::{
    Servo,
    rigid_mass::RigidMass,
    robot::rotation_about,
    simulation::{
        physics::{GRAVITY_MPS2, Physics, mass_properties},
        servo_state::{HINGE_AXIS, ServoState},
    },
};

/// A command to the servo, in force until the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// From when on, s.
    pub time_s: f64,
    /// Angle that it is to go to.
    pub goal_rad: f64,
    /// Whether its motor has current at all.
    pub motor_on: bool,
    /// Stiffness over that of the bench's servo.
    pub stiffness: f64,
    /// Stiffness and torque limit over those of the bench's servo.
    pub torque: f64,
}

impl Command {
    /// A servo with the gain and the supply of this command.
    pub fn servo(&self, servo: &Servo) -> Servo {
        Servo {
            stiffness_nm_per_rad: servo.stiffness_nm_per_rad * self.stiffness * self.torque,
            torque_limit_nm: servo.torque_limit_nm * self.torque,
            ..*servo
        }
    }
}

/// A pendulum on its servo, let go at rest.
pub struct Swing<'a> {
    bench: &'a Bench,
    commands: &'a [Command],
    time_step_s: f64,
    steps: usize,
    servo: ServoState,
    physics: Physics,
}

impl<'a> Swing<'a> {
    /// At rest at the reported angle `start_rad` when the first command comes. Commands are in the
    /// order of their times; each holds until the next.
    pub fn new(
        bench: &'a Bench,
        commands: &'a [Command],
        start_rad: f64,
        time_step_s: f64,
    ) -> Self {
        let mut swing = Self {
            bench,
            commands,
            time_step_s,
            steps: 0,
            servo: ServoState::at(start_rad),
            physics: Physics::new(Physics::parameters(time_step_s, 1)),
        };
        swing.hang(start_rad);
        swing
    }

    /// Hangs the arm on its shaft.
    fn hang(&mut self, start_rad: f64) {
        let physics = &mut self.physics;
        let shaft = physics.bodies.insert(RigidBodyBuilder::fixed());
        let arm = physics.bodies.insert(
            RigidBodyBuilder::dynamic()
                .can_sleep(false)
                .additional_mass_properties(mass_properties(&mass_of(&self.bench.arm))),
        );
        // Every joint of rapier turns about its own x axis; the shaft lies along y.
        let quarter = std::f64::consts::FRAC_PI_2;
        let turned = rotation_about(&Vector3::z(), quarter);
        let hinge = Isometry3::from_parts(Vector3::zeros().into(), turned);
        physics.hang(arm, shaft, &hinge, &hinge);
        physics.recompute_masses();
        // Until now rapier takes the shaft for a free body.
        physics.move_parts();
        if let Some(multibody) = physics.multibody_mut() {
            let armature = self.bench.servo.drive.armature_kg_m2;
            multibody.armature_mut().fill(armature as f32);
            multibody.apply_displacements(&[start_rad as f32]);
        }
        physics.move_parts();
    }

    /// The reported angle now and after every time step of so many; `None` where it does not stay
    /// finite.
    pub fn angles_rad(mut self, steps: usize) -> Option<Vec<f64>> {
        let mut angles_rad = Vec::with_capacity(steps + 1);
        angles_rad.push(self.angle_rad()?);
        for _ in 0..steps {
            self.step();
            angles_rad.push(self.angle_rad()?);
        }
        Some(angles_rad)
    }

    fn angle_rad(&self) -> Option<f64> {
        let angle_rad = f64::from(self.physics.multibody()?.link(1)?.joint.coords()[HINGE_AXIS]);
        angle_rad.is_finite().then_some(angle_rad)
    }

    /// Torque of the arm's weight on the shaft now, N m.
    fn weight_nm(&self) -> f64 {
        let arm = &self.bench.arm;
        let from_hanging_rad = self.angle_rad().unwrap_or_default() - arm.hanging_rad;
        let weight_n = arm.mass_kg * GRAVITY_MPS2;
        weight_n * arm.length_m * libm::sin(from_hanging_rad)
    }

    /// The command that acts now.
    fn command(&self) -> Option<&'a Command> {
        let first_s = self.commands.first()?.time_s;
        let passed_s = self.steps as f64 * self.time_step_s - self.bench.servo.latency_s;
        // A thousandth of a step is far above what rounding makes of equal times.
        let time_s = first_s + passed_s + 1e-3 * self.time_step_s;
        let later = self.commands.partition_point(|one| one.time_s <= time_s);
        self.commands.get(later.saturating_sub(1))
    }

    fn step(&mut self) {
        let command = self.command().copied();
        let weight_nm = self.weight_nm();
        self.steps += 1;
        if let Some(multibody) = self.physics.multibody_mut() {
            let speed_rad_per_s = multibody.generalized_velocity()[0];
            let motor_on = command.is_some_and(|command| command.motor_on);
            let Servo {
                damping_nm_s_per_rad: damping,
                drive,
                ..
            } = self.bench.servo;
            // A motor without current has no back EMF.
            let friction = drive.viscous_nm_s_per_rad + if motor_on { damping } else { 0.0 };
            multibody.damping_mut().fill(friction as f32);
            if let Some(link) = multibody.link_mut(1) {
                let friction_nm = match command {
                    Some(command) if motor_on => {
                        let servo = command.servo(&self.bench.servo);
                        let step_s = self.time_step_s;
                        let goal_rad = command.goal_rad;
                        self.servo.drive(
                            &servo,
                            goal_rad,
                            speed_rad_per_s,
                            Some(weight_nm),
                            step_s,
                            link,
                        )
                    }
                    _ => self
                        .servo
                        .release(&self.bench.servo, speed_rad_per_s, weight_nm, link),
                };
                multibody.frictions_mut().fill(friction_nm as f32);
            }
        }
        self.physics.step(&(GRAVITY_MPS2 * Vector3::z()));
    }
}

/// The arm in the frame of the joint, which is the world's at angle 0.
fn mass_of(arm: &Arm) -> RigidMass {
    let hanging = rotation_about(&Vector3::y(), -arm.hanging_rad);
    let center_m = hanging * Vector3::new(0.0, 0.0, -arm.length_m);
    let inertia = Matrix3::from_diagonal_element(arm.inertia_kg_m2);
    RigidMass::new(arm.mass_kg, center_m, inertia)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, bench::Reference};

    const STEP_S: f64 = 0.000_5;

    /// A limp servo on a pendulum of 0.5 kg at 0.1 m.
    fn bench(drive: Drive) -> Bench {
        Bench {
            name: "test".into(),
            arm: Arm {
                mass_kg: 0.5,
                length_m: 0.1,
                inertia_kg_m2: 0.0,
                hanging_rad: 0.0,
            },
            servo: Servo {
                stiffness_nm_per_rad: 5.0,
                damping_nm_s_per_rad: 0.05,
                torque_limit_nm: 1.0,
                speed_limit_rad_per_s: 1e3,
                command_hold_s: 0.01,
                latency_s: 0.0,
                drive,
            },
            reference: Reference::default(),
        }
    }

    fn command(goal_rad: f64, motor_on: bool) -> [Command; 1] {
        [Command {
            time_s: 0.0,
            goal_rad,
            motor_on,
            stiffness: 1.0,
            torque: 1.0,
        }]
    }

    fn swung(bench: &Bench, commands: &[Command], start_rad: f64, duration_s: f64) -> Vec<f64> {
        let steps = (duration_s / STEP_S).round() as usize;
        let swing = Swing::new(bench, commands, start_rad, STEP_S);
        swing.angles_rad(steps).unwrap()
    }

    /// Times between passages through the hanging position, doubled.
    fn period_s(angles_rad: &[f64]) -> f64 {
        let passed: Vec<usize> = (1..angles_rad.len())
            .filter(|k| angles_rad[k - 1] * angles_rad[*k] < 0.0)
            .collect();
        let between = passed[passed.len() - 1] - passed[0];
        2.0 * between as f64 * STEP_S / (passed.len() - 1) as f64
    }

    #[test]
    fn without_current_it_swings_as_a_pendulum_and_the_rotor_slows_it() {
        let free = swung(&bench(Drive::default()), &command(1.0, false), 0.1, 3.0);
        let expected_s = std::f64::consts::TAU * (0.1 / 9.81_f64).sqrt();
        assert!((period_s(&free) / expected_s - 1.0).abs() < 0.01);
        let last = free[5000..].iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        assert!((last - 0.1).abs() < 0.005, "no friction, {last}");

        let rotor = Drive {
            armature_kg_m2: 0.005,
            ..Drive::default()
        };
        let heavy = swung(&bench(rotor), &command(1.0, false), 0.1, 3.0);
        assert!((period_s(&heavy) / (expected_s * 2.0_f64.sqrt()) - 1.0).abs() < 0.01);
    }

    #[test]
    fn dry_friction_holds_what_weighs_less_and_no_more() {
        let sticky = |coulomb_nm| {
            let drive = Drive {
                coulomb_nm,
                ..Drive::default()
            };
            let angles = swung(&bench(drive), &command(0.0, false), 0.5, 2.0);
            angles[angles.len() - 1]
        };
        // At 0.5 rad the pendulum weighs 0.235 N m on the shaft.
        assert!((sticky(0.24) - 0.5).abs() < 1e-3);
        let slipped = sticky(0.22);
        assert!(slipped < 0.45, "{slipped}");
        // It stops where friction holds it, not at the bottom; without friction it does not stop.
        let slid = sticky(0.05);
        assert!(slid.abs() < 0.11, "{slid}");
    }

    #[test]
    fn the_servo_holds_the_arm_where_spring_and_weight_balance() {
        let held = swung(&bench(Drive::default()), &command(0.3, true), 0.0, 4.0);
        let angle = held[held.len() - 1];
        let (spring, weight) = (5.0 * (0.3 - angle), 0.5 * 9.81 * 0.1 * angle.sin());
        assert!((spring / weight - 1.0).abs() < 0.01, "{spring} {weight}");
        // A goal beyond what it can lift: the torque limit balances the weight.
        let mut weak = bench(Drive {
            back_emf: true,
            ..Drive::default()
        });
        weak.servo.torque_limit_nm = 0.3;
        let lifted = swung(&weak, &command(2.0, true), 0.0, 4.0);
        let weight = 0.5 * 9.81 * 0.1 * lifted[lifted.len() - 1].sin();
        assert!((weight - 0.3).abs() < 0.003, "{weight}");
    }

    #[test]
    fn back_emf_bounds_the_speed_that_a_limit_alone_does_not() {
        let fastest = |back_emf: bool| {
            let mut light = bench(Drive {
                back_emf,
                ..Drive::default()
            });
            light.arm.mass_kg = 0.01;
            let angles = swung(&light, &command(100.0, true), 0.0, 1.0);
            let step = angles.windows(2).map(|w| w[1] - w[0]);
            step.fold(0.0_f64, f64::max) / STEP_S
        };
        // 1 N m over 0.05 N m s/rad.
        let no_load = fastest(true);
        assert!((no_load / 20.0 - 1.0).abs() < 0.05, "{no_load}");
        assert!(fastest(false) > 2.0 * no_load);
    }

    #[test]
    fn commands_act_after_the_latency_and_turned_about_mirror_each_other() {
        let mut late = bench(Drive::default());
        late.servo.latency_s = 0.05;
        let commands = [command(0.0, true)[0], {
            Command {
                time_s: 0.1,
                ..command(0.2, true)[0]
            }
        }];
        let angles = swung(&late, &commands, 0.0, 0.3);
        let moved = angles.iter().position(|a| a.abs() > 1e-4).unwrap();
        let moved_s = moved as f64 * STEP_S;
        assert!((0.15..0.16).contains(&moved_s), "{moved_s}");
        let mirrored = commands.map(|one| Command {
            goal_rad: -one.goal_rad,
            ..one
        });
        let other = swung(&late, &mirrored, 0.0, 0.3);
        for (one, other) in angles.iter().zip(&other) {
            assert!((one + other).abs() < 1e-5);
        }
    }

    #[test]
    fn in_long_steps_a_servo_relaxes_as_one_with_more_damping() {
        let mut light = bench(Drive::default());
        light.arm.mass_kg = 0.001;
        light.servo = Servo {
            stiffness_nm_per_rad: 30.0,
            damping_nm_s_per_rad: 0.6,
            torque_limit_nm: 1e3,
            speed_limit_rad_per_s: 1e6,
            ..light.servo
        };
        let long_s = 0.005;
        // From 0.1 rad to 0 for 20 ms, which is the time constant of stiffness and damping.
        let after = |bench: &Bench, step_s: f64| -> f64 {
            let steps = (0.02 / step_s).round() as usize;
            let to_zero = command(0.0, true);
            let swing = Swing::new(bench, &to_zero, 0.1, step_s);
            swing.angles_rad(steps).unwrap()[steps]
        };
        let mut damped = light.clone();
        damped.servo.damping_nm_s_per_rad = light.servo.damping_in_steps_nm_s_per_rad(long_s);
        let [in_long_steps, fine, fine_and_damped] = [
            after(&light, long_s),
            after(&light, 1e-4),
            after(&damped, 1e-4),
        ];
        let off = (in_long_steps - fine_and_damped).abs();
        // The control: what is described, in fine steps.
        let uncorrected = (in_long_steps - fine).abs();
        assert!(
            off < 0.2 * uncorrected,
            "{in_long_steps} {fine} {fine_and_damped}"
        );
    }

    /// A servo with friction that follows a swinging goal, at times that all of the steps below meet.
    fn followed(step_s: f64) -> Vec<f64> {
        let sticky = bench(Drive {
            back_emf: true,
            armature_kg_m2: 0.0015,
            coulomb_nm: 0.02,
            load_friction: 0.2,
            ..Drive::default()
        });
        let commands: Vec<Command> = (0..300)
            .map(|k| {
                let time_s = f64::from(k) * 0.008;
                let goal_rad = libm::sin(time_s * time_s * 3.0);
                Command {
                    time_s,
                    ..command(goal_rad, true)[0]
                }
            })
            .collect();
        let each = (0.008 / step_s).round() as usize;
        let angles = Swing::new(&sticky, &commands, 0.0, step_s).angles_rad(300 * each);
        angles.unwrap().into_iter().step_by(each).collect()
    }

    #[test]
    fn steps_of_two_milliseconds_are_fine_enough_and_finer_ones_converge() {
        let finest = followed(0.000_25);
        let error_deg = |step_s: f64| {
            let pairs = followed(step_s).into_iter().zip(&finest);
            let squares: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
            (squares / finest.len() as f64).sqrt().to_degrees()
        };
        let [coarse, usual, fine] = [0.008, 0.002, 0.001].map(error_deg);
        assert!(usual < 0.6, "{usual}°");
        assert!(
            fine < 0.7 * usual && coarse > 2.0 * usual,
            "{coarse} {usual} {fine}"
        );
    }

    #[test]
    fn where_it_hangs_is_where_it_rests() {
        let mut turned = bench(Drive {
            viscous_nm_s_per_rad: 0.02,
            ..Drive::default()
        });
        turned.arm.hanging_rad = 0.4;
        let angles = swung(&turned, &command(0.0, false), 0.0, 6.0);
        assert!((angles[angles.len() - 1] - 0.4).abs() < 0.01);
    }
}
