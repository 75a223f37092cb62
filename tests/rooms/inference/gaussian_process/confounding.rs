//! Tests of `core/src/inference/gaussian_process/confounding.rs`.

use bmv::inference::gaussian_process::confounding::*;
use nalgebra::DMatrix;

#[test]
fn a_free_constant_takes_a_constant_parameter_with_it_and_leaves_a_slope_alone() {
    // Readings a + b x at x = -2..2 with noise 1 and wide priors (sd 10); the discrepancy is a constant of variance 4.
    let xs = [-2.0, -1.0, 0.0, 1.0, 2.0];
    let slopes: Vec<Vec<f64>> = xs.iter().map(|x| vec![1.0, *x]).collect();
    let covariance = bmv::math::dense::square(5, |i, j| 4.0 + if i == j { 1.0 } else { 0.0 });
    let precision = DMatrix::from_row_slice(5, 5, &covariance).try_inverse().expect("regular");
    let residuals = [1.0; 5];
    let information = Information::new(precision.as_slice(), &[1.0; 5], &slopes, &residuals);
    let posterior = [1.0 / (5.0 + 0.01), 0.0, 0.0, 1.0 / (10.0 + 0.01)];
    let moved = moved(&posterior, 2, &[information]).expect("regular");
    // By hand: the mean of the readings has the variance 1 / 5 + 4, the slope keeps its own.
    assert!((moved[0].free_sd - (1.0f64 / (1.0 / 4.2 + 0.01)).sqrt()).abs() < 1e-9, "{moved:?}");
    assert!((moved[0].absorbed - (1.0 - 1.0 / 4.2 / 5.0)).abs() < 1e-12);
    assert!(
        (moved[1].free_sd / moved[1].sd - 1.0).abs() < 1e-9
            && moved[1].shift.abs() < 1e-12
            && moved[1].absorbed < 1e-12
    );
    // The residuals of 1 pull with 1 / 4.2 in place of 5.
    assert!((moved[0].shift - (1.0 / 4.2 - 5.0) / (1.0 / 4.2 + 0.01)).abs() < 1e-9);
}
