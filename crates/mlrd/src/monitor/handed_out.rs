//! Requests that are being worked on.

use std::collections::VecDeque;

/// The number of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RequestNumber(u64);

/// Requests that were handed out, and which of them turned out to be worthless: a sensor's
/// fault may be known only after a stretch that contains it was handed out.
#[derive(Debug, Default)]
pub(super) struct HandedOut {
    last: RequestNumber,
    /// The newest last.
    latest: VecDeque<Stretch>,
}

#[derive(Debug)]
struct Stretch {
    number: RequestNumber,
    end_s: f64,
    spoilt: bool,
}

/// Requests that are remembered. An identification takes longer to come about than to be
/// done; of explanations one is worked on and one waits.
const REMEMBERED: usize = 16;

impl HandedOut {
    /// Numbers a request for a stretch that ends at `end_s`.
    pub(super) fn next(&mut self, end_s: f64) -> RequestNumber {
        self.last.0 += 1;
        self.latest.push_back(Stretch {
            number: self.last,
            end_s,
            spoilt: false,
        });
        if self.latest.len() > REMEMBERED {
            self.latest.pop_front();
        }
        self.last
    }

    /// The samples from `since_s` on were faulty.
    pub(super) fn spoil_from(&mut self, since_s: f64) {
        for stretch in &mut self.latest {
            stretch.spoilt |= stretch.end_s >= since_s;
        }
    }

    /// Whether the sensor was in order throughout the stretch, as far as is known.
    pub(super) fn is_sound(&self, number: RequestNumber) -> bool {
        self.latest
            .iter()
            .any(|stretch| stretch.number == number && !stretch.spoilt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_that_end_before_a_fault_are_sound_and_later_ones_not() {
        let mut handed_out = HandedOut::default();
        let before = handed_out.next(10.0);
        let within = handed_out.next(12.0);
        handed_out.spoil_from(11.0);
        let after = handed_out.next(20.0);
        let sound = [before, within, after].map(|number| handed_out.is_sound(number));
        assert_eq!(sound, [true, false, true]);
    }

    #[test]
    fn what_is_not_remembered_is_not_relied_on() {
        let mut handed_out = HandedOut::default();
        let first = handed_out.next(0.0);
        for end_s in 0..REMEMBERED {
            assert!(handed_out.is_sound(first));
            handed_out.next(end_s as f64);
        }
        assert!(!handed_out.is_sound(first));
    }
}
