use std::{collections::BTreeMap, fmt::Debug};

use mlr_model::{Morphology, Robot};

use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

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
    pub(super) fn link(self) -> usize {
        match self {
            Self::Robot | Self::Leg(_) => 0,
            Self::Link(_, link) => link + 1,
        }
    }
}

/// Something that the model of a walk lacks.
///
/// `values` are those of the parameters, chosen such that the trace grows about in
/// proportion to them; what people read comes from [`report()`](WalkEffect::report).
pub trait WalkEffect: Sync + Debug {
    /// Name in reports.
    fn kind(&self) -> &'static str;

    /// The trace that it leaves in the residual, for people.
    fn trace(&self) -> &'static str;

    /// Where it may sit on a robot that has lost these links.
    fn places(&self, robot: &Robot, morphology: &Morphology) -> Vec<Place> {
        let _ = (robot, morphology);
        vec![Place::Robot]
    }

    /// What is fitted: names, steps and bounds. The starting values do not matter.
    fn parameters(&self, place: Place, model: &WalkModel) -> Vec<Parameter>;

    /// Values from which it is fitted; the best counts.
    fn starts(&self, place: Place, model: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>>;

    /// Adds the effect to the model.
    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel);

    /// The parameters that people read, in the units of their names.
    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64>;

    /// How much less common an effect of this size is than a small one, or than others that do
    /// the same: twice the negative logarithm of its prior density, up to a constant.
    fn rarity(&self, values: &[f64]) -> f64 {
        let _ = values;
        0.0
    }

    /// What it gains by chance on robots that lack nothing, over what most effects do.
    fn chance_share(&self) -> f64 {
        1.0
    }

    /// Whether it acts on the sensor's signals only: the body walks as before.
    fn is_of_sensing(&self) -> bool {
        false
    }

    /// Whether the rates of the standing robot show it, which nothing else changes.
    fn shows_at_rest(&self) -> bool {
        false
    }

    /// Whether it shifts the whole walk in time, which shows only in a log that tells
    /// when the walk was commanded.
    fn is_a_delay(&self) -> bool {
        false
    }
}

/// A report of these names and values.
pub(super) fn named<'n>(values: impl IntoIterator<Item = (&'n str, f64)>) -> BTreeMap<String, f64> {
    values
        .into_iter()
        .map(|(name, value)| (name.to_string(), value))
        .collect()
}

/// How much later than usual something happens.
pub(super) fn delay() -> Parameter {
    Parameter::new("delay_s", 0.0)
        .step(0.005)
        .bounds(0.0, 0.5)
        .neutral(0.0)
        .usual(0.01)
}

/// Points on a circle of this radius.
pub(super) fn around(points: u32, radius: f64) -> Vec<[f64; 2]> {
    (0..points)
        .map(|point| {
            let angle_rad = std::f64::consts::TAU * f64::from(point) / f64::from(points);
            let (sin, cos) = libm::sincos(angle_rad);
            [radius * cos, radius * sin]
        })
        .collect()
}
