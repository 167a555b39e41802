use super::SensorSignals;
use crate::sensor_effects::SensorEffect;

/// What a model has made of the sensor's signals so far.
#[derive(Debug, Clone)]
pub struct Track {
    /// When each sample is taken to have been measured, s.
    pub times_s: Vec<f64>,
    /// Corrected rate, °/s.
    pub rate_dps: Vec<f64>,
    /// Angle, degrees; filled after the rate has been corrected.
    pub angle_deg: Vec<f64>,
    /// What the angle starts at, less the reference's first reading, degrees.
    pub start_deg: f64,
    /// Whether the rate between samples is curved, rather than straight.
    pub curved: bool,
}

/// The data sheet's model of a gyroscope, and the effects added to it. The angle
/// is that of the reference at the first sample plus the integral of the rate.
#[derive(Debug, Clone, Default)]
pub struct SensorModel {
    /// Effects in the order of the library, with their parameters.
    effects: Vec<(&'static dyn SensorEffect, Vec<f64>)>,
}

impl SensorModel {
    /// The data sheet with these effects, which must be in the order of the
    /// library.
    pub fn new(effects: Vec<(&'static dyn SensorEffect, Vec<f64>)>) -> Self {
        Self { effects }
    }

    /// The angle that the model makes of the sensor's signals, degrees, given that
    /// of the reference at the first sample.
    pub fn angle_deg(&self, signals: &SensorSignals, start_deg: f64) -> Vec<f64> {
        let mut track = Track {
            times_s: signals.times_s.clone(),
            rate_dps: signals.rate_dps.clone(),
            angle_deg: Vec::new(),
            start_deg: 0.0,
            curved: false,
        };
        for (effect, values) in &self.effects {
            effect.correct_rate(values, signals, &mut track);
        }
        track.integrate(start_deg);
        for (effect, values) in &self.effects {
            effect.correct_angle(values, signals, &mut track);
        }
        track.angle_deg
    }
}

impl Track {
    /// Integrates the rate over the stamps as they are: uneven steps and gaps are
    /// bridged by the trapezium under the two samples beside them, or by the cubic
    /// through these with the slopes of their neighbours.
    fn integrate(&mut self, start_deg: f64) {
        let start_deg = start_deg + self.start_deg;
        let mut angle = start_deg;
        self.angle_deg = Vec::with_capacity(self.rate_dps.len());
        self.angle_deg
            .extend(self.rate_dps.first().map(|_| start_deg));
        let mut slope = self.slope(0);
        for i in 1..self.rate_dps.len() {
            let step_s = self.times_s[i] - self.times_s[i - 1];
            angle += 0.5 * step_s * (self.rate_dps[i - 1] + self.rate_dps[i]);
            if self.curved {
                let next = self.slope(i);
                angle += step_s * step_s * (slope - next) / 12.0;
                slope = next;
            }
            self.angle_deg.push(angle);
        }
    }

    /// Slope of the rate at a sample, °/s²: that of the parabola through it and its
    /// two neighbours, zero at the ends.
    fn slope(&self, i: usize) -> f64 {
        if !self.curved || i == 0 || i + 1 >= self.rate_dps.len() {
            return 0.0;
        }
        let before_s = self.times_s[i] - self.times_s[i - 1];
        let after_s = self.times_s[i + 1] - self.times_s[i];
        let before = (self.rate_dps[i] - self.rate_dps[i - 1]) / before_s;
        let after = (self.rate_dps[i + 1] - self.rate_dps[i]) / after_s;
        (before * after_s + after * before_s) / (before_s + after_s)
    }

    /// The angle at another time, degrees: on the straight line between samples,
    /// and outside as at the nearest end.
    pub fn at(&self, time_s: f64, hint: &mut usize) -> f64 {
        let last = self.times_s.len().saturating_sub(1);
        while *hint < last && self.times_s[*hint + 1] < time_s {
            *hint += 1;
        }
        while *hint > 0 && self.times_s[*hint] > time_s {
            *hint -= 1;
        }
        let i = *hint;
        if i == last || time_s <= self.times_s[i] {
            return self.angle_deg[i];
        }
        let share = (time_s - self.times_s[i]) / (self.times_s[i + 1] - self.times_s[i]);
        self.angle_deg[i] + share * (self.angle_deg[i + 1] - self.angle_deg[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_of_a_cosine_is_its_sine_on_uneven_stamps() {
        let mut time_s = 0.0_f64;
        let mut times_s: Vec<f64> = Vec::new();
        for i in 0..2000 {
            times_s.push(time_s);
            time_s += if i % 7 == 0 { 0.02 } else { 0.01 };
        }
        let rate_dps: Vec<f64> = times_s.iter().map(|t| 10.0 * t.cos()).collect();
        let signals = SensorSignals::new(times_s, rate_dps);
        let angle = SensorModel::default().angle_deg(&signals, 5.0);
        for (t, angle) in signals.times_s.iter().zip(angle) {
            assert!((angle - 5.0 - 10.0 * t.sin()).abs() < 1e-3);
        }
    }
}
