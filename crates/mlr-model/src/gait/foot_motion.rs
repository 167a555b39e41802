use std::f64::consts::PI;

use mlr_filter::SettingError;
use nalgebra::Point3;

use super::Gait;
use crate::robot::Leg;

/// Each foot swings forward through a half sine and pushes straight back, legs differing only
/// by their phase.
///
/// The stride grows from nothing to its full length over the ramp.
#[derive(Debug, Clone, PartialEq)]
pub struct FootMotion {
    /// How long the stride takes to grow to full length.
    pub ramp_s: f64,
    /// Length of the stride along x.
    pub stride_m: f64,
    /// Height of a swinging foot at mid-swing.
    pub lift_m: f64,
    /// Height of the body's origin over the foot tips.
    pub body_height_m: f64,
    /// Share of the period during which a foot swings.
    pub swing_fraction: f64,
    /// Phase of each leg, leg 1 first, as a share of the period.
    pub phase_offsets: Vec<f64>,
}

/// A foot-tip position in the body frame.
pub type FootTarget = Point3<f64>;

impl FootMotion {
    pub(super) fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("ramp_s", self.ramp_s, 0.0..=60.0, "s")?;
        check("stride_m", self.stride_m, -10.0..=10.0, "m")?;
        check("lift_m", self.lift_m, 0.0..=10.0, "m")?;
        check("body_height_m", self.body_height_m, 0.001..=10.0, "m")?;
        check("swing_fraction", self.swing_fraction, 0.01..=0.99, "")?;
        SettingError::check_each("phase_offsets", &self.phase_offsets, 0.0..=1.0, "")
    }

    /// Where leg `leg` (from 0) is commanded to have its foot tip at gait time `time_s`, in the
    /// body frame, with step cycles of `period_s`.
    pub fn foot_target(
        &self,
        period_s: f64,
        leg: usize,
        description: &Leg,
        time_s: f64,
    ) -> FootTarget {
        let [x_m, y_m] = description.nominal_foot_m;
        if time_s <= 0.0 {
            return Point3::new(x_m, y_m, -self.body_height_m);
        }
        let cycles = time_s / period_s + self.phase_offsets[leg];
        let phase = cycles - libm::floor(cycles);
        let ramp = if time_s < self.ramp_s {
            time_s / self.ramp_s
        } else {
            1.0
        };
        let (stride, lift) = if phase < self.swing_fraction {
            let (sin, cos) = libm::sincos(PI * phase / self.swing_fraction);
            (-0.5 * cos, sin)
        } else {
            (
                0.5 - (phase - self.swing_fraction) / (1.0 - self.swing_fraction),
                0.0,
            )
        };
        Point3::new(
            x_m + ramp * stride * self.stride_m,
            y_m,
            -self.body_height_m + ramp * lift * self.lift_m,
        )
    }
}

impl Gait {
    /// Where leg `leg` (from 0) is commanded to have its foot tip at gait time `time_s`, in the
    /// body frame; `None` of a joint trajectory, which knows no feet.
    pub fn foot_target(&self, leg: usize, description: &Leg, time_s: f64) -> Option<FootTarget> {
        let feet = self.feet()?;
        Some(feet.foot_target(self.period_s, leg, description, time_s))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Robot;

    fn target(leg: usize, time_s: f64) -> FootTarget {
        let robot = Robot::jethexa();
        let gait = Gait::tripod();
        gait.foot_target(leg, &robot.legs()[leg], time_s).unwrap()
    }

    #[test]
    fn stands_until_time_zero() {
        for leg in 0..6 {
            let standing = target(leg, -1.0);
            assert_eq!(standing, target(leg, 0.0));
            assert_eq!(standing.z, -0.090);
        }
    }

    #[test]
    fn first_tripod_swings_while_the_second_stands() {
        let height = |leg: usize| target(leg - 1, 2.25).z;
        for leg in [1, 4, 5] {
            assert!((height(leg) - (-0.090 + 0.040)).abs() < 1e-12, "leg {leg}");
        }
        for leg in [2, 3, 6] {
            assert_eq!(height(leg), -0.090, "leg {leg}");
        }
    }

    proptest! {
        #[test]
        fn targets_are_continuous(time_s in 0.0..5.0_f64, leg in 0_usize..6) {
            let dt_s = 1e-4;
            let (before, after) = (target(leg, time_s), target(leg, time_s + dt_s));
            let top_speed_m_per_s = 0.35;
            prop_assert!((after - before).norm() <= top_speed_m_per_s * dt_s);
        }

        #[test]
        fn repeats_after_a_period(time_s in 1.0..5.0_f64, leg in 0_usize..6) {
            let later = target(leg, time_s + Gait::tripod().period_s);
            prop_assert!((later - target(leg, time_s)).norm() < 1e-9);
        }
    }
}
