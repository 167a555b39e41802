use std::collections::VecDeque;

/// Maximum minus minimum of the samples of the last `window_s`, in amortised
/// constant time per sample.
pub(crate) struct SlidingRange {
    window_s: f64,
    /// Samples that may still become the maximum, values falling.
    falling: VecDeque<(f64, f64)>,
    /// Samples that may still become the minimum, values rising.
    rising: VecDeque<(f64, f64)>,
}

impl SlidingRange {
    pub(crate) fn new(window_s: f64) -> Self {
        Self {
            window_s,
            falling: VecDeque::new(),
            rising: VecDeque::new(),
        }
    }

    /// Adds a sample, later than all before, and returns the range.
    pub(crate) fn push(&mut self, time_s: f64, value: f64) -> f64 {
        while self.falling.back().is_some_and(|&(_, v)| v <= value) {
            self.falling.pop_back();
        }
        while self.rising.back().is_some_and(|&(_, v)| v >= value) {
            self.rising.pop_back();
        }
        for queue in [&mut self.falling, &mut self.rising] {
            queue.push_back((time_s, value));
            while queue
                .front()
                .is_some_and(|&(t, _)| t < time_s - self.window_s)
            {
                queue.pop_front();
            }
        }
        match (self.falling.front(), self.rising.front()) {
            (Some((_, maximum)), Some((_, minimum))) => maximum - minimum,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sliding_range_agrees_with_a_plain_scan(values in prop::collection::vec(-1.0..1.0_f64, 1..100)) {
            let mut range = SlidingRange::new(7.0);
            for (i, value) in values.iter().enumerate() {
                let window = &values[i.saturating_sub(7)..=i];
                let largest = window.iter().copied().fold(f64::MIN, f64::max);
                let smallest = window.iter().copied().fold(f64::MAX, f64::min);
                prop_assert_eq!(range.push(i as f64, *value), largest - smallest);
            }
        }
    }
}
