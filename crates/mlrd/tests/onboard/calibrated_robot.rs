//! A robot with differences of its own, from ten minutes of health to a lost leg, on a real
//! pseudo-terminal. Time is the device's, as fast as the daemon reads.
#![allow(clippy::print_stdout, reason = "what was measured is shown")]

use std::{fs, path::Path, time::Instant};

use crate::daemon::{
    Daemon,
    player::{Device, Line, Row},
};
use mlr_filter::OrientationSeries;
use mlr_model::{
    Gait, GroundContact, Morphology, Outcome, Robot, RobotParameter, SimulationSettings, Simulator,
};
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;

const ROLL: RobotParameter = RobotParameter::ImuMounting(0);
const FEMUR: RobotParameter = RobotParameter::JointZero { leg: 1, joint: 1 };
/// What this robot differs by from its description.
const OWN: [(RobotParameter, f64); 3] =
    [(ROLL, 1.0), (FEMUR, 0.02), (RobotParameter::Clock, 0.002)];

/// Everything is done with little effort: short stretches, few candidates.
const LITTLE: &str = "
status_every_s = 0.5
threads = 2
[learning]
walk_s = 3.5
settled_s = 20.0
every_s = 30.0
processor_share = 1.0
[identification]
window_s = 3.0
leaders = 1
variations = [{}]
[identification.genetic]
population = 8
generations = 4
islands = 1
";
/// All settings, where so many effects are looked for beside damage and what no effect of the library
/// makes.
fn settings(most_effects: usize) -> String {
    let effort = format!(
        "[explanation.effort]\nbases = 0\nscreened = {most_effects}\nentrants = 1\n\
         neighbours = 0\nextended = 0\nmost_effects = {most_effects}\n"
    );
    // A search for a recovery gait would take the time that learning needs.
    format!("recover = false\n{LITTLE}{effort}")
}

/// By how much its sensor is knocked out of place in the end: more than what is left open by so short a lesson.
const KNOCKED_DEG: f64 = 5.0;

fn own_robot() -> Robot {
    let own = |robot: Robot, (one, by)| robot.with_added(one, by);
    OWN.into_iter().fold(Robot::jethexa(), own)
}

