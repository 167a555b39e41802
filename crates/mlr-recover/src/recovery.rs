//! From what is left of a robot to a gait.

use mlr_filter::{DetectorSettings, SettingError};
use mlr_model::{Gait, JointCommands, ModelError, Motion, Robot, kinematics};
use rand::Rng;
use rayon::prelude::*;
use thiserror::Error;

use crate::{
    Progress, RecoverSettings,
    criterion::Criterion,
    diagnosis::Diagnosis,
    first_steps::FirstSteps,
    gait_plan::GaitPlan,
    optimise::Trial,
    possible_robot::PossibleRobot,
    rows::{Joints, NotFollowed},
    screen::{Screened, screen},
    statics::Statics,
    support::Ground,
    swing_order::swing_orders,
    walking::{Walking, fluctuation_deg},
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

/// Finds a gait for a robot of which so much is left.
///
/// `robots` are drawn from what is known of the robot; the gait is optimised on the first of them, and
/// the report is of all. The threshold for fluctuations is the damage detector's.
///
/// # Errors
/// [`RecoverError`].
pub fn recover(
    robot: &Robot,
    nominal: &Gait,
    diagnosis: &Diagnosis,
    robots: &[PossibleRobot],
    detector: DetectorSettings,
    settings: &RecoverSettings,
    generator: &mut impl Rng,
    progress: &dyn Progress,
) -> Result<Recovery, RecoverError> {
    settings.check()?;
    let search = Search::new(robot, nominal, diagnosis, robots, detector, settings)?;
    progress.expect_more(3 + settings.generations + STEERED + 1);
    let before = search.nominal_outlook(nominal)?;
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
    let best = trial.improved(start, generator, progress)?;
    search.finished(best.plan, orders, before, progress)
}

struct Search<'a> {
    diagnosis: &'a Diagnosis,
    robots: &'a [PossibleRobot],
    settings: &'a RecoverSettings,
    joints: Joints<'a>,
    criterion: Criterion,
    /// Angles and feet of the nominal stance, leg by leg.
    stance_rad: Vec<Vec<f64>>,
    feet_m: Vec<Ground>,
    body_height_m: f64,
    nominal_speed_m_per_s: f64,
}

impl<'a> Search<'a> {
    fn new(
        robot: &'a Robot,
        nominal: &Gait,
        diagnosis: &'a Diagnosis,
        robots: &'a [PossibleRobot],
        detector: DetectorSettings,
        settings: &'a RecoverSettings,
    ) -> Result<Self, RecoverError> {
        if robots.is_empty() {
            return Err(RecoverError::NoRobots);
        }
        let commands = JointCommands::new(robot, nominal, 0.0)?;
        let stance_rad: Vec<Vec<f64>> = robot
            .legs()
            .iter()
            .enumerate()
            .map(|(leg, described)| {
                let joints = 0..described.links.len();
                joints
                    .map(|joint| commands.angle_rad(leg, joint, 0.0))
                    .collect()
            })
            .collect();
        let tips = robot.legs().iter().zip(&stance_rad);
        let tips: Vec<_> = tips
            .map(|(leg, angles_rad)| kinematics::foot_tip(leg, angles_rad))
            .collect();
        let lowest_m = tips.iter().map(|tip| tip.z).fold(f64::INFINITY, f64::min);
        let speed = nominal.feet().map(|feet| {
            let stance_s = nominal.period_s * (1.0 - feet.swing_fraction);
            feet.stride_m.abs() / stance_s
        });
        Ok(Self {
            diagnosis,
            robots,
            settings,
            joints: Joints {
                robot,
                left: diagnosis.most_probable(),
                most_turn_rad: settings.most_turn_deg.to_radians(),
            },
            criterion: Criterion { detector },
            stance_rad,
            feet_m: tips.iter().map(|tip| [tip.x, tip.y]).collect(),
            body_height_m: -lowest_m,
            // Without a stride, that of a body height a second.
            nominal_speed_m_per_s: speed.unwrap_or(-lowest_m),
        })
    }

