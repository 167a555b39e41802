//! Effects found on one record, tried on another without fitting anything.

use serde::Serialize;

use crate::{
    Effect, SensorError, SensorModel, SensorRecord,
    sensor_effects::{LIBRARY, SensorEffect, kinds},
    statistics::{BlockErrors, rms},
};

/// Blocks in which the error that is no drift is measured.
const BLOCKS: usize = 30;

/// Effects of an earlier explanation on another record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Transfer {
    /// Root mean square error of the data sheet's model over the whole record, degrees.
    pub error_before_deg: f64,
    /// With all effects that could be applied.
    pub error_after_deg: f64,
    /// Error within blocks of a thirtieth of the record, each less its mean, degrees:
    /// the error that is no drift.
    pub within_blocks_before_deg: f64,
    /// The same with all effects that could be applied.
    pub within_blocks_after_deg: f64,
    /// Each effect by itself.
    pub effects: Vec<TransferredEffect>,
}

/// One effect on another record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TransferredEffect {
    /// Name of the effect.
    pub kind: String,
    /// Error with all effects but this one, degrees; nothing where it could not be
    /// applied.
    pub error_without_deg: Option<f64>,
    /// Within blocks with all effects but this one, degrees.
    pub within_blocks_without_deg: Option<f64>,
    /// What came of it.
    pub verdict: String,
}

/// Applies effects as they are. Parameters named by the sensor's axis (`x_dps`) are
/// taken over to the axis of the record.
///
/// # Errors
/// [`SensorError::UnknownEffect`] or [`SensorError::Parameters`] when the library has
/// no such effect.
pub fn apply_effects(record: &SensorRecord, effects: &[Effect]) -> Result<Transfer, SensorError> {
    let mut chosen: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut reports = Vec::new();
    let fit_stretch = record.fit_stretch();
    for effect in effects {
        let known = LIBRARY.iter().position(|known| known.kind() == effect.kind);
        let index = known.ok_or_else(|| SensorError::UnknownEffect {
            kind: effect.kind.clone(),
            known: kinds(),
        })?;
        match values(LIBRARY[index], effect, &fit_stretch)? {
            Ok(values) => chosen.push((index, values)),
            Err(reason) => reports.push(TransferredEffect {
                kind: effect.kind.clone(),
                error_without_deg: None,
                within_blocks_without_deg: None,
                verdict: format!("not applicable: {reason}"),
            }),
        }
    }
    chosen.sort_by_key(|(index, _)| *index);
    let errors = |skip: Option<usize>| {
        let kept = chosen.iter().filter(|(index, _)| Some(*index) != skip);
        errors_deg(
            record,
            kept.map(|(i, v)| (LIBRARY[*i], v.clone())).collect(),
        )
    };
    let (error_after_deg, within_blocks_after_deg) = errors(None);
    for (index, _) in &chosen {
        let (error_deg, within_deg) = errors(Some(*index));
        let helps = |without: f64, with: f64| {
            if with < 0.99 * without {
                "helps"
            } else if with > 1.01 * without {
                "harms"
            } else {
                "changes nothing"
            }
        };
        reports.push(TransferredEffect {
            kind: LIBRARY[*index].kind().into(),
            error_without_deg: Some(error_deg),
            within_blocks_without_deg: Some(within_deg),
            verdict: format!(
                "{} overall, {} within blocks",
                helps(error_deg, error_after_deg),
                helps(within_deg, within_blocks_after_deg)
            ),
        });
    }
    let (error_before_deg, within_blocks_before_deg) = errors_deg(record, Vec::new());
    Ok(Transfer {
        error_before_deg,
        error_after_deg,
        within_blocks_before_deg,
        within_blocks_after_deg,
        effects: reports,
    })
}

/// An effect's parameters in its own order, or why it cannot act on this record.
fn values(
    known: &dyn SensorEffect,
    effect: &Effect,
    fit_stretch: &SensorRecord,
) -> Result<Result<Vec<f64>, crate::sensor_effects::Inapplicable>, SensorError> {
    let parameters = match known.parameters(fit_stretch) {
        Ok(parameters) => parameters,
        Err(reason) => return Ok(Err(reason)),
    };
    let names: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
    let values: Option<Vec<f64>> = match (names.as_slice(), effect.parameters.len()) {
        ([_], 1) => Some(effect.parameters.values().copied().collect()),
        _ => names
            .iter()
            .map(|name| effect.parameters.get(*name).copied())
            .collect(),
    };
    let listed = |names: &[&str]| names.join(", ");
    let found: Vec<&str> = effect.parameters.keys().map(String::as_str).collect();
    match values.filter(|values| values.len() == found.len()) {
        Some(values) => Ok(Ok(values)),
        // A share of the other axes means nothing about an axis that was the main one.
        None if known.kind() == "cross_axis" => Ok(Err(crate::sensor_effects::Inapplicable(
            "its parameters are those of other axes",
        ))),
        None => Err(SensorError::Parameters {
            kind: effect.kind.clone(),
            expected: listed(&names),
            found: listed(&found),
        }),
    }
}

fn errors_deg(
    record: &SensorRecord,
    effects: Vec<(&'static dyn SensorEffect, Vec<f64>)>,
) -> (f64, f64) {
    let start_deg = record.angle_deg().first().copied().unwrap_or(0.0);
    let predicted_deg = SensorModel::new(effects).angle_deg(record.signals(), start_deg);
    let residual = record.error_deg(&predicted_deg);
    (
        rms(&residual),
        BlockErrors::new(&residual, BLOCKS).within_deg(),
    )
}
