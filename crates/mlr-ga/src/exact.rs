//! Exact search: every feasible morphology, the yardstick for the genetic
//! algorithm.

use mlr_model::{LegLayout, Morphology};

use crate::Evaluations;

/// Candidates evaluated between two looks at the clock of the progress display;
/// also bounds the memory for candidates of robots with very many morphologies.
const BATCH: usize = 1024;

/// Evaluates every feasible morphology of `layout`.
pub fn search(layout: &LegLayout, evaluations: &mut Evaluations<'_>) {
    let count = layout.count().and_then(|count| usize::try_from(count).ok());
    evaluations.progress().expect(count.unwrap_or(usize::MAX));
    let mut morphologies = layout.enumerate();
    loop {
        let batch: Vec<Morphology> = morphologies.by_ref().take(BATCH).collect();
        if batch.is_empty() {
            break;
        }
        evaluations.evaluate(&batch);
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
        search(&layout, &mut evaluations);
        assert_eq!(evaluations.len(), 48);
        assert_eq!(evaluations.best().unwrap().0, &target);
    }
}
