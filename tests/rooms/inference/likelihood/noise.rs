//! Tests of `core/src/inference/likelihood/noise.rs`.

use bmv::inference::likelihood::noise::*;
use bmv::math::cholesky;
use bmv::math::functions::exp;
use bmv::measurement::unknown::Value;

const TIMES: [f64; 6] = [0.0, 1.0, 1.5, 4.0, 9.0, 9.2];
const VALUES: [f64; 6] = [0.3, 0.5, 0.1, -0.7, 0.2, 0.4];

fn run(noise: &Noise, unknowns: &[f64]) -> (f64, Vec<f64>) {
    let n = unknowns.len();
    let mut values = VALUES;
    let mut jacobian = vec![0.0; 6 * n];
    // The differences themselves depend on the last unknown.
    for row in 0..6 {
        jacobian[row * n + n - 1] = 1.0 + row as f64;
        values[row] += (1.0 + row as f64) * unknowns[n - 1];
    }
    let (mut scales, mut gradient) = ([0.0; 6], vec![0.0; n]);
    let mut series = Series {
        times_s: &TIMES,
        values: &mut values,
        jacobian: &mut jacobian,
        log_scales: &mut scales,
        scale_gradient: &mut gradient,
    };
    noise.whiten(unknowns, &mut series).unwrap();
    let value = scales.iter().sum::<f64>() - 0.5 * values.iter().map(|e| e * e).sum::<f64>();
    for row in 0..6 {
        for column in 0..n {
            gradient[column] -= values[row] * jacobian[row * n + column];
        }
    }
    (value, gradient)
}

/// The same from the dense covariance of all readings.
fn dense(sigma: f64, tau: Option<f64>, white: f64, shift: f64) -> f64 {
    let mut covariance = vec![0.0; 36];
    for i in 0..6 {
        for j in 0..6 {
            let apart = (TIMES[i] - TIMES[j]).abs();
            let correlation = tau.map_or(if i == j { 1.0 } else { 0.0 }, |tau| exp(-apart / tau));
            covariance[i * 6 + j] = sigma * sigma * correlation + if i == j { white * white } else { 0.0 };
        }
    }
    cholesky::factor(&mut covariance, 6).unwrap();
    let mut d: Vec<f64> = (0..6).map(|row| VALUES[row] + (1.0 + row as f64) * shift).collect();
    cholesky::solve_lower(&covariance, &mut d);
    -0.5 * cholesky::log_determinant(&covariance, 6) - 0.5 * d.iter().map(|e| e * e).sum::<f64>()
}

#[test]
fn whitening_agrees_with_the_dense_covariance_and_its_derivatives_with_differences() {
    let u = Value::Unknown;
    let at = [0.4, 2.0, 0.3, 0.05];
    let cases = [
        (Noise { sigma: u(0), correlation_time_s: None, white: None }, dense(0.4, None, 0.0, 0.05)),
        (Noise { sigma: u(0), correlation_time_s: None, white: Some(u(2)) }, dense(0.4, None, 0.3, 0.05)),
        (Noise { sigma: u(0), correlation_time_s: Some(u(1)), white: None }, dense(0.4, Some(2.0), 0.0, 0.05)),
        (Noise { sigma: u(0), correlation_time_s: Some(u(1)), white: Some(u(2)) }, dense(0.4, Some(2.0), 0.3, 0.05)),
    ];
    for (noise, expected) in cases {
        let (value, gradient) = run(&noise, &at);
        assert!((value - expected).abs() < 1e-12, "{noise:?}: {value} {expected}");
        for place in 0..4 {
            let moved = |by: f64| {
                let mut point = at;
                point[place] += by;
                run(&noise, &point).0
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((difference - gradient[place]).abs() < 1e-7, "{noise:?} {place}: {difference} {gradient:?}");
        }
    }
}

#[test]
fn a_filter_whitens_to_the_bit_as_the_noise_that_made_it() {
    let u = Value::Unknown;
    let at = [0.4, 2.0, 0.3];
    for (tau, white) in [(None, None), (None, Some(u(2))), (Some(u(1)), None), (Some(u(1)), Some(u(2)))] {
        let noise = Noise { sigma: u(0), correlation_time_s: tau, white };
        let (mut expected, mut values) = (VALUES, VALUES);
        let mut series = Series {
            times_s: &TIMES,
            values: &mut expected,
            jacobian: &mut [],
            log_scales: &mut [0.0; 6],
            scale_gradient: &mut [],
        };
        noise.whiten(&at, &mut series).unwrap();
        noise.filter(&at, &TIMES).unwrap().apply(&mut values);
        assert_eq!(values, expected, "{noise:?}");
    }
    assert!(Noise { sigma: u(0), correlation_time_s: Some(u(1)), white: None }.filter(&[0.4, 0.0], &TIMES).is_err());
}

#[test]
fn noise_that_is_not_above_zero_is_refused() {
    let noise = Noise { sigma: Value::Known(0.0), correlation_time_s: None, white: None };
    let mut values = [1.0];
    let mut series = Series {
        times_s: &[0.0],
        values: &mut values,
        jacobian: &mut [],
        log_scales: &mut [0.0],
        scale_gradient: &mut [],
    };
    assert!(noise.whiten(&[], &mut series).is_err());
}
