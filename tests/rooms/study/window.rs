//! Tests of `src/study/window.rs`.

use bmv::math::functions::exp;
use bmv::random::StreamKey;
use bmv::study::window::*;

#[test]
fn a_straight_line_has_its_slope_and_no_error() {
    let times: Vec<f64> = (0..11).map(f64::from).collect();
    let readings: Vec<f64> = times.iter().map(|t| 290.0 + 0.25 * t).collect();
    let window = window(&times, &readings).expect("readings");
    assert_eq!((window.count, window.mean, window.slope), (11, 291.25, Some(0.25)));
    assert_eq!((window.mean_error, window.slope_error), (Some(0.0), Some(0.0)));
}

/// Residuals +1, -1, -1, +1 about a flat line at t = 0, 1, 2, 3: slope 0, SSE 4, s = sqrt(2), Sxx = 5;
/// neighbouring products -1 + 1 - 1 = -1, so no correction.
#[test]
fn alternating_noise_has_the_textbook_errors() {
    let window = window(&[0.0, 1.0, 2.0, 3.0], &[6.0, 4.0, 4.0, 6.0]).expect("readings");
    assert_eq!((window.mean, window.slope), (5.0, Some(0.0)));
    assert!((window.mean_error.expect("error") - (2.0_f64 / 4.0).sqrt()).abs() < 1e-15);
    assert!((window.slope_error.expect("error") - (2.0_f64 / 5.0).sqrt()).abs() < 1e-15);
}

/// About its parabola a curved approach has no scatter, however much about its line.
#[test]
fn what_bends_is_no_noise() {
    let times: Vec<f64> = (0..8).map(f64::from).collect();
    let readings: Vec<f64> = times.iter().map(|t| 290.0 + 3.0 * t - 0.2 * t * t).collect();
    let window = window(&times, &readings).expect("readings");
    assert!((window.slope.expect("a slope") - 1.6).abs() < 1e-12);
    assert!(window.slope_error.expect("an error") < 1e-12 && window.chance.expect("a chance") < 1e-6);
}

/// Noise of a first-order process, with the correlation from one reading to the next.
fn noise(seed: u64, count: usize, correlation: f64) -> Vec<f64> {
    let mut stream = StreamKey::new(seed, "window", "noise").stream(0);
    let mut value = stream.normal();
    (0..count)
        .map(|_| {
            let now = value;
            value = correlation * value + (1.0 - correlation * correlation).sqrt() * stream.normal();
            now
        })
        .collect()
}

/// In a thousand windows of pure noise the slope looks real at 1 % in about ten: no more than 2 % of them where the
/// noise is white, and no more than 8 % where neighbours agree by 0.5 and there are few readings.
#[test]
fn noise_is_seldom_a_drift() {
    for (count, correlation, most) in [(8, 0.0, 20), (30, 0.0, 20), (120, 0.0, 20), (30, 0.5, 80), (120, 0.5, 40)] {
        let times: Vec<f64> = (0..count).map(|i| 60.0 * i as f64).collect();
        let detected = (0..1000)
            .filter(|&seed| window(&times, &noise(seed, count, correlation)).is_some_and(|w| w.chance < Some(0.01)))
            .count();
        assert!(detected <= most, "{detected} of 1000 with {count} readings and a correlation of {correlation}");
    }
}

/// An approach to equilibrium by one scatter a time constant is seen, over windows of a third of it to three.
#[test]
fn an_approach_to_equilibrium_is_a_drift() {
    for lengths in [0.3, 1.0, 3.0] {
        let times: Vec<f64> = (0..60).map(f64::from).collect();
        let detected = (0..100)
            .filter(|&seed| {
                let scatter = noise(seed, 60, 0.0);
                let reading = |(t, e): (&f64, &f64)| 20.0 * exp(-t / 59.0 * lengths) + e;
                let readings: Vec<f64> = times.iter().zip(&scatter).map(reading).collect();
                window(&times, &readings).is_some_and(|w| w.chance < Some(0.01))
            })
            .count();
        assert!(detected >= 99, "{detected} of 100 over {lengths} time constants");
    }
}

#[test]
fn few_readings_say_less() {
    assert_eq!(window(&[], &[]), None);
    let one = window(&[5.0], &[2.0]).expect("a reading");
    assert_eq!((one.mean, one.slope, one.mean_error), (2.0, None, None));
    let two = window(&[0.0, 2.0], &[1.0, 2.0]).expect("readings");
    assert_eq!((two.slope, two.slope_error), (Some(0.5), None));
}
