//! How far a chain has come: its state after some of its transitions, from which it goes on to the same draws, bit by bit.

/// Keeps states of a chain on its way, and says where it begins.
pub struct Parts<'k, S> {
    /// The state that the chain goes on from; from its start where there is none.
    pub from: Option<S>,
    /// Transitions after which its state may be kept, each time.
    pub every: u64,
    /// Whether it is to be kept then.
    pub is_due: &'k dyn Fn() -> bool,
    /// Takes a state with its number, counted from 1.
    pub keep: &'k mut dyn FnMut(u64, S),
}

impl<S> Parts<'_, S> {
    /// Runs a chain whole, without a state on its way.
    pub fn none<T>(run: impl FnOnce(&mut Parts<'_, S>) -> T) -> T {
        run(&mut Parts { from: None, every: u64::MAX, is_due: &|| false, keep: &mut |_, _| {} })
    }

    /// Keeps the state after so many transitions of all where it is time.
    pub(super) fn at(&mut self, done: u64, all: u64, state: impl FnOnce() -> S) {
        if done < all && done.is_multiple_of(self.every) && (self.is_due)() {
            (self.keep)(done / self.every, state());
        }
    }
}
