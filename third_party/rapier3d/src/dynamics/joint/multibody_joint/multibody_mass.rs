// Not in rapier3d 0.36.1: mass matrices are assembled from what subtrees weigh together.

use crate::dynamics::RigidBody;
use crate::math::{Matrix, Real, Vector};
use crate::utils::{AngularInertiaOps, CrossProductMatrix};
use core::ops::AddAssign;

/// Where a link is and how it moves, about the anchor of the root's joint.
#[derive(Copy, Clone, Debug, Default)]
pub(crate) struct LinkMotion {
    /// Of the link's joint.
    anchor: PointMotion,
    /// Of its center of mass.
    com: PointMotion,
    angvel: Vector,
    parent_angvel: Vector,
}

/// A point of a multibody.
#[derive(Copy, Clone, Debug, Default)]
struct PointMotion {
    position: Vector,
    /// For each shift on the way from the root, its cross product with the sum of the angular velocities at its
    /// two ends, and three times the linear velocities of joints. The derivative of this point's
    /// velocity-dependent acceleration with respect to the velocity of a joint on the way, of axis `a`, has
    /// the term `a × (rate − rate of the joint's anchor)`.
    rate: Vector,
}

impl LinkMotion {
    /// The motion of a link on its parent, if any. Shifts lead from the parent's center of mass to the anchor,
    /// and on to the center of mass of the link.
    pub fn new(
        parent: Option<&Self>,
        shifts: [Vector; 2],
        joint_linvel: Vector,
        angvel: Vector,
    ) -> Self {
        let (anchor, parent_angvel) = match parent {
            None => (PointMotion::default(), Vector::ZERO),
            Some(parent) => {
                let anchor = PointMotion {
                    position: parent.com.position + shifts[0],
                    rate: parent.com.rate
                        + (parent.angvel + angvel).cross(shifts[0])
                        + 3.0 * joint_linvel,
                };
                (anchor, parent.angvel)
            }
        };
        let com = PointMotion {
            position: anchor.position + shifts[1],
            rate: anchor.rate + 2.0 * angvel.cross(shifts[1]),
        };
        Self {
            anchor,
            com,
            angvel,
            parent_angvel,
        }
    }
}

/// Sums over the links of a subtree: `m` their masses, `I` their inertias, `c` their centers of mass, `w` these
/// centers' rates, `ω` their angular velocities.
#[derive(Copy, Clone, Debug, Default)]
pub(crate) struct SubtreeMass {
    /// `Σ m`, along each axis.
    mass: Vector,
    /// `Σ m [c]`, `[c]` being the matrix of `c ×`.
    moment: Matrix,
    /// `Σ I − [c] m [c]`
    inertia: Matrix,
    /// `Σ m [w]`
    coriolis_v: Matrix,
    /// `Σ [ω] I − [I ω] − I [ω] − [c] m [w]`, of which the first two terms are the derivative of gyroscopic
    /// forces.
    coriolis_w: Matrix,
}

impl SubtreeMass {
    /// That of a single link.
    pub fn of_link(rb: &RigidBody, motion: &LinkMotion) -> Self {
        let mass = rb.mprops.effective_mass();
        let inertia = rb.mprops.effective_angular_inertia().into_matrix();
        let com = motion.com.position.gcross_matrix();
        let angvel = motion.angvel.gcross_matrix();
        let weighed = |matrix: Matrix| Matrix::from_diagonal(mass) * matrix;
        let moment = weighed(com);
        let coriolis_v = weighed(motion.com.rate.gcross_matrix());
        Self {
            mass,
            moment,
            inertia: inertia - com * moment,
            coriolis_v,
            coriolis_w: angvel * inertia
                - (inertia * motion.angvel).gcross_matrix()
                - inertia * angvel
                - com * coriolis_v,
        }
    }

    /// The momentum of the subtree with this velocity.
    pub fn momentum(&self, velocity: &Twist) -> Twist {
        Twist {
            linear: self.mass * velocity.linear - self.moment * velocity.angular,
            angular: self.inertia * velocity.angular - self.moment.transpose() * velocity.linear,
        }
    }

    /// The velocity-dependent force on the subtree for the velocity of a degree of freedom.
    pub fn coriolis(&self, dof: &DofMotion) -> Twist {
        let Twist { linear, angular } = self.momentum(&dof.rate);
        Twist {
            linear: linear - self.coriolis_v * dof.axis.angular,
            angular: angular + self.coriolis_w * dof.axis.angular,
        }
    }

    /// What `coriolis` multiplies an axis with, transposed, times a velocity of the subtree.
    pub fn tr_coriolis(&self, velocity: &Twist) -> Vector {
        self.coriolis_w.transpose() * velocity.angular
            - self.coriolis_v.transpose() * velocity.linear
    }
}

impl AddAssign for SubtreeMass {
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.moment += other.moment;
        self.inertia += other.inertia;
        self.coriolis_v += other.coriolis_v;
        self.coriolis_w += other.coriolis_w;
    }
}

/// A velocity, or a force, of the point of a body that is at the anchor of the root's joint.
#[derive(Copy, Clone, Debug, Default)]
pub(crate) struct Twist {
    pub linear: Vector,
    pub angular: Vector,
}

impl Twist {
    pub fn dot(&self, other: &Self) -> Real {
        self.linear.dot(other.linear) + self.angular.dot(other.angular)
    }
}

/// What the velocity of a degree of freedom does to the links that hang on it.
#[derive(Copy, Clone, Debug, Default)]
pub(crate) struct DofMotion {
    /// Their velocity.
    pub axis: Twist,
    /// The part of the derivative of their velocity-dependent acceleration that is the same for all of them.
    pub rate: Twist,
}

impl DofMotion {
    /// That of a degree of freedom of the joint of a link, from its column in the link's Jacobian.
    pub fn new(linear: Vector, angular: Vector, link: &LinkMotion) -> Self {
        let LinkMotion { anchor, com, .. } = link;
        let at_anchor = linear - angular.cross(com.position - anchor.position);
        let rate = (link.parent_angvel + link.angvel).cross(angular);
        Self {
            axis: Twist {
                linear: linear - angular.cross(com.position),
                angular,
            },
            rate: Twist {
                linear: 2.0 * link.parent_angvel.cross(at_anchor)
                    - rate.cross(anchor.position)
                    - angular.cross(anchor.rate),
                angular: rate,
            },
        }
    }
}
