//! How much of the processor learning may take.

use std::time::Duration;

/// Lets work begin so rarely that it takes a share of one processor on average. What it does first
/// is free.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProcessorBudget {
    share: f64,
    not_before: Duration,
}

impl ProcessorBudget {
    /// A budget of this share, above 0.
    pub(crate) fn new(share: f64) -> Self {
        Self {
            share,
            not_before: Duration::ZERO,
        }
    }

    /// Whether work may begin at `now`, which counts from any fixed time on.
    pub(crate) fn allows(&self, now: Duration) -> bool {
        now >= self.not_before
    }

    /// Work that ended at `now` kept a processor busy for so long, at most.
    pub(crate) fn spent(&mut self, now: Duration, busy: Duration) {
        let begun = now.saturating_sub(busy);
        // What cannot be told as a duration is never.
        let pays_s = (busy.as_secs_f64() / self.share).min(1e12);
        self.not_before = begun + Duration::from_secs_f64(pays_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_its_share_on_average() {
        let mut budget = ProcessorBudget::new(0.04);
        let (mut now, mut busy) = (Duration::ZERO, Duration::ZERO);
        let second = Duration::from_secs(1);
        let day = 86_400 * second;
        let mut rounds = 0;
        while now < day {
            if budget.allows(now) {
                let takes = (100 + 50 * (rounds % 3)) * second;
                now += takes;
                busy += takes;
                budget.spent(now, takes);
                rounds += 1;
            } else {
                now += second;
            }
        }
        let share = busy.as_secs_f64() / now.as_secs_f64();
        assert!((0.038..0.042).contains(&share), "{share}");
        // A control: the first begins at once.
        assert!(ProcessorBudget::new(0.04).allows(Duration::ZERO));
    }
}
