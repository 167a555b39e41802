//! What pose and velocities decide: Coriolis and centrifugal terms, inverse dynamics.

use std::ops::Deref;

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

use super::{
    BASE, Dynamics, Posed,
    spatial::{SpatialInertia, carried, carried_wrench, carrying_matrix, joined, momentum_matrix},
};

/// A robot in a pose and in motion; all that a [`Posed`] knows as well.
#[derive(Debug)]
pub struct Moving<'d> {
    pub(super) posed: Posed<'d>,
    /// Of the body.
    pub(super) twist: Vector6<f64>,
}

/// A link in motion; everything in the body frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MovingLink {
    pub(super) twist: Vector6<f64>,
    /// Less that of the body.
    relative: Vector6<f64>,
    /// Of its screw, seen from the body.
    screw_rate: Vector6<f64>,
    /// Acceleration that its joint adds to the part before it at constant speeds.
    pub(super) added: Vector6<f64>,
    /// Acceleration of the link while all velocities ν are constant.
    pub(super) drift: Vector6<f64>,
    /// Wrench that the inverse dynamics accelerate it with.
    wrench: Vector6<f64>,
}

impl<'d> Posed<'d> {
    /// The robot with the quasi-velocities ν, n rows.
    ///
    /// # Panics
    /// When `velocities` has not n rows.
    pub fn moving(self, velocities: &DVector<f64>) -> Moving<'d> {
        let n = self.dynamics.freedoms();
        assert_eq!(velocities.len(), n, "a vector of n");
        let body: Vector6<f64> = velocities.fixed_rows::<BASE>(0).into();
        let Dynamics {
            legs,
            placed,
            moving,
            ..
        } = &mut *self.dynamics;
        for leg in legs {
            let (mut twist, mut drift) = (body, Vector6::zeros());
            let mut relative = Vector6::zeros();
            for index in leg.links() {
                let screw = &placed[index].screw;
                let speed = velocities[BASE + index];
                let added = carried(&twist, screw) * speed;
                let screw_rate = carried(&relative, screw);
                twist += screw * speed;
                relative += screw * speed;
                drift += added;
                moving[index] = MovingLink {
                    twist,
                    relative,
                    screw_rate,
                    added,
                    drift,
                    wrench: Vector6::zeros(),
                };
            }
        }
        Moving {
            posed: self,
            twist: body,
        }
    }
}

impl<'d> Deref for Moving<'d> {
    type Target = Posed<'d>;

    fn deref(&self) -> &Posed<'d> {
        &self.posed
    }
}

