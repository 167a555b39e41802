use mlr_model::Gait;

use crate::comparison::ComparableWalk;

/// Phase of the gait at the start of the compared stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GaitPhase {
    /// The start of the walk.
    Start,
    /// In mid-walk, this long after its start.
    Elapsed {
        /// Log time since the start of the walk.
        since_start_s: f64,
    },
    /// In a walk whose start the recording does not show.
    Unknown,
}

/// Step of the search for an unknown phase, in samples: the delays of an alignment cover
/// the time between two steps.
const PHASE_STEP: usize = 3;
/// The gait clock of a robot may run fast or slow by this share.
const CLOCK_ERROR: f64 = 0.03;
/// The start of a walk is found with about this error.
const START_ERROR_S: f64 = 0.02;

/// Samples of a simulated walk that the start of the measured stretch is aligned with.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkOffsets {
    /// Indices into a [`ComparableWalk`].
    pub samples: Vec<usize>,
    /// How much later in the gait than these samples the measured stretch starts.
    pub later_s: f64,
}

impl GaitPhase {
    /// When a simulated robot has reached its steady gait: one period after the ramp, in
    /// whole periods.
    pub(crate) fn steady_s(gait: &Gait) -> f64 {
        (gait.ramp_s / gait.period_s).ceil() * gait.period_s + gait.period_s
    }

    /// The samples of a simulated walk from which it is compared.
    ///
    /// A stretch in mid-walk starts after the simulated robot has reached its
    /// steady gait: one period after the ramp. There, only the phase matters.
    pub fn offsets(self, gait: &Gait) -> WalkOffsets {
        let steady_s = Self::steady_s(gait);
        let (phase_s, error_s) = match self {
            Self::Start => {
                return WalkOffsets {
                    samples: vec![0],
                    later_s: 0.0,
                };
            }
            Self::Elapsed { since_start_s } => (
                since_start_s.rem_euclid(gait.period_s),
                CLOCK_ERROR * since_start_s + START_ERROR_S,
            ),
            Self::Unknown => (0.0, f64::INFINITY),
        };
        let offset = (steady_s + phase_s) * ComparableWalk::RATE_HZ;
        let later_s = offset.fract() / ComparableWalk::RATE_HZ;
        let half_period = gait.period_s * ComparableWalk::RATE_HZ / 2.0;
        let reach = (error_s * ComparableWalk::RATE_HZ).min(half_period);
        let steps = (reach / PHASE_STEP as f64).ceil() as usize;
        let first = (offset.floor() as usize).saturating_sub(steps * PHASE_STEP);
        WalkOffsets {
            samples: (0..=2 * steps)
                .map(|step| first + step * PHASE_STEP)
                .collect(),
            later_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_of_the_walk_is_one_known_time() {
        let offsets = GaitPhase::Start.offsets(&Gait::tripod());
        assert_eq!((offsets.samples, offsets.later_s), (vec![0], 0.0));
    }

    #[test]
    fn a_known_phase_is_tried_within_the_error_of_the_clock() {
        let phase = GaitPhase::Elapsed {
            since_start_s: 7.31,
        };
        let offsets = phase.offsets(&Gait::tripod());
        // The tripod is steady after two seconds; 2.31 s is sample 57.75.
        assert!((offsets.later_s - 0.03).abs() < 1e-9, "{offsets:?}");
        assert_eq!(offsets.samples, [51, 54, 57, 60, 63]);
    }

    #[test]
    fn an_unknown_phase_is_tried_over_a_whole_period() {
        let offsets = GaitPhase::Unknown.offsets(&Gait::tripod());
        let (first, last) = (
            offsets.samples[0],
            offsets.samples[offsets.samples.len() - 1],
        );
        assert!(last - first >= 25, "{offsets:?}");
        assert!(first >= 35, "after the ramp: {offsets:?}");
    }

    #[test]
    fn a_clock_that_had_long_to_go_wrong_makes_the_phase_unknown() {
        let late = GaitPhase::Elapsed {
            since_start_s: 60.0,
        };
        let unknown = GaitPhase::Unknown.offsets(&Gait::tripod());
        assert_eq!(
            late.offsets(&Gait::tripod()).samples.len(),
            unknown.samples.len()
        );
    }
}
