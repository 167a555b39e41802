use mlr_model::Robot;

use super::Share;
use crate::{
    answer::{Effect, Errors, Explanation, Rival},
    words::{kind, legs, name_and_unit, percent, signed},
};

/// Kinds of effects and hypotheses that are shown, and the least probability of a kind.
const SHOWN: usize = 8;
const LEAST_SHOWN: f64 = 0.005;

/// What else is wrong.
pub(super) struct ExplanationView {
    pub(super) verdict: String,
    pub(super) is_unexplained: bool,
    pub(super) damage: String,
    pub(super) kinds: Vec<(String, Share)>,
    pub(super) effects: Vec<EffectView>,
    pub(super) hypotheses: Vec<HypothesisView>,
    pub(super) errors: Vec<ErrorView>,
    pub(super) stretches: [String; 2],
    pub(super) remains: String,
    /// Axis; mean without and with the effects; irregular part without and with them.
    pub(super) residuals: Vec<[String; 5]>,
    pub(super) candidates: Vec<[String; 3]>,
    pub(super) warnings: Vec<String>,
}

pub(super) struct EffectView {
    pub(super) name: String,
    pub(super) explains: String,
    pub(super) probability: Option<Share>,
    pub(super) parameters: Vec<ParameterView>,
    pub(super) rivals: String,
}

pub(super) struct ParameterView {
    pub(super) name: String,
    pub(super) value: String,
    pub(super) interval: String,
    pub(super) note: &'static str,
}

pub(super) struct HypothesisView {
    pub(super) damage: String,
    pub(super) effects: String,
    pub(super) share: Share,
}

pub(super) struct ErrorView {
    pub(super) name: &'static str,
    /// Over all axes, roll, pitch and yaw, where parameters were fitted, and where not.
    pub(super) values: Vec<String>,
}

impl ExplanationView {
    pub(super) fn of(found: &Explanation, robot: &Robot) -> Self {
        let effects: Vec<String> = found.effects.iter().map(|one| kind(&one.kind)).collect();
        let verdict = if found.unexplained {
            "Something is wrong that no effect of the library makes".into()
        } else if effects.is_empty() {
            "Nothing else is wrong that the log tells".into()
        } else {
            format!("Besides: {}", effects.join(" and "))
        };
        let stretch = |[from_s, to_s]: [f64; 2]| format!("{from_s:.1} to {to_s:.1} s");
        let mut kinds: Vec<(&String, &f64)> = found.effect_probability.iter().collect();
        kinds.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let kinds = kinds.into_iter().filter(|(_, p)| **p >= LEAST_SHOWN);
        let candidates = found.candidates.iter().map(|one| {
            let error = one
                .validation_deg
                .map_or("–".into(), |deg| format!("{deg:.2}°"));
            [kind(&one.kind), error, one.verdict.clone()]
        });
        Self {
            verdict,
            is_unexplained: found.unexplained,
            damage: match found.morphology.is_healthy() {
                true => "No leg is damaged, with the effects in place.".into(),
                false => format!(
                    "With the effects in place, {} damaged: {}.",
                    match found.morphology.damaged_legs().as_slice() {
                        [one] => format!("{} is", legs(&[*one], robot)),
                        several => format!("{} are", legs(several, robot)),
                    },
                    found.morphology.describe()
                ),
            },
            kinds: kinds
                .take(SHOWN)
                .map(|(name, p)| (kind(name), Share::of(*p)))
                .collect(),
            effects: found.effects.iter().map(EffectView::of).collect(),
            hypotheses: hypotheses(found),
            errors: vec![
                ErrorView::of("as described", &found.error_before),
                ErrorView::of("calibrated", &found.error_calibrated),
                ErrorView::of("with effects", &found.error_after),
            ],
            stretches: [found.stretches_s.fit, found.stretches_s.validation].map(stretch),
            remains: remains(found),
            residuals: residuals(found),
            candidates: candidates.collect(),
            warnings: found.warnings.clone(),
        }
    }
}

