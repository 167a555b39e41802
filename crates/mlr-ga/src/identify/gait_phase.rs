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
    /// Gait time at which a simulated robot does what a real one does that has walked for so
    /// long: a start of the steady gait, and the time since.
    ///
    /// The steady gait starts one cycle after the commands begin to repeat, in whole cycles;
    /// since then only the phase matters. A motion that repeats nothing is the same at no two
    /// times: its start is 0.
    pub(crate) fn steady_s(gait: &Gait, since_start_s: f64) -> [f64; 2] {
        match gait.cycle_s() {
            Some(cycle_s) => [
                (gait.steady_from_s() / cycle_s).ceil() * cycle_s + cycle_s,
                since_start_s.rem_euclid(cycle_s),
            ],
            None => [0.0, since_start_s.max(0.0)],
        }
    }

    /// The samples of a simulated walk from which it is compared.
    ///
    /// A stretch in mid-walk starts after the simulated robot has reached its
    /// steady gait: one cycle after its commands repeat. There, only the phase matters.
    pub fn offsets(self, gait: &Gait) -> WalkOffsets {
        // How long it takes until there is nothing new.
        let whole_s = gait.cycle_s().or(gait.duration_s()).unwrap_or(0.0);
        let (since_start_s, error_s) = match self {
            Self::Start => {
                return WalkOffsets {
                    samples: vec![0],
                    later_s: 0.0,
                };
            }
            Self::Elapsed { since_start_s } => {
                (since_start_s, CLOCK_ERROR * since_start_s + START_ERROR_S)
            }
            // Half of it either way is all of it; of what repeats, the phase does not matter.
            Self::Unknown => match gait.cycle_s() {
                Some(_) => (0.0, f64::INFINITY),
                None => (whole_s / 2.0, f64::INFINITY),
            },
        };
        let [steady_s, phase_s] = Self::steady_s(gait, since_start_s);
        let offset = (steady_s + phase_s) * ComparableWalk::RATE_HZ;
        let later_s = offset.fract() / ComparableWalk::RATE_HZ;
        let half = whole_s * ComparableWalk::RATE_HZ / 2.0;
        let reach = (error_s * ComparableWalk::RATE_HZ).min(half);
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
    use mlr_model::{JointTrajectory, Motion};

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

    /// 200 rows of 20 ms.
    fn rows(repeat_rows: Option<std::ops::Range<usize>>) -> Gait {
        let rows_rad = vec![vec![0.0; 18]; 200];
        Gait {
            name: "rows".into(),
            period_s: 0.5,
            motion: Motion::Joints(JointTrajectory::new(0.02, rows_rad, repeat_rows).unwrap()),
        }
    }

    #[test]
    fn a_trajectory_that_repeats_is_steady_a_cycle_after_that() {
        let phase = GaitPhase::Elapsed {
            since_start_s: 7.31,
        };
        // It repeats from 1 s on every 3 s, and so is steady at 6 s; 1.31 s later is sample 182.75.
        let offsets = phase.offsets(&rows(Some(50..200)));
        assert!((offsets.later_s - 0.03).abs() < 1e-9, "{offsets:?}");
        assert_eq!(offsets.samples, [176, 179, 182, 185, 188]);
        // Its cycle counts, and not its period of half a second.
        let unknown = GaitPhase::Unknown.offsets(&rows(Some(50..200)));
        let (first, last) = (
            unknown.samples[0],
            unknown.samples[unknown.samples.len() - 1],
        );
        assert!(last - first >= 75, "{unknown:?}");
    }

    #[test]
    fn a_motion_that_ends_is_compared_at_its_own_time() {
        let phase = GaitPhase::Elapsed {
            since_start_s: 2.31,
        };
        let offsets = phase.offsets(&rows(None));
        assert!((offsets.later_s - 0.03).abs() < 1e-9, "{offsets:?}");
        assert_eq!(offsets.samples, [54, 57, 60]);
        // It ends after 3.98 s.
        let unknown = GaitPhase::Unknown.offsets(&rows(None)).samples;
        assert_eq!(unknown[0], 0, "{unknown:?}");
        assert!(
            (97..=102).contains(&unknown[unknown.len() - 1]),
            "{unknown:?}"
        );
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
