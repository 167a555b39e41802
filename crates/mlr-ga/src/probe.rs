//! The motion of a healthy robot that tells most about its own parameters.

mod report;

pub use report::{ProbeReport, ReportedParameter, ReportedSegment};

use std::collections::BTreeMap;

use mlr_filter::SettingError;
use mlr_model::{FoldedWalk, Gait, ModelError, MotionSegment, Robot, SimulationSettings};
use mlr_residual::{
    Progress,
    walk::{
        BrokenBound, Ensemble, EvidenceSettings, Information, MotionBounds, WalkError, WalkRecord,
    },
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

/// What a motion may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeSettings {
    /// How long it may last.
    pub longest_s: f64,
    /// What every robot of the ensemble stays below.
    pub bounds: MotionBounds,
    /// How many legs are folded at the same time, at most.
    pub most_folded_legs: usize,
    /// Chooses the robots.
    pub seed: u64,
    /// How many robots of the make keep the bounds.
    pub robots: usize,
}

impl Default for ProbeSettings {
    fn default() -> Self {
        Self {
            longest_s: 30.0,
            bounds: MotionBounds { tilt_deg: 15.0 },
            most_folded_legs: 2,
            seed: 1,
            robots: 8,
        }
    }
}

impl ProbeSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let longest_s = WalkRecord::LONGEST_MOTION_S;
        SettingError::check("longest_s", self.longest_s, 5.0..=longest_s, "s")?;
        SettingError::check(
            "bounds.tilt_deg",
            self.bounds.tilt_deg,
            0.1..=90.0,
            "degrees",
        )?;
        SettingError::check("most_folded_legs", self.most_folded_legs, 0..=2, "legs")?;
        SettingError::check("robots", self.robots, 1..=1000, "")
    }

    /// Of how many robots the information of each segment is asked; that of the whole motion, of twice as many.
    fn informed_robots(&self) -> usize {
        self.robots.div_ceil(4)
    }
}

/// Why there is no motion.
#[derive(Debug, Error)]
pub enum ProbeError {
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Robot and gait do not fit.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The robot cannot be simulated.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// Not even a plain walk keeps the bounds.
    #[error(
        "some robots of the make {} where they walk with no leg folded, expected a gait that keeps the \
         bounds, or wider ones", _0.describe()
    )]
    NoSegment(BrokenBound),
}

/// A motion with what it tells.
#[derive(Debug, Clone)]
pub struct CalibrationMotion {
    /// The motion: a joint trajectory that ends.
    pub gait: Gait,
    /// What it is made of, in order.
    pub segments: Vec<Segment>,
    /// How many candidate segments were left out, by reason.
    pub left_out: BTreeMap<String, usize>,
    /// How many were looked at.
    pub candidates: usize,
    /// What a plain walk tells of each of some robots, as much of it as a calibration looks at.
    pub of_walk: Vec<Information>,
    /// What the motion tells of each of them.
    pub of_motion: Vec<Information>,
}

/// A walk with folded legs, and what it tells alone.
#[derive(Debug, Clone)]
pub struct Segment {
    /// The walk.
    pub walk: FoldedWalk,
    /// From stance to stance.
    pub duration_s: f64,
    /// Mean expected reduction of the entropy of the robot's parameters, nats.
    pub gain_nats: f64,
    gait: Gait,
    information: Vec<Information>,
}

/// Why a walk is no segment.
enum LeftOut {
    /// Feet are out of reach.
    Reach(ModelError),
    /// Joints would have to turn faster than their servos can.
    Speed(ModelError),
    /// It breaks a bound.
    Bound(BrokenBound),
}

impl LeftOut {
    /// For people: what robots would do.
    fn describe(&self) -> &'static str {
        match self {
            Self::Reach(_) => "are out of reach",
            Self::Speed(_) => "are too fast for the servos",
            Self::Bound(broken) => broken.describe(),
        }
    }
}

impl From<LeftOut> for ProbeError {
    fn from(of_plain_walk: LeftOut) -> Self {
        match of_plain_walk {
            LeftOut::Reach(error) | LeftOut::Speed(error) => error.into(),
            LeftOut::Bound(broken) => Self::NoSegment(broken),
        }
    }
}

/// Step cycles of a segment at full stride or growing.
pub(crate) const FOLDED_CYCLES: usize = 2;
/// Other steps that the legs of the most informative segments try: stride, lift and period over those
/// of the gait.
const STEPS: [[f64; 3]; 3] = [[1.3, 1.0, 1.0], [0.5, 1.5, 1.0], [1.0, 1.0, 1.5]];
/// Of so many segments.
const VARIED: usize = 3;