impl EffectView {
    fn of(effect: &Effect) -> Self {
        let parameters = effect.parameters.iter().map(|(field, value)| {
            let (name, unit) = name_and_unit(field);
            let with_unit = |text: String| match unit {
                "" => text,
                "°" => text + "°",
                unit => format!("{text} {unit}"),
            };
            let interval = effect.interval_95.get(field);
            let is_in = |names: &[String]| names.iter().any(|one| one == field);
            ParameterView {
                name,
                value: with_unit(signed(&value.to_string())),
                interval: interval.map_or("–".into(), |[low, high]| {
                    with_unit(signed(&format!("{low:.3} to {high:.3}")))
                }),
                note: match (is_in(&effect.undetermined), is_in(&effect.at_bound)) {
                    (true, _) => "not determined by the log",
                    (_, true) => "at its bound",
                    _ => "",
                },
            }
        });
        let mut rivals: Vec<String> = effect.rivals.iter().map(|one| kind(&one.kind)).collect();
        rivals.dedup();
        Self {
            name: kind(&effect.kind),
            explains: effect.explains.clone(),
            probability: effect.probability.map(Share::of),
            parameters: parameters.collect(),
            rivals: rivals.join(", "),
        }
    }
}

impl ErrorView {
    fn of(name: &'static str, errors: &Errors) -> Self {
        let stretch = |all_deg: f64, axes_deg: [f64; 3]| {
            let values = std::iter::once(all_deg).chain(axes_deg);
            values.map(|deg| format!("{deg:.2}°"))
        };
        let fit = stretch(errors.fit_deg, errors.fit_axes_deg);
        let unseen = stretch(errors.validation_deg, errors.validation_axes_deg);
        Self {
            name,
            values: fit.chain(unseen).collect(),
        }
    }
}

fn hypotheses(found: &Explanation) -> Vec<HypothesisView> {
    let shown = found.alternatives.iter().take(SHOWN);
    shown
        .map(|one| {
            let locked = if one.locked_links { ", locked" } else { "" };
            let kinds = one
                .effects
                .iter()
                .map(|Rival { kind: name, .. }| kind(name));
            let mut kinds: Vec<String> = kinds.collect();
            if one.unknown {
                kinds.push("something unknown".into());
            }
            HypothesisView {
                damage: format!("{}{locked}", one.morphology.describe()),
                effects: if kinds.is_empty() {
                    "none".into()
                } else {
                    kinds.join(" + ")
                },
                share: Share::of(one.probability),
            }
        })
        .collect()
}

fn residuals(found: &Explanation) -> Vec<[String; 5]> {
    let (before, after) = (&found.residual_before, &found.residual_after);
    let axes = [
        ("roll", &before.roll, &after.roll),
        ("pitch", &before.pitch, &after.pitch),
        ("yaw", &before.yaw, &after.yaw),
    ];
    let deg = |value: f64| signed(&format!("{value:.2}°"));
    axes.map(|(axis, before, after)| {
        [
            axis.into(),
            deg(before.walking_deg),
            deg(after.walking_deg),
            deg(before.irregular_deg),
            deg(after.irregular_deg),
        ]
    })
    .into()
}

fn remains(found: &Explanation) -> String {
    let left = &found.residual;
    let mut text = format!(
        "{:.2}° of {} remain, {:.2}° are usual: {}.",
        left.remaining_deg, left.axis, left.usual_deg, left.explains
    );
    if let (Some(frequency_hz), Some(amplitude_deg)) = (left.frequency_hz, left.amplitude_deg) {
        text += &format!(
            " The strongest oscillation has {frequency_hz:.2} Hz and {amplitude_deg:.2}°, {} step with \
             the gait.",
            if left.locked_to_gait { "in" } else { "out of" }
        );
    }
    text += &format!(
        " Sensor noise and the model's own shortcomings usually leave {:.2}°. {} is the probability of \
         something unknown.",
        found.noise_floor_deg,
        percent(
            found
                .effect_probability
                .get("unknown")
                .copied()
                .unwrap_or(0.0)
        )
    );
    text
}
