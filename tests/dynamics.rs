//! Mass matrix and bias forces against MuJoCo (`tools/golden/mujoco_dynamics.py`).
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{fs::File, io::BufReader};

use flate2::bufread::GzDecoder;
use mlr_golden_tests::data;
use mlr_model::{LostLinks, Morphology, Robot, dynamics::Dynamics};
use nalgebra::{DMatrix, DVector, UnitQuaternion};

/// Relative to the largest entry of the same matrix or vector. MuJoCo's numbers are written with
/// eleven digits.
const LARGEST_ERROR: f64 = 1e-8;
const STATES: usize = 20;

const CASES: [(&str, &str, LostLinks); 6] = [
    ("healthy", "111 111 111 111 111 111", LostLinks::Absent),
    ("leg3-lost", "111 111 000 111 111 111", LostLinks::Absent),
    (
        "legs2-3-tibia-lost",
        "111 110 110 111 111 111",
        LostLinks::Absent,
    ),
    (
        "legs1-4-lost-5-coxa",
        "000 111 111 000 100 111",
        LostLinks::Absent,
    ),
    (
        "legs3-4-6-locked",
        "111 111 000 110 111 100",
        LostLinks::Locked,
    ),
    ("body-alone", "000 000 000 000 000 000", LostLinks::Absent),
];

/// Mass matrix and bias forces of one state.
struct State {
    mass: DMatrix<f64>,
    bias: DVector<f64>,
}

impl State {
    /// What a row of a golden file says, and what we make of the same state.
    fn golden_and_ours(row: &[f64], dynamics: &mut Dynamics) -> (Self, Self) {
        let n = dynamics.freedoms();
        let (attitude, row) = row.split_at(3);
        let (joints_rad, row) = row.split_at(n - 6);
        let (velocities, row) = row.split_at(n);
        let (bias, lower) = row.split_at(n);
        assert_eq!(lower.len(), n * (n + 1) / 2);
        let entry = |i: usize, j: usize| lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let golden = Self {
            mass: DMatrix::from_fn(n, n, entry),
            bias: DVector::from_column_slice(bias),
        };
        let attitude = UnitQuaternion::from_euler_angles(attitude[0], attitude[1], attitude[2]);
        let posed = dynamics.at(&attitude, joints_rad);
        let mut ours = Self {
            mass: DMatrix::zeros(n, n),
            bias: DVector::zeros(n),
        };
        posed.mass_matrix(&mut ours.mass);
        let mut moving = posed.moving(&DVector::from_column_slice(velocities));
        moving.bias_forces(&mut ours.bias);
        (golden, ours)
    }

    /// Largest errors of mass and bias, relative to the largest entries of `golden`.
    fn errors(&self, golden: &Self) -> [f64; 2] {
        [
            (&self.mass - &golden.mass).amax() / golden.mass.amax(),
            (&self.bias - &golden.bias).amax() / golden.bias.amax(),
        ]
    }
}

fn rows(case: &str) -> Vec<Vec<f64>> {
    let path = data(&format!("golden/mujoco/dynamics/{case}.csv.gz"));
    let text = GzDecoder::new(BufReader::new(File::open(path).unwrap()));
    let mut reader = csv::Reader::from_reader(text);
    let rows = reader.deserialize();
    rows.map(|row| row.unwrap()).collect()
}

#[test]
fn mass_and_bias_are_those_of_mujoco() {
    for (case, morphology, lost_links) in CASES {
        let robot = Robot::jethexa();
        let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
        let mut dynamics = Dynamics::new(&robot, &morphology, lost_links);
        let (mut count, mut most) = (0, [0.0_f64; 2]);
        for row in rows(case) {
            let (golden, ours) = State::golden_and_ours(&row, &mut dynamics);
            let errors = ours.errors(&golden);
            assert!(
                errors.iter().all(|error| *error < LARGEST_ERROR),
                "{case}, state {count}: mass {:e}, bias {:e}",
                errors[0],
                errors[1]
            );
            most = [0, 1].map(|k| most[k].max(errors[k]));
            count += 1;
        }
        assert_eq!(count, STATES, "{case}");
        println!("{case}: mass {:.0e}, bias {:.0e}", most[0], most[1]);
    }
}

/// The controls: another robot, and lost links that are not what they were taken for.
#[test]
fn another_robot_disagrees() {
    let robot = Robot::jethexa();
    let heavier = Robot::JETHEXA_TOML.replace("mass_kg = 0.08993", "mass_kg = 0.08994");
    let heavier = Robot::from_toml(&heavier).unwrap();
    let others = [
        (
            heavier,
            "leg3-lost",
            "111 111 000 111 111 111",
            LostLinks::Absent,
        ),
        (
            robot,
            "legs3-4-6-locked",
            "111 111 000 110 111 100",
            LostLinks::Absent,
        ),
    ];
    for (robot, case, morphology, lost_links) in others {
        let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
        let mut dynamics = Dynamics::new(&robot, &morphology, lost_links);
        for row in rows(case) {
            let (golden, ours) = State::golden_and_ours(&row, &mut dynamics);
            let errors = ours.errors(&golden);
            assert!(
                errors.iter().all(|error| *error > LARGEST_ERROR),
                "{errors:?}"
            );
        }
    }
}
