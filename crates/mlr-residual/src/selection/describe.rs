use super::{ABOVE_NOISE, trial::Trial};
use crate::{
    ResidualDescription, SensorExplanation, SensorRecord,
    statistics::{dominant_frequency, whiteness_p_value},
};

/// So many equal readings in a row at the largest rate are no chance.
const CLIPPED_READINGS: usize = 3;

/// Errors before and after; nothing about effects yet.
pub(super) fn description(
    record: &SensorRecord,
    before: &Trial,
    after: &Trial,
) -> SensorExplanation {
    SensorExplanation {
        effects: Vec::new(),
        unexplained: false,
        error_before: before.error(),
        error_after: after.error(),
        noise_floor_deg: after.noise_floor_deg(),
        candidates: Vec::new(),
        residual: residual(record, after),
        half_s: record.duration_s() / 2.0,
        warnings: warnings(record),
    }
}

/// Parameters, intervals and the residual of the final set of effects.
pub(super) fn complete(record: &SensorRecord, after: &Trial, explanation: &mut SensorExplanation) {
    explanation.error_after = after.error();
    explanation.noise_floor_deg = after.noise_floor_deg();
    explanation.residual = residual(record, after);
    explanation.unexplained = after.error().validation_deg > ABOVE_NOISE * after.noise_floor_deg();
    for effect in &mut explanation.effects {
        effect.parameters = after.parameters_of(&effect.kind);
    }
    for (kind, parameter, width) in after.parameters() {
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
                    "{kind}: {name} may as well be {}, its interval says",
                    absent.unwrap_or_default()
                ));
            }
        }
    }
}

fn residual(record: &SensorRecord, after: &Trial) -> ResidualDescription {
    let values = &after.residual_deg;
    let n = values.len().max(1);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
    let tenth = n / 10;
    let drift_deg = mean(&values[values.len() - tenth..]) - mean(&values[..tenth]);
    let strongest = dominant_frequency(values, record.signals().period_s());
    let error = after.error();
    let whiteness_p_value = whiteness_p_value(values);
    let half_s = record.duration_s() / 2.0;
    let explains = if whiteness_p_value > 0.05 {
        "white noise".to_string()
    } else if error.within_blocks_deg < 0.5 * error.validation_deg {
        format!("slow drift, {drift_deg:+.2}° in {half_s:.0} s, of unknown origin")
    } else {
        match strongest {
            Some((frequency_hz, amplitude_deg))
                if amplitude_deg > 0.5 * error.validation_deg && frequency_hz * half_s > 15.0 =>
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
