//! What a motion tells of a robot's own parameters, before any robot has moved.

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    Gait, Gaussian, LostLinks, Morphology, Record, Robot, RobotParameter, SimulationSettings,
    Trajectory, standard_normal,
};
use nalgebra::{DMatrix, DVector};
use rand::Rng;
use rayon::prelude::*;

use super::{
    EvidenceSettings, Nuisance, NuisancePrior, Observation, WalkError, WalkModel, WalkRecord,
    calibration::{left_by_the_engine, updated},
    evidence::curvature,
    hypothesis::{Hypothesis, Walker},
};

/// Robots drawn from what is known of one: its make, or its calibration, and any day.
///
/// An informative motion is close to tipping, so what it tells of the robot as described says little
/// of what it tells of another.
#[derive(Debug)]
pub struct Ensemble<'a> {
    robot: Robot,
    simulation: SimulationSettings,
    settings: &'a EvidenceSettings,
    /// Coordinates of the parameters of each robot.
    robots: Vec<DVector<f64>>,
}

/// What a motion of a robot must stay below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionBounds {
    /// Tilt of the body.
    pub tilt_deg: f64,
}

impl MotionBounds {
    /// What a walk with recorded torques breaks, if anything, where servos have so much torque.
    pub fn broken_by(&self, walk: &Trajectory, torque_limit_nm: f64) -> Option<BrokenBound> {
        if greatest_tilt_deg(&walk.orientation) > self.tilt_deg {
            return Some(BrokenBound::Tilt);
        }
        let limit_nm = AT_LIMIT * torque_limit_nm;
        let mut torques = walk.torque_nm.iter().flatten().flatten();
        torques
            .any(|torque| torque.abs() >= limit_nm)
            .then_some(BrokenBound::Torque)
    }
}

/// The bound that a motion does not keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BrokenBound {
    /// The robot is not upright to the end, or does not move as numbers can tell.
    Diverges,
    /// The body tilts too far.
    Tilt,
    /// A servo needs all of its torque.
    Torque,
}

impl BrokenBound {
    /// For people: what robots do that break it.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Diverges => "diverge",
            Self::Tilt => "tilt too far",
            Self::Torque => "need all of a servo's torque",
        }
    }
}

/// What a motion of one robot tells, the day's parameters integrated out when asked.
///
/// In standard deviations of the make. Information of motions in one log adds, as far as their errors
/// are independent.
#[derive(Debug, Clone)]
pub struct Information {
    nuisances: Vec<Nuisance>,
    before: DMatrix<f64>,
    curvature: DMatrix<f64>,
    engine_bias: f64,
}

/// How long the robot of a synthetic record stands.
const STAND_S: f64 = 2.0;
/// A servo that is closer to its largest torque is at it.
const AT_LIMIT: f64 = 0.999;

impl<'a> Ensemble<'a> {
    /// So many robots.
    ///
    /// # Errors
    /// [`WalkError`] when a setting makes no sense, or the robot cannot stand.
    pub fn drawn(
        robot: &Robot,
        simulation: &SimulationSettings,
        settings: &'a EvidenceSettings,
        count: usize,
        generator: &mut impl Rng,
    ) -> Result<Self, WalkError> {
        settings.check()?;
        let morphology = Morphology::healthy(&robot.layout());
        let record = level_record(WalkRecord::LONGEST_WALK_S)?;
        let coordinates = Nuisance::of(&morphology, &record).len();
        let robots = (0..count)
            .map(|_| DVector::from_fn(coordinates, |_, _| standard_normal(generator)))
            .collect();
        Ok(Self {
            robot: robot.clone(),
            simulation: simulation.clone(),
            settings,
            robots,
        })
    }

    /// How many robots there are.
    pub fn len(&self) -> usize {
        self.robots.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.robots.is_empty()
    }

    /// The first bound that one of the robots breaks in the first `moved_s` of this gait.
    ///
    /// # Errors
    /// [`WalkError`] when the gait makes no sense for the robot.
    pub fn broken_bound(
        &self,
        gait: &Gait,
        moved_s: f64,
        bounds: MotionBounds,
    ) -> Result<Option<BrokenBound>, WalkError> {
        let record = level_record(moved_s)?;
        let mut nominal = self.nominal(gait);
        nominal.simulation.record = Record {
            torques: true,
            ..Record::default()
        };
        let observed = Observed::new(&record, self.settings, &nominal);
        let walker = observed.walker(&nominal);
        let samples = record.times_s().len();
        let each = self.robots.par_iter().map(|z| {
            let model = walker.model(z);
            let walked = model.trajectory(&walker.hypothesis.morphology, &record, samples)?;
            Ok(match walked {
                Some(walked) => bounds.broken_by(&walked, model.servo.torque_limit_nm),
                None => Some(BrokenBound::Diverges),
            })
        });
        let broken = each.collect::<Result<Vec<_>, WalkError>>()?;
        Ok(broken.into_iter().flatten().next())
    }

