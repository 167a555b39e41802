//! The report of a selection: errors on every stretch, intervals, the residual.

use super::{
    comparison::ABOVE_NOISE,
    search::{Rejected, Search, Selected, Step, what_every_sensor_has},
};
use crate::{
    Candidate, Effect, ErrorDeg, ResidualDescription, SensorExplanation, SensorRecord, Stretches,
    baselines::baselines,
    fitted_model::FittedModel,
    statistics::{Noise, dominant_frequency, whiteness_p_value},
};

/// The rate counts as clipped when its largest value is repeated so many times in a row.
const CLIPPED_READINGS: usize = 3;
/// Cycles in the test stretch from which on an oscillation is told from a drift: one a block.
const MIN_CYCLES: f64 = 15.0;

/// The report of `selected`, whose parameters are those of `refitted`.
pub(super) fn explanation(
    record: &SensorRecord,
    search: &Search<'_>,
    selected: &Selected,
    refitted: &FittedModel,
) -> SensorExplanation {
    let stretches = record.stretches();
    let error_of = |model: &FittedModel| ErrorDeg::new(record, &model.residual_deg(record));
    let walk_s = refitted.random_walk_s(&stretches, stretches.test);
    let noise_floor_deg = noise_before_test(search.record(), refitted).floor_deg(walk_s);
    let error_after = error_of(refitted);
    let mut explanation = SensorExplanation {
        stretches_s: stretches,
        effects: selected
            .steps
            .iter()
            .map(|step| effect(step, refitted, error_of(&step.model)))
            .collect(),
        unexplained: error_after.validation_deg > ABOVE_NOISE * noise_floor_deg,
        error_before: ErrorDeg::new(record, &FittedModel::default().residual_deg(record)),
        error_after,
        baselines: baselines(record),
        noise_floor_deg,
        candidates: selected
            .rejected
            .iter()
            .map(|rejected| candidate(rejected, rejected.model.as_ref().map(error_of)))
            .collect(),
        residual: residual(record, &stretches, refitted, &error_after),
        warnings: warnings(record),
    };
    add_intervals(refitted, &mut explanation);
    explanation
}

/// The noise of the sensor on fit and selection: the smaller reading of the final model and of
/// one with all that every sensor has.
fn noise_before_test(seen: &SensorRecord, refitted: &FittedModel) -> Noise {
    let period_s = seen.signals().period_s();
    let noise_of = |model: &FittedModel| Noise::of(&model.residual_deg(seen), period_s);
    let always = FittedModel::new(seen, what_every_sensor_has(seen));
    noise_of(refitted).least(noise_of(&always))
}

fn effect(step: &Step, refitted: &FittedModel, error_deg: ErrorDeg) -> Effect {
    let kind = step.effect.kind();
    Effect {
        kind: kind.into(),
        parameters: refitted.parameters_of(kind),
        interval_95: [].into(),
        error_deg: Some(error_deg),
        explains: step.effect.signature().into(),
        p_value: Some(step.p_value),
        rivals: step.rivals.clone(),
    }
}

fn candidate(rejected: &Rejected, error: Option<ErrorDeg>) -> Candidate {
    let kind = rejected.effect.kind();
    let parameters = rejected
        .model
        .as_ref()
        .map(|model| model.parameters_of(kind));
    Candidate {
        kind: kind.into(),
        parameters: parameters.unwrap_or_default(),
        selection_deg: error.map(|error| error.selection_deg),
        validation_deg: error.map(|error| error.validation_deg),
        verdict: rejected.verdict.clone(),
    }
}

/// Intervals of the parameters, and warnings where they tell nothing.
fn add_intervals(refitted: &FittedModel, explanation: &mut SensorExplanation) {
    let free = refitted.parameters().filter(|(_, p, _)| !p.is_fixed());
    for (kind, parameter, width) in free {
        let name = &parameter.name;
        let value = parameter.start;
        let effect = explanation.effects.iter_mut().find(|e| e.kind == kind);
        if parameter.is_at_bound(value) {
            explanation.warnings.push(format!(
                "{kind}: {name} = {value} is at the bound of what was allowed"
            ));
        } else if !width.is_finite() {
            explanation
                .warnings
                .push(format!("{kind}: {name} cannot be told from this record"));
        } else if let Some(effect) = effect {
            let interval = [value - width, value + width];
            effect.interval_95.insert(name.clone(), interval);
            let absent = parameter.neutral;
            if absent.is_some_and(|absent| interval[0] <= absent && absent <= interval[1]) {
                explanation.warnings.push(format!(
                    "{kind}: the 95 % interval of {name} includes {}, no effect",
                    absent.unwrap_or_default()
                ));
            }
        }
    }
}

/// What is left on the test stretch.
fn residual(
    record: &SensorRecord,
    stretches: &Stretches,
    refitted: &FittedModel,
    error: &ErrorDeg,
) -> ResidualDescription {
    let residual_deg = refitted.residual_deg(record);
    let [.., values] = stretches.divide(record, &residual_deg);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
    let tenth = values.len() / 10;
    let drift_deg = mean(&values[values.len() - tenth..]) - mean(&values[..tenth]);
    let strongest = dominant_frequency(values, record.signals().period_s());
    let whiteness_p_value = whiteness_p_value(values);
    let duration_s = stretches.test[1] - stretches.test[0];
    let explains = if whiteness_p_value > 0.05 {
        "white noise".to_string()
    } else if error.within_blocks_deg < 0.5 * error.validation_deg {
        format!("slow drift, {drift_deg:+.2}° in {duration_s:.0} s, of unknown origin")
    } else {
        match strongest {
            Some((frequency_hz, amplitude_deg))
                if amplitude_deg > 0.5 * error.validation_deg
                    && frequency_hz * duration_s > MIN_CYCLES =>
            {
                format!("oscillation at {frequency_hz:.2} Hz of unknown origin")
            }
            _ => "correlated noise without a dominant frequency".into(),
        }
    };
    ResidualDescription {
        axis: record.signals().axis.map(|axis| axis.letter()),
        frequency_hz: strongest.map(|(frequency_hz, _)| frequency_hz),
        amplitude_deg: strongest.map(|(_, amplitude_deg)| amplitude_deg),
        mean_deg: mean(values),
        drift_deg,
        whiteness_p_value,
        explains,
    }
}

fn warnings(record: &SensorRecord) -> Vec<String> {
    let mut warnings = Vec::new();
    let signals = record.signals();
    if record.dropped() > 0 {
        warnings.push(format!(
            "{} samples are not later than the one before and were dropped",
            record.dropped()
        ));
    }
    let period_s = signals.period_s();
    let steps = signals.times_s.windows(2).map(|pair| pair[1] - pair[0]);
    let lost: f64 = steps
        .map(|step_s| (step_s / period_s).round() - 1.0)
        .filter(|n| *n > 0.0)
        .sum();
    if lost > 0.0 {
        warnings.push(format!("{lost:.0} samples are missing by the time stamps"));
    }
    let largest = signals
        .rate_dps
        .iter()
        .fold(0.0, |max: f64, rate| max.max(rate.abs()));
    let mut run = 0;
    let longest = signals.rate_dps.iter().fold(0, |longest, rate| {
        run = if rate.abs() >= largest { run + 1 } else { 0 };
        longest.max(run)
    });
    if largest > 0.0 && longest >= CLIPPED_READINGS {
        warnings.push(format!(
            "the rate stays at its largest value, {largest:.1} °/s, for {longest} samples: it may be clipped"
        ));
    }
    warnings
}
