//! Tests of `src/runner/polling.rs`.

use std::time::Duration;

use bmv::runner::engine::StopFlag;
use bmv::runner::polling::*;

#[test]
fn work_is_stopped_when_it_is_so_and_else_ends_by_itself() {
    let every = Duration::from_millis(1);
    assert!(!stopped_when(every, || false, StopFlag::is_stopped));
    stopped_when(every, || true, |stop| wait_until(every, || stop.is_stopped()));
}
