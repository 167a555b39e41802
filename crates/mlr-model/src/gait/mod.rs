//! What the robot is commanded to do.

mod body_motion;
mod file;
mod folded_walk;
mod foot_motion;
mod joint_trajectory;
mod joints_csv;
mod segment;
mod turn_in_place;

pub use body_motion::{BodyNod, LegPress};
pub use folded_walk::FoldedWalk;
pub use foot_motion::{FootMotion, FootTarget};
pub use joint_trajectory::JointTrajectory;
pub use segment::{LEAST_JERK_PEAK, MotionSegment, SegmentTiming, least_jerk_share};
pub use turn_in_place::TurnInPlace;

use std::fmt;

use mlr_filter::SettingError;

use crate::ModelError;

/// What an undamaged robot is commanded to do from gait time 0 on, over and over or once.
///
/// For gait time t ≤ 0 the robot stands. Whether a robot can follow is another question:
/// [`JointCommands`](crate::JointCommands).
#[derive(Clone, PartialEq)]
pub struct Gait {
    /// Name for people.
    pub name: String,
    /// T, the duration of one step cycle: the period whose harmonics the walk is made of.
    pub period_s: f64,
    /// The motion itself.
    pub motion: Motion,
}

/// The two ways to say how the legs move.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Feet swing and push back, all alike but for their phase.
    Feet(FootMotion),
    /// The angles of all joints over time.
    Joints(JointTrajectory),
}

impl Gait {
    /// The embedded nominal gait of the JetHexa, `data/gait/tripod.toml`.
    pub const TRIPOD_TOML: &str = include_str!("../../../../data/gait/tripod.toml");

    /// The most that needs to be read of a gait's file: two minutes of 24 joints at 50 Hz, every
    /// angle with all its digits.
    pub const MOST_FILE_BYTES: u64 = 4_000_000;

    /// The alternating tripod with a period of one second.
    pub fn tripod() -> Self {
        Self::from_toml(Self::TRIPOD_TOML).expect("the embedded gait is checked by a test")
    }

    /// Reads and checks a gait: a joint trajectory where the text has `joints_rad`, else the
    /// motion of feet.
    ///
    /// # Errors
    /// [`ModelError::Syntax`] with line and column when the text is not TOML of
    /// the expected form, [`ModelError::Setting`] when a value makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        file::parse(text)
    }

    /// The gait as [`Self::from_toml`] reads it. Joint angles are rounded to 1e-5 rad, a
    /// four-hundredth of what the JetHexa's servos resolve.
    pub fn to_toml(&self) -> String {
        file::write(self)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("period_s", self.period_s, 0.1..=60.0, "s")?;
        match &self.motion {
            Motion::Feet(feet) => feet.check(),
            Motion::Joints(joints) => {
                joints.check()?;
                self.check_repetition(joints)
            }
        }
    }

    /// What repeats must have the gait's period, or its harmonics are not those of the walk.
    fn check_repetition(&self, joints: &JointTrajectory) -> Result<(), SettingError> {
        let Some(cycle_s) = joints.cycle_s() else {
            return Ok(());
        };
        let periods = cycle_s / self.period_s;
        let whole = periods.round();
        if whole >= 1.0 && (periods - whole).abs() <= 1e-6 * whole {
            return Ok(());
        }
        let expected = format!(
            "the time that repeat_rows take, {cycle_s} s, or a whole fraction of it; or other rows"
        );
        Err(SettingError::new("period_s", self.period_s, expected))
    }

    /// The motion of the feet, of a gait that is described by it.
    pub fn feet(&self) -> Option<&FootMotion> {
        match &self.motion {
            Motion::Feet(feet) => Some(feet),
            Motion::Joints(_) => None,
        }
    }

    /// The same, to change it.
    pub fn feet_mut(&mut self) -> Option<&mut FootMotion> {
        match &mut self.motion {
            Motion::Feet(feet) => Some(feet),
            Motion::Joints(_) => None,
        }
    }

    /// After how long the commands repeat themselves, once they do; `None` of a motion that
    /// ends.
    pub fn cycle_s(&self) -> Option<f64> {
        match &self.motion {
            Motion::Feet(_) => Some(self.period_s),
            Motion::Joints(joints) => joints.cycle_s(),
        }
    }

    /// Gait time from which the commands repeat themselves; of a motion that ends, its end.
    pub fn steady_from_s(&self) -> f64 {
        match &self.motion {
            Motion::Feet(feet) => feet.ramp_s,
            Motion::Joints(joints) => joints.steady_from_s(),
        }
    }

    /// Gait time at which the last angles are commanded and held from then on; `None` of a
    /// motion that repeats itself.
    pub fn duration_s(&self) -> Option<f64> {
        match self.cycle_s() {
            Some(_) => None,
            None => Some(self.steady_from_s()),
        }
    }

    /// Gait time until which everything has been commanded once.
    pub fn first_pass_s(&self) -> f64 {
        self.steady_from_s() + self.cycle_s().unwrap_or(0.0)
    }

    /// Makes the whole gait take `by` times as long.
    pub fn slow_down(&mut self, by: f64) {
        self.period_s *= by;
        match &mut self.motion {
            Motion::Feet(feet) => feet.ramp_s *= by,
            Motion::Joints(joints) => joints.slow_down(by),
        }
    }
}

