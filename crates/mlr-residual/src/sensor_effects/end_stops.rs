use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Turn back by which a turn is told from vibration.
const HYSTERESIS_DEG: f64 = 5.0;
/// Turns at each stop from which it is known.
const MIN_TURNS: i32 = 3;
/// Turns at a stop may differ by this much from their mean.
const MAX_SPREAD_DEG: f64 = 2.0;

/// Finds where an angle turns back, a little after it has.
#[derive(Debug, Default)]
struct Turns {
    extreme_deg: Option<f64>,
    /// +1 while it grows, -1 while it shrinks, 0 before the first turn.
    direction: f64,
}

impl Turns {
    /// Takes the next angle; the angle at the turn and whether it was the upper one
    /// when a turn shows.
    fn next(&mut self, angle_deg: f64) -> Option<(f64, bool)> {
        let extreme_deg = *self.extreme_deg.get_or_insert(angle_deg);
        let moved_deg = angle_deg - extreme_deg;
        if self.direction == 0.0 {
            if moved_deg.abs() > HYSTERESIS_DEG {
                self.direction = moved_deg.signum();
                self.extreme_deg = Some(angle_deg);
            }
            return None;
        }
        if moved_deg * self.direction > 0.0 {
            self.extreme_deg = Some(angle_deg);
        } else if moved_deg.abs() > HYSTERESIS_DEG {
            let upper = self.direction > 0.0;
            self.direction = -self.direction;
            self.extreme_deg = Some(angle_deg);
            return Some((extreme_deg, upper));
        }
        None
    }

    fn shift(&mut self, change_deg: f64) {
        self.extreme_deg = self.extreme_deg.map(|extreme| extreme + change_deg);
    }

    fn collect(mut self, angle_deg: &[f64]) -> Vec<(f64, bool)> {
        angle_deg
            .iter()
            .filter_map(|angle| self.next(*angle))
            .collect()
    }
}

/// The shaft swings between the same two angles, in degrees, known from the stretch
/// that is fitted on. Each time the rate shows that it has turned back, the angle at the
/// turn is moved towards the stop by a share. This is knowledge of the motion, not of
/// the sensor.
#[derive(Debug)]
pub(super) struct EndStops;

impl SensorEffect for EndStops {
    fn kind(&self) -> &'static str {
        "end_stops"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "a drift seen where the shaft turns back"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        let angle_deg = fit_stretch.angle_deg();
        let turns: Vec<(f64, bool)> = Turns::default().collect(angle_deg);
        let mean = |upper: bool| {
            let at = turns.iter().filter(|(_, is_upper)| *is_upper == upper);
            let (sum, count) = at.fold((0.0, 0), |(sum, n), (angle, _)| (sum + angle, n + 1));
            (count >= MIN_TURNS).then(|| sum / f64::from(count))
        };
        let (Some(low), Some(high)) = (mean(false), mean(true)) else {
            return Err(Inapplicable("the shaft turns back too rarely"));
        };
        let spread = |stop: f64, upper: bool| {
            let at = turns.iter().filter(move |(_, is_upper)| *is_upper == upper);
            at.map(move |(angle, _)| (angle - stop).abs())
                .fold(0.0, f64::max)
        };
        if spread(low, false).max(spread(high, true)) > MAX_SPREAD_DEG {
            return Err(Inapplicable(
                "the shaft does not turn back at the same angles",
            ));
        }
        Ok(vec![
            Parameter::new("low_deg", low).step(1e-3),
            Parameter::new("high_deg", high).step(1e-3),
            Parameter::new("share", 0.5)
                .step(1e-3)
                .bounds(0.0, 1.0)
                .neutral(0.0),
        ])
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        let mut turns = Turns::default();
        let mut correction = 0.0;
        for angle in &mut track.angle_deg {
            *angle += correction;
            if let Some((turned_deg, upper)) = turns.next(*angle) {
                let stop_deg = if upper { values[1] } else { values[0] };
                let change = values[2] * (stop_deg - turned_deg);
                correction += change;
                *angle += change;
                turns.shift(change);
            }
        }
    }

    fn observes_drift(&self) -> bool {
        true
    }

    fn is_about_motion(&self) -> bool {
        true
    }
}
