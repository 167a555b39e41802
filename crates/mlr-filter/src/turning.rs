//! How far a robot turns in each cycle of its gait.

use thiserror::Error;

use crate::{
    MotionSettings, MotionStart, OrientationSeries, line::Line, motion_start::Fluctuation,
};

/// The part of a walk in which the commands repeat themselves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyWalk {
    /// When the robot started to walk.
    pub start: MotionStart,
    /// How long after that the commands begin to repeat.
    pub steady_from_s: f64,
    /// After how long they repeat.
    pub cycle_s: f64,
}

/// The change of yaw over each whole cycle of a walk, without the drift that yaw had while the robot
/// stood before.
#[derive(Debug, Clone, PartialEq)]
pub struct Turning {
    /// Change of yaw over each cycle, positive to the left. Never empty.
    cycles_rad: Vec<f64>,
    /// Rate of yaw while the robot stood.
    standing_rad_per_s: f64,
}

/// The recording does not tell how far the robot turns in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NoTurning {
    /// What a biased gyroscope adds to yaw is not known.
    #[error(
        "the log shows the robot standing for {stood_s:.1} s before it walks, expected at least \
         {needed_s:.1} s: they tell what the gyroscope's bias adds to yaw"
    )]
    NotStanding {
        /// For how long it stood.
        stood_s: f64,
        /// For how long it has to.
        needed_s: f64,
    },
    /// Not even one cycle.
    #[error(
        "too short: the log shows {walked_s:.1} s of walking, expected at least {needed_s:.1} s: the \
         way into the gait, and one whole cycle"
    )]
    NoCycle {
        /// For how long it walked.
        walked_s: f64,
        /// For how long it has to.
        needed_s: f64,
    },
}

/// The noise of an MPU-6050's rate, 0.004° per √s, then leaves 0.006 °/s of its bias.
const STANDING_S: f64 = 0.5;
/// A robot that walks moves in each of so many parts of a cycle, quiet moments or not.
const PARTS: usize = 4;

impl Turning {
    /// Of the walk in a recording whose time stamps increase, until the robot stands again.
    ///
    /// # Errors
    /// [`NoTurning`].
    pub fn of(
        recording: &OrientationSeries,
        walk: SteadyWalk,
        settings: &MotionSettings,
    ) -> Result<Self, NoTurning> {
        let (times_s, yaw_rad) = (recording.times_s(), &recording.angles_rad().yaw);
        let index = |time_s: f64| times_s.partition_point(|t| *t < time_s);
        let first_s = times_s.first().copied().unwrap_or(walk.start.start_s);
        let end_s = times_s.last().copied().unwrap_or(first_s);
        let started = index(walk.start.start_s);
        let stood_s = walk.start.start_s - first_s;
        if !walk.start.stood_before || stood_s < STANDING_S || started < 3 {
            return Err(NoTurning::NotStanding {
                stood_s,
                needed_s: STANDING_S,
            });
        }
        let standing_rad_per_s = Line::through(&times_s[..started], &yaw_rad[..started]).slope;
        let fluctuation = Fluctuation::of(recording, settings);
        let walks = |from: usize, to: usize| {
            let part = (to - from).div_ceil(PARTS);
            let mut parts = fluctuation.deg[from..to].chunks(part);
            parts.all(|part| part.iter().any(|deg| *deg > fluctuation.smallest_deg))
        };
        let steady_s = walk.start.start_s + walk.steady_from_s;
        let mut cycles_rad = Vec::new();
        loop {
            let from_s = steady_s + cycles_rad.len() as f64 * walk.cycle_s;
            let to_s = from_s + walk.cycle_s;
            let (from, to) = (index(from_s), index(to_s));
            if to >= times_s.len() || to <= from || !walks(from, to) {
                break;
            }
            let duration_s = times_s[to] - times_s[from];
            // Samples are not where cycles end: the same rate over a whole cycle.
            let rate_rad_per_s = (yaw_rad[to] - yaw_rad[from]) / duration_s - standing_rad_per_s;
            cycles_rad.push(rate_rad_per_s * walk.cycle_s);
        }
        if cycles_rad.is_empty() {
            return Err(NoTurning::NoCycle {
                walked_s: end_s - walk.start.start_s,
                needed_s: walk.steady_from_s + walk.cycle_s,
            });
        }
        Ok(Self {
            cycles_rad,
            standing_rad_per_s,
        })
    }

