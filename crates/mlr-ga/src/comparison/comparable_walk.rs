use mlr_filter::{Axes, MovingMean, OrientationSeries};

/// Roll, pitch and yaw of a simulated walk in degrees, smoothed, at an even rate
/// from the first step on.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparableWalk {
    angles_deg: Axes<Vec<f32>>,
}

impl ComparableWalk {
    /// Samples per second: twice what a walking body shows.
    pub const RATE_HZ: f64 = 25.0;
    /// Angles are means over the time between two samples.
    pub(super) const HALF_WIDTH_S: f64 = 0.5 / Self::RATE_HZ;

    /// Samples a simulated walk, whose first step is at time 0, up to its end.
    pub fn new(walk: &OrientationSeries) -> Self {
        let end_s = walk.times_s().last().copied().unwrap_or(0.0);
        let means = MovingMean::new(walk);
        let mut angles_deg = Axes::<Vec<f32>>::default();
        // The last mean must be whole; a hair of tolerance for the sums of steps.
        let last = ((end_s - Self::HALF_WIDTH_S) * Self::RATE_HZ + 1e-6).floor();
        for index in 0..=last.max(0.0) as u32 {
            let time_s = f64::from(index) / Self::RATE_HZ;
            let mean = means.around(time_s, Self::HALF_WIDTH_S);
            angles_deg.push(mean.map(|_, angle_rad| angle_rad.to_degrees() as f32));
        }
        Self { angles_deg }
    }

    /// A walk of these samples.
    ///
    /// # Panics
    /// When the axes differ in length.
    pub fn from_samples(angles_deg: Axes<Vec<f32>>) -> Self {
        let length = angles_deg.roll.len();
        assert!(
            angles_deg.pitch.len() == length && angles_deg.yaw.len() == length,
            "every axis has as many samples"
        );
        Self { angles_deg }
    }

    /// Samples of each axis.
    pub fn len(&self) -> usize {
        self.angles_deg.roll.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples.
    pub fn angles_deg(&self) -> &Axes<Vec<f32>> {
        &self.angles_deg
    }

    /// How long a walk must be simulated to have `samples` samples.
    pub fn duration_s(samples: usize) -> f64 {
        samples.saturating_sub(1) as f64 / Self::RATE_HZ + Self::HALF_WIDTH_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_of_the_stated_duration_has_its_samples() {
        let times_s: Vec<f64> = (0..=1000).map(|i| f64::from(i) * 0.01).collect();
        for samples in [1, 2, 125] {
            let duration_s = ComparableWalk::duration_s(samples);
            let cut: Vec<f64> = times_s
                .iter()
                .copied()
                .filter(|t| *t <= duration_s + 1e-9)
                .collect();
            let roll: Vec<f64> = cut.iter().map(|t| t.to_radians()).collect();
            let walk = OrientationSeries::new(cut, Axes::from_fn(|_| roll.clone())).unwrap();
            let comparable = ComparableWalk::new(&walk);
            assert_eq!(comparable.len(), samples);
            let last = comparable.angles_deg().roll[samples - 1];
            let expected = (samples - 1) as f32 / 25.0;
            // The first mean has only its later half.
            let tolerance = if samples == 1 { 0.011 } else { 1e-5 };
            assert!((last - expected).abs() < tolerance, "{last} {expected}");
        }
    }
}
