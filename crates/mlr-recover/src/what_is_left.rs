//! What is left of a robot, as far as standing needs it.

use mlr_model::{Fault, LostLinks, Morphology, Robot, kinematics};
use nalgebra::Vector3;

/// A robot with its damage.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIsLeft {
    /// The links that are still there.
    pub morphology: Morphology,
    /// Whether the others are gone or hang on.
    pub lost_links: LostLinks,
    /// What else is wrong.
    pub faults: Vec<Fault>,
}

/// Height over the ground that a leg which does not walk is held at, at least.
const CLEAR_M: f64 = 0.03;
/// Angles tried for each joint of a leg that does not come clear as its description says.
const TRIED_RAD: [f64; 9] = [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.3, 1.5];

impl WhatIsLeft {
    /// Nothing but lost links.
    pub fn of(morphology: Morphology) -> Self {
        Self {
            morphology,
            lost_links: LostLinks::default(),
            faults: Vec::new(),
        }
    }

    /// Whether a leg (from 0) can walk at all: all of its links are there, and none of its joints is
    /// stuck.
    pub fn can_walk(&self, leg: usize) -> bool {
        let whole = self.morphology.remaining(leg) == self.morphology.links(leg);
        whole && self.stuck(leg).next().is_none()
    }

    /// Whether a leg that can walk is weak.
    pub fn is_weak(&self, leg: usize) -> bool {
        let weak =
            |fault: &Fault| matches!(fault, Fault::WeakLeg { leg: one, .. } if *one == leg + 1);
        self.faults.iter().any(weak)
    }

    /// Joints of a leg (from 0) that are stuck, with their angles.
    fn stuck(&self, leg: usize) -> impl Iterator<Item = (usize, f64)> {
        self.faults.iter().filter_map(move |fault| match *fault {
            Fault::StuckJoint {
                leg: one,
                joint,
                angle_rad,
            } if one == leg + 1 => Some((joint - 1, angle_rad)),
            _ => None,
        })
    }

    /// The angles at which a leg that does not walk is held: those of locked links in the robot's
    /// description, or, where a stuck joint would keep them near the ground, those that hold it highest.
    pub(crate) fn folded_rad(&self, robot: &Robot, leg: usize, body_height_m: f64) -> Vec<f64> {
        let described = &robot.legs()[leg];
        let links = &described.links;
        let stuck: Vec<(usize, f64)> = self.stuck(leg).collect();
        let with_stuck = |mut angles_rad: Vec<f64>| {
            for (joint, angle_rad) in &stuck {
                angles_rad[*joint] = *angle_rad;
            }
            angles_rad
        };
        let there = self.morphology.remaining(leg);
        let height_m = |angles_rad: &[f64]| {
            let lowest = kinematics::lowest_contact_m(described, &angles_rad[..there]);
            lowest.map_or(f64::INFINITY, |lowest_m| lowest_m + body_height_m)
        };
        let locked = with_stuck(links.iter().map(|link| link.locked_rad).collect());
        if stuck.is_empty() || height_m(&locked) >= CLEAR_M {
            return locked;
        }
        // The first joint turns the leg about the vertical, which lifts nothing.
        let mut best = locked;
        for joint in 1..links.len() {
            let mut tried = Vec::new();
            for angle_rad in TRIED_RAD {
                let mut angles_rad = best.clone();
                angles_rad[joint] = angle_rad;
                tried.push(with_stuck(angles_rad));
            }
            for angles_rad in tried {
                if height_m(&angles_rad) > height_m(&best) {
                    best = angles_rad;
                }
            }
        }
        best
    }

    /// Mass of the body with all legs that do not walk, and its first moment in kg m, body frame.
    pub(crate) fn resting_mass(
        &self,
        robot: &Robot,
        walking: &[usize],
        body_height_m: f64,
    ) -> (f64, Vector3<f64>) {
        let body = robot.body();
        let mut mass_kg = body.mass_kg;
        let mut moment = body.mass_kg * body.center_of_mass_m.coords;
        for (leg, described) in robot.legs().iter().enumerate() {
            if walking.contains(&leg) {
                continue;
            }
            let angles_rad = self.folded_rad(robot, leg, body_height_m);
            let there = match self.lost_links {
                LostLinks::Absent => self.morphology.remaining(leg),
                LostLinks::Locked => described.links.len(),
            };
            let (of_leg_kg, of_leg) = kinematics::mass_moment(described, &angles_rad[..there]);
            mass_kg += of_leg_kg;
            moment += of_leg;
        }
        (mass_kg, moment)
    }
}
