//! Segments that a diagnosis motion may be made of.

use mlr_model::{BodyNod, Gait, JointAxis, LegPress, MotionSegment, Robot};

/// What can be tried with a robot.
pub(super) struct Candidates<'r> {
    pub(super) robot: &'r Robot,
    /// Whose stance it stands in.
    pub(super) gait: &'r Gait,
}

/// How far the body is lowered for pressing. Lower, knees bend further than servos of the JetHexa go.
const LOWERED_M: [f64; 2] = [0.0, 0.03];
/// Angles to which a leg presses: from where a straight leg just reaches the ground to straight down.
const PRESSING_DEG: [f64; 6] = [-25.0, -35.0, -45.0, -55.0, -65.0, -80.0];
/// What is outside of the joint that presses is bent up by so much, away from the ground. Bus servos
/// turn by 120° either way.
const BENT_UP_DEG: f64 = 110.0;
/// Slowly enough that the robot does not sway.
const PRESS_S: f64 = 0.5;
const HOLD_S: f64 = 0.3;
/// The second time shows what is chance.
const TIMES: usize = 2;

/// Far beyond what a standing robot sways, and less than any bound on tilt that makes sense.
const NOD_DEG: f64 = 3.0;
const NOD_S: f64 = 0.25;

impl Candidates<'_> {
    /// Each leg in doubt presses with its first link that turns up and down.
    pub(super) fn presses(&self, legs: &[usize]) -> Vec<MotionSegment> {
        let depths = || {
            LOWERED_M
                .iter()
                .flat_map(|low_m| PRESSING_DEG.map(|deg| (*low_m, deg)))
        };
        let of_leg = |&leg: &usize| {
            let links = &self.robot.legs().get(leg)?.links;
            let joint = links
                .iter()
                .position(|link| link.joint == JointAxis::Lift)?;
            Some(depths().map(move |(lowered_m, pressing_deg)| {
                let pose_rad = links.iter().enumerate().map(|(index, link)| {
                    match (index.cmp(&joint), link.joint) {
                        (std::cmp::Ordering::Equal, _) => pressing_deg.to_radians(),
                        (std::cmp::Ordering::Greater, JointAxis::Lift) => BENT_UP_DEG.to_radians(),
                        _ => link.posture_rad,
                    }
                });
                MotionSegment::Press(LegPress {
                    gait: self.gait.clone(),
                    leg,
                    pose_rad: pose_rad.collect(),
                    joint,
                    lowered_m,
                    press_s: PRESS_S,
                    hold_s: HOLD_S,
                    times: TIMES,
                })
            }))
        };
        legs.iter().filter_map(of_leg).flatten().collect()
    }
}

/// How a motion begins.
pub(super) fn opening(gait: &Gait) -> MotionSegment {
    MotionSegment::Nod(BodyNod {
        gait: gait.clone(),
        roll_rad: NOD_DEG.to_radians(),
        nod_s: NOD_S,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_presses_with_its_femur_and_everything_outside_bent_up() {
        let (robot, gait) = (Robot::jethexa(), Gait::tripod());
        let candidates = Candidates {
            robot: &robot,
            gait: &gait,
        };
        let presses = candidates.presses(&[2]);
        assert_eq!(presses.len(), LOWERED_M.len() * PRESSING_DEG.len());
        for press in &presses {
            let MotionSegment::Press(press) = press else {
                panic!("{press:?}");
            };
            assert_eq!((press.leg, press.joint), (2, 1));
            assert!(press.pose_rad[1] < 0.0 && press.pose_rad[2] > 1.5);
            // The robot can do it.
            let alone = MotionSegment::Press(press.clone());
            assert!(Gait::of_segments("test", 1.0, &robot, &[alone]).is_ok());
        }
        assert!(candidates.presses(&[]).is_empty());
        assert!(candidates.presses(&[6]).is_empty());
    }
}