    /// What the first `seen_s` of this gait tell of each of the first `robots` robots.
    ///
    /// # Errors
    /// [`WalkError`] when the gait makes no sense for the robot, or a robot's walk diverges.
    pub fn information(
        &self,
        gait: &Gait,
        seen_s: f64,
        robots: usize,
    ) -> Result<Vec<Information>, WalkError> {
        let of_robots = self.robots.par_iter().take(robots);
        of_robots
            .map(|z| self.information_of(z, gait, seen_s))
            .collect()
    }

    fn information_of(
        &self,
        z: &DVector<f64>,
        gait: &Gait,
        seen_s: f64,
    ) -> Result<Information, WalkError> {
        let nominal = self.nominal(gait);
        // The discrepancy grows with how far a robot swings: what it would record comes first.
        let level = level_record(seen_s)?;
        let observed = Observed::new(&level, self.settings, &nominal);
        let walked = observed.walker(&nominal).walk(z.clone());
        let recorded = walked.ok_or(WalkError::Diverged)?.prediction.angles_deg;
        let record = recorded_as(&level, &recorded)?;
        let observed = Observed::new(&record, self.settings, &nominal);
        let walker = observed.walker(&nominal);
        let walked = walker.walk(z.clone()).ok_or(WalkError::Diverged)?;
        let jacobian = walker.jacobian(&walked);
        let whitening = walker.whitening(&jacobian).ok_or(WalkError::Diverged)?;
        let precisions = whitening.usual_precisions();
        let mut curvature = curvature(&whitening, &whitening.apply(&jacobian), precisions);
        if let Some(unmixing) = walker.mixing().try_inverse() {
            curvature = unmixing.tr_mul(&curvature) * unmixing;
        }
        let nuisances = Nuisance::of(&walker.hypothesis.morphology, &record);
        let before = observed.prior.physical(&nuisances, &record, &nominal);
        Ok(Information {
            nuisances,
            before: before.covariance,
            curvature,
            engine_bias: self.settings.nuisance.engine_bias,
        })
    }

    fn nominal(&self, gait: &Gait) -> WalkModel {
        WalkModel::of_make(
            self.robot.clone(),
            gait.clone(),
            self.simulation.clone(),
            &self.settings.nuisance,
        )
    }
}

/// A record with what is needed to predict it.
struct Observed<'r> {
    observation: Observation<'r>,
    prior: NuisancePrior,
}

impl<'r> Observed<'r> {
    fn new(record: &'r WalkRecord, settings: &EvidenceSettings, nominal: &WalkModel) -> Self {
        let period_s = nominal.gait.period_s;
        Self {
            observation: Observation::of_whole(record, &settings.discrepancy, period_s),
            prior: NuisancePrior::new(&settings.nuisance, nominal),
        }
    }

    /// The whole robot without effects.
    fn walker(&self, nominal: &WalkModel) -> Walker<'_> {
        let hypothesis = Hypothesis {
            morphology: Morphology::healthy(&nominal.robot.layout()),
            lost_links: LostLinks::Absent,
            effects: Vec::new(),
        };
        Walker::new(hypothesis, &self.observation, &self.prior, nominal)
    }
}

impl Information {
    /// What both motions tell in one log.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            curvature: &self.curvature + &other.curvature,
            ..self.clone()
        }
    }

    /// The reduction of the entropy of the robot's own parameters that is to be expected, in nats:
    /// half the logarithm of the determinants' ratio of their covariance before and after.
    pub fn gain_nats(&self) -> f64 {
        let ln_determinant = |covariance: &DMatrix<f64>| {
            let own = self.own();
            let rows: Vec<usize> = own.iter().map(|(row, _)| *row).collect();
            let of_own = covariance.select_rows(&rows).select_columns(&rows);
            of_own
                .cholesky()
                .map_or(0.0, |factors| factors.ln_determinant())
        };
        0.5 * (ln_determinant(&self.before) - ln_determinant(&self.after()))
    }

    /// Standard deviations of the robot's own parameters that are left, over those of the make.
    pub fn deviations(&self) -> Vec<(RobotParameter, f64)> {
        self.own_deviations(&self.after())
    }

    /// The same before the motion.
    pub fn deviations_before(&self) -> Vec<(RobotParameter, f64)> {
        self.own_deviations(&self.before)
    }

    fn own_deviations(&self, covariance: &DMatrix<f64>) -> Vec<(RobotParameter, f64)> {
        let own = self.own().into_iter();
        own.map(|(row, parameter)| (parameter, covariance[(row, row)].max(0.0).sqrt()))
            .collect()
    }

    fn own(&self) -> Vec<(usize, RobotParameter)> {
        let each = self.nuisances.iter().enumerate();
        each.filter_map(|(row, nuisance)| Some((row, nuisance.parameter()?)))
            .collect()
    }

    /// Covariance of all parameters after the motion.
    fn after(&self) -> DMatrix<f64> {
        let n = self.before.nrows();
        let before = Gaussian {
            mean: DVector::zeros(n),
            covariance: self.before.clone(),
        };
        let zero = DVector::zeros(n);
        let left = left_by_the_engine(&self.nuisances, self.engine_bias, &self.curvature);
        updated(&before, &zero, &zero, &(left * &self.curvature)).covariance
    }
}

