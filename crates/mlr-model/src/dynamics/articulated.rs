//! Forward dynamics by articulated bodies (Featherstone, 1987), from the feet to the body and back.

use nalgebra::{DVector, Matrix6, Vector3, Vector6};

use super::{
    BASE, Dynamics, Moving,
    spatial::{carried_wrench, joined},
};

/// What a joint hands on to the part before it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ArticulatedLink {
    /// Momentum of what hangs on the joint, all joints beyond it free, per speed of the joint.
    momentum: Vector6<f64>,
    /// Inertia that the joint's torque moves, kg m².
    inertia_kg_m2: f64,
    /// Torque that is left to accelerate the joint.
    torque_nm: f64,
}

impl Moving<'_> {
    /// Forward dynamics: dν/dt, n rows, under generalised forces, n rows: torques of the joints,
    /// and Jᵀ f of all that touches the robot (see
    /// [`add_force`](super::Posed::add_force)). Gravity is added.
    ///
    /// # Panics
    /// When one of the vectors has not n rows.
    pub fn forward(&mut self, forces: &DVector<f64>, accelerations: &mut DVector<f64>) {
        let falling = joined(self.gravity_mps2, Vector3::zeros());
        let Dynamics {
            body,
            legs,
            placed,
            moving,
            articulated,
            ..
        } = &mut *self.posed.dynamics;
        let n = BASE + placed.len();
        assert_eq!(forces.len(), n, "a vector of n");
        assert_eq!(accelerations.len(), n, "a vector of n");
        let mut inertia = body.matrix();
        let mut wrench: Vector6<f64> = forces.fixed_rows::<BASE>(0).into();
        wrench -= carried_wrench(&self.twist, &body.momentum(&self.twist));
        for leg in legs.iter() {
            let mut beyond = Matrix6::zeros();
            let mut resistance = Vector6::zeros();
            for index in leg.links().rev() {
                let (place, motion) = (&placed[index], &moving[index]);
                beyond += place.inertia.matrix();
                resistance += carried_wrench(&motion.twist, &place.inertia.momentum(&motion.twist));
                let momentum = beyond * place.screw;
                let inertia_kg_m2 = place.screw.dot(&momentum);
                let torque_nm = forces[BASE + index] - place.screw.dot(&resistance);
                beyond -= momentum * momentum.transpose() / inertia_kg_m2;
                resistance += beyond * motion.added + momentum * (torque_nm / inertia_kg_m2);
                articulated[index] = ArticulatedLink {
                    momentum,
                    inertia_kg_m2,
                    torque_nm,
                };
            }
            inertia += beyond;
            wrench -= resistance;
        }
        // Positive definite, because every part has a mass: the factors always exist.
        let of_body = inertia
            .cholesky()
            .map_or(Vector6::repeat(f64::NAN), |factors| factors.solve(&wrench));
        for leg in legs.iter() {
            let mut acceleration = of_body;
            for index in leg.links() {
                let link = &articulated[index];
                acceleration += moving[index].added;
                let of_joint =
                    (link.torque_nm - link.momentum.dot(&acceleration)) / link.inertia_kg_m2;
                accelerations[BASE + index] = of_joint;
                acceleration += placed[index].screw * of_joint;
            }
        }
        // All of it falls besides.
        accelerations
            .fixed_rows_mut::<BASE>(0)
            .copy_from(&(of_body + falling));
    }
}
