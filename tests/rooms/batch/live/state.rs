//! Tests of `src/batch/live/state.rs`.

use bmv::batch::live::state::uncoloured;

#[test]
fn colours_are_taken_off() {
    assert_eq!(uncoloured("\u{1b}[1;31merror\u{1b}[0m: a [m"), "error: a [m");
    assert_eq!(uncoloured("plain"), "plain");
}
