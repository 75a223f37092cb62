//! Looking again and again whether something has become so: while nothing else is done, or beside work that is then stopped.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use super::engine::StopFlag;

/// Waits until it is so.
pub fn wait_until(every: Duration, mut is_so: impl FnMut() -> bool) {
    while !is_so() {
        std::thread::sleep(every);
    }
}

/// Does the work, which is lent a flag that is raised as soon as it is so.
pub fn stopped_when<T>(every: Duration, is_so: impl Fn() -> bool + Sync, work: impl FnOnce(&StopFlag) -> T) -> T {
    let stop = StopFlag::default();
    std::thread::scope(|scope| {
        // Dropped when the work is done, also where that unwinds.
        let (done, is_done) = channel::<()>();
        let (flag, is_so) = (stop.clone(), &is_so);
        scope.spawn(move || {
            while is_done.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                if is_so() {
                    return flag.stop();
                }
            }
        });
        let worked = work(&stop);
        drop(done);
        worked
    })
}
