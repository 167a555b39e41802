//! One fault at a time, injected into a good log: each is named, and the good log has none.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f64::consts::{PI, TAU};

use mlr_filter::{Axes, MotionSettings, OrientationSeries};
use mlr_imu::{
    OrientationSource, RawSeries, Recording,
    quality::{Finding, FindingKind, LogQuality, Severity},
};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

const RATE_HZ: f64 = 500.0;
const START_S: f64 = 2.0;
const GRAVITY_MPS2: f64 = 9.81;

/// A sensor with a count or so of noise that stands for 2 s and then rocks and turns for 6 s.
#[derive(Clone)]
struct Log {
    times_s: Vec<f64>,
    angles: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    rates: Vec<[f64; 3]>,
}

fn good(swing_rad: f64) -> Log {
    let orientation = |t: f64| {
        let walked_s = (t - START_S).max(0.0);
        [
            swing_rad * (TAU * walked_s).sin(),
            swing_rad * (1.0 - (2.0 * TAU * walked_s).cos()) / 2.0,
            0.1 * walked_s,
        ]
    };
    let noise = |index: usize, channel: usize| {
        (((index * 7919 + channel * 104_729) % 1009) as f64 / 1009.0 - 0.5) * 2.0
    };
    let mut log = Log {
        times_s: Vec::new(),
        angles: Vec::new(),
        forces: Vec::new(),
        rates: Vec::new(),
    };
    for index in 0..(8.0 * RATE_HZ) as usize {
        let t = index as f64 / RATE_HZ;
        let [roll, pitch, yaw] = orientation(t);
        let now = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let [r, p, y] = orientation(t + 1e-4);
        let soon = UnitQuaternion::from_euler_angles(r, p, y);
        let rate = (now.inverse() * soon).scaled_axis() / 1e-4;
        let force = now.inverse() * (Vector3::z() * GRAVITY_MPS2);
        log.times_s.push(t);
        log.angles
            .push([roll, pitch, yaw].map(|a| a + 1e-5 * noise(index, 0)));
        log.forces.push(std::array::from_fn(|axis| {
            force[axis] + 0.05 * noise(index, 1 + axis)
        }));
        log.rates.push(std::array::from_fn(|axis| {
            rate[axis] + 0.002 * noise(index, 4 + axis)
        }));
    }
    log
}

impl Log {
    fn each_angle(mut self, f: impl Fn(usize, f64) -> f64) -> Self {
        for row in &mut self.angles {
            *row = std::array::from_fn(|axis| f(axis, row[axis]));
        }
        self
    }

    fn each_force(mut self, f: impl Fn(usize, f64) -> f64) -> Self {
        for row in &mut self.forces {
            *row = std::array::from_fn(|axis| f(axis, row[axis]));
        }
        self
    }

    fn each_rate(mut self, f: impl Fn(usize, f64) -> f64) -> Self {
        for row in &mut self.rates {
            *row = std::array::from_fn(|axis| f(axis, row[axis]));
        }
        self
    }

    /// Each row shows the values of another one.
    fn rows_of(mut self, source: impl Fn(usize) -> usize) -> Self {
        let before = self.clone();
        for index in 0..self.times_s.len() {
            let from = source(index);
            self.angles[index] = before.angles[from];
            self.forces[index] = before.forces[from];
            self.rates[index] = before.rates[from];
        }
        self
    }

    fn recording(&self) -> Recording {
        let column = |axis: usize| {
            self.angles
                .iter()
                .map(|row| row[axis])
                .collect::<Vec<f64>>()
        };
        let angles = Axes {
            roll: column(0),
            pitch: column(1),
            yaw: column(2),
        };
        let vectors = |rows: &[[f64; 3]]| rows.iter().copied().map(Vector3::from).collect();
        Recording {
            raw: Some(RawSeries {
                times_s: self.times_s.clone(),
                accelerations_mps2: vectors(&self.forces),
                angular_rates_radps: vectors(&self.rates),
            }),
            ..OrientationSeries::new(self.times_s.clone(), angles)
                .unwrap()
                .into()
        }
    }

    /// What its raw samples alone say.
    fn without_angles(&self) -> Recording {
        let recording = self.recording();
        let raw = recording.raw.clone().unwrap();
        Recording {
            orientation: raw.fuse().unwrap(),
            source: OrientationSource::Fused,
            ..recording
        }
    }

    fn without_raw(&self) -> Recording {
        self.recording().orientation.into()
    }
}

fn quality(recording: &Recording) -> LogQuality {
    LogQuality::of(recording, &MotionSettings::default())
}

