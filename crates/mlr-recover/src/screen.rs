//! The quasi-static screen: every order in which legs can swing, with the stances and the sway that
//! keep the centre of mass over the feet.

use mlr_model::standard_normal;
use rand::{Rng, RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::{
    gait_plan::GaitPlan,
    statics::{Standing, Statics},
    swing_order::SwingOrder,
};

/// A plan with its statics.
#[derive(Debug, Clone)]
pub(crate) struct Screened {
    pub(crate) plan: GaitPlan,
    pub(crate) standing: Standing,
}

/// Time of a slot of the cycle.
const SLOT_S: f64 = 0.4;
/// Steps of the search for each plan, at least and at most.
const STEPS: std::ops::RangeInclusive<usize> = 250..=8000;
/// More steps for each of those that are looked at more closely.
const MORE_STEPS: usize = 1200;
/// So many orders are.
const CLOSER: usize = 24;
/// At most so many plans are searched, the most promising before that: all of six legs.
const MOST: usize = 3300;
/// More margin than this is worth nothing.
const ENOUGH_M: f64 = 0.04;
/// What a metre of a foot off its nominal place, or of sway, costs in margin.
const DEVIATION_COST: f64 = 0.04;
/// Margin at which half of the plans walk, and by how much more most do. Only ranks plans.
const HALF_M: f64 = 0.012;
const WIDTH_M: f64 = 0.004;

/// The most promising plan of each order at each of some speeds, best first.
///
/// `nominal` gives everything but order, duration and speed. The search takes about so many steps in
/// all.
pub(crate) fn screen(
    statics: &Statics,
    nominal: &GaitPlan,
    orders: &[SwingOrder],
    speeds_m_per_s: &[f64],
    steps: usize,
    generator: &mut impl Rng,
) -> Vec<Screened> {
    let assessed = |plan: GaitPlan| Screened {
        standing: statics.assess(&plan),
        plan,
    };
    let mut screened: Vec<Screened> = orders
        .par_iter()
        .flat_map_iter(|order| speeds_m_per_s.iter().map(move |speed| (order, *speed)))
        .map(|(order, speed_m_per_s)| {
            let period_s = SLOT_S * order.len() as f64;
            assessed(GaitPlan {
                order: order.clone(),
                period_s,
                advance_m: speed_m_per_s * period_s,
                ..nominal.clone()
            })
        })
        .collect();
    if screened.len() > MOST {
        sort(&mut screened);
        screened.truncate(MOST);
    }
    let steps = steps / screened.len().max(1);
    for steps in [steps.clamp(*STEPS.start(), *STEPS.end()), MORE_STEPS] {
        let seeds: Vec<u64> = screened.iter().map(|_| generator.random()).collect();
        screened = screened
            .into_par_iter()
            .zip(seeds)
            .map(|(one, seed)| assessed(steadied(statics, nominal, one.plan, steps, seed)))
            .collect();
        sort(&mut screened);
        screened.truncate(CLOSER);
    }
    screened
}

fn sort(screened: &mut [Screened]) {
    screened.sort_by(|a, b| b.promise().total_cmp(&a.promise()));
}

impl Screened {
    /// How fast it probably walks, m/s; only its order means anything.
    pub(crate) fn promise(&self) -> f64 {
        let Standing { margin_m, amiss } = self.standing;
        let stands = 1.0 / (1.0 + libm::exp(-(margin_m - HALF_M) / WIDTH_M));
        self.plan.speed_m_per_s() * stands * libm::exp(-100.0 * amiss)
    }
}

/// The plan with stances and sway that have the greatest margin, by a (1 + 1) evolution strategy with
/// the one-fifth rule (Rechenberg 1973).
fn steadied(
    statics: &Statics,
    nominal: &GaitPlan,
    mut plan: GaitPlan,
    steps: usize,
    seed: u64,
) -> GaitPlan {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let dimension = plan.dimension();
    let mut size = 1.0;
    let mut best = score(statics, nominal, &plan);
    for _ in 0..steps {
        let moves: Vec<f64> = (0..dimension)
            .map(|_| size * standard_normal(&mut generator))
            .collect();
        let tried = plan.moved_in_place(&moves);
        let score = score(statics, nominal, &tried);
        if score > best {
            (plan, best) = (tried, score);
            size = f64::min(size * 1.5, 3.0);
        } else {
            size = f64::max(size * 0.9, 0.02);
        }
    }
    plan
}

fn score(statics: &Statics, nominal: &GaitPlan, plan: &GaitPlan) -> f64 {
    let Standing { margin_m, amiss } = statics.assess(plan);
    let moved = plan.stance_m.iter().flatten();
    let moved = moved.zip(nominal.stance_m.iter().flatten());
    let moved_sq: f64 = moved.map(|(a, b)| (a - b) * (a - b)).sum();
    let sway_sq: f64 = plan.sway_m.iter().flatten().map(|a| a * a).sum();
    let cost = DEVIATION_COST * libm::sqrt(moved_sq + sway_sq);
    margin_m.min(ENOUGH_M) - cost - amiss
}
