//! How the model may differ from the robot, whatever is in question.

use mlr_model::Variation;
use mlr_residual::walk::NuisanceSettings;

/// Variations of the model that each robot in question is simulated under, at most.
const DRAWS: usize = 6;

/// Some of the variations of an identification: the nominal model, servos, friction, payloads, slopes.
pub(super) fn usual(all: &[Variation]) -> Vec<Variation> {
    let count = all.len().min(DRAWS);
    let drawn = (0..count).map(|draw| all[draw * all.len() / count]);
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
