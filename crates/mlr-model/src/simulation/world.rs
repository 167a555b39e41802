//! The damaged robot as a rapier3d multibody on its ground.

use mlr_filter::Axes;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use super::{
    Simulator, contacts,
    leg_state::LegState,
    physics::{GRAVITY_MPS2, Physics, mass_properties, to_pose, to_vector},
    servo_state::ServoState,
};
use crate::{
    Fault, JointAxis, JointCommands, Morphology,
    assembly::{Assembly, LinkPart},
    kinematics,
    robot::{ContactShape, rotation_about},
};

/// One robot on one ground.
pub(super) struct World<'a> {
    /// Time from a command to its effect.
    latency_s: f64,
    legs: Vec<LegState<'a>>,
    time_step_s: f64,
    physics: Physics,
    body: RigidBodyHandle,
    /// In the order of the multibody's links.
    joints: Vec<Joint>,
    /// What each collider belongs to: the body is 0, leg i is i + 1.
    owners: Vec<(ColliderHandle, usize)>,
}

struct Joint {
    leg: usize,
    link: usize,
    servo: ServoState,
}

impl<'a> World<'a> {
    /// Sets the robot down on its feet, parallel to the ground, joints at the
    /// stance.
    pub(super) fn new(simulator: &'a Simulator, morphology: &Morphology) -> Self {
        let mut world = Self::empty(simulator);
        let faults = &simulator.settings.faults;
        let legs: Vec<LegState<'_>> = (0..simulator.robot.legs().len())
            .map(|leg| LegState::new(&simulator.robot, leg, faults))
            .collect();
        let start = start_pose(simulator, morphology, &legs);
        let body = simulator.robot.body();
        let mut assembly =
            Assembly::of_parts(body, &legs, morphology, simulator.settings.lost_links);
        if let Some(payload) = &simulator.settings.payload {
            assembly = assembly.carrying(payload);
        }
        world.body = world.physics.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(to_pose(&start))
                .can_sleep(false)
                .additional_mass_properties(mass_properties(&assembly.body)),
        );
        world.add_collider(
            contacts::body(body, &simulator.settings.contact),
            world.body,
            0,
        );
        for ((index, leg), left) in legs.iter().enumerate().zip(&assembly.legs) {
            world.add_leg(simulator, index, leg, &left.links, &start);
        }
        world.physics.recompute_masses();
        world.legs = legs;
        world.set_stance(&simulator.commands);
        let pull_n = to_vector(&pull_n(faults));
        world.physics.bodies[world.body].add_force(pull_n, true);
        world
    }

    fn empty(simulator: &'a Simulator) -> Self {
        let settings = &simulator.settings;
        let mut world = Self {
            latency_s: simulator.robot.servo().latency_s,
            legs: Vec::new(),
            time_step_s: settings.time_step_s,
            physics: Physics::new(contacts::solved(
                &settings.contact,
                Physics::parameters(settings.time_step_s, settings.substeps),
            )),
            body: RigidBodyHandle::invalid(),
            joints: Vec::new(),
            owners: Vec::new(),
        };
        let pose = Isometry3::from_parts(Translation3::identity(), simulator.ground_rotation);
        world.physics.colliders.insert(contacts::ground(
            simulator.ground.clone(),
            to_pose(&pose),
            &settings.contact,
        ));
        world
    }

    fn add_collider(&mut self, collider: Collider, part: RigidBodyHandle, owner: usize) {
        let Physics {
            bodies, colliders, ..
        } = &mut self.physics;
        let handle = colliders.insert_with_parent(collider, part, bodies);
        self.owners.push((handle, owner));
    }

    /// Hangs the links that are left of a leg on the body, each by a revolute joint.
    fn add_leg(
        &mut self,
        simulator: &Simulator,
        index: usize,
        state: &LegState<'_>,
        chain: &[LinkPart],
        start: &Isometry3<f64>,
    ) {
        let mut parent = self.body;
        for (link_index, link) in chain.iter().enumerate() {
            let part = self.physics.bodies.insert(
                RigidBodyBuilder::dynamic()
                    .pose(to_pose(start))
                    .can_sleep(false)
                    .additional_mass_properties(mass_properties(&link.mass)),
            );
            let hinge = hinge_frame(link.axis);
            self.physics
                .hang(part, parent, &(link.frame * hinge), &hinge);
            self.joints.push(Joint {
                leg: index,
                link: link_index,
                servo: ServoState::at(state.target_rad(&simulator.commands, link_index, 0.0)),
            });
            let ground = &simulator.settings.contact;
            for collider in contacts::links(link, ground, state.friction) {
                self.add_collider(collider, part, index + 1);
            }
            parent = part;
        }
    }

    /// Bends the joints to the stance and gives them the servo's damping and rotor; the
    /// free body keeps none of rapier's default damping.
    fn set_stance(&mut self, commands: &JointCommands) {
        let Some(multibody) = self.physics.multibody_mut() else {
            return;
        };
        let mut displacements = vec![0.0; multibody.ndofs()];
        multibody.damping_mut().fill(0.0);
        for (index, joint) in self.joints.iter().enumerate() {
            let freedom = multibody
                .link(index + 1)
                .map_or(0, MultibodyLink::assembly_id);
            let leg = &self.legs[joint.leg];
            displacements[freedom] = leg.target_rad(commands, joint.link, 0.0) as f32;
            let servo = leg.servo();
            let damping = servo.damping_nm_s_per_rad + servo.drive.viscous_nm_s_per_rad;
            multibody.damping_mut()[freedom] = damping as f32;
            multibody.armature_mut()[freedom] = servo.drive.armature_kg_m2 as f32;
        }
        multibody.apply_displacements(&displacements);
        self.physics.move_parts();
    }

    /// Drives the servos with the commands of gait time `time_s` and advances by
    /// one time step. Returns whether the state is still finite.
    pub(super) fn step(&mut self, commands: &JointCommands, time_s: f64) -> bool {
        self.drive_servos(commands, time_s - self.latency_s);
        let is_whole = self.physics.step(&(GRAVITY_MPS2 * Vector3::z()));
        let pose = self.physics.bodies[self.body].position();
        is_whole && pose.translation.is_finite() && pose.rotation.is_finite()
    }

    fn drive_servos(&mut self, commands: &JointCommands, command_time_s: f64) {
        let Some(multibody) = self.physics.multibody_mut() else {
            return;
        };
        for (index, joint) in self.joints.iter_mut().enumerate() {
            let Some(freedom) = multibody.link(index + 1).map(MultibodyLink::assembly_id) else {
                continue;
            };
            let speed_rad_per_s = multibody.generalized_velocity()[freedom];
            let leg = &self.legs[joint.leg];
            let command_rad = leg.target_rad(commands, joint.link, command_time_s);
            let Some(link) = multibody.link_mut(index + 1) else {
                continue;
            };
            let friction_nm = joint.servo.drive(
                leg.servo(),
                command_rad,
                speed_rad_per_s,
                None,
                self.time_step_s,
                link,
            );
            multibody.frictions_mut()[freedom] = friction_nm as f32;
        }
    }

    /// The body's in the world.
    fn pose(&self) -> Isometry3<f64> {
        let pose = self.physics.bodies[self.body].position();
        let (p, q) = (pose.translation, pose.rotation);
        let [x, y, z, w] = [q.x, q.y, q.z, q.w].map(f64::from);
        Isometry3::from_parts(
            [p.x, p.y, p.z].map(f64::from).into(),
            UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
        )
    }

    /// Roll, pitch and yaw of the body, yaw within ±π.
    pub(super) fn roll_pitch_yaw_rad(&self) -> Axes<f64> {
        let [x, y, z, w] = self.pose().rotation.coords.into();
        let sin_pitch = 2.0 * (w * y - z * x);
        Axes {
            roll: libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
            pitch: libm::asin(sin_pitch.clamp(-1.0, 1.0)),
            yaw: libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        }
    }

    pub(super) fn position_m(&self) -> [f64; 3] {
        self.pose().translation.vector.into()
    }

    /// Normal force of the ground on the body (first) and on each leg.
    pub(super) fn contact_force_n(&self) -> Vec<f64> {
        let mut force_n = vec![0.0; self.legs.len() + 1];
        for (collider, owner) in &self.owners {
            let impulse: f32 = self
                .physics
                .narrow_phase
                .contact_pairs_with(*collider)
                .map(ContactPair::total_impulse_magnitude)
                .sum();
            force_n[*owner] += f64::from(impulse) / self.time_step_s;
        }
        force_n
    }

    pub(super) fn energy_j(&self) -> f64 {
        self.physics
            .bodies
            .iter()
            .map(|(_, part)| {
                let height_m = f64::from(part.center_of_mass().z);
                let weight_n = f64::from(part.mass()) * -GRAVITY_MPS2;
                f64::from(part.kinetic_energy()) + weight_n * height_m
            })
            .sum()
    }

    pub(super) fn torque_nm(&self) -> Vec<f64> {
        self.joints
            .iter()
            .map(|joint| joint.servo.torque_nm())
            .collect()
    }
}

