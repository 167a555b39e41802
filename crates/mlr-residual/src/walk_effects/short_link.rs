use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// A link has lost its outer end, with that part's share of the mass.
///
/// - `length_lost_m`: what is missing, in metres.
/// - Prior: 0.2 ± 0.13 of the link's length: a lost foot or a broken tip is a tenth to a third of
///   its link. Assumed, not measured.
/// - Bounds: 0 to 0.6 of the link's length.
#[derive(Debug)]
pub(super) struct ShortLink;

impl ShortLink {
    fn length_m(place: Place, robot: &Robot) -> f64 {
        let leg = robot.legs().get(place.leg() - 1);
        leg.and_then(|leg| leg.links.get(place.link() - 1))
            .map_or(0.0, |link| link.length_m)
    }
}

impl WalkEffect for ShortLink {
    fn kind(&self) -> &'static str {
        "short_link"
    }

    fn signature(&self) -> &'static str {
        "the body sinks towards that leg while it should stand"
    }

    /// Links that can touch the ground.
    fn places(&self, robot: &Robot, morphology: &Morphology) -> Vec<Place> {
        let mut places = Place::links(morphology);
        places.retain(|place| {
            let leg = &robot.legs()[place.leg() - 1];
            leg.links[place.link() - 1].contact.is_some()
        });
        places
    }

    fn parameters(&self, place: Place, model: &WalkModel) -> Vec<EffectParameter> {
        let length_m = Self::length_m(place, &model.robot);
        let prior = Prior::Normal {
            mean: 0.2 * length_m,
            deviation: 0.13 * length_m,
        };
        let lost = EffectParameter::new("length_lost_m", prior);
        vec![lost.bounds(0.0, 0.6 * length_m).neutral(0.0)]
    }

    fn starts(&self, place: Place, model: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let length_m = Self::length_m(place, &model.robot);
        vec![vec![0.1 * length_m], vec![0.3 * length_m]]
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.faults.push(Fault::ShortLink {
            leg: place.leg(),
            link: place.link(),
            length_lost_m: values[0],
        });
    }

    fn report(&self, place: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("leg", place.leg() as f64),
            ("link", place.link() as f64),
            ("length_lost_m", values[0]),
        ])
    }
}
