use std::collections::BTreeMap;

use mlr_model::{Fault, JointCommands, Morphology, Robot};

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// A joint ignores its commands and holds one angle.
///
/// - `off_stance_rad`: that angle less the joint's angle in the stance, in radians; the sign is that
///   of the joint. People read `angle_rad`, the angle itself. No value of it makes a joint move.
/// - Prior: 0 ± 0.3 rad: a joint is stuck where it was, within the reach of its walk, or where it
///   was knocked to. Assumed, not measured.
/// - Bounds: ±1.2 rad.
#[derive(Debug)]
pub(super) struct StuckJoint;

/// How far off its stance a joint may be stuck.
const FARTHEST_RAD: f64 = 1.2;

impl StuckJoint {
    /// The angle of the joint in the stance, in which the gait begins.
    fn stance_rad(place: Place, model: &WalkModel) -> f64 {
        // A gait that the robot cannot follow is refused before it is simulated.
        JointCommands::new(&model.robot, &model.gait, 0.0).map_or(0.0, |commands| {
            commands.angle_rad(place.leg() - 1, place.link() - 1, 0.0)
        })
    }
}

impl WalkEffect for StuckJoint {
    fn kind(&self) -> &'static str {
        "stuck_joint"
    }

    fn signature(&self) -> &'static str {
        "that leg's share of every swing is missing, and the body leans if it is held off its stance"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::links(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 0.3,
        };
        vec![EffectParameter::new("off_stance_rad", prior).bounds(-FARTHEST_RAD, FARTHEST_RAD)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        // Fits of other effects also begin where these are absent. No value makes a stuck joint move, so its prior's mode
        // is one of the starts.
        [-0.5, -0.2, 0.0, 0.2, 0.5].map(|rad| vec![rad]).into()
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        let angle_rad = Self::stance_rad(place, model) + values[0];
        let (leg, joint) = (place.leg(), place.link());
        let fault = Fault::StuckJoint {
            leg,
            joint,
            angle_rad,
        };
        model.simulation.faults.push(fault);
    }

    fn replaces(&self, place: Place) -> Vec<Nuisance> {
        vec![Nuisance::JointZero(place.leg() - 1, place.link() - 1)]
    }

    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("leg", place.leg() as f64),
            ("joint", place.link() as f64),
            ("angle_rad", Self::stance_rad(place, model) + values[0]),
        ])
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, JointTrajectory, Motion, SimulationSettings};

    use super::*;

    #[test]
    fn the_stance_is_the_first_row_of_a_trajectory_and_else_that_of_the_feet() {
        let place = Place::Link(2, 1);
        let tripod = WalkModel::nominal(
            Robot::jethexa(),
            Gait::tripod(),
            SimulationSettings::default(),
        );
        let of_feet_rad = StuckJoint::stance_rad(place, &tripod);
        // The femur is lifted.
        assert!((0.3..0.9).contains(&of_feet_rad), "{of_feet_rad}");

        let joints = JointTrajectory::commanded(&tripod.robot, &tripod.gait, 1.0).unwrap();
        let mut rows_rad = joints.rows_rad().to_vec();
        let mut on_rows = tripod.clone();
        let mut stance_of = |rows_rad: &[Vec<f64>]| {
            let joints = JointTrajectory::new(0.02, rows_rad.to_vec(), None).unwrap();
            on_rows.gait.motion = Motion::Joints(joints);
            let reported = StuckJoint.report(place, &[0.1], &on_rows);
            reported["angle_rad"] - 0.1
        };
        assert!((stance_of(&rows_rad) - of_feet_rad).abs() < 1e-12);
        // The control: another first row is another stance, another second one is not.
        let femur = 3 * (place.leg() - 1) + place.link() - 1;
        rows_rad[1][femur] += 0.2;
        assert!((stance_of(&rows_rad) - of_feet_rad).abs() < 1e-12);
        rows_rad[0][femur] += 0.2;
        assert!((stance_of(&rows_rad) - of_feet_rad - 0.2).abs() < 1e-12);
    }
}
