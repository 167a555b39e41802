//! From what is left of a robot to a gait.

use mlr_filter::{DetectorSettings, SettingError};
use mlr_model::{Gait, ModelError, Progress, Robot};
use rand::Rng;
use rayon::prelude::*;
use thiserror::Error;

use crate::{
    RecoverSettings,
    criterion::Criterion,
    diagnosis::Diagnosis,
    gait_plan::GaitPlan,
    nominal_stance::NominalStance,
    optimise::Trial,
    possible_robot::PossibleRobot,
    rows::{Joints, NotFollowed},
    screen::{Screened, screen},
    statics::LIFT_M,
    swing_order::swing_orders,
    walking::{Walking, fluctuation_deg},
    whole_gait::WholeGait,
};

/// Why there is no gait.
#[derive(Debug, Error)]
pub enum RecoverError {
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Robot and gait do not fit.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// No robot was given.
    #[error("no robot to walk on, expected at least one that may be the case")]
    NoRobots,
    /// Too few legs are left.
    #[error("{0} of the robot's legs can still walk, expected at least 2")]
    TooFewLegs(usize),
    /// No gait was found that the joints can follow.
    #[error("no gait found that the robot's joints can follow")]
    NoGait(#[from] NotFollowed),
}

/// A gait with what is to be expected of it.
#[derive(Debug, Clone)]
pub struct Recovery {
    /// The gait: from the nominal stance into a cycle that repeats.
    pub gait: Gait,
    /// What it is made of.
    pub plan: GaitPlan,
    /// Least static stability margin over its cycle, of the robot as described. Not positive where
    /// nothing statically stable was found: the gait is a limp.
    pub margin_m: f64,
    /// The same on the way into it.
    pub first_steps_margin_m: f64,
    /// Orders in which the legs could swing.
    pub orders: usize,
    /// How the robots walk with the nominal gait.
    pub before: Outlook,
    /// How they walk with the recovery gait.
    pub after: Outlook,
    /// Largest fluctuation of roll or pitch of any of them on the way into the gait.
    pub first_steps_fluctuation_deg: f64,
}

/// How robots walk that may be the case.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlook {
    /// Each of them; `None` of one whose simulation diverged.
    pub walks: Vec<Option<Walking>>,
    /// Probability that the fluctuation stays below the detector's threshold.
    pub calm_probability: f64,
    /// The speed that can be counted on: what gaits are chosen by.
    pub reliable_speed_m_per_s: f64,
}

/// Shares of the nominal gait's speed that are looked at.
const SPEEDS: [f64; 3] = [0.8, 0.55, 0.3];
/// Plans that walk in the model.
const SHORTLIST: usize = 10;
/// Cycles of the final walks.
const CYCLES: f64 = 4.0;
/// The same with the nominal gait.
const NOMINAL_CYCLES: f64 = 5.0;
/// The finished gait is steered so many times.
const STEERED: usize = 2;
/// Feet of a body that stands.
const STANDING: usize = 3;

/// What a gait is searched for.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The robot in full health, as it is described.
    pub robot: &'a Robot,
    /// Its nominal gait.
    pub nominal: &'a Gait,
    /// What may be left of it.
    pub diagnosis: &'a Diagnosis,
    /// Robots that may be this one. The gait is optimised on the first of them, and judged on all.
    pub robots: &'a [PossibleRobot],
    /// The damage detector, whose threshold fluctuations should stay below.
    pub detector: DetectorSettings,
}

/// Finds a gait for what is left of a robot.
///
/// # Errors
/// [`RecoverError`].
pub fn recover(
    task: Task<'_>,
    settings: &RecoverSettings,
    generator: &mut impl Rng,
    progress: &dyn Progress,
) -> Result<Recovery, RecoverError> {
    settings.check()?;
    let search = Search::new(task, settings)?;
    progress.expect_more(3 + settings.generations + STEERED + 1);
    let before = search.nominal_outlook()?;
    progress.advance();
    let (mut screened, orders) = search.screened(generator)?;
    progress.advance();
    screened.truncate(SHORTLIST);
    let plans = screened.into_iter().map(|one| one.plan).collect();
    let trial = search.trial();
    let start = trial.best_of(plans)?.into_iter().next();
    progress.advance();
    let start = start.ok_or(RecoverError::TooFewLegs(0))?;
    trial.joints.of_gait(&start.plan)?;
    let best = trial.improved(start.clone(), generator, progress)?;
    match search.finished(best.plan, orders, &before, progress) {
        // Where the way into the best gait is barred, into the one that it came from it may not be.
        Err(RecoverError::NoGait(_)) => search.finished(start.plan, orders, &before, progress),
        finished => finished,
    }
}

/// How one robot walks with a gait; `None` where it diverges.
struct Played {
    walking: Option<Walking>,
    /// Largest fluctuation from its first step on.
    fluctuation_deg: f64,
}

struct Search<'a> {
    task: Task<'a>,
    settings: &'a RecoverSettings,
    joints: Joints<'a>,
    criterion: Criterion,
    stance: NominalStance,
    nominal_speed_m_per_s: f64,
}

impl<'a> Search<'a> {
    fn new(task: Task<'a>, settings: &'a RecoverSettings) -> Result<Self, RecoverError> {
        let Task { robot, nominal, .. } = task;
        if task.robots.is_empty() {
            return Err(RecoverError::NoRobots);
        }
        let stance = NominalStance::of(robot, nominal)?;
        let speed = nominal.feet().map(|feet| {
            let stance_s = nominal.period_s * (1.0 - feet.swing_fraction);
            feet.stride_m.abs() / stance_s
        });
        Ok(Self {
            task,
            settings,
            joints: Joints {
                robot,
                left: task.diagnosis.most_probable(),
                most_turn_rad: settings.most_turn_deg.to_radians(),
            },
            criterion: Criterion {
                detector: task.detector,
            },
            // Without a stride, that of a body height a second.
            nominal_speed_m_per_s: speed.unwrap_or(stance.body_height_m),
            stance,
        })
    }

