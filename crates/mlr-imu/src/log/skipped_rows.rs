//! Rows that cannot be read and are left out, as long as they are few.

use super::{LogLimits, LogProblem, Place};

/// Counts the rows of a log and what is wrong with those that cannot be read.
#[derive(Debug)]
pub(super) struct SkippedRows {
    limits: LogLimits,
    rows: u64,
    skipped: u64,
    /// How many of the last rows could not be read.
    run: u64,
    first: Option<LogProblem>,
}

impl SkippedRows {
    pub(super) fn new(limits: LogLimits) -> Self {
        Self {
            limits,
            rows: 0,
            skipped: 0,
            run: 0,
            first: None,
        }
    }

    /// Counts a row.
    ///
    /// # Errors
    /// [`LogProblem::TooManyRows`].
    pub(super) fn begin_row(&mut self, place: &Place) -> Result<(), LogProblem> {
        self.rows += 1;
        if self.rows > self.limits.max_rows {
            return Err(LogProblem::TooManyRows {
                place: place.clone(),
                max_rows: self.limits.max_rows,
            });
        }
        Ok(())
    }

    /// The row could be read.
    pub(super) fn keep(&mut self) {
        self.run = 0;
    }

    /// The row could not be read.
    ///
    /// # Errors
    /// The first such problem, when too many follow each other.
    pub(super) fn skip(&mut self, problem: LogProblem) -> Result<(), LogProblem> {
        self.skipped += 1;
        self.run += 1;
        if self.run > self.limits.max_unreadable_run {
            return Err(self.first.take().unwrap_or(problem));
        }
        self.first.get_or_insert(problem);
        Ok(())
    }

    /// The row is not counted: it is only the beginning of one.
    pub(super) fn forget_row(&mut self) {
        self.rows = self.rows.saturating_sub(1);
    }

    /// What to tell of the rows left out, if there were any.
    ///
    /// # Errors
    /// The first problem, when too many rows could not be read.
    pub(super) fn finish(self) -> Result<Option<String>, LogProblem> {
        let Some(first) = self.first else {
            return Ok(None);
        };
        let (skipped, rows) = (self.skipped, self.rows);
        if skipped as f64 > self.limits.max_unreadable_share * rows as f64 {
            return Err(first);
        }
        Ok(Some(format!(
            "{skipped} of {rows} rows cannot be read and are left out; the first: {first}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What comes of rows of which those on the given lines cannot be read.
    fn read(rows: u64, unreadable: &[u64]) -> Result<Option<String>, LogProblem> {
        let mut tally = SkippedRows::new(LogLimits::default());
        for line in 1..=rows {
            tally.begin_row(&Place::Line(line))?;
            if unreadable.contains(&line) {
                tally.skip(LogProblem::NotText { line })?;
            } else {
                tally.keep();
            }
        }
        tally.finish()
    }

    #[test]
    fn few_rows_are_left_out_and_counted() {
        assert_eq!(read(200, &[]).unwrap(), None);
        let note = read(200, &[70, 120]).unwrap().unwrap();
        assert!(note.starts_with("2 of 200 rows"), "{note}");
        assert!(note.contains("line 70"), "{note}");
    }

    #[test]
    fn too_many_rows_end_with_the_first_problem() {
        for (rows, unreadable) in [
            (99, vec![7]),
            (200, vec![7, 9, 11]),
            (10_000, (7..=12).collect()),
        ] {
            let problem = read(rows, &unreadable).unwrap_err();
            assert!(
                matches!(problem, LogProblem::NotText { line: 7 }),
                "{problem}"
            );
        }
        assert!(read(10_000, &[7, 8, 9, 10, 11, 13]).unwrap().is_some());
    }
}
