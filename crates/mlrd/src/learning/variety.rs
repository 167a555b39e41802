//! Which of the healthy stretches is learned from next.

use std::{collections::VecDeque, sync::Arc};

use crate::monitor::WalkStretch;

/// Keeps the most different ones of the healthy stretches, and hands out the one that is least like
/// those learned from before: another ground, another heading, another time of the day tell more than
/// the same again.
#[derive(Debug)]
pub struct Variety {
    most: usize,
    kept: Vec<(Traits, Arc<WalkStretch>)>,
    learned: VecDeque<Traits>,
}

/// What stretches differ by, each in units of a remarkable difference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Traits([f64; 7]);

/// A tilt of the ground or of the walking body, a swing, and a time that make a difference.
const TILT_DEG: f64 = 0.5;
const SWING_DEG: f64 = 0.5;
const TIME_S: f64 = 600.0;
/// Stretches learned from that are remembered.
const REMEMBERED: usize = 16;

impl Traits {
    fn of(stretch: &WalkStretch) -> Self {
        let orientation = &stretch.recording.orientation;
        let angles = orientation.angles_rad();
        let from = orientation
            .times_s()
            .partition_point(|time_s| *time_s < stretch.from_s);
        let mean = |angles: &[f64]| angles.iter().sum::<f64>() / angles.len().max(1) as f64;
        let (roll, pitch, yaw) = (
            &angles.roll[from..],
            &angles.pitch[from..],
            &angles.yaw[from..],
        );
        let tilts_rad = [mean(roll), mean(pitch)];
        let squares = [(roll, tilts_rad[0]), (pitch, tilts_rad[1])].map(|(angles, mean_rad)| {
            let squares = angles.iter().map(|angle| (angle - mean_rad).powi(2));
            squares.sum::<f64>() / angles.len().max(1) as f64
        });
        let swing_deg = squares.iter().sum::<f64>().sqrt().to_degrees();
        let heading_rad = yaw.first().copied().unwrap_or(0.0);
        let in_mid_walk = stretch
            .walk_start
            .time_s()
            .is_none_or(|at_s| at_s < stretch.from_s);
        Self([
            tilts_rad[0].to_degrees() / TILT_DEG,
            tilts_rad[1].to_degrees() / TILT_DEG,
            heading_rad.cos(),
            heading_rad.sin(),
            swing_deg / SWING_DEG,
            stretch.from_s / TIME_S,
            f64::from(u8::from(in_mid_walk)),
        ])
    }

    fn distance(&self, other: &Self) -> f64 {
        let each = self.0.iter().zip(&other.0);
        each.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    fn nearest<'a>(&self, others: impl Iterator<Item = &'a Self>) -> f64 {
        others
            .map(|other| self.distance(other))
            .fold(f64::INFINITY, f64::min)
    }
}

impl Variety {
    /// One that keeps so many stretches at most.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            kept: Vec::new(),
            learned: VecDeque::new(),
        }
    }

    /// Takes a stretch; lets go of the one most like another when there are too many.
    pub fn offer(&mut self, stretch: WalkStretch) {
        self.kept.push((Traits::of(&stretch), Arc::new(stretch)));
        if self.kept.len() <= self.most {
            return;
        }
        let likeness = |index: &usize| {
            let others = self.kept.iter().enumerate().filter(|(i, _)| i != index);
            let others = others.map(|(_, (traits, _))| traits).chain(&self.learned);
            self.kept[*index].0.nearest(others)
        };
        let most_alike = (0..self.kept.len()).min_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        if let Some(index) = most_alike {
            self.kept.remove(index);
        }
    }

    /// The stretch to learn from, and another one, which stays, to compare calibrations on; none
    /// while there are no two.
    pub fn take_pair(&mut self) -> Option<(Arc<WalkStretch>, Arc<WalkStretch>)> {
        if self.kept.len() < 2 {
            return None;
        }
        let newness = |index: &usize| self.kept[*index].0.nearest(self.learned.iter());
        let next = (0..self.kept.len())
            .rev()
            .max_by(|a, b| newness(a).total_cmp(&newness(b)))?;
        let (traits, stretch) = self.kept.remove(next);
        let unlike = |(other, _): &&(Traits, Arc<WalkStretch>)| traits.distance(other);
        let compared = self
            .kept
            .iter()
            .max_by(|a, b| unlike(a).total_cmp(&unlike(b)))?;
        self.learned.push_back(traits);
        if self.learned.len() > REMEMBERED {
            self.learned.pop_front();
        }
        Some((stretch, Arc::clone(&compared.1)))
    }

    /// Forgets every stretch that is kept: the robot may have been damaged.
    pub fn clear(&mut self) {
        self.kept.clear();
    }
}

#[cfg(test)]
mod tests {
    use mlr_filter::{Axes, OrientationSeries};
    use mlr_ga::WalkStart;

    use super::*;

    /// A stretch on ground that is tilted by so much.
    fn stretch(from_s: f64, roll_deg: f64) -> WalkStretch {
        let times_s: Vec<f64> = (0..100)
            .map(|i| from_s - 0.2 + f64::from(i) * 0.01)
            .collect();
        let mut angles_rad = Axes::from_fn(|_| vec![0.0; times_s.len()]);
        angles_rad.roll.fill(f64::to_radians(roll_deg));
        WalkStretch {
            recording: OrientationSeries::new(times_s, angles_rad).unwrap().into(),
            walk_start: WalkStart::ObservedAtS(from_s),
            motion_start_s: Some(from_s),
            from_s,
        }
    }

    #[test]
    fn what_is_new_comes_first_and_is_compared_on_what_is_unlike_it() {
        let mut variety = Variety::new(4);
        variety.offer(stretch(10.0, 0.0));
        assert!(variety.take_pair().is_none(), "nothing to compare on");
        variety.offer(stretch(20.0, 0.0));
        let (first, compared) = variety.take_pair().unwrap();
        assert_eq!((first.from_s, compared.from_s), (10.0, 20.0));
        variety.offer(stretch(30.0, 2.0));
        variety.offer(stretch(40.0, 0.1));
        let (second, compared) = variety.take_pair().unwrap();
        assert_eq!((second.from_s, compared.from_s), (30.0, 20.0));
        variety.clear();
        assert!(variety.take_pair().is_none());
    }

    #[test]
    fn of_too_many_the_ones_most_alike_go() {
        let mut variety = Variety::new(3);
        for (from_s, roll_deg) in [
            (10.0, 0.0),
            (20.0, 3.0),
            (30.0, -3.0),
            (40.0, 0.02),
            (50.0, 3.02),
        ] {
            variety.offer(stretch(from_s, roll_deg));
        }
        let mut tilts: Vec<i64> = variety
            .kept
            .iter()
            .map(|(_, one)| {
                one.recording.orientation.angles_rad().roll[0]
                    .to_degrees()
                    .round() as i64
            })
            .collect();
        tilts.sort_unstable();
        assert_eq!(tilts, [-3, 0, 3]);
    }
}
