//! Lines that wait to be written, bounded in number and size.

use std::collections::VecDeque;

/// What a queue may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Entries that may be dropped.
    pub expendable: usize,
    /// Bytes of all lines together.
    pub bytes: usize,
}

/// How many were dropped for want of room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// Entries that may be dropped.
    pub expendable: u64,
    /// Lines.
    pub lines: u64,
}

/// What comes next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Entry<E> {
    /// An entry that could have been dropped, and what was dropped since the last one that
    /// got through.
    Expendable(E, Dropped),
    /// A line that was to be kept.
    Line(String),
}

/// A queue in order of arrival. When it is full, expendable entries are dropped first, the
/// oldest before the others; lines only when nothing expendable is left.
#[derive(Debug)]
pub struct OutputQueue<E> {
    limits: Limits,
    /// Both kinds, with the number of their arrival.
    expendable: VecDeque<(u64, E)>,
    lines: VecDeque<(u64, String)>,
    line_bytes: usize,
    arrived: u64,
    dropped: Dropped,
}

/// What an expendable entry counts for among the bytes: about what a `status` takes.
const EXPENDABLE_BYTES: usize = 512;

impl<E> OutputQueue<E> {
    /// An empty queue.
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            expendable: VecDeque::new(),
            lines: VecDeque::new(),
            line_bytes: 0,
            arrived: 0,
            dropped: Dropped::default(),
        }
    }

    /// Appends what may be dropped.
    pub fn push_expendable(&mut self, entry: E) {
        self.expendable.push_back((self.arrived, entry));
        self.arrived += 1;
        self.make_room();
    }

    /// Appends what is to be kept.
    pub fn push_line(&mut self, line: String) {
        self.line_bytes += line.len();
        self.lines.push_back((self.arrived, line));
        self.arrived += 1;
        self.make_room();
    }

    /// Takes out what arrived first.
    pub fn pop(&mut self) -> Option<Entry<E>> {
        let line_is_first = match (self.lines.front(), self.expendable.front()) {
            (Some((line, _)), Some((expendable, _))) => line < expendable,
            (line, _) => line.is_some(),
        };
        if line_is_first {
            return self.pop_line().map(Entry::Line);
        }
        let (_, entry) = self.expendable.pop_front()?;
        Some(Entry::Expendable(entry, std::mem::take(&mut self.dropped)))
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.expendable.is_empty() && self.lines.is_empty()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.expendable.clear();
        self.lines.clear();
        self.line_bytes = 0;
    }

    fn bytes(&self) -> usize {
        self.line_bytes + self.expendable.len() * EXPENDABLE_BYTES
    }

    fn pop_line(&mut self) -> Option<String> {
        let (_, line) = self.lines.pop_front()?;
        self.line_bytes -= line.len();
        Some(line)
    }

    fn make_room(&mut self) {
        while self.expendable.len() > self.limits.expendable
            || (self.bytes() > self.limits.bytes && !self.expendable.is_empty())
        {
            self.expendable.pop_front();
            self.dropped.expendable += 1;
        }
        while self.bytes() > self.limits.bytes && self.pop_line().is_some() {
            self.dropped.lines += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SMALL: Limits = Limits {
        expendable: 3,
        bytes: 3000,
    };

    #[test]
    fn the_order_of_arrival_is_kept() {
        let mut queue = OutputQueue::new(SMALL);
        queue.push_line("a".into());
        queue.push_expendable(1);
        queue.push_line("b".into());
        let taken: Vec<Entry<i32>> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(
            taken,
            [
                Entry::Line("a".into()),
                Entry::Expendable(1, Dropped::default()),
                Entry::Line("b".into()),
            ]
        );
    }

    #[test]
    fn the_oldest_expendable_entries_go_first_and_are_counted_once() {
        let mut queue = OutputQueue::new(SMALL);
        queue.push_line("kept".into());
        for number in 0..5 {
            queue.push_expendable(number);
        }
        assert_eq!(queue.pop(), Some(Entry::Line("kept".into())));
        let dropped = Dropped {
            expendable: 2,
            lines: 0,
        };
        assert_eq!(queue.pop(), Some(Entry::Expendable(2, dropped)));
        assert_eq!(queue.pop(), Some(Entry::Expendable(3, Dropped::default())));
    }

    #[test]
    fn lines_are_dropped_only_beyond_their_bytes() {
        let mut queue = OutputQueue::new(SMALL);
        queue.push_expendable(());
        for _ in 0..4 {
            queue.push_line("x".repeat(1000));
        }
        queue.push_expendable(());
        let lines = std::iter::from_fn(|| queue.pop())
            .filter(|entry| matches!(entry, Entry::Line(_)))
            .count();
        assert_eq!(lines, 3);
        queue.push_expendable(());
        let dropped = Dropped {
            expendable: 2,
            lines: 1,
        };
        assert_eq!(queue.pop(), Some(Entry::Expendable((), dropped)));
    }

    #[derive(Debug, Clone)]
    enum Step {
        PushExpendable,
        PushLine(usize),
        Pop,
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            Just(Step::PushExpendable),
            (1..1500_usize).prop_map(Step::PushLine),
            Just(Step::Pop),
        ]
    }

    proptest! {
        /// Whatever is pushed is popped in order or counted as dropped, and no line is
        /// dropped beside an expendable entry.
        #[test]
        fn nothing_is_lost_uncounted(steps in prop::collection::vec(step(), 0..200)) {
            let mut queue = OutputQueue::new(SMALL);
            let (mut pushed, mut popped) = (Dropped::default(), Dropped::default());
            let mut told = Dropped::default();
            let mut last = None;
            let mut number = 0_u64;
            let mut take = |entry: Option<Entry<u64>>| {
                let arrived = match entry {
                    None => return Ok(()),
                    Some(Entry::Expendable(arrived, dropped)) => {
                        popped.expendable += 1;
                        told.expendable += dropped.expendable;
                        told.lines += dropped.lines;
                        arrived
                    }
                    Some(Entry::Line(line)) => {
                        popped.lines += 1;
                        line.trim_start().parse().unwrap()
                    }
                };
                prop_assert!(last.is_none_or(|last| last < arrived));
                last = Some(arrived);
                Ok(())
            };
            for step in steps {
                match step {
                    Step::PushExpendable => {
                        queue.push_expendable(number);
                        pushed.expendable += 1;
                    }
                    Step::PushLine(width) => {
                        let lines_dropped = queue.dropped.lines;
                        queue.push_line(format!("{number:>width$}"));
                        pushed.lines += 1;
                        let dropped = queue.dropped.lines > lines_dropped;
                        prop_assert!(!dropped || queue.expendable.is_empty());
                    }
                    Step::Pop => take(queue.pop())?,
                }
                number += 1;
                prop_assert!(queue.expendable.len() <= SMALL.expendable);
                prop_assert!(queue.bytes() <= SMALL.bytes);
            }
            while let Some(entry) = queue.pop() {
                take(Some(entry))?;
            }
            queue.push_expendable(number);
            pushed.expendable += 1;
            take(queue.pop())?;
            prop_assert_eq!(pushed.expendable, popped.expendable + told.expendable);
            prop_assert_eq!(pushed.lines, popped.lines + told.lines);
        }
    }
}
