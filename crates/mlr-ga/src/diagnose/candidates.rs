//! Segments that a diagnosis motion may be made of.

use mlr_model::{
    BodyNod, FoldedWalk, Gait, JointAxis, LegPress, MotionSegment, Robot, TurnInPlace,
};

use crate::probe::{FOLDED_CYCLES, varied};

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

/// Turns to either side by a right angle and by most of a half turn: what comes from the ground or pulls from
/// outside shows along other axes of the body then. A step is as long on the circle of the feet as
/// half a stride of the gait.
const TURN_STEP_RAD: f64 = 0.2;
const TURN_CYCLES: [usize; 2] = [4, 7];
/// Nods that load one side, slower than a servo's lag and faster.
const LARGE_NODS: [(f64, f64); 2] = [(8.0, 0.8), (8.0, 0.4)];
/// Steps on the spot: every change of the standing legs shakes the body.
const MARKED_CYCLES: usize = 3;

/// Strides of walks with a leg folded, over that of the gait.
const STRIDES: [f64; 2] = [1.0, 0.4];

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

    /// What a robot can do with all legs that it has: turn on the spot, nod, and mark time.
    pub(super) fn of_the_whole_body(&self) -> Vec<MotionSegment> {
        let sides = [1.0, -1.0];
        let turns = TURN_CYCLES.iter().flat_map(|&cycles| {
            sides.map(|side| {
                MotionSegment::Turn(TurnInPlace {
                    gait: self.gait.clone(),
                    step_rad: side * TURN_STEP_RAD,
                    cycles,
                })
            })
        });
        let nods = LARGE_NODS.iter().flat_map(|&(roll_deg, nod_s)| {
            sides.map(|side| {
                MotionSegment::Nod(BodyNod {
                    gait: self.gait.clone(),
                    roll_rad: f64::to_radians(side * roll_deg),
                    nod_s,
                })
            })
        });
        let mut marking = self.gait.clone();
        if let Some(feet) = marking.feet_mut() {
            feet.stride_m = 0.0;
        }
        let marked = MotionSegment::Walk(FoldedWalk {
            folded_legs: Vec::new(),
            gait: marking,
            cycles: MARKED_CYCLES,
        });
        turns.chain(nods).chain([marked]).collect()
    }

    /// Walks with one leg folded: the others carry more. Shorter steps tilt a robot with soft servos less. With two
    /// folded, a robot tips more than the model expects (`docs/probe.md`).
    pub(super) fn with_a_folded_leg(&self) -> Vec<MotionSegment> {
        let legs = 0..self.robot.legs().len();
        let walks = legs.flat_map(|leg| {
            let walk = FoldedWalk {
                folded_legs: vec![leg],
                gait: self.gait.clone(),
                cycles: FOLDED_CYCLES,
            };
            STRIDES.map(|stride| MotionSegment::Walk(varied(&walk, [stride, 1.0, 1.0])))
        });
        walks.collect()
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
        for whole in candidates.of_the_whole_body() {
            assert!(Gait::of_segments("test", 1.0, &robot, &[whole]).is_ok());
        }
        assert!(candidates.presses(&[]).is_empty());
        assert!(candidates.presses(&[6]).is_empty());
    }
}
