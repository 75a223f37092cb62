//! Tests of `diagnosis/src/diagnosis/noise/restricted_likelihood.rs`.

use bmv::diagnosis::noise::estimate::{EstimatedNoise, SensorRows};
use bmv::diagnosis::noise::restricted_likelihood::*;
use bmv::math::lanes::dot;
use bmv::random::StreamKey;
use nalgebra::{DMatrix, DVector};

/// Of the errors of a white fit the restricted likelihood under correlated noise, against the dense formula.
#[test]
fn it_is_the_restricted_likelihood() {
    let (rows, columns) = (40, 3);
    let times_s: Vec<f64> = (0..rows).map(|row| 60.0 * f64::from(row as u32)).collect();
    let mut stream = StreamKey::new(5, "taken", "test").stream(0);
    // 1, t and t^2.
    let x = DMatrix::from_fn(rows, columns, |row, column| (0..column).map(|_| row as f64 / 40.0).product());
    let y = DVector::from_fn(rows, |_, _| stream.normal());
    let fitted = (x.transpose() * &x).lu().solve(&(x.transpose() * &y)).expect("independent columns");
    let errors = &y - &x * fitted;
    let series = SensorRows { measurement: 0, sensor: 0, rows: (0..rows).collect(), times_s: times_s.clone() };
    let fit = LinearFit {
        columns: (0..columns).map(|column| x.column(column).iter().copied().collect()).collect(),
        errors: errors.iter().copied().collect(),
    };
    let mut sums = Vec::new();
    for noise in [
        EstimatedNoise::white(1.3),
        EstimatedNoise { sigma: 0.9, correlation_time_s: Some(400.0), white: Some(0.4) },
        EstimatedNoise { sigma: 1.1, correlation_time_s: Some(150.0), white: None },
    ] {
        let mut whitened = fit.errors.clone();
        let scales = noise.whiten(&times_s, &mut whitened);
        let restricted = scales - 0.5 * dot(&whitened, &whitened)
            + fit.correction(std::slice::from_ref(&series), std::slice::from_ref(&noise));
        let covariance = DMatrix::from_fn(rows, rows, |a, b| {
            let slow = noise
                .correlation_time_s
                .map_or(f64::from(u8::from(a == b)), |time| libm::exp(-(times_s[a] - times_s[b]).abs() / time));
            let white = noise.white.unwrap_or(0.0);
            noise.sigma * noise.sigma * slow + if a == b { white * white } else { 0.0 }
        });
        let inverse = covariance.clone().try_inverse().expect("positive");
        let information = x.transpose() * &inverse * &x;
        let fit = information.clone().lu().solve(&(x.transpose() * &inverse * &y)).expect("independent columns");
        let left = &y - &x * fit;
        let dense = -0.5 * libm::log(covariance.determinant())
            - 0.5 * libm::log(information.determinant())
            - 0.5 * (left.transpose() * &inverse * &left)[(0, 0)];
        sums.push(restricted - dense);
    }
    assert!(sums.iter().all(|sum| (sum - sums[0]).abs() < 1e-8), "{sums:?}");
}
