//! How far the body swings.

use super::*;

/// Root mean square of roll and pitch about their means over four cycles.
fn swing_deg(kind: &str, value: f64) -> f64 {
    let walks = Walks::lasting(6.2);
    let walked = walks.with(kind, Place::Robot, &[value]);
    let variance = |angles: &[f64]| {
        let angles = &angles[walks.at(2.0)..walks.at(6.0)];
        let mean_deg = mean(angles);
        mean(
            &angles
                .iter()
                .map(|a| (a - mean_deg).powi(2))
                .collect::<Vec<_>>(),
        )
    };
    (variance(&walked.roll) + variance(&walked.pitch)).sqrt()
}

#[test]
fn softer_servos_let_the_body_swing_further() {
    let [soft_deg, described_deg, stiff_deg] =
        [-1.0, 0.0, 0.5].map(|value| swing_deg("servo_stiffness", value));
    assert!(soft_deg > 1.3 * described_deg, "{soft_deg} {described_deg}");
    assert!(
        stiff_deg < 0.8 * described_deg,
        "{stiff_deg} {described_deg}"
    );
}

#[test]
fn softer_ground_lets_the_body_swing_further() {
    let [described_deg, soft_deg, softer_deg] =
        [0.0, 0.7, 2.0].map(|value| swing_deg("ground_compliance", value));
    assert!(soft_deg > 2.0 * described_deg, "{soft_deg} {described_deg}");
    assert!(softer_deg > 1.5 * soft_deg, "{softer_deg} {soft_deg}");
}
