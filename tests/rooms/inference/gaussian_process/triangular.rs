//! Tests of `core/src/inference/gaussian_process/triangular.rs`.

use bmv::inference::gaussian_process::triangular::*;
use bmv::math::cholesky;

#[test]
fn factors_and_inverses_are_those_of_the_plain_ones() {
    for n in 1..=13 {
        let matrix = bmv::math::dense::square(n, |i, j| {
            let apart = i as f64 - j as f64;
            1.0 / (1.0 + apart * apart) + if i == j { 0.3 } else { 0.0 }
        });
        let (mut plain, mut own) = (matrix.clone(), matrix);
        cholesky::factor(&mut plain, n).expect("positive definite");
        factor(&mut own, n).expect("positive definite");
        let (expected, found) = (cholesky::inverse(&plain, n), inverse(&own, n));
        for i in 0..n {
            for j in 0..=i {
                assert!((own[i * n + j] - plain[i * n + j]).abs() < 1e-14, "{n} {i} {j}");
                assert!((found[i * n + j] - expected[i * n + j]).abs() < 1e-13, "{n} {i} {j}");
            }
        }
    }
    assert!(factor(&mut [1.0, 0.0, 2.0, 1.0], 2).is_err() && factor(&mut [f64::NAN], 1).is_err());
}
