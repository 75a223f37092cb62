//! Tests of `core/src/inference/gaussian_process/cross_validation.rs`.

use bmv::inference::gaussian_process::cross_validation::*;
use bmv::inference::gaussian_process::{Form, Training, Trend};
use bmv::random::StreamKey;

#[test]
fn without_hyperparameters_values_left_out_are_those_of_the_plain_mean() {
    let values = vec![1.0, 2.0, 4.0, 3.0, 5.0];
    let training = Training::new(0, vec![], values.clone(), vec![0.25; 5]).expect("values");
    let form = Form { kernel: None, trend: Trend::Constant, scatter: false };
    let key = StreamKey::new(1, "a", "b");
    let left_out = left_out(&training, &form, &[], &[], &key).expect("scores");
    // By hand: the mean of the other four, and its variance beside the noise.
    assert!((left_out[0].mean - 3.5).abs() < 1e-12 && (left_out[0].sd - (0.25f64 * 1.25).sqrt()).abs() < 1e-12);
    let (sum, error) = score(&[-1.0, -3.0]);
    // By hand: scatter of two values that differ by 2, times the root of 2.
    assert!((sum + 4.0).abs() < 1e-15 && (error - 2.0).abs() < 1e-12, "{sum} {error}");
}
