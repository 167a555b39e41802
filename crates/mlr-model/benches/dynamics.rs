//! Time of the equations of motion, by how much of the robot is left, and what they allocate
//! (nothing).
//!
//! ```text
//! cargo bench -p mlr-model --bench dynamics
//! ```

use mlr_model::{LostLinks, Morphology, Robot, dynamics::Dynamics};
use nalgebra::{DMatrix, DVector, UnitQuaternion};

#[global_allocator]
static ALLOCATOR: divan::AllocProfiler = divan::AllocProfiler::system();

const HEALTHY: &str = "111 111 111 111 111 111";
const DAMAGED: &str = "111 110 000 111 111 111";

fn main() {
    divan::main();
}

/// A robot with all that its equations need, in some state.
struct Case {
    dynamics: Dynamics,
    attitude: UnitQuaternion<f64>,
    joints_rad: Vec<f64>,
    velocities: DVector<f64>,
    forces: DVector<f64>,
    result: DVector<f64>,
    matrix: DMatrix<f64>,
}

impl Case {
    fn new(morphology: &str) -> Self {
        let robot = Robot::jethexa();
        let morphology =
            Morphology::parse(morphology, &robot.layout()).expect("the arguments are morphologies");
        let dynamics = Dynamics::new(&robot, &morphology, LostLinks::Absent);
        let n = dynamics.freedoms();
        let some = |k: usize| (0.7 * k as f64).sin();
        Self {
            dynamics,
            attitude: UnitQuaternion::from_euler_angles(0.1, -0.2, 0.3),
            joints_rad: (0..n - 6).map(some).collect(),
            velocities: DVector::from_fn(n, |k, _| some(k + 3)),
            forces: DVector::from_fn(n, |k, _| some(k + 5)),
            result: DVector::zeros(n),
            matrix: DMatrix::zeros(n, n),
        }
    }
}

/// M(q), from joint angles on.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn mass_matrix(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let mut case = Case::new(morphology);
    bencher.bench_local(|| {
        let posed = case.dynamics.at(&case.attitude, &case.joints_rad);
        posed.mass_matrix(&mut case.matrix);
    });
}

/// C(q, ν), from joint angles on.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn coriolis_matrix(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let mut case = Case::new(morphology);
    bencher.bench_local(|| {
        let posed = case.dynamics.at(&case.attitude, &case.joints_rad);
        let moving = posed.moving(&case.velocities);
        moving.coriolis_matrix(&mut case.matrix);
    });
}

/// C ν + g, from joint angles on.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn bias_forces(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let mut case = Case::new(morphology);
    bencher.bench_local(|| {
        let posed = case.dynamics.at(&case.attitude, &case.joints_rad);
        posed.moving(&case.velocities).bias_forces(&mut case.result);
    });
}

/// Torques for accelerations, from joint angles on.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn inverse(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let mut case = Case::new(morphology);
    bencher.bench_local(|| {
        let posed = case.dynamics.at(&case.attitude, &case.joints_rad);
        let mut moving = posed.moving(&case.velocities);
        moving.inverse(&case.forces, &mut case.result);
    });
}

/// Accelerations under torques, from joint angles on.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn forward(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let mut case = Case::new(morphology);
    bencher.bench_local(|| {
        let posed = case.dynamics.at(&case.attitude, &case.joints_rad);
        let mut moving = posed.moving(&case.velocities);
        moving.forward(&case.forces, &mut case.result);
    });
}

/// What is done once for a robot and a morphology.
#[divan::bench(args = [HEALTHY, DAMAGED])]
fn construction(bencher: divan::Bencher<'_, '_>, morphology: &str) {
    let robot = Robot::jethexa();
    let morphology =
        Morphology::parse(morphology, &robot.layout()).expect("the arguments are morphologies");
    bencher.bench_local(|| Dynamics::new(&robot, &morphology, LostLinks::Absent));
}
