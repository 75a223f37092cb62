//! Tests of `core/src/watch/share.rs`.

use bmv::watch::share::*;

#[test]
fn a_loop_tells_the_block_that_it_runs_in() {
    let (outer, inner) = (Share::default(), Share::default());
    at(1, 2);
    with_share(&outer, || {
        at(1, 4);
        with_share(&inner, || at(3, 4));
        at(2, 4);
    });
    at(4, 4);
    assert_eq!([outer.done(), inner.done()], [0.5, 0.75]);
    outer.set(7, 0);
    assert_eq!(outer.done(), 0.0);
}
