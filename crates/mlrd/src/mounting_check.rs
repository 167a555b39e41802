//! Whether the sensor is mounted as the settings say, as far as gravity shows it.

use mlr_imu::{ImuSample, Mounting, STANDARD_GRAVITY_MPS2};
use nalgebra::Vector3;

/// Watches which way is up when a robot is first heard of.
///
/// Each second of samples is judged by its mean, which hardly depends on whether the robot
/// walks. Once the body has been seen upright nothing is judged any more: a robot that
/// falls on its back later on is not mounted upside down.
#[derive(Debug)]
pub struct MountingCheck {
    mounting: Mounting,
    second: Second,
    verdict: Verdict,
}

/// Which way the body has been seen.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Verdict {
    Unknown,
    Upright,
    UpsideDown,
}

/// What has been seen of the current second.
#[derive(Debug, Default)]
struct Second {
    begin_s: Option<f64>,
    /// Sum of the directions that point up, in the body's axes, in g.
    up: Vector3<f64>,
    samples: u32,
}

/// The check's verdict has changed.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// The body lies on its back, or the sensor is mounted otherwise than told.
    UpsideDown {
        /// Time of the first sample of the second that showed it.
        since_s: f64,
        /// What is wrong and what to do about it.
        reason: String,
    },
    /// It does not any more.
    Upright,
}

const SECOND_S: f64 = 1.0;
/// Fewer samples say nothing.
const FEWEST_SAMPLES: u32 = 10;
/// Up is within 60° of the body's z axis, or of its opposite; else nothing is said.
const CLEAR: f64 = 0.5;

impl MountingCheck {
    /// Nothing seen yet of a sensor mounted like this.
    pub fn new(mounting: Mounting) -> Self {
        Self {
            mounting,
            second: Second::default(),
            verdict: Verdict::Unknown,
        }
    }

    /// Takes a sample in what the settings say are the body's axes.
    pub fn take(&mut self, time_s: f64, sample: &ImuSample) -> Option<Turn> {
        if self.verdict == Verdict::Upright {
            return None;
        }
        let up = up(sample)?;
        let since_s = *self.second.begin_s.get_or_insert(time_s);
        self.second.up += up;
        self.second.samples += 1;
        if time_s - since_s < SECOND_S {
            return None;
        }
        let second = std::mem::take(&mut self.second);
        let height = second.up.z / f64::from(second.samples);
        if second.samples < FEWEST_SAMPLES || !(CLEAR..).contains(&height.abs()) {
            return None;
        }
        let before = self.verdict;
        self.verdict = if height > 0.0 {
            Verdict::Upright
        } else {
            Verdict::UpsideDown
        };
        match (before, self.verdict) {
            (Verdict::Unknown, Verdict::UpsideDown) => Some(Turn::UpsideDown {
                since_s,
                reason: format!("{UPSIDE_DOWN}. {}", cure(&self.mounting)),
            }),
            (Verdict::UpsideDown, Verdict::Upright) => Some(Turn::Upright),
            _ => None,
        }
    }
}

/// What a sensor that is mounted upside down shows.
pub(crate) const UPSIDE_DOWN: &str =
    "gravity points out of the robot's back: the sensor is mounted upside down";

/// What to do about a sensor that is mounted upside down, going by these settings.
///
/// The body turned by half about its x axis is Rx(180°)·Rz(ψ)·Ry(θ)·Rx(φ) =
/// Rz(-ψ)·Ry(-θ)·Rx(φ + 180°).
pub(crate) fn cure(told: &Mounting) -> String {
    let Mounting {
        roll_deg,
        pitch_deg,
        yaw_deg,
        ..
    } = *told;
    let mut lines = format!("roll_deg = {:.1}", within_half_a_turn(roll_deg + 180.0));
    for (name, angle_deg) in [("pitch_deg", -pitch_deg), ("yaw_deg", -yaw_deg)] {
        if angle_deg != 0.0 {
            lines += &format!(", {name} = {angle_deg:.1}");
        }
    }
    let other_yaw_deg = within_half_a_turn(180.0 - yaw_deg);
    format!(
        "In mlrd.toml set [mounting] {lines} (and yaw_deg = {other_yaw_deg:.1} if its x axis then \
         points backward), and start mlrd anew. A robot that only lies on its back needs to be put on \
         its feet"
    )
}

/// The direction that points up, in the sample's axes: that of the device where it knows,
/// else the specific force, in g.
pub(crate) fn up(sample: &ImuSample) -> Option<Vector3<f64>> {
    match (sample.orientation, sample.acceleration_mps2) {
        (Some(world_from_body), _) => Some(world_from_body.inverse_transform_vector(&Vector3::z())),
        (None, Some(force_mps2)) => Some(force_mps2 / STANDARD_GRAVITY_MPS2),
        (None, None) => None,
    }
}

