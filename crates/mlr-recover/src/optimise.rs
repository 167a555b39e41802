//! Plans in the simulated model, over robots that may be the case.

use mlr_model::{Gait, ModelError, Motion, Progress, standard_normal};
use rand::Rng;
use rayon::prelude::*;

use crate::{
    criterion::Criterion, gait_plan::GaitPlan, possible_robot::PossibleRobot, rows::Joints,
    walking::Walking,
};

/// Simulates plans.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial<'a> {
    pub(crate) joints: Joints<'a>,
    pub(crate) robots: &'a [PossibleRobot],
    pub(crate) criterion: Criterion,
    /// Generations of the optimisation, at most.
    pub(crate) generations: usize,
}

/// A plan with its walks.
#[derive(Debug, Clone)]
pub(crate) struct Tried {
    pub(crate) plan: GaitPlan,
    pub(crate) score: f64,
    /// Mean turn of the robots in a cycle.
    pub(crate) turn_rad: f64,
}

/// Cycles that are measured.
const CYCLES: f64 = 2.0;
/// Plans of a generation, those of them that walk on all robots, and the robots that choose them.
const OFFSPRING: usize = 8;
const FINALISTS: usize = 2;
const FIRST_ROBOTS: usize = 2;
/// A search ends after so many generations without a better plan.
const WITHOUT_PROGRESS: usize = 6;
/// Share of the mean turn that is steered against at once.
const STEERING: f64 = 0.8;

impl Trial<'_> {
    /// How each of some robots walks; `None` of a plan that joints cannot follow.
    fn walks(
        &self,
        plan: &GaitPlan,
        robots: &[PossibleRobot],
    ) -> Result<Option<Vec<Option<Walking>>>, ModelError> {
        let Ok(joints) = self.joints.of_gait(plan) else {
            return Ok(None);
        };
        let cycle_s = joints.repeat_rows().map_or(0, |rows| rows.len()) as f64 * joints.row_s();
        let gait = Gait {
            name: "plan".into(),
            period_s: cycle_s,
            motion: Motion::Joints(joints),
        };
        // The gait starts over one cycle, and is steady half a cycle later.
        let from_s = 1.5 * cycle_s;
        let each = robots.par_iter().map(|robot| {
            let walked = robot.walk(&gait, from_s + CYCLES * cycle_s)?;
            let detector = self.criterion.detector;
            Ok(walked.map(|walked| Walking::of(robot, &walked, from_s, cycle_s, detector)))
        });
        each.collect::<Result<_, _>>().map(Some)
    }

    /// A plan on the first of the robots.
    pub(crate) fn tried(&self, plan: GaitPlan, robots: usize) -> Result<Tried, ModelError> {
        let robots = &self.robots[..robots.min(self.robots.len())];
        let margin_m = self.joints.margin_m(&plan);
        let (Ok(margin_m), Some(walks)) = (margin_m, self.walks(&plan, robots)?) else {
            return Ok(Tried {
                plan,
                score: f64::NEG_INFINITY,
                turn_rad: 0.0,
            });
        };
        let turns = walks.iter().flatten().map(|one| one.turn_rad_per_cycle);
        let turn_rad = turns.sum::<f64>() / walks.len().max(1) as f64;
        Ok(Tried {
            plan,
            score: self.criterion.score(margin_m, &walks),
            turn_rad,
        })
    }

    /// The best of several plans on all robots: those that walk well on a few come first.
    pub(crate) fn best_of(&self, plans: Vec<GaitPlan>) -> Result<Vec<Tried>, ModelError> {
        let few = |plan: GaitPlan| {
            let slowed = self.joints.slowed(plan.clone()).unwrap_or(plan);
            self.tried(slowed, FIRST_ROBOTS)
        };
        let mut first: Vec<Tried> = plans.into_par_iter().map(few).collect::<Result<_, _>>()?;
        sort(&mut first);
        first.truncate(FINALISTS);
        let all = |one: Tried| self.tried(one.plan, self.robots.len());
        let mut tried: Vec<Tried> = first.into_par_iter().map(all).collect::<Result<_, _>>()?;
        sort(&mut tried);
        Ok(tried)
    }

    /// The plan improved by a (1 + λ) evolution strategy, and steered straight on the way.
    pub(crate) fn improved(
        &self,
        start: Tried,
        generator: &mut impl Rng,
        progress: &dyn Progress,
    ) -> Result<Tried, ModelError> {
        let mut best = start;
        let mut size = 0.5;
        let mut fruitless = 0;
        for generation in 0..self.generations {
            let straight = GaitPlan {
                turn_rad: best.plan.turn_rad - STEERING * best.turn_rad,
                ..best.plan.clone()
            };
            let dimension = straight.dimension();
            let mut plans = vec![straight.clone()];
            for _ in 1..OFFSPRING {
                let steps: Vec<f64> = (0..dimension)
                    .map(|_| size * standard_normal(generator))
                    .collect();
                plans.push(straight.moved(&steps));
            }
            let found = self.best_of(plans)?.into_iter().next();
            progress.advance();
            match found.filter(|found| found.score > best.score) {
                Some(better) => {
                    best = better;
                    size = f64::min(size * 1.3, 2.0);
                    fruitless = 0;
                }
                None => {
                    size = f64::max(size * 0.75, 0.05);
                    fruitless += 1;
                }
            }
            if fruitless == WITHOUT_PROGRESS {
                for _ in generation + 1..self.generations {
                    progress.advance();
                }
                break;
            }
        }
        Ok(best)
    }
}

fn sort(tried: &mut [Tried]) {
    tried.sort_by(|a, b| b.score.total_cmp(&a.score));
}
