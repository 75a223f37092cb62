//! Tests of `core/src/watch/stop.rs`.

use bmv::watch::stop::*;
use std::panic::catch_unwind;

#[test]
fn a_loop_goes_on_until_the_flag_that_its_thread_was_lent_is_raised() {
    let flag = Flag::default();
    let steps = std::thread::spawn({
        let flag = flag.clone();
        move || {
            lend(&flag);
            let mut steps = 0;
            let left = catch_unwind(std::panic::AssertUnwindSafe(|| {
                loop {
                    check();
                    steps += 1;
                    if steps == 5 {
                        flag.stop();
                    }
                }
            }));
            (steps, left.is_err_and(|payload| Stopped::is(payload.as_ref())))
        }
    });
    assert_eq!(steps.join().unwrap(), (5, true));
    assert!(flag.is_stopped());
    // No other thread is concerned.
    check();
}
