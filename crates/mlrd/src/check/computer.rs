//! How fast this computer simulates, and what that means.

use std::{
    thread,
    time::{Duration, Instant},
};

use mlr_model::{Gait, Morphology, Robot, SimulationSettings, Simulator};
use serde::Serialize;

use super::findings::{COLUMN, Findings};
use crate::Settings;

/// The speed of this computer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Speed {
    cores: usize,
    /// Walks of five seconds that all cores together simulate in a second, with the first legs lost.
    walks_per_s: f64,
    estimates: Vec<Estimate>,
}

/// How long a task of the daemon takes here, by the walks that it simulates.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Estimate {
    task: &'static str,
    /// Walks of five seconds.
    walks: f64,
    threads: usize,
    estimated_s: f64,
}

const MEASURED: Duration = Duration::from_secs(2);

/// Walks of five seconds that an identification without an atlas takes: measured are 17 s of two
/// cores (README.md), at 31 ms a walk. Not counted.
const IDENTIFICATION_WALKS: f64 = 1100.0;
/// The same of an explanation: 3629 and 2906 walks were counted, of up to ten seconds each
/// (docs/explain.md); measured are 82 s of two cores, at 31 ms for five seconds of walk.
const EXPLANATION_WALKS: f64 = 5000.0;
/// The same of a lesson from one healthy walk: an explanation, which checks it, and a fit of 35 s of processor time
/// (docs/calibrate.md), at 31 ms for five seconds of walk.
const CALIBRATION_WALKS: f64 = EXPLANATION_WALKS + 1100.0;

pub(super) fn measure(settings: &Settings, robot: &Robot, gait: &Gait, findings: &mut Findings) {
    const CHECK: &str = "computer";
    let simulation = SimulationSettings::default();
    let simulator = match Simulator::new(robot.clone(), gait, simulation) {
        Ok(simulator) => simulator,
        Err(error) => {
            findings.failed(CHECK, error.to_string(), "correct the robot or its gait");
            return;
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let walks_per_s = walks_per_s(&simulator, cores, MEASURED);
    findings.ok(
        CHECK,
        format!("{cores} cores simulate {walks_per_s:.1} walks of 5 s a second"),
    );
    findings.speed(Speed::new(settings, cores, walks_per_s));
}

/// Walks that threads on so many cores simulate in a second, measured for so long: of the robot
/// as it should be and with each leg lost.
fn walks_per_s(simulator: &Simulator, cores: usize, time: Duration) -> f64 {
    let layout = simulator.robot().layout();
    let healthy = Morphology::healthy(&layout);
    let damaged = (0..layout.legs()).map(|leg| healthy.clone().without_leg(leg));
    let morphologies: Vec<Morphology> = damaged.chain([healthy.clone()]).collect();
    let one_core = |first: usize| {
        let begin = Instant::now();
        let mut walks = 0.0;
        for morphology in morphologies.iter().cycle().skip(first) {
            simulator.simulate(morphology);
            walks += 1.0;
            if begin.elapsed() >= time {
                break;
            }
        }
        walks / begin.elapsed().as_secs_f64()
    };
    thread::scope(|scope| {
        let threads: Vec<_> = (0..cores)
            .map(|core| scope.spawn(move || one_core(core)))
            .collect();
        threads
            .into_iter()
            .filter_map(|thread| thread.join().ok())
            .sum()
    })
}

impl Speed {
    fn new(settings: &Settings, cores: usize, walks_per_s: f64) -> Self {
        let estimate = |task, walks: f64, threads: usize| Estimate {
            task,
            walks,
            threads,
            // More threads than cores are no faster.
            estimated_s: walks / (walks_per_s / cores as f64 * threads.min(cores) as f64),
        };
        let threads = settings.answer_threads();
        let mut estimates = Vec::new();
        if settings.atlas.is_none() {
            estimates.push(estimate("identification", IDENTIFICATION_WALKS, threads));
        }
        if settings.explains() {
            estimates.push(estimate("explanation", EXPLANATION_WALKS, threads));
        }
        // What is learned has a share of one processor.
        if settings.learning().is_some() {
            estimates.push(estimate("calibration", CALIBRATION_WALKS, 1));
        }
        Self {
            cores,
            walks_per_s,
            estimates,
        }
    }

    pub(super) fn lines(&self) -> String {
        let indent = " ".repeat(COLUMN);
        let line = |estimate: &Estimate| {
            let Estimate {
                task,
                walks,
                threads,
                estimated_s,
            } = estimate;
            let threads = match threads {
                1 => "1 thread".to_owned(),
                threads => format!("{threads} threads"),
            };
            format!(
                "{indent}estimate: {task} takes about {estimated_s:.0} s on {threads} ({walks:.0} walks)\n"
            )
        };
        self.estimates.iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_follow_from_walks_and_threads() {
        let settings = Settings {
            threads: Some(2),
            ..Settings::default()
        };
        let speed = Speed::new(&settings, 4, 100.0);
        let [identification, explanation, calibration] = speed.estimates.as_slice() else {
            panic!("{speed:?}");
        };
        assert_eq!(identification.estimated_s, IDENTIFICATION_WALKS / 50.0);
        assert_eq!(explanation.estimated_s, EXPLANATION_WALKS / 50.0);
        assert_eq!(calibration.estimated_s, CALIBRATION_WALKS / 25.0);
        let with_atlas = Settings {
            atlas: Some("jethexa.atlas".into()),
            explain: false,
            ..settings
        };
        assert_eq!(Speed::new(&with_atlas, 4, 100.0).estimates.len(), 1);
    }
}
