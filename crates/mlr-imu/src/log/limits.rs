/// What is read of a log at most, so that no file takes more memory than the machine has.
///
/// The defaults hold a quarter of an hour at 1 kHz with every column that is known, and rows
/// with many more columns than that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogLimits {
    /// Rows, those that cannot be read included.
    pub max_rows: u64,
    /// Bytes of text, after decompression.
    pub max_bytes: u64,
    /// Bytes of one line.
    pub max_line_bytes: usize,
    /// Columns of the header.
    pub max_columns: usize,
    /// Share of the rows that may be left out because they cannot be read: a log of fewer than
    /// a hundred rows must be whole.
    pub max_unreadable_share: f64,
    /// How many rows one after the other may be left out.
    pub max_unreadable_run: u64,
}

impl Default for LogLimits {
    fn default() -> Self {
        Self {
            max_rows: 1_000_000,
            max_bytes: 512_000_000,
            max_line_bytes: 1_000_000,
            max_columns: 1000,
            max_unreadable_share: 0.01,
            max_unreadable_run: 5,
        }
    }
}
