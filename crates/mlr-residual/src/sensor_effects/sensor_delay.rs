use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Largest delay that is tried, s: for so long a corrected angle may have to be waited for.
pub(crate) const MAX_DELAY_S: f64 = 0.3;

/// The rate is reported late, by this many seconds after the reference. Its angle is
/// then known as late as that.
#[derive(Debug)]
pub(super) struct SensorDelay;

impl SensorEffect for SensorDelay {
    fn kind(&self) -> &'static str {
        "sensor_delay"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Always
    }

    fn signature(&self) -> &'static str {
        "proportional to the change of angle within the delay"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("delay_s", 0.005)
                .step(2e-4)
                .bounds(-MAX_DELAY_S, MAX_DELAY_S)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        // The reference's first reading belongs to the first sample's true time, when
        // the late rate had not yet caught up.
        let (Some(start_s), Some(start_dps)) = (track.times_s.first(), track.rate_dps.first())
        else {
            return;
        };
        let end_s = start_s + values[0];
        let mut turned_deg = start_dps * values[0].min(0.0);
        for (times_s, rates_dps) in track.times_s.windows(2).zip(track.rate_dps.windows(2)) {
            let step_s = end_s.min(times_s[1]) - times_s[0];
            if step_s <= 0.0 {
                break;
            }
            let slope = (rates_dps[1] - rates_dps[0]) / (times_s[1] - times_s[0]);
            turned_deg += step_s * (rates_dps[0] + 0.5 * step_s * slope);
        }
        track.start_deg -= turned_deg;
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        let mut hint = 0;
        let asked = track.times_s.iter().map(|time_s| time_s + values[0]);
        let angle_deg = asked.map(|time_s| track.at(time_s, &mut hint)).collect();
        track.angle_deg = angle_deg;
    }
}
