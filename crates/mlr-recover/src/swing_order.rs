//! Which legs swing together, and in which order.

/// Groups of legs (from 0) that swing one after the other, over and over.
pub type SwingOrder = Vec<Vec<usize>>;

/// Every order in which these legs can swing, in which at least `standing` legs stand at any time.
///
/// Orders that differ by where the cycle begins are the same: a wave of five legs has 4! = 24 orders.
pub fn swing_orders(legs: &[usize], standing: usize) -> Vec<SwingOrder> {
    let most = legs.len().saturating_sub(standing);
    let mut orders = Vec::new();
    for groups in partitions(legs, most) {
        let Some((first, rest)) = groups.split_first() else {
            continue;
        };
        for others in permutations(rest) {
            orders.push(
                std::iter::once(first.clone())
                    .chain(others)
                    .collect::<SwingOrder>(),
            );
        }
    }
    orders.retain(|order| order.len() > 1);
    orders
}

/// Every partition into groups of at most `most` legs.
fn partitions(legs: &[usize], most: usize) -> Vec<Vec<Vec<usize>>> {
    let Some((last, before)) = legs.split_last() else {
        return vec![Vec::new()];
    };
    let mut all = Vec::new();
    for groups in partitions(before, most) {
        for index in 0..groups.len() {
            if groups[index].len() < most {
                let mut joined = groups.clone();
                joined[index].push(*last);
                all.push(joined);
            }
        }
        if most > 0 {
            let mut alone = groups;
            alone.push(vec![*last]);
            all.push(alone);
        }
    }
    all
}

pub(crate) fn permutations<T: Clone>(of: &[T]) -> Vec<Vec<T>> {
    let Some((first, rest)) = of.split_first() else {
        return vec![Vec::new()];
    };
    let mut all = Vec::new();
    for others in permutations(rest) {
        for place in 0..=others.len() {
            let mut one = others.clone();
            one.insert(place, first.clone());
            all.push(one);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn all_cyclic_orders_are_there_once() {
        // Sum over k of Stirling's S(n, k) (k - 1)!, without the one group of all.
        for (legs, expected) in [(4, 25), (5, 149), (6, 1081)] {
            let legs: Vec<usize> = (0..legs).collect();
            let orders = swing_orders(&legs, 0);
            assert_eq!(orders.len(), expected);
            let different: BTreeSet<_> = orders.iter().collect();
            assert_eq!(different.len(), expected);
            for order in &orders {
                let mut swung = order.concat();
                swung.sort_unstable();
                assert_eq!(swung, legs);
            }
        }
    }

    #[test]
    fn enough_legs_stand_at_any_time() {
        let legs = [0, 1, 3, 4, 5];
        let orders = swing_orders(&legs, 3);
        assert!(!orders.is_empty());
        assert!(orders.iter().flatten().all(|group| group.len() <= 2));
        // A crawl is all that four legs have, and three have nothing.
        assert_eq!(swing_orders(&[0, 1, 4, 5], 3).len(), 6);
        assert!(swing_orders(&[0, 1, 4], 3).is_empty());
    }
}