/// Searches segments (no leg folded, each one, each pair, other steps) that keep the bounds, and joins
/// those that tell most in their time.
///
/// The motion begins with a plain walk: a log shows when that starts.
///
/// # Errors
/// [`ProbeError`].
pub fn calibration_motion(
    robot: &Robot,
    gait: &Gait,
    simulation: &SimulationSettings,
    explanation: &EvidenceSettings,
    settings: ProbeSettings,
    progress: &dyn Progress,
) -> Result<CalibrationMotion, ProbeError> {
    settings.check()?;
    let mut generator = ChaCha8Rng::seed_from_u64(settings.seed);
    let count = settings.robots;
    let ensemble = Ensemble::drawn(robot, simulation, explanation, count, &mut generator)?;
    let search = Search {
        robot,
        settings,
        ensemble,
        progress,
    };
    let mut left_out = BTreeMap::new();
    let folded = folded_legs(robot.legs().len(), settings.most_folded_legs);
    let walks: Vec<FoldedWalk> = folded
        .into_iter()
        .map(|folded_legs| FoldedWalk {
            folded_legs,
            gait: gait.clone(),
            cycles: FOLDED_CYCLES,
        })
        .collect();
    // The first has no leg folded.
    let (plain, folded) = (&walks[0], &walks[1..]);
    let mut candidates = walks.len();
    progress.expect_more(walks.len() + VARIED * STEPS.len() + 2);
    let opening = search.segment(plain)??;
    progress.advance();
    let mut segments = search.kept(folded, &mut left_out)?;
    segments.sort_by(|a, b| b.rate().total_cmp(&a.rate()));
    let varied: Vec<FoldedWalk> = segments
        .iter()
        .take(VARIED)
        .flat_map(|segment| STEPS.map(|steps| varied(&segment.walk, steps)))
        .collect();
    candidates += varied.len();
    segments.extend(search.kept(&varied, &mut left_out)?);
    let mut chosen = search.greedy(opening, segments);
    let whole = loop {
        let walks: Vec<FoldedWalk> = chosen.iter().map(|one| one.walk.clone()).collect();
        let whole = search.joined(&walks)?;
        match search.broken_bound(&whole)? {
            Some(broken) if chosen.len() == 1 => return Err(ProbeError::NoSegment(broken)),
            // Segments are simulated alone; what they leave of the one before may be too much.
            Some(_) => drop(chosen.pop()),
            None => break whole,
        }
    };
    let informed = (2 * settings.informed_robots()).min(search.ensemble.len());
    let moved_s = whole.duration_s().unwrap_or_default();
    let of_motion = search.ensemble.information(&whole, moved_s, informed)?;
    progress.advance();
    let of_walk = search
        .ensemble
        .information(gait, WalkRecord::LONGEST_WALK_S, informed)?;
    progress.advance();
    Ok(CalibrationMotion {
        gait: whole,
        segments: chosen,
        left_out,
        candidates,
        of_walk,
        of_motion,
    })
}

/// No leg, each leg, and each pair of legs, as far as so many may be folded.
fn folded_legs(legs: usize, most: usize) -> Vec<Vec<usize>> {
    let pairs = (0..legs).flat_map(|one| (one + 1..legs).map(move |other| vec![one, other]));
    std::iter::once(Vec::new())
        .chain((0..legs).map(|leg| vec![leg]))
        .chain(pairs)
        .filter(|folded| folded.len() <= most)
        .collect()
}

/// The same walk with other steps: stride, lift and period over those that it has.
pub(crate) fn varied(walk: &FoldedWalk, [stride, lift, period]: [f64; 3]) -> FoldedWalk {
    let mut walk = walk.clone();
    walk.gait.period_s *= period;
    if let Some(feet) = walk.gait.feet_mut() {
        feet.stride_m *= stride;
        feet.lift_m *= lift;
    }
    walk
}

struct Search<'s> {
    robot: &'s Robot,
    settings: ProbeSettings,
    ensemble: Ensemble<'s>,
    progress: &'s dyn Progress,
}

