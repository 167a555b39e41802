//! Exact search: every feasible morphology, the reference for the genetic
//! algorithm.

use mlr_model::{LegLayout, Morphology};

use crate::Evaluations;

/// Candidates evaluated between two updates of the best cost and of the progress
/// display; also bounds the memory for robots with very many morphologies. Fixed, so
/// that the same candidates are abandoned whatever the number of threads.
const BATCH: usize = 256;
/// Candidates with up to this many damaged legs are evaluated first: they are the
/// most probable, and a low cost found early lets others be abandoned.
const FEW_LEGS: usize = 2;

/// Evaluates every feasible morphology of `layout`. Candidates whose cost exceeds
/// `margin` times the lowest so far may be abandoned.
pub fn search(layout: &LegLayout, margin: f64, evaluations: &mut Evaluations<'_>) {
    let count = layout.count().and_then(|count| usize::try_from(count).ok());
    evaluations.progress().expect(count.unwrap_or(usize::MAX));
    let has_few = |morphology: &Morphology| morphology.damaged_legs().len() <= FEW_LEGS;
    in_batches(layout.enumerate().filter(has_few), margin, evaluations);
    let has_many = |morphology: &Morphology| !has_few(morphology);
    in_batches(layout.enumerate().filter(has_many), margin, evaluations);
}

fn in_batches(
    mut morphologies: impl Iterator<Item = Morphology>,
    margin: f64,
    evaluations: &mut Evaluations<'_>,
) {
    loop {
        let batch: Vec<Morphology> = morphologies.by_ref().take(BATCH).collect();
        if batch.is_empty() {
            break;
        }
        let best_deg = evaluations
            .best()
            .map_or(f64::INFINITY, |(_, best)| best.cost_deg);
        evaluations.evaluate_within(&batch, best_deg * margin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::tests::Distance;

    #[test]
    fn finds_the_optimum_among_all() {
        let layout = LegLayout::new([3, 2, 3]).unwrap();
        let target = Morphology::parse("110 00 100", &layout).unwrap();
        let objective = Distance::to(target.clone());
        let mut evaluations = Evaluations::new(&objective, &());
        search(&layout, f64::INFINITY, &mut evaluations);
        assert_eq!(evaluations.len(), 48);
        assert_eq!(evaluations.best().unwrap().0, &target);
    }
}