fn useless(recording: &Recording) -> Vec<Finding> {
    let findings = quality(recording).findings;
    findings
        .into_iter()
        .filter(|finding| finding.severity == Severity::Useless)
        .collect()
}

fn assert_first(recording: &Recording, kind: FindingKind, cure_has: &str) {
    let found = useless(recording);
    let Some(first) = found.first() else {
        panic!("{kind:?} is not found");
    };
    assert_eq!(first.kind, kind, "{found:?}");
    let cure = first.cure.clone().unwrap_or_default();
    assert!(cure.contains(cure_has), "{cure}");
}

#[test]
fn a_good_log_has_no_findings() {
    for swing_rad in [0.005, 0.1, 0.4] {
        let log = good(swing_rad);
        for recording in [log.recording(), log.without_angles(), log.without_raw()] {
            let quality = quality(&recording);
            assert_eq!(quality.findings, [], "{swing_rad}");
            assert!((quality.sample_rate_hz - RATE_HZ).abs() < 0.1);
            assert!((quality.value_rate_hz - RATE_HZ).abs() < 1.0);
        }
        let gravity = quality(&log.recording()).gravity_mps2.unwrap();
        assert!((gravity - GRAVITY_MPS2).abs() < 0.01);
    }
}

#[test]
fn angles_in_degrees_are_told_from_the_rates_whatever_their_size() {
    for swing_rad in [0.005, 0.1, 0.4] {
        let log = good(swing_rad).each_angle(|_, angle| angle.to_degrees());
        assert_first(
            &log.recording(),
            FindingKind::AngleUnit,
            "--column roll=roll_rad,deg --column pitch=pitch_rad,deg",
        );
    }
    let log = good(0.1).each_angle(|_, angle| angle.to_degrees());
    assert_first(
        &log.without_raw(),
        FindingKind::AngleUnit,
        "roll=roll_rad,deg",
    );
}

#[test]
fn angles_from_0_to_2_pi_are_radians() {
    let log = good(0.1).each_angle(|axis, angle| if axis == 0 { angle + TAU } else { angle });
    assert_eq!(useless(&log.recording()), []);
}

#[test]
fn rates_in_degrees_are_told_from_the_angles_or_from_gravity() {
    for swing_rad in [0.02, 0.1, 0.4] {
        let log = good(swing_rad).each_rate(|_, rate| rate.to_degrees());
        for recording in [log.recording(), log.without_angles()] {
            assert_first(
                &recording,
                FindingKind::RateUnit,
                "--column gx=gx_radps,dps",
            );
        }
    }
}

#[test]
fn both_in_degrees_are_told_from_gravity() {
    let log = good(0.02)
        .each_rate(|_, rate| rate.to_degrees())
        .each_angle(|_, angle| angle.to_degrees());
    assert_first(&log.recording(), FindingKind::RateUnit, "dps");
}

#[test]
fn gravity_tells_the_unit_of_accelerations() {
    let log = good(0.1).each_force(|_, force| force / 9.806_65);
    assert_first(
        &log.recording(),
        FindingKind::AccelerationUnit,
        "--column ax=ax_mps2,g",
    );
    let log = good(0.1).each_force(|_, force| force * 16384.0 / 9.806_65);
    assert_first(&log.recording(), FindingKind::AccelerationUnit, "");
    let log = good(0.1).each_force(|_, force| force * 5.0);
    assert_first(&log.recording(), FindingKind::Gravity, "");
    // As far off as the vendor's calibration of a real JetHexa says: worth a warning.
    let log = good(0.1).each_force(|axis, force| if axis == 2 { force - 2.3 } else { force });
    assert_eq!(useless(&log.recording()), []);
    let quality = quality(&log.recording());
    assert_eq!(quality.findings[0].kind, FindingKind::Gravity);
    assert!(quality.is_worse());
}

#[test]
fn a_sensor_that_points_down_is_told_with_its_cure() {
    // NED: y right, z down.
    let ned = |axis: usize, value: f64| if axis == 0 { value } else { -value };
    let log = good(0.1).each_force(ned).each_rate(ned).each_angle(ned);
    assert_first(
        &log.recording(),
        FindingKind::UpsideDown,
        "--column pitch=-pitch_rad",
    );
    assert_first(
        &log.without_angles(),
        FindingKind::UpsideDown,
        "roll_deg = 180",
    );
    // Turned over about x, its own orientation with it.
    let turned = |axis: usize, angle: f64| if axis == 0 { angle + PI } else { angle };
    let log = good(0.1).each_force(ned).each_rate(ned).each_angle(turned);
    for recording in [log.recording(), log.without_raw()] {
        assert_first(
            &recording,
            FindingKind::UpsideDown,
            "[mounting] roll_deg = 180",
        );
    }
}

