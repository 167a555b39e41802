//! An effect drawn from its prior is one that a fit may find.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::*;

fn drawn(effect: &dyn WalkEffect, morphology: &Morphology, seed: u64) -> WalkModel {
    let mut model = described();
    effect.draw(morphology, &mut model, &mut ChaCha8Rng::seed_from_u64(seed));
    model
}

#[test]
fn every_effect_is_drawn_with_many_sizes_and_the_same_by_the_same_seed() {
    let robot = Robot::jethexa();
    let whole = Morphology::healthy(&robot.layout());
    for effect in LIBRARY {
        let of = |seed| drawn(*effect, &whole, seed);
        assert_eq!(of(1), of(1), "{}", effect.kind());
        let sizes: std::collections::BTreeSet<String> =
            (0..8).map(|seed| format!("{:?}", of(seed))).collect();
        // A few may lie at a bound.
        assert!(sizes.len() >= 4, "{}", effect.kind());
        for seed in 0..8 {
            assert!(of(seed).simulation.check_on(&robot).is_ok());
            assert!(robot.clone().with_servo(of(seed).servo).is_ok());
        }
    }
}

#[test]
fn where_an_effect_can_sit_nowhere_nothing_is_drawn() {
    let layout = Robot::jethexa().layout();
    let none_left = Morphology::parse_legs_lost("1,2,3,4,5,6", &layout).unwrap();
    let foot_friction = effect("foot_friction");
    assert_eq!(drawn(foot_friction, &none_left, 1), described());
    let one_left = Morphology::parse_legs_lost("1,2,3,4,5", &layout).unwrap();
    // The control: only the leg that has its foot can lose its grip.
    let faults = drawn(foot_friction, &one_left, 1).simulation.faults;
    assert!(
        matches!(faults[..], [mlr_model::Fault::FootFriction { leg: 6, .. }]),
        "{faults:?}"
    );
}