    fn trial(&self) -> Trial<'a> {
        let few = self.settings.robots.min(self.robots.len());
        Trial {
            joints: self.joints,
            robots: &self.robots[..few],
            criterion: self.criterion,
            generations: self.settings.generations,
        }
    }

    fn statics(&self, walking: &[usize], body_height_m: f64) -> Statics {
        let Joints {
            robot,
            left,
            most_turn_rad,
        } = self.joints;
        Statics::new(robot, left, walking, body_height_m, LIFT_M, most_turn_rad)
    }

    /// Plans of all sets of legs, best first, and how many orders there were.
    fn screened(&self, generator: &mut impl Rng) -> Result<(Vec<Screened>, usize), RecoverError> {
        let mut all = Vec::new();
        let mut orders_in_all = 0;
        let speeds = SPEEDS.map(|share| share * self.nominal_speed_m_per_s);
        let sets = self.diagnosis.walking_sets(self.feet_m.len());
        let most = sets.iter().map(Vec::len).max().unwrap_or(0);
        if most < 2 {
            return Err(RecoverError::TooFewLegs(most));
        }
        for walking in sets {
            let statics = self.statics(&walking, self.body_height_m);
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
                body_height_m: self.body_height_m,
                stance_m: self.feet_m.clone(),
                sway_m: [[0.0; 4]; 2],
            };
            all.extend(screen(&statics, &plan, &orders, &speeds, generator));
        }
        all.sort_by(|a, b| b.promise().total_cmp(&a.promise()));
        Ok((all, orders_in_all))
    }

    fn nominal_outlook(&self, nominal: &Gait) -> Result<Outlook, RecoverError> {
        let from_s = nominal.steady_from_s();
        let cycle_s = nominal.period_s;
        let walks = self.walks(nominal, from_s, cycle_s, NOMINAL_CYCLES)?;
        // Whatever its margin is: it is there already.
        let walks = walks.into_iter().map(|(walking, _)| walking).collect();
        Ok(self.outlook(f64::INFINITY, walks))
    }

    /// How each robot walks with a gait, and its fluctuation before.
    fn walks(
        &self,
        gait: &Gait,
        from_s: f64,
        cycle_s: f64,
        cycles: f64,
    ) -> Result<Vec<(Option<Walking>, f64)>, RecoverError> {
        let detector = self.criterion.detector;
        let each = self.robots.par_iter().map(|robot| {
            let walked = robot.walk(gait, from_s + cycles * cycle_s)?;
            let Some(walked) = walked else {
                return Ok((None, f64::INFINITY));
            };
            let onset = fluctuation_deg(&walked, 0, detector);
            let walking = Walking::of(robot, &walked, from_s, cycle_s, detector);
            Ok((Some(walking), onset))
        });
        each.collect::<Result<_, ModelError>>().map_err(Into::into)
    }

    fn outlook(&self, margin_m: f64, walks: Vec<Option<Walking>>) -> Outlook {
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
        before: Outlook,
        progress: &dyn Progress,
    ) -> Result<Recovery, RecoverError> {
        let walking = plan.walking();
        let statics = self.statics(&walking, plan.body_height_m);
        for _ in 0..STEERED {
            let (_, _, walks) = self.whole(&statics, &plan)?;
            let turns = walks.iter().filter_map(|(walking, _)| *walking);
            let turn_rad: f64 = turns.map(|walking| walking.turn_rad_per_cycle).sum();
            plan.turn_rad -= turn_rad / walks.len().max(1) as f64;
            progress.advance();
        }
        let margin_m = self.joints.margin_m(&plan)?;
        let (gait, first, walks) = self.whole(&statics, &plan)?;
        progress.advance();
        let onsets = walks.iter().map(|(_, onset_deg)| *onset_deg);
        let first_steps_fluctuation_deg = onsets.fold(0.0, f64::max);
        let walks = walks.into_iter().map(|(walking, _)| walking).collect();
        let after = self.outlook(margin_m, walks);
        Ok(Recovery {
            gait,
            plan,
            margin_m,
            first_steps_margin_m: first.margin_m,
            orders,
            before,
            after,
            first_steps_fluctuation_deg,
        })
    }

    /// A plan with the way into it, and how all robots walk.
    fn whole(
        &self,
        statics: &Statics,
        plan: &GaitPlan,
    ) -> Result<(Gait, FirstSteps, Vec<(Option<Walking>, f64)>), RecoverError> {
        let first = FirstSteps::into(statics, plan, &self.feet_m);
        let joints = self.joints.from_stance(&self.stance_rad, plan, &first)?;
        let cycle_s = joints.repeat_rows().map_or(1, |rows| rows.len()) as f64 * joints.row_s();
        let gait = Gait {
            name: "recovery".into(),
            period_s: cycle_s,
            motion: Motion::Joints(joints),
        };
        let from_s = gait.steady_from_s() + 0.5 * cycle_s;
        let walks = self.walks(&gait, from_s, cycle_s, CYCLES)?;
        Ok((gait, first, walks))
    }
}

/// How high feet are lifted at first.
const LIFT_M: f64 = 0.035;