impl Search<'_> {
    /// Walks one after the other as a gait.
    fn joined(&self, walks: &[FoldedWalk]) -> Result<Gait, ModelError> {
        let period_s = walks.first().map_or(1.0, |walk| walk.gait.period_s);
        let segments: Vec<_> = walks.iter().cloned().map(MotionSegment::Walk).collect();
        Gait::of_segments("calibration", period_s, self.robot, &segments)
    }

    /// Those walks that keep the bounds, with what they tell. Counts the others by reason.
    fn kept(
        &self,
        walks: &[FoldedWalk],
        left_out: &mut BTreeMap<String, usize>,
    ) -> Result<Vec<Segment>, ProbeError> {
        let mut kept = Vec::new();
        for walk in walks {
            match self.segment(walk)? {
                Ok(segment) => kept.push(segment),
                Err(why) => *left_out.entry(why.describe().into()).or_default() += 1,
            }
            self.progress.advance();
        }
        Ok(kept)
    }

    /// The first bound that a whole motion breaks.
    fn broken_bound(&self, motion: &Gait) -> Result<Option<BrokenBound>, WalkError> {
        let duration_s = motion.duration_s().unwrap_or_default();
        let bounds = self.settings.bounds;
        self.ensemble.broken_bound(motion, duration_s, bounds)
    }

    /// A walk with what it tells, or why it is left out.
    fn segment(&self, walk: &FoldedWalk) -> Result<Result<Segment, LeftOut>, ProbeError> {
        let gait = match self.joined(std::slice::from_ref(walk)) {
            Ok(gait) => gait,
            Err(error @ ModelError::Unreachable { .. }) => return Ok(Err(LeftOut::Reach(error))),
            Err(error @ ModelError::Setting(_)) if !walk.folded_legs.is_empty() => {
                return Ok(Err(LeftOut::Speed(error)));
            }
            Err(error) => return Err(error.into()),
        };
        if let Some(broken) = self.broken_bound(&gait)? {
            return Ok(Err(LeftOut::Bound(broken)));
        }
        let duration_s = gait.duration_s().unwrap_or_default();
        let robots = self.settings.informed_robots();
        let information = self.ensemble.information(&gait, duration_s, robots)?;
        Ok(Ok(Segment {
            walk: walk.clone(),
            duration_s,
            gain_nats: mean_gain_nats(&information),
            gait,
            information,
        }))
    }

    /// The segment that adds most information for its time, again and again while there is time left.
    fn greedy(&self, opening: Segment, mut left: Vec<Segment>) -> Vec<Segment> {
        let mut known = opening.information.clone();
        let mut time_s = opening.duration_s;
        let mut chosen = vec![opening];
        loop {
            left.retain(|segment| time_s + segment.duration_s <= self.settings.longest_s);
            let before_nats = mean_gain_nats(&known);
            let rate = |segment: &Segment| {
                let added = both(&known, &segment.information);
                (mean_gain_nats(&added) - before_nats) / segment.duration_s
            };
            let best = (0..left.len()).max_by(|a, b| rate(&left[*a]).total_cmp(&rate(&left[*b])));
            let Some(best) = best else {
                return chosen;
            };
            let segment = left.swap_remove(best);
            known = both(&known, &segment.information);
            time_s += segment.duration_s;
            chosen.push(segment);
        }
    }
}

impl Segment {
    fn rate(&self) -> f64 {
        self.gain_nats / self.duration_s
    }

    /// The segment alone as a gait.
    pub fn gait(&self) -> &Gait {
        &self.gait
    }
}

/// What two motions tell of the same robots.
fn both(one: &[Information], other: &[Information]) -> Vec<Information> {
    let pairs = one.iter().zip(other);
    pairs.map(|(one, other)| one.and(other)).collect()
}

/// Expected reduction of entropy over an ensemble.
pub(crate) fn mean_gain_nats(information: &[Information]) -> f64 {
    let sum: f64 = information.iter().map(Information::gain_nats).sum();
    sum / information.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_leg_each_leg_and_each_pair_are_candidates() {
        let sets = folded_legs(6, 2);
        assert_eq!(sets.len(), 1 + 6 + 15);
        assert_eq!(folded_legs(6, 1), sets[..7]);
        assert_eq!(sets[0], Vec::<usize>::new());
        assert!(sets.contains(&vec![0, 3]) && sets.contains(&vec![2]));
    }

    /// Bounds and search on few robots and in little time.
    #[test]
    fn the_motion_keeps_its_time_and_tells_more_than_a_walk() {
        let settings = ProbeSettings {
            longest_s: 10.0,
            most_folded_legs: 1,
            robots: 2,
            ..ProbeSettings::default()
        };
        let found = |settings| {
            let (robot, gait) = (Robot::jethexa(), Gait::tripod());
            let simulation = SimulationSettings::default();
            let explanation = EvidenceSettings::default();
            calibration_motion(&robot, &gait, &simulation, &explanation, settings, &())
        };
        let motion = found(settings).unwrap();
        assert!(motion.gait.duration_s().unwrap() <= 10.0);
        assert!(motion.segments.len() >= 2);
        assert!(motion.segments[0].walk.folded_legs.is_empty());
        let (of_motion, opening) = (mean_gain_nats(&motion.of_motion), &motion.segments[0]);
        assert!(of_motion > 1.3 * opening.gain_nats, "{of_motion}");
        // As much time as a calibration looks at of a walk tells less where no leg is folded.
        let of_walk = mean_gain_nats(&motion.of_walk);
        assert!(of_motion > of_walk, "{of_motion} {of_walk}");
        let left_out: usize = motion.left_out.values().sum();
        assert!(left_out < motion.candidates);
        // Bounds that nothing keeps are said to be so.
        let bounds = MotionBounds { tilt_deg: 0.1 };
        let error = found(ProbeSettings { bounds, ..settings }).unwrap_err();
        assert!(
            matches!(error, ProbeError::NoSegment(BrokenBound::Tilt)),
            "{error}"
        );
    }
}
