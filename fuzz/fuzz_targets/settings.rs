#![no_main]

use std::fmt::Debug;

use libfuzzer_sys::fuzz_target;
use mlr_ga::{Configuration, IdentifySettings};
use mlr_model::{Gait, Motion, Robot};
use serde::Serialize;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if let Ok(robot) = Robot::from_toml(text) {
        check_robot(&robot);
    }
    if let Ok(gait) = Gait::from_toml(text) {
        check_gait(&gait);
    }
    if let Ok(settings) = toml::from_str::<IdentifySettings>(text)
        && settings.check().is_ok()
    {
        check_numbers(&settings);
    }
    if let Ok(configuration) = Configuration::from_toml(text) {
        check_numbers(&configuration);
    }
});

/// What passes its checks is finite, and can be written down.
fn check_numbers(settings: &(impl Serialize + Debug)) {
    let value = toml::Value::try_from(settings).expect("what was read can be written");
    assert!(is_finite(&value), "{settings:?}");
}

fn is_finite(value: &toml::Value) -> bool {
    match value {
        toml::Value::Float(number) => number.is_finite(),
        toml::Value::Array(values) => values.iter().all(is_finite),
        toml::Value::Table(table) => table.values().all(is_finite),
        _ => true,
    }
}

fn check_robot(robot: &Robot) {
    let body = robot.body();
    let servo = robot.servo();
    let mut numbers = vec![
        body.mass_kg,
        servo.stiffness_nm_per_rad,
        servo.damping_nm_s_per_rad,
        servo.torque_limit_nm,
        servo.speed_limit_rad_per_s,
        servo.command_hold_s,
        servo.latency_s,
    ];
    numbers.extend(body.size_m.iter());
    numbers.extend(body.center_of_mass_m.iter());
    for leg in robot.legs() {
        numbers.extend(leg.hip_m.iter());
        numbers.extend(leg.nominal_foot_m);
        numbers.push(leg.hip_yaw_rad);
        for link in &leg.links {
            numbers.extend([
                link.length_m,
                link.mass_kg,
                link.center_of_mass_m,
                link.posture_rad,
                link.locked_rad,
            ]);
        }
    }
    assert!(numbers.iter().all(|x| x.is_finite()), "{robot:?}");
    assert!(!robot.legs().is_empty());
}

fn check_gait(gait: &Gait) {
    let numbers: Vec<f64> = match &gait.motion {
        Motion::Feet(feet) => {
            let numbers = [
                feet.ramp_s,
                feet.stride_m,
                feet.lift_m,
                feet.body_height_m,
                feet.swing_fraction,
            ];
            numbers.iter().chain(&feet.phase_offsets).copied().collect()
        }
        Motion::Joints(joints) => joints.rows_rad().concat(),
    };
    let times = [gait.period_s, gait.steady_from_s(), gait.first_pass_s()];
    let mut numbers = numbers.into_iter().chain(times);
    assert!(numbers.all(f64::is_finite), "{gait:?}");
    let written = gait.to_toml();
    assert!(Gait::from_toml(&written).is_ok(), "{written}");
}
