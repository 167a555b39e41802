use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot, kinematics};
use nalgebra::Point3;

use super::{Place, WalkEffect, effect::named, joint_offset::USUAL_RAD};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// A joint ignores its commands.
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

    fn trace(&self) -> &'static str {
        "that leg's share of every swing is missing, and the body leans if it is held off its stance"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::links(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        vec![
            Parameter::new("off_stance_rad", 0.0)
                .step(0.04)
                .bounds(-FARTHEST_RAD, FARTHEST_RAD),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-0.35], vec![-0.1], vec![0.1], vec![0.35]]
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

    /// A joint may be stuck anywhere; one that is only off its zero, which the walk may not
    /// tell from it where the joint has little to do, is off by so much at most.
    fn rarity(&self, _: &[f64]) -> f64 {
        let offset_rad = USUAL_RAD * std::f64::consts::TAU.sqrt();
        2.0 * (2.0 * FARTHEST_RAD / offset_rad).ln()
    }

    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("leg", place.leg() as f64),
            ("joint", place.link() as f64),
            ("angle_rad", Self::stance_rad(place, model) + values[0]),
        ])
    }
}
