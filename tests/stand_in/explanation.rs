use mlr_ga::{ExplainSettings, explain};
use mlr_imu::Recording;
use mlr_residual::walk::{EvidenceSettings, Reported, WalkExplanation};

use crate::{
    model::{KNOWN, settings},
    recording,
    truth::Truth,
};

fn explained(recording: &Recording) -> WalkExplanation {
    assert!(recording.raw_beside_angles().is_some());
    let mut explanation = EvidenceSettings::default();
    // On the robot identified alone, for time, and with fewer hypotheses: both are sure to have all legs.
    (explanation.effort.bases, explanation.effort.screened) = (0, 1);
    (explanation.effort.entrants, explanation.effort.neighbours) = (24, 8);
    let how = ExplainSettings {
        identify: &settings(),
        explanation: &explanation,
    };
    explain(recording, KNOWN.with_atlas(), how, &())
        .unwrap()
        .explanation
}

fn quantity(reported: &Reported) -> f64 {
    match reported {
        Reported::Quantity(value) => *value,
        other => panic!("{other:?} is no quantity"),
    }
}

/// Whether the explanation names the damaged legs and, of effects, nothing but one of these.
fn is_explained_by(kinds: &[&str], truth: &Truth, explanation: &WalkExplanation) -> bool {
    let found: Vec<&str> = explanation
        .effects
        .iter()
        .map(|effect| effect.kind.as_str())
        .collect();
    explanation.damaged_legs == truth.damaged_legs()
        && found.len() == usize::from(!kinds.is_empty())
        && found.iter().all(|kind| kinds.contains(kind))
        && !explanation.unexplained
}

/// On a robot that walks straight, a slope tilts the sensor as a mounting does: which of the two is the likelier is
/// decided by less than rounding changes, that it is one of them is not.
#[test]
fn a_tilted_sensor_is_told_from_everything_but_a_slope() {
    let explanation = explained(&recording("undeclared-c"));
    let truth = &Truth::all()["undeclared-c"];
    let kinds = ["imu_misalignment", "slope"];
    assert_eq!(truth.effect.as_deref(), Some(kinds[0]));
    assert!(
        is_explained_by(&kinds, truth, &explanation),
        "{:?}",
        explanation.effects
    );
    let of = &explanation.effect_probability;
    assert!(kinds.iter().all(|kind| of[*kind] > 0.2), "{of:?}");
    let mut others = of
        .iter()
        .filter(|(kind, _)| !kinds.contains(&kind.as_str()));
    assert!(others.all(|(_, p)| *p < 0.1), "{of:?}");
    assert!(of["none"] < 0.05, "{of:?}");

    let mut tilted = explanation.alternatives.iter().flat_map(|one| &one.effects);
    let tilted = tilted.find(|effect| effect.kind == kinds[0]).unwrap();
    for (axis, name) in ["roll_deg", "pitch_deg"].into_iter().enumerate() {
        let tilt_deg = truth.plant["mis_deg"][axis].as_f64().unwrap();
        let found_deg = quantity(&tilted.parameters[name]);
        assert!((found_deg - tilt_deg).abs() < 0.5, "{name} {found_deg}");
        assert!(tilt_deg.abs() > 1.0, "none would be found as well");
    }
    let (before, after) = (explanation.error_before, explanation.error_after);
    assert!(after.validation_deg < 0.05 * before.validation_deg);
}

#[test]
fn a_robot_that_lacks_nothing_has_no_effects() {
    // Less of the walk takes less time.
    let explanation = explained(&recording("healthy").before(10.5));
    let truths = Truth::all();
    assert_eq!(truths["healthy"].effect, None);
    assert!(
        is_explained_by(&[], &truths["healthy"], &explanation),
        "{explanation:#?}"
    );
    assert!(!is_explained_by(
        &["imu_misalignment"],
        &truths["undeclared-c"],
        &explanation
    ));
    let of = &explanation.effect_probability;
    // Effects too small to be seen share the rest, no kind of them much.
    assert!(of["none"] > 0.5 && of["unknown"] < 0.1, "{of:?}");
    let likeliest = of.iter().filter(|(kind, _)| *kind != "none");
    assert!(
        likeliest.map(|(_, p)| *p).fold(0.0, f64::max) < 0.25,
        "{of:?}"
    );
}