#[test]
fn angles_with_another_sign_than_the_rates_contradict_them() {
    let log = good(0.1).each_angle(|axis, angle| if axis == 1 { -angle } else { angle });
    assert_first(
        &log.recording(),
        FindingKind::Contradiction,
        "--column pitch=-pitch_rad",
    );
}

#[test]
fn a_frozen_sensor_spoils_what_comes_after() {
    let frozen = good(0.1).rows_of(|index| index.min((4.0 * RATE_HZ) as usize));
    for recording in [
        frozen.recording(),
        frozen.without_angles(),
        frozen.without_raw(),
    ] {
        let quality = quality(&recording);
        assert_eq!(quality.findings[0].kind, FindingKind::Frozen);
        assert!((quality.findings[0].from_s - 4.0).abs() < 0.05);
        assert!(quality.spoilt_within(2.0..7.0).is_some());
        assert!(quality.spoilt_within(2.0..3.9).is_none());
    }
}

#[test]
fn a_slow_sensor_is_not_frozen_and_its_rate_is_told() {
    let held = good(0.1).rows_of(|index| index / 25 * 25);
    for recording in [held.recording(), held.without_angles(), held.without_raw()] {
        let quality = quality(&recording);
        assert_eq!(useless(&recording), []);
        assert_eq!(quality.findings[0].kind, FindingKind::Held);
        assert!((quality.value_rate_hz - 20.0).abs() < 0.5, "{quality:?}");
        assert!((quality.sample_rate_hz - RATE_HZ).abs() < 0.1);
    }
}

#[test]
fn values_that_never_change_say_nothing() {
    let log = good(0.1).rows_of(|_| 0).without_raw();
    assert_eq!(useless(&log)[0].kind, FindingKind::Frozen);
}

#[test]
fn two_sensors_in_turn_are_told() {
    let (one, other) = (good(0.1), good(0.05));
    let mut both = one.clone();
    for index in (0..both.times_s.len()).step_by(2) {
        both.angles[index] = other.angles[index].map(|angle| angle + 0.01);
        both.forces[index] = other.forces[index].map(|force| force + 0.2);
        both.rates[index] = other.rates[index].map(|rate| rate + 0.03);
    }
    for recording in [both.recording(), both.without_raw()] {
        assert_first(&recording, FindingKind::Interleaved, "");
    }
}

#[test]
fn values_that_are_cut_off_are_told() {
    let clipped = |limit: f64| move |_: usize, value: f64| value.clamp(-limit, limit);
    let log = good(0.3).each_rate(clipped(0.5));
    assert_first(&log.recording(), FindingKind::Saturated, "range");
    let log = good(0.3).each_angle(|axis, angle| match axis {
        0 => angle.clamp(-0.1, 0.1),
        _ => angle,
    });
    assert_first(&log.without_raw(), FindingKind::Saturated, "");
    // Rarely: a warning.
    let log = good(0.3).each_rate(clipped(1.883));
    assert_eq!(useless(&log.recording()), []);
    assert_eq!(
        quality(&log.recording()).findings[0].kind,
        FindingKind::Saturated
    );
}

#[test]
fn a_robot_that_is_carried_tips_over() {
    let found = useless(&good(1.3).recording());
    assert_eq!(found[0].kind, FindingKind::TippedOver, "{found:?}");
}

#[test]
fn advice_names_the_columns_that_the_user_has() {
    let mut recording = good(0.1)
        .each_angle(|_, angle| angle.to_degrees())
        .recording();
    recording.columns.rename("roll=imu.roll").unwrap();
    assert_first(
        &recording,
        FindingKind::AngleUnit,
        "--column roll=imu.roll,deg",
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_finite_numbers_are_examined(
        rows in prop::collection::vec(prop::array::uniform10(-1e300..1e300_f64), 0..60),
    ) {
        let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
        let vectors = |first: usize| {
            rows.iter()
                .map(|row| Vector3::new(row[first], row[first + 1], row[first + 2]))
                .collect()
        };
        let angles = Axes { roll: column(1), pitch: column(2), yaw: column(3) };
        let orientation = OrientationSeries::new(column(0), angles).unwrap();
        let recording = Recording {
            raw: Some(RawSeries {
                times_s: column(0),
                accelerations_mps2: vectors(4),
                angular_rates_radps: vectors(7),
            }),
            ..orientation.into()
        };
        let (recording, _) = recording.with_increasing_times();
        let quality = quality(&recording);
        prop_assert!(quality.sample_rate_hz >= 0.0 && quality.value_rate_hz >= 0.0);
    }
}
