use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A share of the rates about the other axes, because the axes of the sensor and the
/// shaft are not square; without unit.
#[derive(Debug)]
pub(super) struct CrossAxis;

impl SensorEffect for CrossAxis {
    fn kind(&self) -> &'static str {
        "cross_axis"
    }

    fn signature(&self) -> &'static str {
        "grows with the angle turned about the other axes"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        let cross = &fit_stretch.signals().cross_rates_dps;
        if cross.is_empty() {
            return Err(Inapplicable(
                "the log has no rates about the sensor's other axes",
            ));
        }
        let parameter = |axis: char| {
            Parameter::new(format!("{axis}_share"), 0.0)
                .step(1e-3)
                .bounds(-0.1, 0.1)
                .neutral(0.0)
        };
        Ok(cross
            .iter()
            .map(|(axis, _)| parameter(axis.letter()))
            .collect())
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        for ((_, cross), share) in signals.cross_rates_dps.iter().zip(values) {
            for (rate, cross) in track.rate_dps.iter_mut().zip(cross) {
                *rate -= signals.sign * share * cross;
            }
        }
    }
}
