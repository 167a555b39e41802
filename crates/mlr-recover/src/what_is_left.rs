//! What is left of a robot, as far as standing needs it.

use mlr_model::{Fault, LostLinks, Morphology, Payload, Robot, SimulationSettings, kinematics};
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
    /// What the body carries.
    pub payload: Option<Payload>,
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
            payload: None,
        }
    }

    /// The settings of a simulation with this damage.
    pub fn simulated(&self, settings: &SimulationSettings) -> SimulationSettings {
        SimulationSettings {
            lost_links: self.lost_links,
            faults: self.faults.clone(),
            payload: self.payload.or(settings.payload),
            ..settings.clone()
        }
    }

    /// Whether no link is lost and nothing else is wrong that a gait has to do with.
    pub fn is_sound(&self) -> bool {
        self.morphology.is_healthy() && self.faults.is_empty() && self.payload.is_none()
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
        if let Some(payload) = &self.payload {
            mass_kg += payload.mass_kg;
            moment += payload.mass_kg * Vector3::from(payload.position_m);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn with(faults: Vec<Fault>) -> WhatIsLeft {
        let healthy = Morphology::healthy(&Robot::jethexa().layout());
        WhatIsLeft {
            faults,
            ..WhatIsLeft::of(healthy)
        }
    }

    #[test]
    fn a_leg_is_folded_clear_of_the_ground_around_a_stuck_joint() {
        let robot = Robot::jethexa();
        let leg = &robot.legs()[3];
        let height_m = |angles_rad: &[f64]| kinematics::lowest_contact_m(leg, angles_rad).unwrap();
        let free: Vec<f64> = leg.links.iter().map(|link| link.locked_rad).collect();
        assert_eq!(with(vec![]).folded_rad(&robot, 3, 0.09), free);
        for (joint, angle_rad) in [
            (1, 0.6),
            (2, -0.6),
            (2, 0.3),
            (3, -2.0),
            (3, -1.2),
            (3, 0.5),
        ] {
            let left = with(vec![Fault::StuckJoint {
                leg: 4,
                joint,
                angle_rad,
            }]);
            let folded = left.folded_rad(&robot, 3, 0.09);
            assert_eq!(folded[joint - 1], angle_rad);
            let clear_m = height_m(&folded) + 0.09;
            assert!(clear_m > 0.02, "joint {joint} at {angle_rad}: {clear_m}");
            assert!(!left.can_walk(3) && left.can_walk(2));
        }
    }

    #[test]
    fn the_mass_is_that_of_all_parts_that_are_there() {
        let robot = Robot::jethexa();
        let leg_kg: f64 = robot.legs()[0].links.iter().map(|link| link.mass_kg).sum();
        let body_kg = robot.body().mass_kg;
        let lost = Morphology::parse_legs_lost("3", &robot.layout()).unwrap();
        let gone = WhatIsLeft::of(lost.clone());
        let walking = [0, 1, 3, 4];
        // Leg 6 is there and does not walk.
        let (mass_kg, moment) = gone.resting_mass(&robot, &walking, 0.09);
        assert!((mass_kg - body_kg - leg_kg).abs() < 1e-12);
        assert!(moment.x < 0.0 && moment.y < 0.0);
        let locked = WhatIsLeft {
            lost_links: LostLinks::Locked,
            ..gone
        };
        let (mass_kg, _) = locked.resting_mass(&robot, &walking, 0.09);
        assert!((mass_kg - body_kg - 2.0 * leg_kg).abs() < 1e-12);
        let loaded = WhatIsLeft {
            payload: Some(Payload {
                mass_kg: 0.5,
                position_m: [0.1, 0.0, 0.0],
            }),
            ..WhatIsLeft::of(lost)
        };
        let (mass_kg, loaded_moment) = loaded.resting_mass(&robot, &walking, 0.09);
        assert!((mass_kg - body_kg - leg_kg - 0.5).abs() < 1e-12);
        assert!((loaded_moment.x - moment.x - 0.05).abs() < 1e-12);
        assert!(!loaded.is_sound() && with(vec![]).is_sound());
    }
}
