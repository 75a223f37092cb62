//! Tests of `core/src/measurement/lag.rs`.

use bmv::math::functions::exp;
use bmv::measurement::lag::apply;

fn reading(times_s: &[f64], truth: &[f64], lag_s: f64) -> Vec<f64> {
    let mut readings = truth.to_vec();
    apply(times_s, &mut readings, lag_s, None);
    readings
}

#[test]
fn a_lagging_sensor_follows_a_ramp_one_time_constant_behind() {
    let times: Vec<f64> = (0..200).map(f64::from).collect();
    let truth: Vec<f64> = times.iter().map(|t| 0.5 * t).collect();
    let read = reading(&times, &truth, 14.0);
    // s(t) = a (t - tau) + a tau exp(-t / tau), the closed form.
    for (t, s) in times.iter().zip(&read) {
        let expected = 0.5 * (t - 14.0) + 0.5 * 14.0 * exp(-t / 14.0);
        assert!((s - expected).abs() < 1e-10, "{t}: {s} {expected}");
    }
}

#[test]
fn no_lag_reads_the_truth() {
    assert_eq!(reading(&[0.0, 1.0], &[3.0, 4.0], 0.0), [3.0, 4.0]);
}

#[test]
fn the_derivative_is_that_of_the_readings() {
    let times = [0.0, 1.0, 3.5, 4.0, 9.0];
    let truth = [300.0, 303.0, 299.0, 299.5, 310.0];
    let mut values = truth;
    let mut slope = [0.0; 5];
    apply(&times, &mut values, 3.0, Some(&mut slope));
    let (high, low) = (reading(&times, &truth, 3.0 + 1e-5), reading(&times, &truth, 3.0 - 1e-5));
    for row in 0..5 {
        let difference = (high[row] - low[row]) / 2e-5;
        assert!((difference - slope[row]).abs() < 1e-7, "{row}: {difference} {}", slope[row]);
    }
}
