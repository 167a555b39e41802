//! Time of one simulated walk of 5 s, by how much of the robot is left.
//!
//! ```text
//! cargo bench -p mlr-model
//! ```

use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};

fn main() {
    divan::main();
}

#[divan::bench(args = [
    "111 111 111 111 111 111",
    "111 111 000 111 111 111",
    "111 110 111 100 111 111",
    "000 111 111 000 111 111",
    "000 000 000 111 111 111",
])]
fn walk(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let robot = Robot::jethexa();
    let morphology =
        Morphology::parse(morphology, &robot.layout()).expect("the arguments are morphologies");
    let simulator = Simulator::new(robot, &Gait::tripod(), SimulationSettings::default())
        .expect("the embedded robot can walk the embedded gait");
    bencher.bench(|| match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory.orientation.len(),
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    });
}

/// Checking robot and gait and solving the inverse kinematics, once per search.
#[divan::bench]
fn prepare(bencher: divan::Bencher<'_, '_>) {
    let robot = Robot::jethexa();
    bencher.bench(|| {
        Simulator::new(
            robot.clone(),
            &Gait::tripod(),
            SimulationSettings::default(),
        )
        .is_ok()
    });
}
