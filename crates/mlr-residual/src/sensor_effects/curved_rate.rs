use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// The rate between two samples follows the curve of their neighbours rather than a
/// straight line. Matters where samples are lost while the rate oscillates. Needs the
/// next sample, as the straight line does.
#[derive(Debug)]
pub(super) struct CurvedRate;

impl SensorEffect for CurvedRate {
    fn kind(&self) -> &'static str {
        "curved_rate"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "steps where samples are lost or the rate changes fast"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(Vec::new())
    }

    fn correct_rate(&self, _: &[f64], _: &SensorSignals, track: &mut Track) {
        track.curved = true;
    }
}