/// A recording of raw rates, integrated, of a robot that stands and then is seen for so long.
fn recorded(recording: &OrientationSeries, seen_s: f64) -> Result<WalkRecord, WalkError> {
    let record = WalkRecord::up_to(seen_s, recording, STAND_S, false, STAND_S, Some([0.0; 3]))?;
    Ok(record.dead_reckoned())
}

/// That of a robot which is level all the time.
pub(super) fn level_record(seen_s: f64) -> Result<WalkRecord, WalkError> {
    let samples = ((STAND_S + seen_s) * WalkRecord::RATE_HZ).ceil().max(0.0) as usize + 2;
    let times_s: Vec<f64> = (0..samples)
        .map(|index| index as f64 * WalkRecord::PERIOD_S)
        .collect();
    let level = Axes::from_fn(|_| vec![0.0; samples]);
    series(times_s, level).and_then(|level| recorded(&level, seen_s))
}

/// That of a robot which moves like this at the times of another record.
fn recorded_as(like: &WalkRecord, angles_deg: &Axes<Vec<f64>>) -> Result<WalkRecord, WalkError> {
    let times_s = &like.times_s()[..angles_deg.roll.len()];
    let angles_rad = angles_deg
        .as_ref()
        .map(|_, angles| angles.iter().map(|angle| angle.to_radians()).collect());
    let last_s = times_s.last().copied().unwrap_or(0.0);
    series(times_s.to_vec(), angles_rad).and_then(|moved| recorded(&moved, last_s - STAND_S))
}

fn series(times_s: Vec<f64>, angles_rad: Axes<Vec<f64>>) -> Result<OrientationSeries, WalkError> {
    // Times rise evenly; angles that are not finite are those of a walk that diverges.
    OrientationSeries::new(times_s, angles_rad).map_err(|_| WalkError::Diverged)
}

/// The largest angle between the body's z axis and the vertical.
fn greatest_tilt_deg(orientation: &OrientationSeries) -> f64 {
    let angles_rad = orientation.angles_rad();
    let each = angles_rad.roll.iter().zip(&angles_rad.pitch);
    let tilts = each.map(|(roll, pitch)| libm::acos(libm::cos(*roll) * libm::cos(*pitch)));
    tilts.fold(0.0, f64::max).to_degrees()
}

#[cfg(test)]
mod tests {
    use mlr_model::{FoldedWalk, MotionSegment};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn folded(legs: &[usize]) -> Gait {
        let robot = Robot::jethexa();
        let walk = FoldedWalk {
            folded_legs: legs.to_vec(),
            gait: Gait::tripod(),
            cycles: 2,
        };
        Gait::of_segments("folded", 1.0, &robot, &[MotionSegment::Walk(walk)]).unwrap()
    }

    fn of_ensemble<T>(robot: &Robot, of: impl Fn(&Ensemble<'_>) -> T) -> T {
        let settings = EvidenceSettings::default();
        let mut generator = ChaCha8Rng::seed_from_u64(5);
        let simulation = SimulationSettings::default();
        let ensemble = Ensemble::drawn(robot, &simulation, &settings, 2, &mut generator);
        of(&ensemble.unwrap())
    }

    #[test]
    fn folded_legs_tell_more_and_information_adds() {
        of_ensemble(&Robot::jethexa(), |ensemble| {
            let told = |gait: &Gait| ensemble.information(gait, 4.6, 1).unwrap().remove(0);
            let (plain, folded) = (told(&Gait::tripod()), told(&folded(&[0, 3])));
            assert!(plain.gain_nats() > 0.0);
            let more = folded.gain_nats() - plain.gain_nats();
            assert!(more > 1.0, "{more} of {} nats", plain.gain_nats());
            let both = plain.and(&folded);
            assert!(both.gain_nats() > folded.gain_nats());
            assert!(both.gain_nats() < plain.gain_nats() + folded.gain_nats() + 1e-9);
            for ((parameter, after), (_, before)) in
                both.deviations().into_iter().zip(both.deviations_before())
            {
                assert!((before - 1.0).abs() < 1e-12);
                assert!(after <= before + 1e-9, "{parameter}: {after}");
            }
        });
    }

    #[test]
    fn a_motion_that_tilts_too_far_for_one_of_the_robots_breaks_a_bound() {
        of_ensemble(&Robot::jethexa(), |ensemble| {
            let broken = |gait: &Gait, tilt_deg| {
                let bounds = MotionBounds { tilt_deg };
                ensemble.broken_bound(gait, 4.0, bounds).unwrap()
            };
            assert_eq!(broken(&Gait::tripod(), 15.0), None);
            assert_eq!(broken(&Gait::tripod(), 0.1), Some(BrokenBound::Tilt));
        });
    }
}
