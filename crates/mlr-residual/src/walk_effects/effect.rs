use std::{collections::BTreeMap, fmt::Debug};

use mlr_model::{Morphology, Robot};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::EffectParameter;
pub(super) use crate::effect_parameter::named;
use crate::walk::{Nuisance, WalkModel, WalkRecord};

/// Where on the robot an effect may sit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// It concerns the robot, its ground or its sensor as a whole.
    Robot,
    /// A leg, counted from 0.
    Leg(usize),
    /// A link of a leg and the joint at its inner end, both counted from 0.
    Link(usize, usize),
}

impl Place {
    /// Every leg that has a link left.
    pub(super) fn legs(morphology: &Morphology) -> Vec<Self> {
        (0..morphology.legs())
            .filter(|leg| morphology.remaining(*leg) > 0)
            .map(Self::Leg)
            .collect()
    }

    /// Every leg that has all its links, and with them a foot.
    pub(super) fn feet(morphology: &Morphology) -> Vec<Self> {
        (0..morphology.legs())
            .filter(|leg| morphology.remaining(*leg) == morphology.links(*leg))
            .map(Self::Leg)
            .collect()
    }

    /// Every link that is left.
    pub(super) fn links(morphology: &Morphology) -> Vec<Self> {
        let of_leg = |leg| (0..morphology.remaining(leg)).map(move |link| Self::Link(leg, link));
        (0..morphology.legs()).flat_map(of_leg).collect()
    }

    /// Number of the leg, from 1; 0 for the robot as a whole.
    pub(crate) fn leg(self) -> usize {
        match self {
            Self::Robot => 0,
            Self::Leg(leg) | Self::Link(leg, _) => leg + 1,
        }
    }

    /// Number of the link or joint, from 1.
    pub(crate) fn link(self) -> usize {
        match self {
            Self::Robot | Self::Leg(_) => 0,
            Self::Link(_, link) => link + 1,
        }
    }
}

/// Something that the model of a walk lacks.
///
/// `values` are those of the parameters, in the order of [`parameters()`](WalkEffect::parameters),
/// chosen such that the residual grows about in proportion to them; what people read comes from
/// [`report()`](WalkEffect::report).
pub trait WalkEffect: Sync + Debug {
    /// Name in reports.
    fn kind(&self) -> &'static str;

    /// What it leaves in the residual, in words.
    fn signature(&self) -> &'static str;

    /// Where it may sit on a robot that has lost these links.
    fn places(&self, robot: &Robot, morphology: &Morphology) -> Vec<Place> {
        let _ = (robot, morphology);
        vec![Place::Robot]
    }

    /// What is fitted, with priors and bounds.
    fn parameters(&self, place: Place, model: &WalkModel) -> Vec<EffectParameter>;

    /// Values from which it is fitted; the best counts.
    fn starts(&self, place: Place, model: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>>;

    /// Adds the effect to the model.
    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel);

    /// The parameters that people read, in the units of their names.
    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64>;

    /// Adds it to the model of a robot with these links, anywhere that it may sit and as large as its prior has it. Where
    /// it can sit nowhere, nothing changes.
    fn draw(&self, morphology: &Morphology, model: &mut WalkModel, generator: &mut ChaCha8Rng) {
        let places = self.places(&model.robot, morphology);
        if places.is_empty() {
            return;
        }
        let place = places[generator.random_range(0..places.len())];
        let parameters = self.parameters(place, model);
        let values = parameters
            .iter()
            .map(|parameter| parameter.value(mlr_model::standard_normal(generator)));
        let values: Vec<f64> = values.collect();
        self.apply(place, &values, model);
    }

    /// Nuisance parameters of the same quantity: a hypothesis with the effect goes without them, because
    /// its prior is so much wider.
    fn replaces(&self, place: Place) -> Vec<Nuisance> {
        let _ = place;
        Vec::new()
    }

    /// Values with which it does to a model what these changes of the nuisance parameters do that it replaces, one for
    /// each: logarithms of factors, and differences. `None` where only other values can be told.
    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        let _ = changes;
        None
    }

    /// Whether it acts on the sensor's signals only: the body walks as before.
    fn is_of_sensing(&self) -> bool {
        false
    }

    /// Whether it shifts the whole walk in time, which shows only in a log that tells
    /// when the walk was commanded.
    fn is_a_delay(&self) -> bool {
        false
    }
}
