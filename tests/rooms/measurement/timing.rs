//! Tests of `core/src/measurement/timing.rs`.

use bmv::measurement::timing::{Timing, TimingSlopes};

const TIMES_S: [f64; 5] = [0.0, 1.0, 3.5, 4.0, 9.0];
const TRUTH: [f64; 5] = [300.0, 303.0, 299.0, 299.5, 310.0];

fn read(lag_s: f64, behind_s: f64) -> Vec<f64> {
    Timing { lag_s, behind_s }.reading(&TIMES_S, &TRUTH)
}

#[test]
fn a_clock_that_is_behind_shows_what_happens_later() {
    // By hand: at 0.5, 1.5, 4 and 4.5 s, and as at the end beyond it.
    assert_eq!(read(0.0, 0.5), [301.5, 302.2, 299.5, 300.55, 310.0]);
    assert_eq!(read(0.0, -1.0), [300.0, 300.0, 300.6, 299.8, 307.9]);
    assert_eq!(read(0.0, 20.0), [310.0; 5]);
    assert_eq!(read(0.0, -20.0), [300.0; 5]);
    assert_eq!(read(0.0, 0.0), TRUTH);
}

#[test]
fn a_lagged_reading_is_shifted_as_the_truth_is() {
    let lagged = read(3.0, 0.0);
    assert_ne!(lagged, TRUTH);
    assert_eq!(read(3.0, -1.5), Timing { lag_s: 0.0, behind_s: -1.5 }.reading(&TIMES_S, &lagged));
}

#[test]
fn derivatives_are_those_of_the_readings() {
    const STEP_S: f64 = 1e-5;
    // The last meets rows, where the derivative is the mean of those to both sides, as a central difference is.
    for (lag_s, behind_s) in [(0.0, 0.3), (3.0, 0.3), (3.0, -1.7), (2.0, 4.9), (0.0, 0.0), (3.0, 0.0), (0.0, -0.5)] {
        let mut slopes = TimingSlopes::default();
        let mut values = TRUTH;
        Timing { lag_s, behind_s }.apply(&TIMES_S, &mut values, Some(&mut slopes));
        assert_eq!(values.to_vec(), read(lag_s, behind_s));
        let (high, low) = (read(lag_s, behind_s + STEP_S), read(lag_s, behind_s - STEP_S));
        for row in 0..TIMES_S.len() {
            let difference = (high[row] - low[row]) / (2.0 * STEP_S);
            let slope = slopes.by_behind[row];
            assert!((difference - slope).abs() < 1e-6, "{lag_s}, {behind_s}, {row}: {difference} {slope}");
        }
        if lag_s > 0.0 {
            let (high, low) = (read(lag_s + STEP_S, behind_s), read(lag_s - STEP_S, behind_s));
            for row in 0..TIMES_S.len() {
                let difference = (high[row] - low[row]) / (2.0 * STEP_S);
                let slope = slopes.by_lag[row];
                assert!((difference - slope).abs() < 1e-6, "{lag_s}, {behind_s}, {row}: {difference} {slope}");
            }
        }
    }
}
