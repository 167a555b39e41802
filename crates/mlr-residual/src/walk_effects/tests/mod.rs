//! How walks change with effects: what a fit relies on.

mod drawing;
mod leaning;
mod mirroring;
mod neutrality;
mod starts;
mod swinging;
mod timing;
mod turning;

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{Gait, Morphology, Robot, SimulationSettings};

use super::{LIBRARY, Place, WalkEffect, find};
use crate::walk::{WalkModel, WalkRecord};

/// How long the robot of a record stands before it walks.
const STANDS_S: f64 = 1.0;

/// What a sensor without noise reports of walks, at the samples of one record.
struct Walks {
    record: WalkRecord,
    morphology: Morphology,
}

impl Walks {
    /// Of a whole robot that walks for so long, 3 to 12 s.
    fn lasting(walk_s: f64) -> Self {
        let rate_hz = 100.0;
        let samples = ((STANDS_S + walk_s + 2.0 * WalkRecord::PERIOD_S) * rate_hz) as usize;
        let times_s: Vec<f64> = (0..samples).map(|i| i as f64 / rate_hz).collect();
        let level = Axes::from_fn(|_| vec![0.0; samples]);
        let recording = OrientationSeries::new(times_s, level).unwrap();
        let record = WalkRecord::new(&recording, STANDS_S, true, STANDS_S, None).unwrap();
        Self {
            record,
            morphology: Morphology::healthy(&Robot::jethexa().layout()),
        }
    }

    fn of(&self, model: &WalkModel) -> Axes<Vec<f64>> {
        let samples = self.record.times_s().len();
        let body = model.walk(&self.morphology, &self.record, samples);
        let body = body.unwrap().expect("the walk stays finite");
        model.observe(&body, &self.record, samples)
    }

    /// With this effect alone on the robot as described.
    fn with(&self, kind: &str, place: Place, values: &[f64]) -> Axes<Vec<f64>> {
        self.of(&changed(described(), kind, place, values))
    }

    /// What an effect at these values adds to the robot as described.
    fn added(&self, kind: &str, place: Place, values: &[f64]) -> Axes<Vec<f64>> {
        less(&self.with(kind, place, values), &self.of(&described()))
    }

    /// Number of the sample so long after the start of the walk.
    fn at(&self, walked_s: f64) -> usize {
        let times_s = self.record.times_s();
        times_s.partition_point(|time_s| *time_s < STANDS_S + walked_s - 1e-9)
    }
}

fn described() -> WalkModel {
    WalkModel::nominal(
        Robot::jethexa(),
        Gait::tripod(),
        SimulationSettings::default(),
    )
}

/// A robot that turns to the left by some degrees per cycle: its middle left leg is weak.
fn turning() -> WalkModel {
    changed(described(), "weak_leg", Place::Leg(2), &[-1.5])
}

fn changed(mut model: WalkModel, kind: &str, place: Place, values: &[f64]) -> WalkModel {
    effect(kind).apply(place, values, &mut model);
    model
}

fn effect(kind: &str) -> &'static dyn WalkEffect {
    find(kind).expect("an effect of the library")
}

/// Every effect of the library at every place of a whole robot.
fn everywhere() -> impl Iterator<Item = (&'static dyn WalkEffect, Place)> {
    let robot = Robot::jethexa();
    let morphology = Morphology::healthy(&robot.layout());
    LIBRARY.iter().copied().flat_map(move |effect| {
        let places = effect.places(&robot, &morphology).into_iter();
        places.map(move |place| (effect, place))
    })
}

fn less(a: &Axes<Vec<f64>>, b: &Axes<Vec<f64>>) -> Axes<Vec<f64>> {
    let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    Axes {
        roll: difference(&a.roll, &b.roll),
        pitch: difference(&a.pitch, &b.pitch),
        yaw: difference(&a.yaw, &b.yaw),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Yaw at the last sample.
fn turn_deg(angles_deg: &Axes<Vec<f64>>) -> f64 {
    angles_deg.yaw.last().copied().expect("a walk has samples")
}

/// Root mean square over these samples of all axes.
fn rms(angles_deg: &Axes<Vec<f64>>, samples: std::ops::Range<usize>) -> f64 {
    let axes = [&angles_deg.roll, &angles_deg.pitch, &angles_deg.yaw];
    let squares = axes.map(|axis| {
        mean(
            &axis[samples.clone()]
                .iter()
                .map(|a| a * a)
                .collect::<Vec<_>>(),
        )
    });
    mean(&squares).sqrt()
}
