//! Ctrl-C and the scheduler's request to end. While jobs run the first one asks the run to stop and the second ends the
//! program at once; at any other time the first one does. Ending at any moment is safe, because objects of the cache
//! appear whole or not at all.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::engine::StopFlag;
use super::error::RunnerError;

/// After this time blocks that do not look at the flag are given up.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a signal does.
#[derive(Clone, Debug)]
pub struct Interrupts {
    stop: StopFlag,
    is_running: Arc<AtomicBool>,
    /// Whether what runs counts the signals itself, and how many there were.
    is_counted: Arc<AtomicBool>,
    count: Arc<AtomicUsize>,
}

/// Signals that end the program although what runs counts them.
const TOO_MANY: usize = 3;

impl Interrupts {
    /// Catches signals from now on: each ends the program with `status`, unless a run is under way.
    ///
    /// # Errors
    /// [`RunnerError::Threads`] if the system refuses.
    pub fn catch(status: i32) -> Result<Self, RunnerError> {
        let refused = |error: std::io::Error| RunnerError::Threads { threads: 1, reason: error.to_string() };
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
        let interrupt = Self {
            stop: StopFlag::default(),
            is_running: Arc::default(),
            is_counted: Arc::default(),
            count: Arc::default(),
        };
        let Self { stop, is_running, is_counted, count } = interrupt.clone();
        let wait = move || {
            for _ in signals.forever() {
                if is_counted.load(Ordering::SeqCst) && count.fetch_add(1, Ordering::SeqCst) + 1 < TOO_MANY {
                    continue;
                }
                if stop.is_stopped() || !is_running.load(Ordering::SeqCst) {
                    std::process::exit(status);
                }
                stop.stop();
                // A closed standard error must not matter now.
                let _ = writeln!(std::io::stderr(), "stopping; what is finished is kept; once more to leave at once");
                let _ = std::thread::Builder::new().spawn(move || {
                    std::thread::sleep(PATIENCE);
                    std::process::exit(status);
                });
            }
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map_err(refused)?;
        Ok(interrupt)
    }

    /// Runs what looks at the flag: meanwhile a signal raises it.
    pub fn during<T>(&self, run: impl FnOnce(&StopFlag) -> T) -> T {
        self.is_running.store(true, Ordering::SeqCst);
        let done = run(&self.stop);
        self.is_running.store(false, Ordering::SeqCst);
        done
    }

    /// Runs what decides by itself about a first and a second signal: it looks at their number now and then. A third one
    /// ends the program.
    pub fn counted<T>(&self, run: impl FnOnce(&AtomicUsize) -> T) -> T {
        self.is_counted.store(true, Ordering::SeqCst);
        let done = run(&self.count);
        self.is_counted.store(false, Ordering::SeqCst);
        done
    }

    /// Whether a run was asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_stopped()
    }
}
