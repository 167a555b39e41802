//! Removes single samples that a bad byte has thrown off.

use mlr_filter::Axes;

use crate::sensor::Reading;

/// The median of three successive orientations, axis by axis; a sample late.
///
/// i2cdevlib's teapot packets have no check sum: a byte that arrives wrong may
/// pass for a small jump there and back, which would be taken for the start of a
/// walk. A body does not move like that between two samples.
#[derive(Debug, Default)]
pub struct SpikeFilter {
    /// The sample before the one held back, and that one.
    last: Option<(Axes<f64>, Reading)>,
}

impl SpikeFilter {
    /// Takes a reading, returns the one before it.
    pub fn push(&mut self, reading: Reading) -> Option<Reading> {
        let angles = reading.attitude.angles_rad;
        let Some((before, mut held)) = self.last.take() else {
            self.last = Some((angles, reading));
            return None;
        };
        let held_angles = held.attitude.angles_rad;
        self.last = Some((held_angles, reading));
        held.attitude.angles_rad = Axes {
            roll: median(before.roll, held_angles.roll, angles.roll),
            pitch: median(before.pitch, held_angles.pitch, angles.pitch),
            yaw: median(before.yaw, held_angles.yaw, angles.yaw),
        };
        Some(held)
    }

    /// The reading held back, if any; the next one begins anew.
    pub fn flush(&mut self) -> Option<Reading> {
        self.last.take().map(|(_, held)| held)
    }
}

fn median(a: f64, b: f64, c: f64) -> f64 {
    a.max(b).min(a.min(b).max(c))
}

#[cfg(test)]
mod tests {
    use mlr_imu::ImuSample;
    use proptest::prelude::*;

    use super::*;
    use crate::attitude::Attitude;

    fn filtered(rolls_rad: &[f64]) -> Vec<f64> {
        let mut filter = SpikeFilter::default();
        rolls_rad
            .iter()
            .enumerate()
            .filter_map(|(index, roll)| {
                filter.push(Reading {
                    attitude: Attitude {
                        time_s: index as f64,
                        angles_rad: Axes {
                            roll: *roll,
                            pitch: 0.0,
                            yaw: 0.0,
                        },
                    },
                    sample: ImuSample::default(),
                })
            })
            .map(|reading| reading.attitude.angles_rad.roll)
            .collect()
    }

    #[test]
    fn a_spike_is_removed_and_a_ramp_is_not_touched() {
        assert_eq!(
            filtered(&[0.0, 0.1, 9.0, 0.3, 0.4, 0.5]),
            [0.0, 0.1, 0.3, 0.4, 0.4]
        );
    }

    proptest! {
        #[test]
        fn what_rises_or_falls_steadily_passes_unchanged(
            mut values in prop::collection::vec(-1.0..1.0_f64, 3..40),
        ) {
            values.sort_by(f64::total_cmp);
            prop_assert_eq!(filtered(&values), &values[..values.len() - 1]);
        }
    }
}
