//! Repair of time stamps that are duplicated or run backwards.

/// What was wrong with the time stamps of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimeStampFaults {
    /// Samples dropped because they repeat the time of another.
    pub duplicated: usize,
    /// Samples dropped because they are out of order.
    pub out_of_order: usize,
    /// Index of the first sample whose time is not later than the one before.
    pub first: Option<usize>,
}

impl TimeStampFaults {
    /// Samples dropped altogether.
    pub fn dropped(&self) -> usize {
        self.duplicated + self.out_of_order
    }
}

/// Indices of the longest subsequence of samples whose time stamps strictly increase, and
/// why the others are dropped.
///
/// Taking the longest such subsequence rather than every sample later than all before
/// means that one stamp far in the future costs one sample, not the rest of the
/// recording.
pub fn increasing_times(times_s: &[f64]) -> (Vec<usize>, TimeStampFaults) {
    let Some(first_fault) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) else {
        return ((0..times_s.len()).collect(), TimeStampFaults::default());
    };
    let kept = longest_increasing(times_s);
    let duplicated = count_duplicates(times_s, &kept);
    let faults = TimeStampFaults {
        duplicated,
        out_of_order: times_s.len() - kept.len() - duplicated,
        first: Some(first_fault + 1),
    };
    (kept, faults)
}

/// Indices of a longest strictly increasing subsequence (patience sorting).
fn longest_increasing(values: &[f64]) -> Vec<usize> {
    let mut tails: Vec<usize> = Vec::new();
    let mut predecessor: Vec<Option<usize>> = Vec::with_capacity(values.len());
    for (index, value) in values.iter().enumerate() {
        let pile = tails.partition_point(|&tail| values[tail] < *value);
        predecessor.push(pile.checked_sub(1).map(|below| tails[below]));
        if pile == tails.len() {
            tails.push(index);
        } else {
            tails[pile] = index;
        }
    }
    let mut kept = Vec::with_capacity(tails.len());
    let mut next = tails.last().copied();
    while let Some(index) = next {
        kept.push(index);
        next = predecessor[index];
    }
    kept.reverse();
    kept
}

/// Dropped samples whose exact time is among the kept ones.
fn count_duplicates(times_s: &[f64], kept: &[usize]) -> usize {
    let mut kept_indices = kept.iter().copied().peekable();
    (0..times_s.len())
        .filter(|index| {
            if kept_indices.next_if_eq(index).is_some() {
                return false;
            }
            kept.binary_search_by(|&k| times_s[k].total_cmp(&times_s[*index]))
                .is_ok()
        })
        .count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Axes, OrientationSeries};

    fn recording(times_s: Vec<f64>) -> OrientationSeries {
        let n = times_s.len();
        let count: Vec<f64> = (0..n).map(|i| i as f64).collect();
        OrientationSeries::new(times_s, Axes::from_fn(|_| count.clone())).unwrap()
    }

    fn cleaned(recording: &OrientationSeries) -> (OrientationSeries, TimeStampFaults) {
        let (kept, faults) = increasing_times(recording.times_s());
        (recording.picked(&kept), faults)
    }

    #[test]
    fn good_time_stamps_are_left_alone() {
        let series = recording(vec![0.0, 0.1, 0.2]);
        let (cleaned, faults) = cleaned(&series);
        assert_eq!(cleaned, series);
        assert_eq!(faults, TimeStampFaults::default());
    }

    #[test]
    fn duplicates_and_backward_steps_are_told_apart() {
        let (cleaned, faults) = cleaned(&recording(vec![0.0, 1.0, 2.0, 2.0, 0.5, 3.0]));
        assert_eq!(cleaned.times_s(), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!((faults.duplicated, faults.out_of_order), (1, 1));
        assert_eq!(faults.first, Some(3));
    }

    #[test]
    fn one_stamp_in_the_future_costs_one_sample() {
        let mut times_s: Vec<f64> = (0..100).map(f64::from).collect();
        times_s[50] = 1e6;
        let (cleaned, faults) = cleaned(&recording(times_s));
        assert_eq!(cleaned.len(), 99);
        assert_eq!(faults.out_of_order, 1);
    }

    proptest! {
        #[test]
        fn the_result_increases_and_nothing_is_counted_twice(
            times_s in prop::collection::vec((0..50_i32).prop_map(f64::from), 1..80),
        ) {
            let total = times_s.len();
            let (cleaned, faults) = cleaned(&recording(times_s));
            prop_assert!(cleaned.times_s().windows(2).all(|pair| pair[0] < pair[1]));
            prop_assert_eq!(cleaned.len() + faults.dropped(), total);
        }
    }
}
