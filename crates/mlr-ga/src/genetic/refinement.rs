use mlr_model::Morphology;

use crate::Evaluations;

/// Local search: tries every change of a single leg and moves to the best as
/// long as that improves.
pub(super) fn climb(start: &Morphology, evaluations: &mut Evaluations<'_>) -> Morphology {
    let mut current = start.clone();
    loop {
        let neighbours = single_leg_changes(&current);
        evaluations.evaluate(&neighbours);
        let best = neighbours
            .into_iter()
            .min_by(|a, b| evaluations.order(a, b));
        match best {
            Some(best) if evaluations.order(&best, &current).is_lt() => current = best,
            _ => return current,
        }
    }
}

/// All morphologies that differ from `morphology` in one leg.
fn single_leg_changes(morphology: &Morphology) -> Vec<Morphology> {
    (0..morphology.legs())
        .flat_map(|leg| (0..=morphology.links(leg)).map(move |remaining| (leg, remaining)))
        .filter(|&(leg, remaining)| remaining != morphology.remaining(leg))
        .map(|(leg, remaining)| morphology.clone().with_remaining(leg, remaining))
        .collect()
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;

    use super::*;
    use crate::evaluation::tests::Distance;

    #[test]
    fn climbs_to_the_top_of_a_smooth_hill() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let target = Morphology::parse("000 111 110 111 100 111", &layout).unwrap();
        let objective = Distance::to(target.clone());
        let mut evaluations = Evaluations::new(&objective, &());
        let start = Morphology::healthy(&layout);
        evaluations.evaluate(std::slice::from_ref(&start));
        assert_eq!(climb(&start, &mut evaluations), target);
    }

    #[test]
    fn neighbours_differ_in_one_leg() {
        let layout = LegLayout::new([3, 2]).unwrap();
        let start = Morphology::parse("110 11", &layout).unwrap();
        let neighbours = single_leg_changes(&start);
        assert_eq!(neighbours.len(), 3 + 2);
        for neighbour in neighbours {
            let changed = (0..2)
                .filter(|&leg| neighbour.remaining(leg) != start.remaining(leg))
                .count();
            assert_eq!(changed, 1);
        }
    }
}
