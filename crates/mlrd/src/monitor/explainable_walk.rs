//! The longer stretch of a damaged walk that an explanation needs.

use mlr_ga::WalkStart;

use super::{
    Request, WalkStretch,
    handed_out::HandedOut,
    recent::{Recent, Stretch},
};

/// A damaged walk from its flag on, or from its first step where the robot was damaged then.
#[derive(Debug, Default)]
pub(super) enum ExplainableWalk {
    /// There is none: no damage, nothing that could be explained, or it is handed out.
    #[default]
    None,
    /// It goes on.
    Growing {
        /// Where it begins: at the first step, at the flag, or at the last pause in the samples.
        from_s: f64,
    },
    /// It is long enough, and waits for the identification to be done.
    Grown(Box<Request>),
}

/// What is known of the walk that an explanation is to begin in.
#[derive(Debug, Clone, Copy)]
pub(super) struct WalkSeen {
    /// When it started, where that was seen.
    pub(super) motion_start_s: Option<f64>,
    /// When a cycle of its gait began, followed from its start until it was damaged.
    pub(super) cycle_start_s: Option<f64>,
}

/// Windows of identification that an explanation takes: one to fit, one to judge.
const WINDOWS: f64 = 2.0;
/// So much standing must be on record: the offsets of the angles at rest come from it.
pub(super) const LEAST_STANDING_S: f64 = 1.0;
/// Standing longer ago than this before the walk tells nothing.
pub(super) const STANDING_S: f64 = 8.0;
/// Healthy walk that is handed over with a stretch in mid-walk.
const HEALTHY_S: f64 = 12.0;

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

    /// Whether the stretch is long enough to be taken down.
    pub(super) fn is_due(&self, now_s: f64, window_s: f64) -> bool {
        matches!(self, Self::Growing { from_s } if now_s >= from_s + WINDOWS * window_s)
    }

    /// Takes the stretch down: with the start of the walk where that is on record, else with the
    /// cycle of the gait in which it begins, else alone: the phase of its gait is then found in it.
    pub(super) fn take_down(
        &mut self,
        now_s: f64,
        seen: WalkSeen,
        recent: &Recent,
        handed_out: &mut HandedOut,
    ) {
        let Self::Growing { from_s } = std::mem::take(self) else {
            return;
        };
        let on_record = |start_s: &f64| recent.reaches_back_to(start_s - LEAST_STANDING_S);
        let started_s = seen.motion_start_s.filter(on_record);
        let (begin_s, walk_start) = match (started_s, seen.cycle_start_s) {
            (Some(start_s), _) => (start_s - STANDING_S, WalkStart::ObservedAtS(start_s)),
            (None, Some(cycle_s)) => (from_s - HEALTHY_S, WalkStart::ObservedAtS(cycle_s)),
            (None, None) => (from_s, WalkStart::FoundInRecording),
        };
        let of = match started_s.is_some_and(|start_s| from_s <= start_s) {
            true => Stretch::FromTheStart,
            false => Stretch::InMidWalk,
        };
        let Some(recording) = recent.recording(begin_s..=now_s, of) else {
            return;
        };
        *self = Self::Grown(Box::new(Request {
            number: handed_out.next(now_s),
            stretch: WalkStretch {
                recording,
                walk_start,
                motion_start_s: seen.motion_start_s,
                from_s,
            },
        }));
    }

    /// Where it begins, while it goes on.
    pub(super) fn begins_s(&self) -> Option<f64> {
        match self {
            Self::Growing { from_s } => Some(*from_s),
            _ => None,
        }
    }

    /// Hands the stretch out, once.
    pub(super) fn take(&mut self) -> Option<Request> {
        match std::mem::take(self) {
            Self::Grown(request) => Some(*request),
            other => {
                *self = other;
                None
            }
        }
    }
}
