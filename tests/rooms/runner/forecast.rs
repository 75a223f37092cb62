//! Tests of `src/runner/forecast.rs`.

use bmv::runner::forecast::*;

/// A block of a recorded run: when it began and ended after the stage did, s, and whether it reported its share,
/// which then grows evenly.
type Recorded = (f64, f64, bool);

/// What was seen of a recorded stage at an instant.
fn seen(blocks: &[Recorded], threads: usize, is_last: bool, at_s: f64) -> Seen {
    let running = blocks.iter().filter(|(begin, end, _)| *begin <= at_s && at_s < *end);
    Seen {
        ended_s: blocks.iter().filter(|(_, end, _)| *end <= at_s).map(|(begin, end, _)| end - begin).collect(),
        running: running
            .map(|&(begin, end, tells)| RunningBlock {
                elapsed_s: at_s - begin,
                share: if tells { (at_s - begin) / (end - begin) } else { 0.0 },
            })
            .collect(),
        waiting: blocks.iter().filter(|(begin, ..)| *begin > at_s).count(),
        threads,
        is_last,
    }
}

/// Four chains and the evidence of the two-heater board's calibration on two threads, as recorded; and the same blocks
/// side by side, as eight threads run them.
const ON_TWO: [Recorded; 5] =
    [(0.0, 319.3, true), (0.0, 289.9, true), (289.9, 671.5, true), (319.3, 662.7, true), (662.7, 666.8, true)];
const ON_EIGHT: [Recorded; 5] =
    [(0.0, 319.3, true), (0.0, 289.9, true), (0.0, 381.6, true), (0.0, 343.4, true), (0.0, 4.1, true)];

#[test]
fn a_short_block_among_long_ones_says_nothing_of_them() {
    // A rate would say: one of five blocks in 4.1 s, so 16 s left. 377 s were.
    assert_eq!(left(&seen(&ON_EIGHT, 8, false, 4.2)), Left::Unknown);
    let mute: Vec<Recorded> = ON_EIGHT.iter().map(|&(begin, end, _)| (begin, end, false)).collect();
    for at_s in [4.2, 100.0, 300.0, 350.0] {
        assert_eq!(left(&seen(&mute, 8, true, at_s)), Left::Unknown, "at {at_s} s");
    }
}

#[test]
fn blocks_that_tell_their_share_are_carried_on_and_stages_to_come_are_not_promised() {
    for at_s in [30.0, 60.0, 120.0, 350.0, 370.0, 600.0] {
        if at_s < 381.6 {
            let Left::AtLeast(left_s) = left(&seen(&ON_EIGHT, 8, false, at_s)) else { panic!("at {at_s} s") };
            assert!((left_s - (381.6 - at_s)).abs() < 1e-6, "at {at_s} s: {left_s} s");
        }
        // Of those that wait nothing is known: they add nothing, so that it stays a bound.
        let Left::AtLeast(left_s) = left(&seen(&ON_TWO, 2, true, at_s)) else { panic!("at {at_s} s") };
        let share = left_s / (671.5 - at_s);
        assert!((0.3..1.0 + 1e-9).contains(&share), "at {at_s} s: {left_s} s");
    }
    let last = left(&seen(&ON_EIGHT, 8, true, 300.0));
    assert!(matches!(last, Left::About(left_s) if (left_s - 81.6).abs() < 1e-6), "{last:?}");
    assert_eq!(last.text().as_deref(), Some("about 82 s left"));
    assert_eq!(Left::AtLeast(90.0).text().as_deref(), Some("at least 90 s left"));
    assert_eq!([Left::AtLeast(0.0).text(), Left::About(0.3).text()], [None, None]);
}

#[test]
fn many_like_blocks_that_tell_nothing_are_counted_once_enough_have_ended() {
    // 100 blocks of 2 s on 4 threads.
    let blocks: Vec<Recorded> = (0..100).map(|i| (f64::from(i / 4) * 2.0, f64::from(i / 4 + 1) * 2.0, false)).collect();
    assert_eq!(left(&seen(&blocks, 4, true, 3.0)), Left::Unknown, "one round");
    for at_s in [5.0, 21.0, 43.0] {
        let Left::About(left_s) = left(&seen(&blocks, 4, true, at_s)) else { panic!("at {at_s} s") };
        assert!((left_s - (50.0 - at_s)).abs() < 1e-9, "at {at_s} s: {left_s} s");
    }
}

#[test]
fn one_block_alone_is_known_by_its_share_only() {
    assert_eq!(left(&seen(&[(0.0, 50.0, false)], 2, true, 20.0)), Left::Unknown);
    let time_left = left(&seen(&[(0.0, 50.0, true)], 2, true, 20.0));
    assert!(matches!(time_left, Left::About(left_s) if (left_s - 30.0).abs() < 1e-9), "{time_left:?}");
    assert_eq!(left(&seen(&[(0.0, 50.0, true)], 2, true, 1.0)), Left::Unknown, "too early");
    assert_eq!(left(&Seen { threads: 2, is_last: true, ..Seen::default() }), Left::Unknown, "not begun");
}
