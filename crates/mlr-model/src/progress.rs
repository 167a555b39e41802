//! How far a computation of this crate, or of one that builds on it, has come.

/// Learns how far a longer computation has come.
pub trait Progress: Sync {
    /// So many more steps than expected before.
    fn expect_more(&self, steps: usize);
    /// One more step is done.
    fn advance(&self);
}

/// Tells nobody.
impl Progress for () {
    fn expect_more(&self, _: usize) {}
    fn advance(&self) {}
}
