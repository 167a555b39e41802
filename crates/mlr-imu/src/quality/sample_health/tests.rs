use proptest::prelude::*;

use super::*;

/// A sample of a robot that rocks, with a count or so of noise.
fn rocking(index: u32) -> ImuSample {
    let t = f64::from(index) * 1e-3;
    let noise = f64::from((index * 7919) % 13) * 1e-3;
    ImuSample {
        acceleration_mps2: Some(Vector3::new(
            0.3 * (6.0 * t).sin() + noise,
            0.1,
            9.8 + noise,
        )),
        angular_rate_radps: Some(Vector3::new(0.5 * (6.0 * t).cos() + noise, 0.01, 0.0)),
        ..ImuSample::default()
    }
}

/// The first fault of 8 s at 1 kHz, spoilt from 4 s on.
fn fault_of(walking: bool, spoil: impl Fn(u32, ImuSample) -> ImuSample) -> Option<SampleFault> {
    let mut health = SampleHealth::new(FullScale::default());
    (0..8000).find_map(|index| {
        let sample = rocking(index);
        let sample = if index < 4000 {
            sample
        } else {
            spoil(index, sample)
        };
        health.take(f64::from(index) * 1e-3, &sample, walking)
    })
}

fn assert_fault(fault: Option<SampleFault>, kind: FaultKind) {
    let fault = fault.unwrap();
    assert_eq!(fault.kind(), kind);
    assert!((fault.since_s() - 4.0).abs() < 0.05, "{fault}");
}

#[test]
fn good_samples_have_no_fault() {
    for walking in [false, true] {
        assert_eq!(fault_of(walking, |_, sample| sample), None);
    }
}

#[test]
fn frozen_samples_are_told_walking_or_not() {
    for walking in [false, true] {
        assert_fault(fault_of(walking, |_, _| rocking(3999)), FaultKind::Frozen);
    }
}

#[test]
fn a_slow_sensor_that_is_read_fast_is_not_frozen() {
    // A new value every 50 ms, and one that comes late.
    let mut health = SampleHealth::new(FullScale::default());
    let fault = (0..8000).find_map(|index| {
        let held = if (4000..4150).contains(&index) {
            4000
        } else {
            index / 50 * 50
        };
        health.take(f64::from(index) * 1e-3, &rocking(held), true)
    });
    assert_eq!(fault, None);
}

#[test]
fn an_orientation_may_rest_with_the_robot_but_not_walk_frozen() {
    let still = |_, _| ImuSample {
        orientation: Some(UnitQuaternion::identity()),
        ..ImuSample::default()
    };
    assert_eq!(fault_of(false, still), None);
    assert_fault(fault_of(true, still), FaultKind::Frozen);
}

#[test]
fn zeros_are_a_dead_accelerometer() {
    let zeros = |_, _| ImuSample {
        acceleration_mps2: Some(Vector3::zeros()),
        angular_rate_radps: Some(Vector3::zeros()),
        ..ImuSample::default()
    };
    assert_fault(fault_of(false, zeros), FaultKind::DeadAccelerometer);
}

#[test]
fn one_dead_half_is_named() {
    let dead_rates = |_, sample| ImuSample {
        angular_rate_radps: Some(Vector3::zeros()),
        ..sample
    };
    assert_fault(fault_of(true, dead_rates), FaultKind::DeadGyroscope);
    let dead_force = |_, sample| ImuSample {
        acceleration_mps2: Some(Vector3::new(0.1, 0.2, 9.8)),
        ..sample
    };
    assert_fault(fault_of(true, dead_force), FaultKind::DeadAccelerometer);
}

#[test]
fn a_log_with_few_decimals_has_no_dead_half() {
    let coarse = |_, sample: ImuSample| ImuSample {
        acceleration_mps2: sample
            .acceleration_mps2
            .map(|a| a.map(|x| (x * 2.0).round() / 2.0)),
        ..sample
    };
    assert_eq!(fault_of(true, coarse), None);
}

#[test]
fn rates_cut_off_at_the_range_are_saturated_and_a_footfall_is_not() {
    let end = (32767.0_f64 / 131.0).to_radians();
    let cut_off = |_, sample: ImuSample| ImuSample {
        angular_rate_radps: sample
            .angular_rate_radps
            .map(|r| Vector3::new(end, r.y, r.z)),
        ..sample
    };
    assert_fault(fault_of(true, cut_off), FaultKind::Saturated);
    let footfall = |index: u32, sample: ImuSample| ImuSample {
        acceleration_mps2: sample.acceleration_mps2.map(|a| {
            let z = if index % 500 < 5 {
                2.0 * STANDARD_GRAVITY_MPS2
            } else {
                a.z
            };
            Vector3::new(a.x, a.y, z)
        }),
        ..sample
    };
    assert_eq!(fault_of(true, footfall), None);
}

#[test]
fn two_sensors_on_one_line_jump_to_and_fro() {
    let two = |index: u32, sample| ImuSample {
        orientation: Some(UnitQuaternion::from_euler_angles(
            if index.is_multiple_of(2) { 0.0 } else { 0.8 },
            f64::from(index) * 1e-6,
            0.0,
        )),
        ..sample
    };
    assert_fault(fault_of(true, two), FaultKind::Impossible);
}

#[test]
fn a_fault_that_is_over_may_come_again() {
    let mut health = SampleHealth::new(FullScale::default());
    let faults = (0..12_000).filter_map(|index| {
        let frozen = (4000..5000).contains(&index) || (8000..9000).contains(&index);
        let sample = if frozen {
            rocking(4000)
        } else {
            rocking(index)
        };
        health.take(f64::from(index) * 1e-3, &sample, true)
    });
    assert_eq!(faults.count(), 2);
    assert_eq!(health.fault(), None);
}

proptest! {
    #[test]
    fn no_values_and_no_times_make_it_panic(
        samples in prop::collection::vec((any::<f64>(), prop::array::uniform6(any::<f64>())), 0..100),
    ) {
        let mut health = SampleHealth::new(FullScale::default());
        for (time_s, v) in samples {
            let sample = ImuSample {
                acceleration_mps2: Some(Vector3::new(v[0], v[1], v[2])),
                angular_rate_radps: Some(Vector3::new(v[3], v[4], v[5])),
                ..ImuSample::default()
            };
            health.take(time_s, &sample, true);
        }
    }
}