    fn trial(&self) -> Trial<'a> {
        let robots = self.task.robots;
        Trial {
            joints: self.joints,
            robots: &robots[..self.settings.robots.min(robots.len())],
            criterion: self.criterion,
            generations: self.settings.generations,
        }
    }

    /// Plans of all sets of legs, best first, and how many orders there were.
    fn screened(&self, generator: &mut impl Rng) -> Result<(Vec<Screened>, usize), RecoverError> {
        let mut all = Vec::new();
        let mut orders_in_all = 0;
        let speeds = SPEEDS.map(|share| share * self.nominal_speed_m_per_s);
        let sets = self.task.diagnosis.walking_sets(self.stance.feet_m.len());
        let most = sets.iter().map(Vec::len).max().unwrap_or(0);
        if most < 2 {
            return Err(RecoverError::TooFewLegs(most));
        }
        for walking in sets {
            let statics = self.joints.statics(&walking, self.stance.body_height_m);
            let standing = STANDING.min(walking.len().saturating_sub(1));
            let orders = swing_orders(&walking, standing);
            orders_in_all += orders.len();
            let plan = GaitPlan {
                order: Vec::new(),
                swing_share: 0.8,
                period_s: 1.0,
                advance_m: 0.0,
                turn_rad: 0.0,
                lift_m: LIFT_M,
                body_height_m: self.stance.body_height_m,
                stance_m: self.stance.feet_m.clone(),
                sway_m: [[0.0; 4]; 2],
            };
            let steps = self.settings.screen_steps;
            all.extend(screen(&statics, &plan, &orders, &speeds, steps, generator));
        }
        all.sort_by(|a, b| b.promise().total_cmp(&a.promise()));
        Ok((all, orders_in_all))
    }

    fn nominal_outlook(&self) -> Result<Outlook, RecoverError> {
        let nominal = self.task.nominal;
        let from_s = nominal.steady_from_s();
        let cycle_s = nominal.period_s;
        let walks = self.walks(nominal, from_s, cycle_s, NOMINAL_CYCLES)?;
        // Whatever its margin is: it is there already.
        Ok(self.outlook(f64::INFINITY, &walks))
    }

    /// How each robot walks with a gait.
    fn walks(
        &self,
        gait: &Gait,
        from_s: f64,
        cycle_s: f64,
        cycles: f64,
    ) -> Result<Vec<Played>, RecoverError> {
        let detector = self.criterion.detector;
        let each = self.task.robots.par_iter().map(|robot| {
            let walked = robot.walk(gait, from_s + cycles * cycle_s)?;
            Ok(match walked {
                Some(walked) => Played {
                    walking: Some(Walking::of(robot, &walked, from_s, cycle_s, detector)),
                    fluctuation_deg: fluctuation_deg(&walked, 0, detector),
                },
                None => Played {
                    walking: None,
                    fluctuation_deg: f64::INFINITY,
                },
            })
        });
        each.collect::<Result<_, ModelError>>().map_err(Into::into)
    }

    fn outlook(&self, margin_m: f64, played: &[Played]) -> Outlook {
        let walks: Vec<Option<Walking>> = played.iter().map(|one| one.walking).collect();
        let calm = walks.iter().flatten();
        let calm = calm.map(|walking| self.criterion.calm_probability(walking));
        let calm_probability = calm.sum::<f64>() / walks.len().max(1) as f64;
        Outlook {
            reliable_speed_m_per_s: self.criterion.score(margin_m, &walks),
            walks,
            calm_probability,
        }
    }

    /// The whole gait, from the nominal stance on, steered by how all robots turn.
    fn finished(
        &self,
        mut plan: GaitPlan,
        orders: usize,
        before: &Outlook,
        progress: &dyn Progress,
    ) -> Result<Recovery, RecoverError> {
        for _ in 0..STEERED {
            let (_, played) = self.whole(&plan)?;
            let turns = played.iter().filter_map(|one| one.walking);
            let turn_rad: f64 = turns.map(|walking| walking.turn_rad_per_cycle).sum();
            plan.turn_rad -= turn_rad / played.len().max(1) as f64;
            plan = self.joints.slowed(plan)?;
            progress.advance();
        }
        let margin_m = self.joints.margin_m(&plan)?;
        let (whole, played) = self.whole(&plan)?;
        progress.advance();
        let onsets = played.iter().map(|one| one.fluctuation_deg);
        let first_steps_fluctuation_deg = onsets.fold(0.0, f64::max);
        let after = self.outlook(margin_m, &played);
        Ok(Recovery {
            gait: whole.gait,
            plan,
            margin_m,
            first_steps_margin_m: whole.first_steps_margin_m,
            orders,
            before: before.clone(),
            after,
            first_steps_fluctuation_deg,
        })
    }

    /// A plan with the way into it, and how all robots walk.
    fn whole(&self, plan: &GaitPlan) -> Result<(WholeGait, Vec<Played>), RecoverError> {
        let whole = WholeGait::of(plan, self.joints, &self.stance)?;
        let cycle_s = whole.gait.period_s;
        let from_s = whole.gait.steady_from_s() + 0.5 * cycle_s;
        let played = self.walks(&whole.gait, from_s, cycle_s, CYCLES)?;
        Ok((whole, played))
    }
}
