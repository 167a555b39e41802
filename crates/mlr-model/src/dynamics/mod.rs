//! Equations of motion of what is left of a robot, in closed form.
//!
//! ```text
//! M(q) dν/dt + C(q, ν) ν + g(R, q) = τ + Σ J_kᵀ f_k
//! ```
//!
//! These are the Boltzmann-Hamel equations of the robot, d/dt ∂T/∂ν_k − ∂T/∂π_k + Σ γ ∂T/∂ν ν =
//! Q_k with T = ½ νᵀ M ν: the base's velocities are no time derivatives of coordinates but
//! quasi-velocities, and what their structure coefficients γ (the Lie bracket of SE(3)) add is part
//! of C. Nothing depends on where the robot is; its attitude R enters through gravity only.
//!
//! # Order of coordinates, frames, units
//! The n = 6 + joints quasi-velocities ν are
//!
//! | rows | what | unit |
//! |:--|:--|:--|
//! | 0 to 2 | velocity of the body's origin, along the axes of the body frame | m/s |
//! | 3 to 5 | angular velocity of the body, along the axes of the body frame | rad/s |
//! | 6 on | speeds of the joints that are left, leg by leg from the body outward | rad/s |
//!
//! [`Dynamics::joints`] names the joint of each row. Generalised forces have the same order: force
//! on the body in N, moment about its origin in N m, torques of the joints in N m. The first three
//! rows of dν/dt are the derivatives of the components in the turning body frame: the acceleration
//! of the origin less ω × v. Angles have the signs and zeros of [`Link`](crate::Link); they are
//! true ones, not commands. Points, forces and Jacobians of feet are in the body frame.
//!
//! # Use
//! A [`Dynamics`] is made once for a robot and a [`Morphology`]; everything it needs is allocated
//! then. Another morphology is another vector in that call and nothing else. [`Dynamics::at`]
//! takes the pose, [`Posed::moving`] the velocities:
//!
//! ```
//! use mlr_model::{LostLinks, Morphology, Robot, dynamics::Dynamics};
//! use nalgebra::{DMatrix, DVector, UnitQuaternion};
//!
//! let robot = Robot::jethexa();
//! let legs_3_and_4_lost = Morphology::parse_legs_lost("3,4", &robot.layout())?;
//! let mut dynamics = Dynamics::new(&robot, &legs_3_and_4_lost, LostLinks::Absent);
//! let n = dynamics.freedoms();
//! assert_eq!(n, 6 + 12);
//!
//! let joints_rad = [0.0, 0.5, -1.8].repeat(4);
//! let level = UnitQuaternion::identity();
//! let mut posed = dynamics.at(&level, &joints_rad);
//! let mut mass = DMatrix::zeros(n, n);
//! posed.mass_matrix(&mut mass);
//! let total_kg = 1.369 + 4.0 * (0.02556 + 0.08807 + 0.08993);
//! assert!((mass[(0, 0)] - total_kg).abs() < 1e-12);
//!
//! // In free fall, from rest, nothing but the body's origin accelerates.
//! let mut falling = posed.moving(&DVector::zeros(n));
//! let mut acceleration = DVector::zeros(n);
//! falling.forward(&DVector::zeros(n), &mut acceleration);
//! assert!((acceleration[2] + 9.81).abs() < 1e-9);
//! assert!(acceleration.rows(3, n - 3).norm() < 1e-9);
//! # Ok::<(), mlr_model::ModelError>(())
//! ```
//!
//! Legs are branches that only meet in the body, so no term between two legs is computed; all sums
//! run once from the feet to the body (composite bodies for M, C and g, recursive Newton-Euler for
//! inverse, articulated bodies for forward dynamics), with all quantities in the body frame.

mod articulated;
mod contact;
mod motion;
mod pose;
mod spatial;

pub use contact::Foot;
pub use motion::Moving;
pub use pose::Posed;

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::{Assembly, LostLinks, Morphology, Robot};
use articulated::ArticulatedLink;
use motion::MovingLink;
use pose::PlacedLink;
use spatial::SpatialInertia;

/// Freedoms of the body.
pub(super) const BASE: usize = 6;

/// The equations of motion of one robot with one morphology.
#[derive(Debug, Clone)]
pub struct Dynamics {
    body: SpatialInertia,
    legs: Vec<Leg>,
    links: Vec<Link>,
    placed: Vec<PlacedLink>,
    moving: Vec<MovingLink>,
    articulated: Vec<ArticulatedLink>,
}

/// Where a leg's links are among all.
#[derive(Debug, Clone, Copy)]
struct Leg {
    first: usize,
    end: usize,
}

#[derive(Debug, Clone)]
struct Link {
    leg: usize,
    link: usize,
    frame: Isometry3<f64>,
    axis: Vector3<f64>,
    length_m: f64,
    mass_kg: f64,
    center_m: Vector3<f64>,
    /// About the centre of mass, along the link's axes.
    inertia_kg_m2: Matrix3<f64>,
}

impl Dynamics {
    /// Of what `morphology` leaves of `robot`.
    ///
    /// # Panics
    /// When `morphology` belongs to a robot with other legs.
    pub fn new(robot: &Robot, morphology: &Morphology, lost_links: LostLinks) -> Self {
        Self::of(&Assembly::new(robot, morphology, lost_links))
    }

    /// Of these parts.
    pub fn of(assembly: &Assembly) -> Self {
        let mut legs = Vec::with_capacity(assembly.legs.len());
        let mut links = Vec::new();
        for (leg, left) in assembly.legs.iter().enumerate() {
            let first = links.len();
            links.extend(left.links.iter().enumerate().map(|(link, part)| Link {
                leg,
                link,
                frame: part.frame,
                axis: part.axis.direction(),
                length_m: part.length_m,
                mass_kg: part.mass.mass_kg(),
                center_m: part.mass.center_m().coords,
                inertia_kg_m2: *part.mass.inertia_kg_m2(),
            }));
            legs.push(Leg {
                first,
                end: links.len(),
            });
        }
        Self {
            body: SpatialInertia::of(&assembly.body),
            placed: vec![PlacedLink::default(); links.len()],
            moving: vec![MovingLink::default(); links.len()],
            articulated: vec![ArticulatedLink::default(); links.len()],
            legs,
            links,
        }
    }

    /// n, the number of quasi-velocities.
    pub fn freedoms(&self) -> usize {
        BASE + self.links.len()
    }

    /// Leg and link, both from 0, of the joint of each row from 6 on.
    pub fn joints(&self) -> impl Iterator<Item = (usize, usize)> {
        self.links.iter().map(|link| (link.leg, link.link))
    }
}

impl Leg {
    fn links(self) -> std::ops::Range<usize> {
        self.first..self.end
    }
}
