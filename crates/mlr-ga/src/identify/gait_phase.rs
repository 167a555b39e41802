use mlr_model::Gait;

/// Where in the gait the compared window begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GaitPhase {
    /// With the walk.
    Start,
    /// In mid-walk, this long after its start.
    Elapsed {
        /// Log time since the start of the walk.
        since_start_s: f64,
    },
    /// In a walk whose start the recording does not show.
    Unknown,
}

/// How finely an unknown phase is tried: the 20 ms for which a controller holds
/// a command.
const PHASE_STEP_S: f64 = 0.020;
/// The gait clock of a robot may run fast or slow by this share.
const CLOCK_ERROR: f64 = 0.005;
/// The start of a walk is found with about this error.
const START_ERROR_S: f64 = 0.02;

impl GaitPhase {
    /// The gait times of a simulated walk at which the window may begin.
    ///
    /// A window in mid-walk begins after the simulated robot has reached its
    /// steady gait: one period after the ramp. There, only the phase matters.
    pub fn gait_times_s(self, gait: &Gait) -> Vec<f64> {
        let steady_s = (gait.ramp_s / gait.period_s).ceil() * gait.period_s + gait.period_s;
        let half_period_s = gait.period_s / 2.0;
        match self {
            Self::Start => vec![0.0],
            Self::Elapsed { since_start_s } => {
                let error_s = CLOCK_ERROR * since_start_s + START_ERROR_S;
                around(since_start_s, error_s.min(half_period_s))
                    .map(|time_s| steady_s + time_s.rem_euclid(gait.period_s))
                    .collect()
            }
            Self::Unknown => around(half_period_s, half_period_s)
                .map(|time_s| steady_s + time_s.rem_euclid(gait.period_s))
                .collect(),
        }
    }
}

/// Times a phase step apart, at most `error_s` from `center_s`.
fn around(center_s: f64, error_s: f64) -> impl Iterator<Item = f64> {
    let steps = (error_s / PHASE_STEP_S).floor() as i32;
    (-steps..=steps).map(move |step| center_s + f64::from(step) * PHASE_STEP_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_of_the_walk_is_one_known_time() {
        assert_eq!(GaitPhase::Start.gait_times_s(&Gait::tripod()), [0.0]);
    }

    #[test]
    fn a_known_phase_is_tried_within_the_error_of_the_clock() {
        let phase = GaitPhase::Elapsed {
            since_start_s: 15.2,
        };
        let times_s = phase.gait_times_s(&Gait::tripod());
        assert_eq!(times_s.len(), 2 * 4 + 1);
        for time_s in times_s {
            assert!((2.0..3.0).contains(&time_s));
            assert!((time_s - 2.2).abs() < 0.1);
        }
    }

    #[test]
    fn an_unknown_phase_is_tried_all_around() {
        let mut times_s = GaitPhase::Unknown.gait_times_s(&Gait::tripod());
        times_s.sort_by(f64::total_cmp);
        assert!(times_s[0] < 2.0 + 1e-9 && times_s[times_s.len() - 1] > 2.97);
        assert!(times_s.windows(2).all(|pair| pair[1] - pair[0] < 0.0201));
    }
}