impl Moving<'_> {
    /// C, n × n: the matrix for which C ν are the [`coriolis_forces`](Self::coriolis_forces) and
    /// dM/dt − 2 C is skew-symmetric.
    ///
    /// With J the Jacobian of a part's twist in the part's own frame, 𝓘 its inertia there and V
    /// its twist, C is the sum over the parts of `Jᵀ (𝓘 dJ/dt + B J)`, where B V = −ad_Vᵀ 𝓘 V. B is
    /// linear in the momentum and skew-symmetric, and M is the sum of Jᵀ 𝓘 J.
    ///
    /// # Panics
    /// When `coriolis` is not n × n.
    pub fn coriolis_matrix(&self, coriolis: &mut DMatrix<f64>) {
        let Dynamics {
            body,
            legs,
            placed,
            moving,
            ..
        } = &*self.posed.dynamics;
        let n = self.posed.dynamics.freedoms();
        assert_eq!(coriolis.shape(), (n, n), "a matrix of n × n");
        coriolis.fill(0.0);
        let mut whole = momentum_matrix(&body.momentum(&self.twist));
        for leg in legs {
            let mut beyond = SpatialInertia::none();
            // 𝓘 dJ/dt + B J for a twist that the body gives to the parts.
            let mut gyration = Matrix6::zeros();
            for outer in leg.links().rev() {
                let (place, motion) = (&placed[outer], &moving[outer]);
                beyond.add(&place.inertia);
                gyration += momentum_matrix(&place.inertia.momentum(&motion.twist))
                    - place.inertia.matrix() * carrying_matrix(&motion.relative);
                let column = beyond.momentum(&motion.screw_rate) + gyration * place.screw;
                let row = gyration.tr_mul(&place.screw);
                let momentum = beyond.momentum(&place.screw);
                let at = BASE + outer;
                for base in 0..BASE {
                    coriolis[(base, at)] = column[base];
                    coriolis[(at, base)] = row[base];
                }
                for inner in leg.first..outer {
                    coriolis[(BASE + inner, at)] = placed[inner].screw.dot(&column);
                    coriolis[(at, BASE + inner)] =
                        momentum.dot(&moving[inner].screw_rate) + row.dot(&placed[inner].screw);
                }
                coriolis[(at, at)] = place.screw.dot(&column);
            }
            whole += gyration;
        }
        coriolis
            .fixed_view_mut::<BASE, BASE>(0, 0)
            .copy_from(&whole);
    }

    /// C ν, n rows.
    ///
    /// # Panics
    /// When `forces` has not n rows.
    pub fn coriolis_forces(&mut self, forces: &mut DVector<f64>) {
        let still = Vector6::zeros();
        self.newton_euler(still, |_| 0.0, forces);
    }

    /// The bias: C ν + g, n rows.
    ///
    /// # Panics
    /// When `forces` has not n rows.
    pub fn bias_forces(&mut self, forces: &mut DVector<f64>) {
        let falling = joined(-self.gravity_mps2, nalgebra::Vector3::zeros());
        self.newton_euler(falling, |_| 0.0, forces);
    }

    /// Inverse dynamics: the generalised forces, n rows, that accelerate the robot with dν/dt:
    /// M dν/dt + C ν + g. Where nothing but the ground touches the body, the first six are the sum
    /// of Jᵀ f over the contacts; the joints' torques are the other rows less theirs.
    ///
    /// # Panics
    /// When one of the vectors has not n rows.
    pub fn inverse(&mut self, accelerations: &DVector<f64>, forces: &mut DVector<f64>) {
        let n = self.posed.dynamics.freedoms();
        assert_eq!(accelerations.len(), n, "a vector of n");
        let body: Vector6<f64> = accelerations.fixed_rows::<BASE>(0).into();
        // Who is held against gravity accelerates upward.
        let lifted = body - joined(self.gravity_mps2, nalgebra::Vector3::zeros());
        self.newton_euler(lifted, |index| accelerations[BASE + index], forces);
    }

    /// Kinetic energy of all parts, ½ νᵀ M ν.
    pub fn kinetic_energy_j(&self) -> f64 {
        let Dynamics {
            body,
            placed,
            moving,
            ..
        } = &*self.posed.dynamics;
        let links = placed.iter().zip(moving);
        let twice = links.fold(
            self.twist.dot(&body.momentum(&self.twist)),
            |sum, (place, motion)| sum + motion.twist.dot(&place.inertia.momentum(&motion.twist)),
        );
        twice / 2.0
    }

    /// Forces for an acceleration of the body and of each joint, from the body outward and back.
    fn newton_euler(
        &mut self,
        of_body: Vector6<f64>,
        of_joint: impl Fn(usize) -> f64,
        forces: &mut DVector<f64>,
    ) {
        let Dynamics {
            body,
            legs,
            placed,
            moving,
            ..
        } = &mut *self.posed.dynamics;
        assert_eq!(forces.len(), BASE + placed.len(), "a vector of n");
        let rate = |inertia: &SpatialInertia, twist: &Vector6<f64>, acceleration: &Vector6<f64>| {
            inertia.momentum(acceleration) + carried_wrench(twist, &inertia.momentum(twist))
        };
        let mut whole = rate(body, &self.twist, &of_body);
        for leg in legs {
            let mut acceleration = of_body;
            for index in leg.links() {
                let (place, motion) = (&placed[index], &mut moving[index]);
                acceleration += motion.added + place.screw * of_joint(index);
                motion.wrench = rate(&place.inertia, &motion.twist, &acceleration);
            }
            let mut beyond = Vector6::zeros();
            for index in leg.links().rev() {
                beyond += moving[index].wrench;
                forces[BASE + index] = placed[index].screw.dot(&beyond);
            }
            whole += beyond;
        }
        forces.fixed_rows_mut::<BASE>(0).copy_from(&whole);
    }
}
