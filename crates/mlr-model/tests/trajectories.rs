//! Gaits that are joint trajectories, in the simulator.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Gait, JointCommands, JointTrajectory, ModelError, Morphology, Motion, Outcome, Robot,
    SimulationSettings, Simulator,
};
use proptest::prelude::*;

/// Joint angles of the JetHexa.
const JOINTS: usize = 18;
/// Rows of a cycle of the tripod.
const CYCLE: usize = 50;

/// A gait that commands what the tripod does until `duration_s`.
fn written_down(duration_s: f64) -> (Gait, JointTrajectory) {
    let tripod = Gait::tripod();
    let joints = JointTrajectory::commanded(&Robot::jethexa(), &tripod, duration_s).unwrap();
    (playing(joints.clone()), joints)
}

fn playing(joints: JointTrajectory) -> Gait {
    Gait {
        name: "rows".into(),
        period_s: 1.0,
        motion: Motion::Joints(joints),
    }
}

/// With one angle of one row changed.
fn with_a_changed_row(joints: &JointTrajectory, row: usize, joint: usize, by_rad: f64) -> Gait {
    let mut rows_rad = joints.rows_rad().to_vec();
    rows_rad[row][joint] += by_rad;
    playing(JointTrajectory::new(joints.row_s(), rows_rad, joints.repeat_rows()).unwrap())
}

/// Roll, pitch and yaw of the walk, bit by bit.
fn walk(gait: &Gait, legs_lost: &str, duration_s: f64) -> Vec<u64> {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost(legs_lost, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        duration_s,
        ..Default::default()
    };
    let simulator = Simulator::new(robot, gait, settings).unwrap();
    match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => {
            let angles = trajectory.orientation.angles_rad();
            let angles = [&angles.roll, &angles.pitch, &angles.yaw];
            angles
                .into_iter()
                .flatten()
                .map(|angle| angle.to_bits())
                .collect()
        }
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn a_gait_of_feet_written_down_row_by_row_is_the_same_walk(
        legs_lost in prop::sample::select(vec!["", "3", "1,4"]),
        repeats in any::<bool>(),
        row in 1..3 * CYCLE,
        joint in 0..JOINTS,
    ) {
        const DURATION_S: f64 = 4.5;
        let tripod = walk(&Gait::tripod(), legs_lost, DURATION_S);
        // Three seconds of it, the last of which repeats; or all of it.
        let (rows, joints) = written_down(if repeats { 3.0 } else { DURATION_S });
        prop_assert_eq!(joints.repeat_rows().is_some(), true);
        prop_assert_eq!(walk(&rows, legs_lost, DURATION_S) == tripod, true);
        // The control: the legs that are left move in the first three seconds, and so does one
        // row that is changed.
        let lost = legs_lost.split(',').any(|leg| leg.parse() == Ok(joint / 3 + 1));
        let changed = with_a_changed_row(&joints, row, joint, 0.05);
        prop_assert_eq!(walk(&changed, legs_lost, DURATION_S) == tripod, lost);
    }

    #[test]
    fn a_trajectory_that_does_not_repeat_holds_its_end(end in 5..2 * CYCLE) {
        let (_, joints) = written_down(2.0);
        let rows_rad = joints.rows_rad()[..=end].to_vec();
        let ending = playing(JointTrajectory::new(joints.row_s(), rows_rad.clone(), None).unwrap());
        let repeating = JointTrajectory::new(joints.row_s(), rows_rad.clone(), Some(0..end + 1));
        let repeating = Gait { period_s: 0.02 * (end + 1) as f64, ..playing(repeating.unwrap()) };
        let robot = Robot::jethexa();
        let commands = |gait: &Gait| JointCommands::new(&robot, gait, 10.0).unwrap();
        let (held, goes_on) = (commands(&ending), commands(&repeating));
        let end_s = 0.02 * end as f64;
        prop_assert!((ending.duration_s().unwrap() - end_s).abs() < 1e-9);
        for (joint, (first_rad, last_rad)) in rows_rad[0].iter().zip(&rows_rad[end]).enumerate() {
            let angle_rad = |commands: &JointCommands, time_s| commands.angle_rad(joint / 3, joint % 3, time_s);
            prop_assert_eq!(angle_rad(&held, -1.0), *first_rad);
            for later_s in [0.0, 0.02, 1.0, 7.0] {
                prop_assert_eq!(angle_rad(&held, end_s + later_s), *last_rad);
            }
            // The control: what repeats goes back to its first row.
            prop_assert_eq!(angle_rad(&goes_on, end_s + 0.02), *first_rad);
        }
    }
}

#[test]
fn slowed_down_it_walks_almost_like_the_gait_of_feet_slowed_down() {
    // Rows are joined by straight lines where the feet follow curves.
    let robot = Robot::jethexa();
    let (mut rows, _) = written_down(5.0);
    let mut tripod = Gait::tripod();
    for gait in [&mut rows, &mut tripod] {
        gait.slow_down(1.07);
    }
    let commands = |gait: &Gait| JointCommands::new(&robot, gait, 5.0).unwrap();
    let apart_rad = |a: &JointCommands, b: &JointCommands| {
        let angles = (0..250).flat_map(|tick| (0..JOINTS).map(move |joint| (tick, joint)));
        let apart = angles.map(|(tick, joint)| {
            let angle_rad = |commands: &JointCommands| {
                commands.angle_rad(joint / 3, joint % 3, 0.02 * f64::from(tick))
            };
            (angle_rad(a) - angle_rad(b)).abs()
        });
        apart.fold(0.0, f64::max)
    };
    let slowed_rad = apart_rad(&commands(&rows), &commands(&tripod));
    assert!(slowed_rad < 0.02, "{slowed_rad}");
    // The control: not slowed down it is another gait.
    let not_slowed_rad = apart_rad(&commands(&written_down(5.0).0), &commands(&tripod));
    assert!(not_slowed_rad > 0.3, "{not_slowed_rad}");
}

#[test]
fn a_trajectory_for_other_joints_is_refused() {
    let (rows, joints) = written_down(2.0);
    let robot = Robot::jethexa();
    let rows_rad = joints.rows_rad().iter().map(|row| row[1..].to_vec());
    let few = playing(JointTrajectory::new(0.02, rows_rad.collect(), None).unwrap());
    let error = JointCommands::new(&robot, &few, 1.0).unwrap_err();
    assert!(
        matches!(
            error,
            ModelError::JointCount {
                gait: 17,
                robot: 18
            }
        ),
        "{error}"
    );
    assert!(JointCommands::new(&robot, &rows, 1.0).is_ok());
}

#[test]
fn a_first_row_in_which_the_robot_does_not_stand_is_refused() {
    let robot = Robot::jethexa();
    let standing_in = |row_rad: &[f64; 3]| {
        let rows_rad = vec![row_rad.repeat(6); 2];
        let gait = playing(JointTrajectory::new(0.02, rows_rad, None).unwrap());
        JointCommands::new(&robot, &gait, 1.0)
    };
    let error = standing_in(&[0.0, 1.2, 0.0]).unwrap_err();
    assert!(matches!(error, ModelError::NoFooting { .. }), "{error}");
    assert!(error.to_string().contains("joints_rad"), "{error}");
    assert!(standing_in(&[0.0, 0.5, -1.8]).is_ok());
}