/// The same angle above -180° and up to 180°.
fn within_half_a_turn(angle_deg: f64) -> f64 {
    180.0 - (180.0 - angle_deg).rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;

    fn resting(up: Vector3<f64>) -> ImuSample {
        ImuSample {
            acceleration_mps2: Some(up * STANDARD_GRAVITY_MPS2),
            angular_rate_radps: Some(Vector3::zeros()),
            ..ImuSample::default()
        }
    }

    fn turns(
        check: &mut MountingCheck,
        seconds: std::ops::Range<u32>,
        sample: &ImuSample,
    ) -> Vec<Turn> {
        (seconds.start * 100..seconds.end * 100)
            .filter_map(|index| check.take(f64::from(index) * 0.01, sample))
            .collect()
    }

    #[test]
    fn a_body_upside_down_is_told_once_with_its_cure_until_it_is_turned_over() {
        let mut check = MountingCheck::new(Mounting::default());
        let told = turns(&mut check, 0..5, &resting(-Vector3::z()));
        let [Turn::UpsideDown { since_s, reason }] = told.as_slice() else {
            panic!("{told:?}");
        };
        assert_eq!(*since_s, 0.0);
        assert!(reason.contains("[mounting] roll_deg = 180.0 ("), "{reason}");
        assert!(reason.contains("yaw_deg = 180.0"), "{reason}");
        assert!(turns(&mut check, 5..8, &resting(Vector3::x())).is_empty());
        assert_eq!(
            turns(&mut check, 8..12, &resting(Vector3::z())),
            [Turn::Upright]
        );
        // It fell.
        assert!(turns(&mut check, 12..20, &resting(-Vector3::z())).is_empty());
    }

    #[test]
    fn a_device_is_believed_about_its_own_orientation() {
        let device = |roll_rad: f64| ImuSample {
            orientation: Some(UnitQuaternion::from_euler_angles(roll_rad, 0.1, 2.0)),
            ..ImuSample::default()
        };
        for (roll_deg, told) in [(179.0, 1), (-175.0, 1), (30.0, 0), (90.0, 0)] {
            let mut check = MountingCheck::new(Mounting::default());
            let turns = turns(&mut check, 0..5, &device(f64::to_radians(roll_deg)));
            assert_eq!(turns.len(), told, "{roll_deg}");
        }
    }

    #[test]
    fn no_gravity_says_nothing() {
        let mut check = MountingCheck::new(Mounting::default());
        assert!(turns(&mut check, 0..5, &resting(Vector3::zeros())).is_empty());
        let nothing = ImuSample::default();
        assert!(turns(&mut check, 5..10, &nothing).is_empty());
        let not_a_number = resting(Vector3::repeat(f64::NAN));
        assert!(turns(&mut check, 10..15, &not_a_number).is_empty());
        assert_eq!(turns(&mut check, 15..20, &resting(-Vector3::z())).len(), 1);
    }

    fn number_after(reason: &str, name: &str) -> f64 {
        let Some((_, after)) = reason.split_once(&format!("{name} = ")) else {
            return 0.0;
        };
        let end = after.find([',', ' ']).unwrap();
        after[..end].parse().unwrap()
    }

    proptest! {
        /// Whatever the settings said, those that are proposed turn the same samples upright.
        #[test]
        fn the_cure_cures(
            roll_deg in -180..=180_i32, pitch_deg in -80..=80_i32, yaw_deg in -180..=180_i32,
        ) {
            let mounting = Mounting {
                roll_deg: f64::from(roll_deg),
                pitch_deg: f64::from(pitch_deg),
                yaw_deg: f64::from(yaw_deg),
                ..Mounting::default()
            };
            let told_body_from_sensor = UnitQuaternion::from_euler_angles(
                mounting.roll_deg.to_radians(),
                mounting.pitch_deg.to_radians(),
                mounting.yaw_deg.to_radians(),
            );
            let raw = resting(told_body_from_sensor.inverse() * -Vector3::z());
            let mut check = MountingCheck::new(mounting);
            let told = turns(&mut check, 0..3, &mounting.in_body_axes(&raw));
            let Some(Turn::UpsideDown { reason, .. }) = told.first() else {
                panic!("{told:?}");
            };
            let (first, _) = reason.split_once('(').unwrap();
            let cured = Mounting {
                roll_deg: number_after(first, "roll_deg"),
                pitch_deg: number_after(first, "pitch_deg"),
                yaw_deg: number_after(first, "yaw_deg"),
                ..Mounting::default()
            };
            cured.check().unwrap();
            let up = cured.in_body_axes(&raw).acceleration_mps2.unwrap();
            prop_assert!((up - Vector3::z() * STANDARD_GRAVITY_MPS2).norm() < 1e-9);
        }
    }
}