/// What the IMU of this robot shows of a walk.
fn walk(robot: &Robot, legs_lost: &str, cycles: f64, friction: f64) -> OrientationSeries {
    let settings = SimulationSettings {
        duration_s: cycles,
        contact: GroundContact {
            friction,
            ..GroundContact::default()
        },
        ..SimulationSettings::default()
    };
    let morphology = match legs_lost {
        "" => Morphology::healthy(&robot.layout()),
        legs => Morphology::parse_legs_lost(legs, &robot.layout()).unwrap(),
    };
    let simulator = Simulator::new(robot.clone(), &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(walked) = simulator.simulate(&morphology) else {
        panic!("it diverged");
    };
    let seen = robot.imu().on(&walked.orientation);
    let times_s = seen.times_s().iter().map(|t| t * robot.clock());
    OrientationSeries::new(times_s.collect(), seen.angles_rad().clone()).unwrap()
}

/// What a sensor sends of one thing after another.
struct Story {
    rows: Vec<Row>,
    attitude: UnitQuaternion<f64>,
    /// A little noise, always the same: 16 bits of a linear congruential generator.
    noise: u32,
}

/// Twice as often as it is simulated.
const STEP_S: f64 = 0.005;

impl Story {
    fn begun() -> Self {
        Self {
            rows: Vec::new(),
            attitude: UnitQuaternion::identity(),
            noise: 1,
        }
    }

    fn noise(&mut self) -> f64 {
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        f64::from(self.noise >> 16) / 32_768.0 - 1.0
    }

    fn show(&mut self, attitude: UnitQuaternion<f64>) {
        let turned = (self.attitude.inverse() * attitude).scaled_axis() / STEP_S;
        self.attitude = attitude;
        let (roll, pitch, yaw) = attitude.euler_angles();
        let (dps, mps2) = (0.05_f64.to_radians(), 0.01);
        let row = Row {
            time_s: self.rows.len() as f64 * STEP_S,
            force_mps2: attitude.inverse() * (Vector3::z() * 9.806_65)
                + Vector3::from_fn(|_, _| mps2 * self.noise()),
            rate_radps: turned + Vector3::from_fn(|_, _| dps * self.noise()),
            angles_rad: Vector3::new(roll, pitch, yaw),
        };
        self.rows.push(row);
    }

    /// Shows what a walk shows between two times, the heading going on.
    fn shows(&mut self, seen: &OrientationSeries, from_s: f64, to_s: f64) {
        let angles = seen.angles_rad();
        let at = |time_s: f64| {
            let k = seen.times_s().partition_point(|t| *t < time_s);
            let k = k.clamp(1, seen.len() - 1);
            let (before_s, after_s) = (seen.times_s()[k - 1], seen.times_s()[k]);
            let share = ((time_s - before_s) / (after_s - before_s)).clamp(0.0, 1.0);
            let between = |angle: &[f64]| angle[k - 1] + share * (angle[k] - angle[k - 1]);
            UnitQuaternion::from_euler_angles(
                between(&angles.roll),
                between(&angles.pitch),
                between(&angles.yaw),
            )
        };
        let heading = |attitude: &UnitQuaternion<f64>| attitude.euler_angles().2;
        let turn = heading(&self.attitude) - heading(&at(from_s));
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        for index in 0..((to_s - from_s) / STEP_S).round() as u32 {
            self.show(turn * at(from_s + f64::from(index) * STEP_S));
        }
    }

    /// Stands as the walk begins.
    fn stands(&mut self, seen: &OrientationSeries, for_s: f64) {
        let begin_s = seen.times_s()[0];
        let at_rest = OrientationSeries::new(
            vec![begin_s, begin_s + for_s],
            seen.angles_rad().as_ref().map(|_, angle| vec![angle[0]; 2]),
        );
        self.shows(&at_rest.unwrap(), begin_s, begin_s + for_s);
    }
}

fn started(port: &Path, config: &Path, state: &Path) -> (Daemon, Value) {
    let daemon = Daemon::start([
        "--port".as_ref(),
        port.as_os_str(),
        "--config".as_ref(),
        config.as_os_str(),
        "--state-dir".as_ref(),
        state.as_os_str(),
    ]);
    let started = daemon.next("started");
    daemon.next("port_lost");
    (daemon, started)
}

/// Plugs in a line and sends all of it.
fn play(daemon: &Daemon, port: &Path, story: &Story) -> Line {
    let mut line = Line::plugged_in(port);
    daemon.next("port_opened");
    line.send_all(&Device::RegisterBurst.frames_of(&story.rows));
    line
}

#[test]
fn a_robot_is_learned_and_explained_across_a_restart_and_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (port, config, state) = (at("imu"), at("mlrd.toml"), at("state"));
    fs::write(&config, settings(0)).unwrap();
    let begin = Instant::now();
    let told = |what: &str| println!("{:6.1} s: {what}", begin.elapsed().as_secs_f64());

    // Ten minutes of health, in ten walks on two kinds of ground.
    let own = own_robot();
    let grounds = [0.8, 0.7].map(|friction| walk(&own, "", 56.0, friction));
    let mut healthy = Story::begun();
    for index in 0..10 {
        healthy.stands(&grounds[index % 2], 5.0);
        healthy.shows(&grounds[index % 2], 0.0, 55.0);
    }
    let (daemon, start) = started(&port, &config, &state);
    assert!(start.get("calibration").is_none());
    let line = play(&daemon, &port, &healthy);
    let calibrated = daemon.next("calibrated");
    told("calibrated");
    let learned_deg = expect_what_is_its_own(&calibrated);
    drop(line);
    daemon.terminate();

    // It is known after a restart. A kill in the middle of the next lesson leaves it as it was.
    let (daemon, start) = started(&port, &config, &state);
    assert_eq!(start["calibration"]["walks"], 1);
    let kept = || fs::read(state.join("calibration.json")).unwrap();
    let before = kept();
    let line = play(&daemon, &port, &healthy);
    daemon.told_until(|event| event["good"] == healthy.rows.len());
    daemon.kill();
    drop(line);
    assert_eq!(kept(), before);
    told("restarted, and killed");

    // Its sensor is knocked, which nobody tells; it walks for 40 s and loses a leg.
    fs::write(&config, settings(1)).unwrap();
    let (daemon, start) = started(&port, &config, &state);
    assert_eq!(start["calibration"]["walks"], 1);
    let knocked = own.clone().with_added(ROLL, KNOCKED_DEG);
    let cycle_s = knocked.clock();
    let whole = walk(&knocked, "", 41.0, 0.8);
    let mut damaged = Story::begun();
    damaged.stands(&whole, 5.0);
    damaged.shows(&whole, 0.0, 40.0 * cycle_s);
    let lost = walk(&knocked, "3", 16.0, 0.8);
    damaged.shows(&lost, 4.0 * cycle_s, 16.0 * cycle_s);
    let _line = play(&daemon, &port, &damaged);
    let identified = daemon.next("identified");
    told("identified");
    assert_eq!(identified["result"]["damaged_legs"], serde_json::json!([3]));
    let start_s = identified["result"]["motion_start_s"].as_f64().unwrap();
    assert!((start_s - 5.0).abs() < 0.2, "{start_s}");
    let explained = daemon.next("explained");
    told("explained");
    let result = &explained["result"];
    assert_eq!(result["damaged_legs"], serde_json::json!([3]));
    let probability = &result["effect_probability"];
    assert_eq!(
        result["effects"].as_array().unwrap().len(),
        1,
        "{probability}"
    );
    assert_eq!(result["effects"][0]["kind"], "imu_misalignment");
    let found_deg = result["effects"][0]["parameters"]["roll_deg"]
        .as_f64()
        .unwrap();
    println!("knocked by {found_deg:.2}° where {learned_deg:.2}° were known");
    // Both together are what the sensor is off by.
    let interval = &result["effects"][0]["interval_95"]["roll_deg"];
    let [low_deg, high_deg] = [0, 1].map(|end| interval[end].as_f64().unwrap());
    let left_deg = OWN[0].1 + KNOCKED_DEG - learned_deg;
    assert!(
        low_deg > 0.0 && (low_deg..high_deg).contains(&left_deg),
        "{interval}"
    );
    let error = |when: &str| result[when]["validation_deg"].as_f64().unwrap();
    assert!(error("error_after") < 0.5 * error("error_before"));
    // What is found of the sensor is corrected from then on.
    let corrected = daemon.next("sensor_corrected");
    let roll_deg = corrected["sensing"]["misalignment_deg"][0]
        .as_f64()
        .unwrap();
    assert!((roll_deg - found_deg).abs() < 1e-9);
    daemon.terminate();
}

/// The robot's own parameters must have been found; returns the roll of its sensor.
fn expect_what_is_its_own(calibrated: &Value) -> f64 {
    assert_eq!(
        (&calibrated["walks"], &calibrated["level"]),
        (&1.into(), &0.into())
    );
    assert!(calibrated["gain_nats"].as_f64().unwrap() > 0.0);
    let result = &calibrated["result"];
    assert_eq!(result["schema"], "mlr.calibration/1");
    let parameters = result["parameters"].as_array().unwrap();
    let mut learned_deg = 0.0;
    for (own, by) in OWN {
        let is_it = |one: &&Value| one["name"] == own.to_string();
        let found = parameters.iter().find(is_it).unwrap();
        let number = |name: &str| found[name].as_f64().unwrap();
        let changed = number("fitted") - number("described");
        let (off, deviation) = (changed - by, number("deviation"));
        println!("{own}: off by {off:.4} of {by}, deviation {deviation:.4}");
        assert!(off.abs() < 3.0 * deviation);
        if own == ROLL {
            learned_deg = changed;
        }
        // Less than three seconds of walk tell little of a clock.
        if own != RobotParameter::Clock {
            assert!(off.abs() < 0.5 * by);
        }
    }
    learned_deg
}
