use mlr_model::Morphology;

use super::Share;
use crate::{
    report::Report,
    words::{left_of_leg, legs, percent},
};

/// Which legs are damaged.
pub(super) struct IdentificationView {
    pub(super) verdict: String,
    pub(super) is_doubtful: bool,
    pub(super) sure: String,
    pub(super) notes: Vec<String>,
    pub(super) legs: Vec<LegView>,
    pub(super) morphologies: Vec<MorphologyView>,
    pub(super) search: String,
    /// Whether the best morphology has not the least F.
    pub(super) is_f_overruled: bool,
    pub(super) cost: String,
}

pub(super) struct LegView {
    pub(super) number: usize,
    pub(super) name: String,
    pub(super) left: String,
    pub(super) damage: Option<Share>,
}

pub(super) struct MorphologyView {
    pub(super) rank: usize,
    pub(super) vector: String,
    pub(super) words: String,
    pub(super) share: Share,
    pub(super) locked: String,
    pub(super) cost: String,
}

impl IdentificationView {
    pub(super) fn of(report: &Report<'_>) -> Self {
        let found = report.identification;
        let best = &found.morphology;
        let damaged = best.damaged_legs();
        let verdict = if found.implausible {
            "No morphology explains this log".into()
        } else if damaged.is_empty() {
            "No leg is damaged".into()
        } else {
            format!("Damaged: {}", legs(&damaged, report.robot))
        };
        let sure = format!(
            "{}, of exactly these links ({}) {}.",
            match found.implausible {
                true => format!(
                    "The closest is “{}”: the probability of these legs is {}",
                    best.describe(),
                    percent(found.legs_probability)
                ),
                false if damaged.is_empty() => format!(
                    "The probability that every leg is whole is {}",
                    percent(found.legs_probability)
                ),
                false => format!(
                    "The probability of exactly these legs is {}",
                    percent(found.legs_probability)
                ),
            },
            best.describe(),
            percent(found.probability)
        );
        Self {
            verdict,
            is_doubtful: found.implausible,
            sure,
            notes: notes(report),
            legs: legs_of(report),
            is_f_overruled: found
                .alternatives
                .iter()
                .any(|one| one.cost_rad < found.cost_rad),
            morphologies: morphologies(report),
            search: format!(
                "{} morphologies were looked at ({}){}.",
                found.evaluations,
                match found.search.as_str() {
                    "ga" => "genetic algorithm",
                    "exact" => "all that are feasible, simulated",
                    "atlas" => "all that are feasible, from the atlas",
                    other => other,
                },
                match found.elapsed_s {
                    Some(elapsed_s) => format!(" in {elapsed_s:.1} s"),
                    None => String::new(),
                }
            ),
            cost: format!(
                "F = {:.2} rad on the nominal model, {:.2}° per sample and axis",
                found.cost_rad, found.mean_error_deg
            ),
        }
    }
}

/// What a reader should know before the answer is believed.
fn notes(report: &Report<'_>) -> Vec<String> {
    let found = report.identification;
    let mut notes = Vec::new();
    if let Some(doubt) = found
        .something_else_probability
        .filter(|doubt| *doubt >= 0.05)
    {
        notes.push(format!(
            "{}: the probability that something else than damage to legs decides how the robot walks.",
            percent(doubt)
        ));
    }
    let alike = found.indistinguishable.len();
    if alike > 0 {
        let others = match alike {
            1 => "1 other morphology".to_string(),
            more => format!("{more} other morphologies"),
        };
        notes.push(format!(
            "The log cannot tell this morphology from {others}: together they hold nearly all of the \
             probability."
        ));
    }
    if let Some(locked) = found.locked_probability {
        notes.push(format!(
            "{}: the probability that the lost links are locked and still on the robot, not gone.",
            percent(locked)
        ));
    }
    notes
}

fn legs_of(report: &Report<'_>) -> Vec<LegView> {
    let found = report.identification;
    let legs = report.robot.legs().iter().enumerate();
    legs.map(|(index, leg)| LegView {
        number: index + 1,
        name: leg.name.clone(),
        left: left_of_leg(&found.morphology, index),
        damage: found
            .leg_damage_probability
            .get(index)
            .copied()
            .map(Share::of),
    })
    .collect()
}

/// Of the ranked morphologies, those that are shown.
const SHOWN: usize = 20;

fn morphologies(report: &Report<'_>) -> Vec<MorphologyView> {
    let found = report.identification;
    let best = (
        &found.morphology,
        found.probability,
        found.locked_probability,
        found.cost_rad,
    );
    let others = found.alternatives.iter();
    let others = others.map(|one| {
        (
            &one.morphology,
            one.probability,
            one.locked_probability,
            one.cost_rad,
        )
    });
    let ranked = (1..).zip(std::iter::once(best).chain(others));
    let view = |(rank, (morphology, probability, locked, cost_rad)): (
        usize,
        (&Morphology, f64, Option<f64>, f64),
    )| MorphologyView {
        rank,
        vector: morphology.to_string(),
        words: morphology.describe(),
        share: Share::of(probability),
        locked: locked.map_or("–".into(), percent),
        cost: format!("{cost_rad:.2}"),
    };
    ranked.take(SHOWN).map(view).collect()
}
