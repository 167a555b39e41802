//! Rapier with one multibody: what a walking robot and a servo on a bench have in common.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::rigid_mass::RigidMass;

/// Gravity, m/s² along z.
pub(crate) const GRAVITY_MPS2: f64 = -9.81;
/// Rapier's tolerances are made for objects of a metre; these are a tenth.
const LENGTH_UNIT: f32 = 0.1;

/// The parts of rapier, and the multibody in them.
pub(crate) struct Physics {
    pub(crate) bodies: RigidBodySet,
    pub(crate) colliders: ColliderSet,
    pub(crate) narrow_phase: NarrowPhase,
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd_solver: CCDSolver,
    multibody: Option<MultibodyIndex>,
}

impl Physics {
    /// Nothing yet, with these parameters.
    pub(crate) fn new(parameters: IntegrationParameters) -> Self {
        Self {
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            narrow_phase: NarrowPhase::new(),
            pipeline: PhysicsPipeline::new(),
            parameters,
            islands: IslandManager::new(),
            broad_phase: DefaultBroadPhase::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd_solver: CCDSolver::new(),
            multibody: None,
        }
    }

    /// Parameters of steps of so many seconds.
    pub(crate) fn parameters(time_step_s: f64, substeps: usize) -> IntegrationParameters {
        IntegrationParameters {
            dt: time_step_s as f32,
            num_solver_iterations: substeps,
            length_unit: LENGTH_UNIT,
            // Recycled contacts may be stale by millimetres, and a walking
            // robot is never fast enough to tunnel.
            contact_recycling: false,
            max_ccd_substeps: 0,
            ..Default::default()
        }
    }

    /// Hangs a new part on another by a revolute joint about the x axes of these frames.
    pub(crate) fn hang(
        &mut self,
        part: RigidBodyHandle,
        on: RigidBodyHandle,
        frame_on: &Isometry3<f64>,
        frame_of_part: &Isometry3<f64>,
    ) {
        let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
            .local_frame1(to_pose(frame_on))
            .local_frame2(to_pose(frame_of_part))
            .contacts_enabled(false);
        self.multibody_joints
            .insert(on, part, joint, true)
            .expect("every part is new, so no loop can close");
        self.multibody = self
            .multibody_joints
            .rigid_body_link(part)
            .map(|id| id.multibody);
    }

    /// Rapier would only do so during the first step.
    pub(crate) fn recompute_masses(&mut self) {
        for (_, part) in self.bodies.iter_mut() {
            part.recompute_mass_properties_from_colliders(&self.colliders);
        }
    }

    /// The multibody; `None` where nothing hangs on anything.
    pub(crate) fn multibody(&self) -> Option<&Multibody> {
        self.multibody_joints.get_multibody(self.multibody?)
    }

    /// The same, to be changed.
    pub(crate) fn multibody_mut(&mut self) -> Option<&mut Multibody> {
        self.multibody_joints.get_multibody_mut(self.multibody?)
    }

    /// Moves the parts to where the coordinates and velocities of the multibody have them.
    pub(crate) fn move_parts(&mut self) {
        let multibody = self
            .multibody
            .and_then(|index| self.multibody_joints.get_multibody_mut(index));
        if let Some(multibody) = multibody {
            multibody.forward_kinematics(&self.bodies, true);
            multibody.update_rigid_bodies(&mut self.bodies, true);
        }
    }

    /// Advances by one time step. Returns whether rapier had to take nothing out.
    pub(crate) fn step(&mut self, gravity_mps2: &Vector3<f64>) -> bool {
        self.pipeline.step(
            to_vector(gravity_mps2),
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd_solver,
            &(),
            &(),
        );
        self.pipeline.quarantine().is_empty()
    }
}

pub(crate) fn to_vector(vector: &Vector3<f64>) -> Vector {
    let [x, y, z] = vector.cast::<f32>().into();
    Vector::new(x, y, z)
}

fn to_rotation(rotation: &UnitQuaternion<f64>) -> Rotation {
    let [x, y, z, w] = rotation.coords.cast::<f32>().into();
    Rotation::from_xyzw(x, y, z, w)
}

pub(crate) fn to_pose(isometry: &Isometry3<f64>) -> Pose {
    Pose::from_parts(
        to_vector(&isometry.translation.vector),
        to_rotation(&isometry.rotation),
    )
}

pub(crate) fn mass_properties(mass: &RigidMass) -> MassProperties {
    let center: Vector3<f32> = mass.center_m().coords.cast();
    let inertia: Matrix3<f32> = mass.inertia_kg_m2().cast();
    MassProperties::with_inertia_matrix(
        Vector::new(center.x, center.y, center.z),
        mass.mass_kg() as f32,
        rapier3d::math::Matrix::from_cols_array_2d(&inertia.data.0),
    )
}
