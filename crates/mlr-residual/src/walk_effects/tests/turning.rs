//! How effects change the yaw: positive turns to the left.

use super::*;

fn turned_deg(walks: &Walks, kind: &str, place: Place, values: &[f64]) -> f64 {
    turn_deg(&walks.added(kind, place, values))
}

/// How an effect changes the turn of a robot that walks straight, and of one that turns.
fn changes_deg(kind: &str, place: Place, values: &[f64]) -> [f64; 2] {
    let walks = Walks::lasting(7.0);
    [described(), turning()].map(|model| {
        let with = changed(model.clone(), kind, place, values);
        turn_deg(&walks.of(&with)) - turn_deg(&walks.of(&model))
    })
}

#[test]
fn a_bias_about_the_vertical_turns_the_yaw_by_its_sign() {
    let walks = Walks::lasting(3.2);
    let elapsed_s = walks.record.times_s().last().unwrap() - walks.record.times_s()[0];
    for z_dps in [-2.0, 0.5] {
        let turned_deg = turned_deg(&walks, "gyro_bias", Place::Robot, &[0.0, 0.0, z_dps, 0.0]);
        assert!(
            (turned_deg - z_dps * elapsed_s).abs() < 0.01,
            "{turned_deg}"
        );
    }
}

#[test]
fn a_drift_bends_the_yaw_like_a_parabola() {
    let walks = Walks::lasting(3.2);
    let elapsed_s = walks.record.times_s().last().unwrap() - walks.record.times_s()[0];
    for dps_per_min in [-20.0, 10.0] {
        let turned_deg = turned_deg(&walks, "bias_drift", Place::Robot, &[dps_per_min]);
        let expected_deg = 0.5 * dps_per_min / 60.0 * elapsed_s * elapsed_s;
        assert!(
            (turned_deg / expected_deg - 1.0).abs() < 0.03,
            "{turned_deg}"
        );
    }
}

#[test]
fn a_scale_shrinks_or_stretches_turns_and_makes_none() {
    let walks = Walks::lasting(3.2);
    let turn = turn_deg(&walks.of(&turning()));
    for scale_less_1 in [-0.2, 0.2] {
        let values = [scale_less_1];
        let scaled = changed(turning(), "gyro_scale", Place::Robot, &values);
        let expected_deg = turn / (1.0 + scale_less_1);
        assert!(
            (turn_deg(&walks.of(&scaled)) - expected_deg).abs() < 0.05,
            "{turn}"
        );
        assert!(turned_deg(&walks, "gyro_scale", Place::Robot, &values).abs() < 0.05);
    }
}

/// MuJoCo, too, has it turn less on ground that grips more: by 0.9°.
#[test]
fn friction_changes_the_turn_of_a_lame_robot() {
    let [straight_deg, slippery_deg] = changes_deg("friction", Place::Robot, &[-1.2]);
    let [_, gripping_deg] = changes_deg("friction", Place::Robot, &[0.5]);
    assert!(
        slippery_deg.abs() > 1.0 && gripping_deg < -0.3,
        "{slippery_deg} {gripping_deg}"
    );
    // Control: a robot whose legs all push alike has nothing to turn it.
    assert!(straight_deg.abs() < 0.5, "{straight_deg}");
}

/// Where the right rear foot slips, nothing holds against what turns the robot to the left.
#[test]
fn a_foot_that_slips_changes_the_turn_of_a_lame_robot() {
    let [straight_deg, rear_right_deg] = changes_deg("foot_friction", Place::Leg(5), &[-1.5]);
    let [_, lame_deg] = changes_deg("foot_friction", Place::Leg(2), &[-1.5]);
    assert!(
        rear_right_deg > 3.0 && lame_deg < -1.0,
        "{rear_right_deg} {lame_deg}"
    );
    assert!(straight_deg.abs() < 0.5, "{straight_deg}");
}

#[test]
fn friction_and_play_of_the_joints_change_the_turn_of_a_lame_robot_the_more_there_is() {
    for (kind, weak, strong) in [("joint_friction", 0.1, 0.4), ("backlash", 0.01, 0.04)] {
        let [straight_deg, strong_deg] = changes_deg(kind, Place::Robot, &[strong]);
        let [_, weak_deg] = changes_deg(kind, Place::Robot, &[weak]);
        assert!(
            weak_deg > 0.1 && strong_deg > 3.0 * weak_deg,
            "{kind} {weak_deg} {strong_deg}"
        );
        // Control: the joints of both sides are alike, and nothing else turns this robot.
        assert!(straight_deg.abs() < 0.3, "{kind} {straight_deg}");
    }
}

#[test]
fn the_robot_turns_towards_its_weak_leg() {
    let walks = Walks::lasting(3.2);
    for leg in 0..6 {
        let turned_deg = turned_deg(&walks, "weak_leg", Place::Leg(leg), &[-1.5]);
        let to_its_side = if leg % 2 == 0 {
            turned_deg
        } else {
            -turned_deg
        };
        assert!(to_its_side > 0.8, "leg {}: {turned_deg}", leg + 1);
    }
}
