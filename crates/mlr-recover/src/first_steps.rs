//! The way from the nominal stance into a gait.

use nalgebra::Point3;

use crate::{
    gait_plan::GaitPlan,
    statics::Statics,
    support::{Ground, margin_m},
};

/// One foot after the other goes to where the gait begins, the body being moved beforehand to where it
/// stands best on the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FirstSteps {
    /// Where the body stands on all walking legs at first, while others are folded, seen from where it
    /// was.
    pub(crate) begin_m: Ground,
    /// Steps in their order.
    pub(crate) steps: Vec<FirstStep>,
    /// Where the body is when the gait begins.
    pub(crate) end_m: Ground,
    /// Least static stability margin.
    pub(crate) margin_m: f64,
}

/// A step of one leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstStep {
    /// The leg, from 0.
    pub(crate) leg: usize,
    /// Where the body is meanwhile.
    pub(crate) body_m: Ground,
    /// From where and to where the foot goes on the ground, seen from where the body was at first.
    pub(crate) from_m: Ground,
    /// Its end.
    pub(crate) to_m: Ground,
}

/// Grid of places of the body that are tried.
const CELL_M: f64 = 0.01;
const CELLS: i32 = 9;
/// What a metre of the body's way costs in margin.
const WAY_COST: f64 = 0.02;
/// A foot that is so near to where it should be does not step.
const NEAR_M: f64 = 0.003;

impl FirstSteps {
    /// The order of steps with the greatest least margin, from feet at these nominal places, by dynamic
    /// programming over the legs that have stepped.
    pub(crate) fn into(statics: &Statics, plan: &GaitPlan, nominal_m: &[Ground]) -> Self {
        let legs = statics.walking();
        let nominal: Vec<Ground> = legs.iter().map(|leg| nominal_m[*leg]).collect();
        let begins: Vec<Ground> = legs.iter().map(|leg| plan.foot(*leg, 0.0).at_m).collect();
        let count = legs.len().max(1) as f64;
        let end_m = [0, 1].map(|axis| {
            let each = nominal.iter().zip(&begins);
            each.map(|(from, to)| from[axis] - to[axis]).sum::<f64>() / count
        });
        let targets: Vec<Ground> = begins.iter().map(|at_m| plus(*at_m, end_m)).collect();
        let (begin_m, begin_margin_m) = best_place(statics, &[&nominal], None, [0.0; 2]);
        // Of each set of legs that have stepped: the least margin so far, the last leg, and the body.
        let sets = 1_usize << legs.len();
        let mut reached: Vec<Option<(f64, usize, Ground)>> = vec![None; sets];
        reached[0] = Some((begin_margin_m, usize::MAX, begin_m));
        for set in 0..sets {
            let Some((so_far_m, _, body_m)) = reached[set] else {
                continue;
            };
            for index in (0..legs.len()).filter(|index| set & (1 << index) == 0) {
                let feet = |set: usize| -> Vec<Ground> {
                    let place = |index: usize| match set & (1 << index) {
                        0 => nominal[index],
                        _ => targets[index],
                    };
                    (0..legs.len()).map(place).collect()
                };
                let after = set | (1 << index);
                let (place_m, margin) = match near(nominal[index], targets[index]) {
                    true => (body_m, f64::INFINITY),
                    false => best_place(statics, &[&feet(set), &feet(after)], Some(index), body_m),
                };
                let least = so_far_m.min(margin);
                if reached[after].is_none_or(|(known, ..)| least > known) {
                    reached[after] = Some((least, index, place_m));
                }
            }
        }
        let mut steps = Vec::new();
        let mut set = sets - 1;
        let margin = reached[set].map_or(f64::NEG_INFINITY, |(margin, ..)| margin);
        while let Some((_, index, body_m)) =
            reached[set].filter(|(_, index, _)| *index < legs.len())
        {
            if !near(nominal[index], targets[index]) {
                steps.push(FirstStep {
                    leg: legs[index],
                    body_m,
                    from_m: nominal[index],
                    to_m: targets[index],
                });
            }
            set &= !(1 << index);
        }
        steps.reverse();
        Self {
            begin_m,
            steps,
            end_m,
            margin_m: margin,
        }
    }
}

/// The place of the body with the greatest margin on feet that stay, of which the one with this index
/// is lifted; the feet must be in reach in each of the given arrangements.
fn best_place(
    statics: &Statics,
    arrangements: &[&[Ground]],
    lifted: Option<usize>,
    from_m: Ground,
) -> (Ground, f64) {
    let mut best = (from_m, f64::NEG_INFINITY, f64::NEG_INFINITY);
    for row in -CELLS..=CELLS {
        for column in -CELLS..=CELLS {
            let body_m = [row, column].map(|cells| CELL_M * f64::from(cells));
            let mut margin = f64::INFINITY;
            let mut unreached = 0;
            for feet in arrangements {
                let seen: Vec<Ground> = feet.iter().map(|at_m| minus(*at_m, body_m)).collect();
                let (center_m, out_of_reach) = statics.center_m(&seen);
                unreached += out_of_reach;
                let standing: Vec<Ground> = seen
                    .iter()
                    .enumerate()
                    .filter(|(index, _)| lifted != Some(*index))
                    .map(|(_, at_m)| *at_m)
                    .collect();
                margin = margin.min(margin_m(&standing, center_m));
            }
            let way_m = libm::hypot(body_m[0] - from_m[0], body_m[1] - from_m[1]);
            // Beyond this margin, a shorter way is better.
            let score = margin.min(0.04) - WAY_COST * way_m - unreached as f64;
            if score > best.2 {
                best = (body_m, margin - unreached as f64, score);
            }
        }
    }
    (best.0, best.1)
}

fn near(from: Ground, to: Ground) -> bool {
    libm::hypot(to[0] - from[0], to[1] - from[1]) < NEAR_M
}

fn plus(a: Ground, b: Ground) -> Ground {
    [a[0] + b[0], a[1] + b[1]]
}

fn minus(a: Ground, b: Ground) -> Ground {
    [a[0] - b[0], a[1] - b[1]]
}

/// Where a foot on the ground is, seen from the body.
pub(crate) fn seen_from(
    body_m: Ground,
    at_m: Ground,
    height_m: f64,
    body_height_m: f64,
) -> Point3<f64> {
    let [x, y] = minus(at_m, body_m);
    Point3::new(x, y, height_m - body_height_m)
}