/// The sum of all pulls at the body, in the world.
fn pull_n(faults: &[Fault]) -> Vector3<f64> {
    let pulls = faults.iter().filter_map(|fault| match fault {
        Fault::ExternalForce { force_n } => Some(Vector3::from(*force_n)),
        _ => None,
    });
    pulls.sum()
}

/// Parallel to the ground at the origin, the lowest contact just above it.
fn start_pose(
    simulator: &Simulator,
    morphology: &Morphology,
    legs: &[LegState<'_>],
) -> Isometry3<f64> {
    let robot = &simulator.robot;
    let mut lowest_m = -robot.body().size_m.z / 2.0;
    for (index, state) in legs.iter().enumerate() {
        let leg = state.description();
        let angles_rad: Vec<f64> = (0..morphology.remaining(index))
            .map(|link| state.target_rad(&simulator.commands, link, 0.0))
            .collect();
        let tip = kinematics::foot_tip(leg, &angles_rad);
        let radius_m = match angles_rad
            .len()
            .checked_sub(1)
            .map(|last| leg.links[last].contact)
        {
            Some(Some(ContactShape::Capsule { radius_m } | ContactShape::Foot { radius_m })) => {
                radius_m
            }
            _ => 0.0,
        };
        lowest_m = lowest_m.min(tip.z - radius_m);
    }
    let terrain = &simulator.settings.terrain;
    let height_m = terrain.highest_m() + simulator.settings.start_clearance_m - lowest_m;
    let inclination = terrain.inclination();
    Isometry3::from_parts(
        (inclination * Vector3::new(0.0, 0.0, height_m)).into(),
        inclination,
    )
}

/// Turns x, rapier's free axis of a revolute joint, to the joint's own axis.
fn hinge_frame(axis: JointAxis) -> Isometry3<f64> {
    let towards = match axis {
        JointAxis::Yaw => Vector3::y(),
        JointAxis::Lift => Vector3::z(),
    };
    Isometry3::from_parts(
        Translation3::identity(),
        rotation_about(&towards, -std::f64::consts::FRAC_PI_2),
    )
}

#[cfg(test)]
mod tests;
