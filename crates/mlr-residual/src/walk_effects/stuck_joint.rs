use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot, kinematics};
use nalgebra::Point3;

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
    /// The angle of the joint in the stance.
    fn stance_rad(place: Place, model: &WalkModel) -> f64 {
        let Some(leg) = model.robot.legs().get(place.leg() - 1) else {
            return 0.0;
        };
        let [x_m, y_m] = leg.nominal_foot_m;
        let foot = Point3::new(x_m, y_m, -model.gait.body_height_m);
        let angles_rad = kinematics::inverse(leg, foot).unwrap_or_default();
        angles_rad.get(place.link() - 1).copied().unwrap_or(0.0)
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
        [-0.5, -0.2, 0.2, 0.5].map(|rad| vec![rad]).into()
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
