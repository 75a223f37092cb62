//! How far a block has come: its loop tells, who shows the progress of a run looks.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

thread_local! {
    static SHARE: RefCell<Option<Share>> = const { RefCell::new(None) };
}

/// The share of a block's work that is done. Clones are the same one.
#[derive(Clone, Debug, Default)]
pub struct Share(Arc<AtomicU64>);

impl Share {
    /// From 0 to 1; 0 where the block does not tell.
    pub fn done(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Notes that so many of some equal steps are done.
    pub fn set(&self, done: u64, of: u64) {
        let share = if of == 0 { 0.0 } else { (done as f64 / of as f64).min(1.0) };
        self.0.store(share.to_bits(), Ordering::Relaxed);
    }
}

/// Runs a block whose loop tells its progress to this share.
pub fn with_share<T>(share: &Share, block: impl FnOnce() -> T) -> T {
    // A thread that waits within a block may run another meanwhile.
    let outer = SHARE.replace(Some(share.clone()));
    let restore = Restore(outer);
    let done = block();
    drop(restore);
    done
}

/// Puts the share of the block around back, also when a block is left by unwinding.
struct Restore(Option<Share>);

impl Drop for Restore {
    fn drop(&mut self) {
        SHARE.set(self.0.take());
    }
}

/// Tells that so many of a block's equal steps are done.
pub fn at(done: u64, of: u64) {
    SHARE.with_borrow(|share| {
        if let Some(share) = share {
            share.set(done, of);
        }
    });
}
