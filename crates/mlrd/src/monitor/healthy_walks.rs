//! Stretches of healthy walk, held back until the robot has walked on unflagged.

use mlr_ga::WalkStart;

use super::{
    WalkStretch,
    explainable_walk::{LEAST_STANDING_S, STANDING_S, WalkSeen},
    recent::{Recent, Stretch},
};
use crate::learning::LearningSettings;

/// Takes stretches of the walk down while nothing is wrong with it, and lets go of them once nothing
/// has been wrong for some time afterwards: damage that was about to show is not in them.
#[derive(Debug)]
pub(super) struct HealthyWalks {
    settings: LearningSettings,
    held: Vec<Held>,
    /// Since when there has been neither a swing like that of a damaged robot nor a pause in the
    /// samples.
    calm_since_s: f64,
    /// End of the last stretch.
    taken_s: Option<f64>,
    now_s: f64,
}

#[derive(Debug)]
struct Held {
    stretch: WalkStretch,
    walked_on_s: f64,
}

/// Stretches that are held at most; the detector's step, within which a robot walks on.
const MOST_HELD: usize = 3;
const LONGEST_STEP_S: f64 = 0.5;
/// Recorded before a stretch in mid-walk, for means over time.
const MARGIN_S: f64 = 0.2;

impl HealthyWalks {
    pub(super) fn new(settings: LearningSettings) -> Self {
        Self {
            settings,
            held: Vec::new(),
            calm_since_s: f64::NEG_INFINITY,
            taken_s: None,
            now_s: f64::NEG_INFINITY,
        }
    }

    /// How much must be kept on record.
    pub(super) fn keep_s(settings: &LearningSettings) -> f64 {
        STANDING_S + settings.walk_s + 2.0
    }

    /// What was walked lately may be damaged, or was not seen as it was.
    pub(super) fn doubt(&mut self, now_s: f64) {
        self.held.clear();
        self.calm_since_s = now_s;
    }

    /// A pause in the samples: no stretch reaches over it.
    pub(super) fn paused(&mut self, now_s: f64) {
        self.calm_since_s = now_s;
    }

    /// The robot walks, unflagged, at this time; returns a stretch that may be learned from.
    pub(super) fn walking(
        &mut self,
        now_s: f64,
        cycle_start_s: impl Fn(f64) -> Option<f64>,
        motion_start_s: Option<f64>,
        recent: &Recent,
    ) -> Option<WalkStretch> {
        let step_s = (now_s - self.now_s).clamp(0.0, LONGEST_STEP_S);
        self.now_s = now_s;
        for held in &mut self.held {
            held.walked_on_s += step_s;
        }
        let seen = WalkSeen {
            motion_start_s,
            cycle_start_s: cycle_start_s(now_s - self.settings.walk_s),
        };
        if let Some(stretch) = self.stretch(now_s, seen, recent) {
            self.taken_s = Some(now_s);
            if self.held.len() == MOST_HELD {
                self.held.remove(0);
            }
            self.held.push(Held {
                stretch,
                walked_on_s: 0.0,
            });
        }
        let settled_s = self.settings.settled_s;
        let settled = self
            .held
            .iter()
            .position(|one| one.walked_on_s >= settled_s)?;
        Some(self.held.remove(settled).stretch)
    }

    /// The stretch that ends now: the beginning of a walk, or, some time after the last stretch,
    /// what was walked since.
    fn stretch(&self, now_s: f64, seen: WalkSeen, recent: &Recent) -> Option<WalkStretch> {
        let walk_s = self.settings.walk_s;
        let taken_since = |time_s: f64| self.taken_s.is_some_and(|taken_s| taken_s > time_s);
        let start_s = seen.motion_start_s?;
        if now_s < start_s + walk_s {
            return None;
        }
        let at_rest_s = start_s - LEAST_STANDING_S;
        let shows_the_start = now_s < start_s + walk_s + 2.0 * LONGEST_STEP_S
            && self.calm_since_s <= at_rest_s
            && recent.reaches_back_to(at_rest_s);
        if shows_the_start && !taken_since(start_s) {
            let recording =
                recent.recording(start_s - STANDING_S..=now_s, Stretch::FromTheStart)?;
            return Some(WalkStretch {
                recording,
                walk_start: WalkStart::ObservedAtS(start_s),
                motion_start_s: seen.motion_start_s,
                from_s: start_s,
            });
        }
        let from_s = now_s - walk_s;
        let begin_s = from_s - MARGIN_S;
        if taken_since(now_s - self.settings.every_s)
            || self.calm_since_s > begin_s
            || !recent.reaches_back_to(begin_s)
        {
            return None;
        }
        Some(WalkStretch {
            recording: recent.recording(begin_s..=now_s, Stretch::InMidWalk)?,
            walk_start: WalkStart::ObservedAtS(seen.cycle_start_s?),
            motion_start_s: seen.motion_start_s,
            from_s,
        })
    }
}
