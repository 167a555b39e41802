//! How the model may differ from the robot, whatever is in question.

use mlr_model::{Variation, standard_normal};
use mlr_residual::walk::NuisanceSettings;
use rand_chacha::ChaCha8Rng;

/// Variations of the model that each robot in question is simulated under, at most.
const DRAWS: usize = 6;

/// Some of the variations of an identification: the nominal model, servos, friction, payloads, slopes.
pub(super) fn usual(all: &[Variation]) -> Vec<Variation> {
    let count = all.len().min(DRAWS);
    let drawn = (0..count).map(|draw| all[draw * all.len() / count]);
    drawn.collect()
}

/// Draws of effects of any size. A payload has a mass and a place: three for each of these.
const DRAWS_OF_ANY_SIZE: usize = 12;

/// Draws of what robots of one make and days differ by, one for each draw of an effect of any size.
pub(super) fn drawn(generator: &mut ChaCha8Rng) -> Vec<Variation> {
    let nuisance = NuisanceSettings::default();
    let draws = 0..DRAWS_OF_ANY_SIZE;
    let drawn = draws.map(|_| Variation {
        stiffness: (nuisance.ln_stiffness * standard_normal(generator)).exp(),
        friction: (nuisance.ln_friction * standard_normal(generator)).exp(),
        ..Variation::default()
    });
    drawn.collect()
}

/// What robots of one make and days differ by, where effects are in question, among which are the others: the
/// nominal model, and stiffness of the servos and friction a deviation higher or lower.
pub(super) fn of_the_make() -> Vec<Variation> {
    let nuisance = NuisanceSettings::default();
    let signs = [
        (0.0, 0.0),
        (1.0, 1.0),
        (1.0, -1.0),
        (-1.0, 1.0),
        (-1.0, -1.0),
    ];
    let of_signs = signs.map(|(stiffness, friction): (f64, f64)| Variation {
        stiffness: (stiffness * nuisance.ln_stiffness).exp(),
        friction: (friction * nuisance.ln_friction).exp(),
        ..Variation::default()
    });
    of_signs.into()
}