    /// How many cycles there are.
    pub fn cycles(&self) -> usize {
        self.cycles_rad.len()
    }

    /// Mean change of yaw in a cycle, positive to the left.
    pub fn mean_rad(&self) -> f64 {
        self.cycles_rad.iter().sum::<f64>() / self.cycles_rad.len() as f64
    }

    /// Standard deviation of the mean, by how much cycles differ; `None` of a single one.
    pub fn deviation_rad(&self) -> Option<f64> {
        let n = self.cycles_rad.len();
        let others = n.checked_sub(1).filter(|others| *others > 0)?;
        let mean_rad = self.mean_rad();
        let squares = self.cycles_rad.iter().map(|turn| (turn - mean_rad).powi(2));
        Some((squares.sum::<f64>() / (others * n) as f64).sqrt())
    }

    /// Rate of yaw while the robot stood, which is taken off.
    pub fn standing_rad_per_s(&self) -> f64 {
        self.standing_rad_per_s
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::Axes;

    /// Stands for `stand_s`, walks for `walk_s` with cycles of 2 s, during which yaw sways and turns,
    /// and stands again for 3 s; the gyroscope is biased all the time.
    fn recording(
        stand_s: f64,
        walk_s: f64,
        turn_rad: f64,
        bias_rad_per_s: f64,
    ) -> OrientationSeries {
        let times_s: Vec<f64> = (0..)
            .map(|i| f64::from(i) * 0.005)
            .take_while(|t| *t < stand_s + walk_s + 3.0)
            .collect();
        let walked_s = |t: f64| (t - stand_s).clamp(0.0, walk_s);
        let sway = |t: f64| 0.01 * (TAU * walked_s(t) / 2.0).sin();
        let yaw = |t: f64| sway(t) + turn_rad * walked_s(t) / 2.0 + bias_rad_per_s * t;
        let angles_rad = Axes {
            roll: times_s.iter().map(|t| sway(*t)).collect(),
            pitch: vec![0.0; times_s.len()],
            yaw: times_s.iter().map(|t| yaw(*t)).collect(),
        };
        OrientationSeries::new(times_s, angles_rad).unwrap()
    }

    fn turning(recording: &OrientationSeries) -> Result<Turning, NoTurning> {
        let settings = MotionSettings::default();
        let walk = SteadyWalk {
            start: MotionStart::find(recording, &settings).unwrap(),
            steady_from_s: 1.0,
            cycle_s: 2.0,
        };
        Turning::of(recording, walk, &settings)
    }

    proptest! {
        #[test]
        fn turns_are_found_whatever_the_bias(turn_deg in -10.0..10.0_f64, bias_dps in -3.0..3.0_f64) {
            let found = turning(&recording(2.0, 9.5, turn_deg.to_radians(), bias_dps.to_radians()));
            let found = found.unwrap();
            prop_assert_eq!(found.cycles(), 4);
            prop_assert!((found.mean_rad().to_degrees() - turn_deg).abs() < 0.05, "{:?}", found);
            prop_assert!((found.standing_rad_per_s().to_degrees() - bias_dps).abs() < 0.01);
            prop_assert!(found.deviation_rad().unwrap().to_degrees() < 0.05);
        }
    }

    #[test]
    fn a_robot_that_stands_again_walks_no_further() {
        // Of three more seconds, one cycle would fit.
        assert_eq!(turning(&recording(2.0, 5.2, 0.1, 0.0)).unwrap().cycles(), 2);
        let one = turning(&recording(2.0, 3.2, 0.1, 0.0)).unwrap();
        assert_eq!((one.cycles(), one.deviation_rad()), (1, None));
    }

    #[test]
    fn what_a_recording_cannot_tell_is_said() {
        let short = recording(2.0, 9.0, 0.1, 0.0);
        let until = short.times_s().partition_point(|t| *t < 4.5);
        let short = short.picked(&(0..until).collect::<Vec<_>>());
        let message = turning(&short).unwrap_err().to_string();
        assert!(message.contains("one whole cycle"), "{message}");
        let message = turning(&recording(0.3, 9.0, 0.1, 0.0)).unwrap_err();
        assert!(message.to_string().contains("standing for"), "{message}");
    }
}
