//! Tests of `diagnosis/src/diagnosis/verdict/everywhere.rs`.

use bmv::diagnosis::verdict::everywhere::Everywhere;
use bmv::random::StreamKey;

const ROWS: usize = 60;

/// Forty directions of length 1, and noise of standard deviation 1.
fn drawn(seed: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut stream = StreamKey::new(seed, "everywhere", "test").stream(0);
    let mut direction = || {
        let column: Vec<f64> = (0..ROWS).map(|_| stream.normal()).collect();
        let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
        column.into_iter().map(|value| value / length).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = (0..40).map(|_| direction()).collect();
    let mut noise = StreamKey::new(seed, "everywhere", "noise").stream(0);
    (columns, (0..ROWS).map(|_| noise.normal()).collect())
}

/// The fit of one direction to residuals.
fn fitted(column: &[f64], y: &[f64]) -> Vec<f64> {
    let amplitude: f64 = column.iter().zip(y).map(|(a, b)| a * b).sum();
    column.iter().map(|value| amplitude * value).collect()
}

#[test]
fn one_large_effect_is_told_from_small_ones_everywhere() {
    for seed in 0..10 {
        let (columns, noise) = drawn(seed);
        let mut amplitudes = StreamKey::new(seed, "everywhere", "amplitudes").stream(0);
        let everywhere = Everywhere::new(columns.clone());
        let one: Vec<f64> = noise.iter().zip(&columns[3]).map(|(noise, value)| noise + 30.0 * value).collect();
        let large = everywhere.log_bayes_factor(&one, &fitted(&columns[3], &one));
        // The random sum of the same square costs the volume of forty directions.
        assert!(large > 20.0, "{large}");
        let mut sum = noise.clone();
        for column in &columns {
            let amplitude = 30.0 / 40.0_f64.sqrt() * amplitudes.normal();
            sum.iter_mut().zip(column).for_each(|(sum, value)| *sum += amplitude * value);
        }
        // The best of forty.
        let ratios = columns.iter().map(|column| everywhere.log_bayes_factor(&sum, &fitted(column, &sum)));
        let most = ratios.fold(f64::NEG_INFINITY, f64::max);
        assert!(most < 8.0 && most < large - 12.0, "{most}, {large}");
    }
}

#[test]
fn without_other_effects_nothing_is_everywhere() {
    assert_eq!(Everywhere::new(Vec::new()).dimensions(), 0.0);
}

/// With the covariance of the rows, inverted.
#[test]
fn the_likelihood_is_that_of_the_covariance() {
    let (columns, y) = drawn(5);
    let g = fitted(&columns[0], &y).iter().map(|value| 3.0 * value).collect::<Vec<f64>>();
    let everywhere = Everywhere::new(columns.clone());
    let log = |size: f64, with: f64| {
        let covariance = nalgebra::DMatrix::from_fn(ROWS, ROWS, |i, k| {
            let of_others: f64 = columns.iter().map(|column| column[i] * column[k]).sum::<f64>() / 40.0;
            size * of_others + with * g[i] * g[k] + if i == k { 1.0 } else { 0.0 }
        });
        let decomposition = covariance.cholesky().unwrap();
        let rows = nalgebra::DVector::from_column_slice(&y);
        -0.5 * (decomposition.ln_determinant() + rows.dot(&decomposition.solve(&rows)))
    };
    for size in [0.0, 3.0, 200.0] {
        let (alone, both) = everywhere.log_likelihoods(&y, &g)(size);
        assert!((alone - log(size, 0.0)).abs() < 1e-9 && (both - log(size, 1.0)).abs() < 1e-9, "{size}");
    }
}
