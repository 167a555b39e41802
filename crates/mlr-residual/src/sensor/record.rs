use crate::{SensorError, sensor_effects::MAX_DELAY_S};

/// Shortest record that can be divided into three stretches and these into blocks.
const MIN_DURATION_S: f64 = 20.0;
/// Samples for the same.
const MIN_SAMPLES: usize = 400;
/// Samples of each stretch: four for each block.
const MIN_STRETCH_SAMPLES: usize = 60;
/// Least motion of the reference from which a scale can be told.
const MIN_RANGE_DEG: f64 = 5.0;
/// Share of bad time stamps from which on the order of samples is in doubt.
const MAX_DROPPED_SHARE: f64 = 0.1;

/// An axis of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AxisName {
    /// The sensor's x axis.
    X,
    /// The sensor's y axis.
    Y,
    /// The sensor's z axis.
    Z,
}

impl AxisName {
    /// All three in right-handed order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Lower-case letter.
    pub fn letter(self) -> char {
        match self {
            Self::X => 'x',
            Self::Y => 'y',
            Self::Z => 'z',
        }
    }

    /// The next in right-handed order: x, y, z, x.
    pub fn next(self) -> Self {
        match self {
            Self::X => Self::Y,
            Self::Y => Self::Z,
            Self::Z => Self::X,
        }
    }
}

/// What a sensor says by itself, without the reference. Effects see only this, so
/// that none can look at the angle that it is to predict.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSignals {
    /// Time stamps, s, strictly increasing.
    pub times_s: Vec<f64>,
    /// Rate as the data sheet scales it, °/s, positive where the reference angle
    /// grows: the sign of the mounting is already applied.
    pub rate_dps: Vec<f64>,
    /// +1 or -1: the sign of the mounting, reported rate to `rate_dps`.
    pub sign: f64,
    /// Which axis of the sensor reports the rate, if known.
    pub axis: Option<AxisName>,
    /// Rates about the sensor's other axes, °/s, as reported.
    pub cross_rates_dps: Vec<(AxisName, Vec<f64>)>,
    /// Specific force along x, y, z in g, as reported: +1 along the axis that
    /// points up at rest.
    pub accelerations_g: Option<[Vec<f64>; 3]>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<Vec<f64>>,
}

impl SensorSignals {
    /// Nothing but time stamps in s and a rate in °/s, positive where the reference
    /// angle grows.
    pub fn new(times_s: Vec<f64>, rate_dps: Vec<f64>) -> Self {
        Self {
            times_s,
            rate_dps,
            sign: 1.0,
            axis: None,
            cross_rates_dps: Vec::new(),
            accelerations_g: None,
            temperature_c: None,
        }
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// Median time between samples, s.
    pub fn period_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.times_s.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(0.0)
    }

    fn columns_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut Vec<f64>)> {
        let cross = self.cross_rates_dps.iter_mut();
        let cross = cross.map(|(_, column)| ("a cross rate", column));
        let accelerations = self.accelerations_g.iter_mut().flatten();
        [
            ("the time", &mut self.times_s),
            ("the rate", &mut self.rate_dps),
        ]
        .into_iter()
        .chain(cross)
        .chain(accelerations.map(|column| ("an acceleration", column)))
        .chain(
            self.temperature_c
                .iter_mut()
                .map(|t| ("the temperature", t)),
        )
    }

    /// The first `samples` only.
    fn truncated(&self, samples: usize) -> Self {
        let mut start = self.clone();
        for (_, column) in start.columns_mut() {
            column.truncate(samples);
        }
        start
    }
}

/// A sensor's signals and the angle that was measured beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorRecord {
    signals: SensorSignals,
    angle_deg: Vec<f64>,
    dropped: usize,
}

impl SensorRecord {
    /// Signals and reference angle in degrees, sample by sample. Samples that are
    /// not later than the one before are dropped.
    ///
    /// # Errors
    /// [`SensorError`] when columns differ in length, too many stamps are out of
    /// order, or the record is too short, has a gap over most of a stretch, or is without
    /// motion.
    pub fn new(mut signals: SensorSignals, mut angle_deg: Vec<f64>) -> Result<Self, SensorError> {
        let total = signals.len();
        let mut latest = f64::NEG_INFINITY;
        let keep: Vec<bool> = signals
            .times_s
            .iter()
            .map(|&time| {
                let later = time > latest;
                latest = latest.max(time);
                later
            })
            .collect();
        let kept = keep.iter().filter(|keep| **keep).count();
        for (column, values) in signals
            .columns_mut()
            .chain([("the reference angle", &mut angle_deg)])
        {
            if values.len() != total {
                return Err(SensorError::Length {
                    column,
                    found: values.len(),
                    expected: total,
                });
            }
            let mut flags = keep.iter();
            values.retain(|_| flags.next().copied().unwrap_or(false));
        }
        let dropped = total - kept;
        if dropped as f64 > MAX_DROPPED_SHARE * total as f64 {
            return Err(SensorError::Disordered { dropped, total });
        }
        let record = Self {
            signals,
            angle_deg,
            dropped,
        };
        let duration_s = record.duration_s();
        if duration_s < MIN_DURATION_S || kept < MIN_SAMPLES {
            return Err(SensorError::TooShort {
                duration_s,
                samples: kept,
                needed_s: MIN_DURATION_S,
                needed_samples: MIN_SAMPLES,
            });
        }
        let stretches = record.stretches();
        let samples = stretches.samples(&record.signals.times_s);
        let borders = [stretches.fit, stretches.selection, stretches.test];
        for (range, [from_s, to_s]) in samples.iter().zip(borders) {
            if range.len() < MIN_STRETCH_SAMPLES {
                return Err(SensorError::Gap {
                    from_s,
                    to_s,
                    samples: range.len(),
                    needed: MIN_STRETCH_SAMPLES,
                });
            }
        }
        let [fit, ..] = samples;
        let fitted = record.angle_deg.iter().take(fit.end).copied();
        let range_deg =
            fitted.clone().fold(f64::NEG_INFINITY, f64::max) - fitted.fold(f64::INFINITY, f64::min);
        if range_deg < MIN_RANGE_DEG {
            return Err(SensorError::NoMotion {
                range_deg,
                needed_deg: MIN_RANGE_DEG,
            });
        }
        Ok(record)
    }

    /// What the sensor says.
    pub fn signals(&self) -> &SensorSignals {
        &self.signals
    }

    /// What was measured beside it, degrees.
    pub fn angle_deg(&self) -> &[f64] {
        &self.angle_deg
    }

    /// Samples dropped because they were not later than the one before.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// From the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        match (self.signals.times_s.first(), self.signals.times_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Reference less a predicted angle, degrees, at all samples but those of the last 0.3 s: the
    /// angle of a sensor that is late is known only when its delay has passed, and after the end
    /// of the record never.
    pub(crate) fn error_deg(&self, predicted_deg: &[f64]) -> Vec<f64> {
        let times_s = &self.signals.times_s;
        let end_s = times_s.last().copied().unwrap_or(0.0) - MAX_DELAY_S;
        let scored = times_s.partition_point(|time| *time < end_s);
        let pairs = self.angle_deg.iter().zip(predicted_deg).take(scored);
        pairs
            .map(|(reference, predicted)| reference - predicted)
            .collect()
    }

    /// The first samples only.
    pub(super) fn truncated(&self, samples: usize) -> Self {
        Self {
            signals: self.signals.truncated(samples),
            angle_deg: self.angle_deg.iter().take(samples).copied().collect(),
            dropped: 0,
        }
    }
}
