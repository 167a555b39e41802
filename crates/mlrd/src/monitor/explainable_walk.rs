//! The longer stretch of a damaged walk that an explanation needs.

use mlr_ga::WalkStart;

use super::{Request, handed_out::HandedOut, recent::Recent};

/// A damaged walk from its flag on.
#[derive(Debug, Default)]
pub(super) enum ExplainableWalk {
    /// There is none: no damage, nothing that could be explained, or it is handed out.
    #[default]
    None,
    /// It goes on.
    Growing {
        /// Time of the flag, or of the last pause in the samples.
        from_s: f64,
    },
    /// It is long enough, and waits for the identification to be done.
    Grown(Request),
}

/// Windows of identification that an explanation takes: one to fit, one to judge.
const WINDOWS: f64 = 2.0;
/// So much standing must be on record: the offsets of the angles at rest come from it.
const LEAST_STANDING_S: f64 = 1.0;
/// Standing longer ago than this before the walk tells nothing.
const STANDING_S: f64 = 8.0;

impl ExplainableWalk {
    /// How much orientation must be kept where a stretch takes so long: the stretch,
    /// the standing, and as long a stretch of healthy walk between them.
    pub(super) fn keep_s(window_s: f64) -> f64 {
        2.0 * WINDOWS * window_s + STANDING_S + 2.0
    }

    /// A pause in the samples: what came before it is no use.
    pub(super) fn begin_anew(&mut self, now_s: f64) {
        if let Self::Growing { from_s } = self {
            *from_s = now_s;
        }
    }

    /// The robot calmed down, stopped or moves otherwise; a stretch that was long
    /// enough by then still is.
    pub(super) fn interrupt(&mut self) {
        if let Self::Growing { .. } = self {
            *self = Self::None;
        }
    }

    /// Takes the stretch down once it is long enough. It is given up where the start of
    /// the walk is not on record: without it the phase of the gait would be guessed.
    pub(super) fn grow(
        &mut self,
        now_s: f64,
        window_s: f64,
        motion_start_s: Option<f64>,
        recent: &Recent,
        handed_out: &mut HandedOut,
    ) {
        let Self::Growing { from_s } = *self else {
            return;
        };
        if now_s < from_s + WINDOWS * window_s {
            return;
        }
        let shown = motion_start_s
            .filter(|start_s| recent.reaches_back_to(start_s - LEAST_STANDING_S))
            .and_then(|start_s| Some((start_s, recent.recording(start_s - STANDING_S)?)));
        *self = shown.map_or(Self::None, |(start_s, recording)| {
            Self::Grown(Request {
                number: handed_out.next(now_s),
                recording,
                walk_start: WalkStart::ObservedAtS(start_s),
                from_s,
            })
        });
    }

    /// Hands the stretch out, once.
    pub(super) fn take(&mut self) -> Option<Request> {
        match std::mem::take(self) {
            Self::Grown(request) => Some(request),
            other => {
                *self = other;
                None
            }
        }
    }
}
