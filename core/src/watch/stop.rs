//! The request to stop, at which long loops look.
//!
//! A transient, a chain or a screening may take minutes; who asks a run to stop should not wait for it. What runs such
//! loops lends its threads a [`Flag`], and a loop calls [`check`] once a step. If the flag is raised, the whole block is
//! left by unwinding to who lent it. It is no error value on purpose: a solve that fails is data (a rejected proposal, a
//! phase without a prediction), and a stop that is taken for one would change a result. So a block ends whole or not at
//! all, and nothing that is kept depends on the flag.

use std::any::Any;
use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static LENT: RefCell<Option<Flag>> = const { RefCell::new(None) };
}

/// Asks to stop. Clones are the same flag.
#[derive(Clone, Debug, Default)]
pub struct Flag(Arc<AtomicBool>);

impl Flag {
    /// Asks.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked.
    pub fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// With what [`check`] unwinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

impl Stopped {
    /// Whether an unwinding was a stop.
    pub fn is(payload: &(dyn Any + Send)) -> bool {
        payload.is::<Self>()
    }
}

/// Lends this thread a flag at which its loops look from now on.
pub fn lend(flag: &Flag) {
    LENT.set(Some(flag.clone()));
}

/// Leaves the block under way if its thread was lent a flag that is raised: unwinds with [`Stopped`]. Costs a few
/// nanoseconds.
pub fn check() {
    let is_stopped = LENT.with_borrow(|lent| lent.as_ref().is_some_and(Flag::is_stopped));
    if is_stopped {
        // No message: this is no panic.
        resume_unwind(Box::new(Stopped));
    }
}
