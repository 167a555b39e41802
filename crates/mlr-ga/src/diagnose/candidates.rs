//! Segments that a diagnosis motion may be made of.

use mlr_model::{BodyNod, FoldedWalk, Gait, JointAxis, LegPress, MotionSegment, Robot};

use crate::probe::{of_legs, varied};

/// What can be tried with a robot.
pub(super) struct Candidates<'r> {
    pub(super) robot: &'r Robot,
    /// Whose stance it stands in, and which it walks with legs folded.
    pub(super) gait: &'r Gait,
}

/// Step cycles of a walk at full stride or growing.
const CYCLES: usize = 2;
/// Other steps of the best walks: stride, lift and period over those of the gait.
const STEPS: [[f64; 3]; 4] = [
    [0.5, 1.0, 1.0],
    [1.3, 1.0, 1.0],
    [0.5, 1.5, 1.0],
    [1.0, 1.0, 1.5],
];
/// Of so many walks.
const VARIED: usize = 2;

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

    /// Walks with no leg, each leg, and each pair of legs folded.
    pub(super) fn walks(&self, most_folded_legs: usize) -> Vec<MotionSegment> {
        let folded = of_legs(self.robot.legs().len(), most_folded_legs).into_iter();
        let walks = folded.map(|folded_legs| FoldedWalk {
            folded_legs,
            gait: self.gait.clone(),
            cycles: CYCLES,
        });
        walks.map(MotionSegment::Walk).collect()
    }

    /// The first of these walks with other steps.
    pub(super) fn other_steps<'m>(
        &self,
        best_first: impl Iterator<Item = &'m MotionSegment>,
    ) -> Vec<MotionSegment> {
        let walks = best_first.filter_map(|motion| match motion {
            MotionSegment::Walk(walk) => Some(walk),
            MotionSegment::Press(_) | MotionSegment::Nod(_) => None,
        });
        let stepped = walks
            .take(VARIED)
            .flat_map(|walk| STEPS.map(|steps| varied(walk, steps)));
        stepped.map(MotionSegment::Walk).collect()
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