impl fmt::Debug for Gait {
    /// Flat like the gait's file. An atlas knows the gait that it was made for by this text.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut flat = f.debug_struct("Gait");
        flat.field("name", &self.name);
        flat.field("period_s", &self.period_s);
        match &self.motion {
            Motion::Feet(feet) => flat
                .field("ramp_s", &feet.ramp_s)
                .field("stride_m", &feet.stride_m)
                .field("lift_m", &feet.lift_m)
                .field("body_height_m", &feet.body_height_m)
                .field("swing_fraction", &feet.swing_fraction)
                .field("phase_offsets", &feet.phase_offsets),
            Motion::Joints(joints) => flat
                .field("row_s", &joints.row_s())
                .field("repeat_rows", &joints.repeat_rows())
                .field("joints_rad", &joints.rows_rad()),
        };
        flat.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 120 rows of two joints: 1 s of standing up, then 1.4 s over and over.
    fn shuffle(repeat_rows: Option<std::ops::Range<usize>>) -> Gait {
        let rows = (0..120).map(|row| vec![0.01 * f64::from(row), 0.0]);
        Gait {
            name: "shuffle".into(),
            period_s: 0.7,
            motion: Motion::Joints(
                JointTrajectory::new(0.02, rows.collect(), repeat_rows).unwrap(),
            ),
        }
    }

    #[test]
    fn feet_are_steady_after_the_ramp_and_repeat_every_period() {
        let mut gait = Gait::tripod();
        gait.period_s = 2.0;
        gait.feet_mut().unwrap().ramp_s = 3.0;
        assert_eq!(gait.steady_from_s(), 3.0);
        assert_eq!(gait.cycle_s(), Some(2.0));
        assert_eq!(gait.duration_s(), None);
        assert_eq!(gait.first_pass_s(), 5.0);
        gait.slow_down(1.5);
        assert_eq!((gait.steady_from_s(), gait.cycle_s()), (4.5, Some(3.0)));
    }

    #[test]
    fn a_trajectory_is_steady_where_it_repeats_or_ends() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let mut repeating = shuffle(Some(50..120));
        assert!(near(repeating.steady_from_s(), 1.0));
        assert!(near(repeating.cycle_s().unwrap(), 1.4));
        assert!(near(repeating.first_pass_s(), 2.4));
        assert_eq!(repeating.duration_s(), None);
        repeating.slow_down(1.5);
        assert!(near(repeating.steady_from_s(), 1.5));
        assert!(near(repeating.cycle_s().unwrap(), 2.1));
        assert!(near(repeating.period_s, 1.05));
        repeating.check().unwrap();

        let ending = shuffle(None);
        assert!(near(ending.steady_from_s(), 2.38));
        assert_eq!(ending.cycle_s(), None);
        assert!(near(ending.duration_s().unwrap(), 2.38));
        assert!(near(ending.first_pass_s(), 2.38));
    }

    #[test]
    fn what_repeats_has_the_period_of_the_gait() {
        let mut gait = shuffle(Some(50..120));
        for (period_s, fits) in [
            (1.4, true),
            (0.7, true),
            (0.35, true),
            (0.8, false),
            (2.8, false),
        ] {
            gait.period_s = period_s;
            assert_eq!(gait.check().is_ok(), fits, "{period_s}");
        }
        // Where nothing repeats there is nothing to compare the period with.
        gait = shuffle(None);
        gait.period_s = 0.8;
        gait.check().unwrap();
    }

    #[test]
    fn the_text_that_atlases_know_a_gait_by_is_that_of_a_flat_structure() {
        assert_eq!(
            format!("{:?}", Gait::tripod()),
            "Gait { name: \"tripod\", period_s: 1.0, ramp_s: 1.0, stride_m: 0.06, lift_m: 0.04, \
             body_height_m: 0.09, swing_fraction: 0.5, \
             phase_offsets: [0.0, 0.5, 0.5, 0.0, 0.0, 0.5] }"
        );
        let text = |gait: &Gait| format!("{gait:?}");
        assert_ne!(text(&shuffle(None)), text(&shuffle(Some(50..120))));
    }
}
