/// The last bytes of a line whose frames have a fixed length and begin with
/// known bytes.
///
/// States: *hunting*, while the bytes at the front cannot begin a frame and are
/// dropped one by one; *filling*, while they can and the frame is not complete;
/// *full*, when a whole frame's length is there and its check decides. A frame
/// that fails gives up its first byte only, so that a true frame which begins
/// inside a false one is found.
#[derive(Debug, Clone)]
pub(super) struct FrameBuffer<const LENGTH: usize> {
    bytes: [u8; LENGTH],
    filled: usize,
}

impl<const LENGTH: usize> Default for FrameBuffer<LENGTH> {
    fn default() -> Self {
        Self {
            bytes: [0; LENGTH],
            filled: 0,
        }
    }
}

impl<const LENGTH: usize> FrameBuffer<LENGTH> {
    /// Takes a byte. `can_begin` judges the first bytes of a possible frame (one
    /// or more); the whole frame is returned when it is complete.
    pub(super) fn push(
        &mut self,
        byte: u8,
        can_begin: impl Fn(&[u8]) -> bool,
    ) -> Option<[u8; LENGTH]> {
        self.bytes[self.filled] = byte;
        self.filled += 1;
        self.hunt(&can_begin);
        (self.filled == LENGTH).then_some(self.bytes)
    }

    /// The frame just returned was good: forgets it.
    pub(super) fn accept(&mut self) {
        self.filled = 0;
    }

    /// The frame just returned was bad: gives up its first byte.
    pub(super) fn reject(&mut self, can_begin: impl Fn(&[u8]) -> bool) {
        self.drop_first();
        self.hunt(&can_begin);
    }

    fn hunt(&mut self, can_begin: &impl Fn(&[u8]) -> bool) {
        while self.filled > 0 && !can_begin(&self.bytes[..self.filled]) {
            self.drop_first();
        }
    }

    fn drop_first(&mut self) {
        self.bytes.copy_within(1..self.filled, 0);
        self.filled -= 1;
    }
}
