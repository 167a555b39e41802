use std::collections::VecDeque;

/// How roll and pitch fluctuated lately: the largest fluctuation of each second.
#[derive(Debug, Clone, Default)]
pub(super) struct FluctuationCourse {
    latest_deg: Option<f64>,
    /// Largest of each whole second that was not taken out yet, the oldest first.
    whole_seconds_deg: VecDeque<f64>,
    /// The second that is not over, and its largest so far.
    current: Option<(f64, f64)>,
}

/// Seconds that are kept.
const KEPT: usize = 60;

impl FluctuationCourse {
    pub(super) fn push(&mut self, time_s: f64, fluctuation_deg: f64) {
        self.latest_deg = Some(fluctuation_deg);
        let second = time_s.floor();
        match &mut self.current {
            Some((current, largest_deg)) if *current == second => {
                *largest_deg = largest_deg.max(fluctuation_deg);
            }
            current => {
                if let Some((_, largest_deg)) = current.replace((second, fluctuation_deg)) {
                    if self.whole_seconds_deg.len() == KEPT {
                        self.whole_seconds_deg.pop_front();
                    }
                    self.whole_seconds_deg.push_back(largest_deg);
                }
            }
        }
    }

    /// What comes next does not follow on what was seen.
    pub(super) fn interrupt(&mut self) {
        self.latest_deg = None;
        self.current = None;
    }

    pub(super) fn latest_deg(&self) -> Option<f64> {
        self.latest_deg
    }

    /// To a thousandth of a degree.
    pub(super) fn take_whole_seconds_deg(&mut self) -> Vec<f64> {
        self.whole_seconds_deg.drain(..).map(rounded).collect()
    }
}

fn rounded(angle_deg: f64) -> f64 {
    (angle_deg * 1000.0).round() / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_second_is_told_once_and_whole() {
        let mut course = FluctuationCourse::default();
        for (time_s, fluctuation_deg) in [(0.5, 1.0), (0.7, 3.0), (0.9, 2.0), (1.1, 4.0)] {
            course.push(time_s, fluctuation_deg);
        }
        assert_eq!(course.latest_deg(), Some(4.0));
        assert_eq!(course.take_whole_seconds_deg(), [3.0]);
        course.push(1.9, 0.5);
        assert!(course.take_whole_seconds_deg().is_empty());
        course.push(2.0, 0.1);
        assert_eq!(course.take_whole_seconds_deg(), [4.0]);
        course.interrupt();
        assert_eq!(course.latest_deg(), None);
        course.push(9.0, 0.2);
        assert!(course.take_whole_seconds_deg().is_empty());
    }

    #[test]
    fn a_minute_is_kept() {
        let mut course = FluctuationCourse::default();
        for second in 0..200 {
            course.push(f64::from(second), f64::from(second));
        }
        let kept_deg = course.take_whole_seconds_deg();
        assert_eq!(
            (kept_deg.len(), kept_deg[0], kept_deg[59]),
            (KEPT, 139.0, 198.0)
        );
    }
}
