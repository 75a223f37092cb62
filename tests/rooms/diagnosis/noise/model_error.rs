//! Tests of `diagnosis/src/diagnosis/noise/model_error.rs`.

use bmv::diagnosis::noise::model_error::*;
use bmv::random::StreamKey;

fn draws(count: usize, seed: u64) -> Vec<f64> {
    let mut stream = StreamKey::new(seed, "model error", "test").stream(0);
    (0..count).map(|_| stream.normal()).collect()
}

/// An autoregressive series of standard deviation 1.
fn slow(count: usize, phi: f64, seed: u64) -> Vec<f64> {
    let mut state = 0.0;
    let next = |draw: f64| {
        state = phi * state + (1.0 - phi * phi).sqrt() * draw;
        state
    };
    draws(count, seed).into_iter().map(next).collect()
}

#[test]
fn the_size_beside_known_noise_is_found() {
    let count = 2000;
    // 0.3 K of noise and 0.4 K of model error are 0.5 K together.
    let errors: Vec<f64> = draws(count, 1).iter().map(|draw| 0.5 * draw).collect();
    let measurement_errors = Errors { errors, noise: vec![0.3; count], readings_of_one: 1.0 };
    let alone = |errors: &Errors| most_likely(std::slice::from_ref(errors), 1.0);
    let (sd, value) = alone(&measurement_errors);
    // 0.5 K is known to 0.5 / sqrt(4000) = 0.008 K, the size to 0.008 * 0.5 / 0.4; 3.5 of them, and half a step of 8 %.
    assert!((sd - 0.4).abs() < 0.035 + 0.017, "{sd}");
    let at = |sd: f64| measurement_errors.of_readings(sd).iter().sum::<f64>();
    assert!((value - at(sd)).abs() < 1e-9 * value.abs(), "the sum over the readings");
    assert!(value > at(0.0) && value > at(0.9 * sd) && value > at(1.1 * sd));
    let white =
        Errors { errors: draws(count, 2).iter().map(|draw| 0.3 * draw).collect(), ..measurement_errors.clone() };
    assert!(alone(&white).0 < 0.1, "noise alone leaves no model error");
    let few = Errors { readings_of_one: 10.0, ..measurement_errors };
    assert!((alone(&few).1 - value / 10.0).abs() < 1e-9, "dependent readings tell less of the same");
}

/// A run that moves little has small errors; one size beside both lies between, and half of the readings count half.
#[test]
fn runs_of_one_model_have_one_size() {
    let run = |size: f64, seed: u64, readings_of_one: f64| Errors {
        errors: draws(4000, seed).iter().map(|draw| size * draw).collect(),
        noise: vec![0.01; 4000],
        readings_of_one,
    };
    // The mean square of 0.2 and 1 is 0.52.
    let (sd, value) = most_likely(&[run(0.2, 11, 1.0), run(1.0, 12, 1.0)], 1.0);
    assert!((sd - 0.52_f64.sqrt()).abs() < 0.05, "{sd}");
    let apart: f64 = [run(0.2, 11, 1.0), run(1.0, 12, 1.0)].map(|one| most_likely(&[one], 1.0).1).iter().sum();
    assert!(value < apart, "sizes of their own fit better");
    // Of the second one reading in four counts: (0.04 + 0.25) / 1.25 is 0.232.
    let (sd, _) = most_likely(&[run(0.2, 11, 1.0), run(1.0, 12, 4.0)], 1.0);
    assert!((sd - 0.232_f64.sqrt()).abs() < 0.05, "{sd}");
}

#[test]
fn slow_errors_and_those_that_come_again_are_worth_few_readings() {
    let white = readings_of_one(&[draws(2000, 3), draws(2000, 4)]);
    assert!(white < 1.6, "{white}");
    // (1 + phi) / (1 - phi) = 19; its relative error is sqrt(2 (2 * 95 + 1) / 8000) = 0.22 (Sokal 1997, window of 5 times 19).
    let dependence = readings_of_one(&[slow(4000, 0.9, 5), slow(4000, 0.9, 6)]);
    assert!((13.0..30.0).contains(&dependence), "{dependence}");
    // Twenty orbits with the same pattern sum up to 0 over each.
    let orbit = slow(100, 0.5, 7);
    let again: Vec<f64> = (0..2000).map(|k| orbit[k % 100]).collect();
    assert!(readings_of_one(&[again]) > 15.0);
    assert_eq!(readings_of_one(&[vec![0.0; 50]]), 1.0, "no errors");
    assert_eq!(readings_of_one(&[]), 1.0, "no readings");
    assert!(readings_of_one(&[vec![1.0; 600]]) <= 20.0, "a record is worth 30 readings at least");
}

#[test]
fn quiet_stretches_show_the_noise_beneath_slow_errors() {
    let noise = draws(3000, 8);
    let mixed: Vec<f64> =
        slow(3000, 0.999, 9).iter().zip(&noise).map(|(slow, noise)| 5.0 * slow + 0.1 * noise).collect();
    // The slow part adds 5 sqrt(1 - 0.999^2) = 0.22 K a step, as much as 0.16 K of noise.
    let scatter = quiet_scatter(&mixed);
    assert!((0.15..0.22).contains(&scatter), "{scatter}");
    let mut jumps: Vec<f64> = noise.iter().map(|noise| 0.1 * noise).collect();
    (0..3000).step_by(50).for_each(|row| jumps[row] += 40.0);
    assert!((quiet_scatter(&jumps) - 0.1).abs() < 0.01, "spikes in 2 % of the rows");
    assert_eq!(quiet_scatter(&[1.0]), 0.0);
}
