//! Tests of `core/src/inference/information/nested.rs`.

use bmv::inference::information::nested::*;
use bmv::math::functions::ln;
use bmv::random::StreamKey;

/// The definition, term by term.
fn plain(predictions: &[f64], readings: &[f64]) -> f64 {
    let terms: Vec<f64> = predictions
        .chunks_exact(readings.len())
        .map(|row| -row.iter().zip(readings).map(|(a, b)| 0.5 * (a - b) * (a - b)).sum::<f64>())
        .collect();
    bmv::math::sum::log_sum_exp(&terms) - ln(terms.len() as f64)
}

#[test]
fn cut_sums_are_the_whole_sums() {
    let mut stream = StreamKey::new(1, "nested", "test").stream(0);
    for readings in [1, 2, 3] {
        let predictions: Vec<f64> = (0..1024 * readings).map(|_| 60.0 * stream.uniform()).collect();
        let inner = Inner::new(&predictions, readings).expect("samples");
        let mut point = vec![0.0; readings];
        // Amid the samples, at their edge, and far from all.
        for place in [30.0, 3.0, -1.0, -20.0, 500.0] {
            let z: Vec<f64> = (0..readings).map(|reading| place + reading as f64).collect();
            let estimate = inner.log_mean(&z, &mut point);
            let (all, half) = (plain(&predictions, &z), predictions.len() / 2);
            assert!((estimate.whole - all).abs() < 1e-10 * all.abs().max(1.0), "{readings} {place}");
            if place > -10.0 && place < 100.0 {
                let halves = [plain(&predictions[..half], &z), plain(&predictions[half..], &z)];
                assert!(estimate.halves.iter().zip(halves).all(|(a, b)| (a - b).abs() < 1e-8), "{readings} {place}");
                assert!(estimate.rise() >= 0.0 && estimate.effective >= 1.0);
            }
        }
    }
}

#[test]
fn samples_without_a_prediction_count_but_weigh_nothing() {
    let inner = Inner::new(&[0.0, f64::NAN, 0.0, f64::NAN], 1).expect("samples");
    let estimate = inner.log_mean(&[0.0], &mut [0.0]);
    assert!((estimate.whole - ln(0.5)).abs() < 1e-15 && estimate.rise().abs() < 1e-15);
    assert!(Inner::new(&[1.0], 1).is_none() && Inner::new(&[], 0).is_none());
    let none = Inner::new(&[f64::NAN; 4], 1).expect("samples").log_mean(&[0.0], &mut [0.0]);
    assert_eq!(none.whole, f64::NEG_INFINITY);
}
