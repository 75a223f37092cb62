//! Ctrl-C and the scheduler's request to end: the first asks a run to stop, the second ends the program at once. Ending at
//! any moment is safe, because objects of the cache appear whole or not at all.

use std::io::Write;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::engine::StopFlag;
use super::error::RunnerError;

/// After this time running blocks are given up.
const PATIENCE: Duration = Duration::from_secs(20);

/// Stops the run of `stop` at the first signal; ends the program with `status` at the second, or if blocks still run after
/// twenty seconds.
///
/// # Errors
/// [`RunnerError::Threads`] if the system refuses.
pub fn stop_on_interrupt(stop: &StopFlag, status: i32) -> Result<(), RunnerError> {
    let refused = |error: std::io::Error| RunnerError::Threads { threads: 1, reason: error.to_string() };
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
    let stop = stop.clone();
    let wait = move || {
        for _ in signals.forever() {
            if stop.is_stopped() {
                std::process::exit(status);
            }
            stop.stop();
            // A closed standard error must not matter now.
            let _ =
                writeln!(std::io::stderr(), "stopping: running blocks are finished and kept; once more to leave now");
            let _ = std::thread::Builder::new().spawn(move || {
                std::thread::sleep(PATIENCE);
                std::process::exit(status);
            });
        }
    };
    std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map(drop).map_err(refused)
}
