//! Tests of `src/job/goal/knowledge.rs`.

use bmv::job::goal::knowledge::*;
use bmv::random::Distribution;
use bmv::statistics::Moments;

fn sharpened(prior: Distribution, reading: f64, error: f64) -> Moments {
    let sharpened = Sharpened::new(&prior, &Known { parameter: 0, reading, error });
    let n = 20_000;
    Moments::of(&(0..n).map(|i| sharpened.quantile((f64::from(i) + 0.5) / f64::from(n))).collect::<Vec<_>>())
}

#[test]
fn a_normal_prior_and_a_normal_error_are_conjugate() {
    // Precisions add: 1/4 + 1 = 5/4; mean (3/4 + 5) / (5/4).
    let prior = Distribution::Normal { mean: 3.0, sd: 2.0, lower: None, upper: None };
    let moments = sharpened(prior, 5.0, 1.0);
    assert!((moments.mean() - 4.6).abs() < 1e-3, "{}", moments.mean());
    // The cells cut the tails: a thousandth.
    assert!((moments.sd() / 0.8_f64.sqrt() - 1.0).abs() < 2e-3, "{}", moments.sd());
}

#[test]
fn a_small_error_within_a_uniform_prior_is_left_as_it_is() {
    let prior = Distribution::Uniform { lower: 0.78, upper: 0.92 };
    let moments = sharpened(prior, 0.85, 0.005);
    assert!((moments.mean() - 0.85).abs() < 1e-6 && (moments.sd() / 0.005 - 1.0).abs() < 1e-3, "{}", moments.sd());
}

#[test]
fn the_error_leaves_the_ratio_asked_for() {
    for prior in [
        Distribution::Uniform { lower: 0.0, upper: 3.0 },
        Distribution::LogNormal { median: 2.0, factor: 1.4 },
        Distribution::Triangular { lower: 0.0, mode: 0.2, upper: 1.0 },
    ] {
        for ratio in [0.9, 0.5, 0.1, 0.02] {
            let error = error_for(&prior, ratio);
            let moments = sharpened(prior, prior.mean(), error);
            // The tails of a lognormal prior are cut by the cells.
            assert!((moments.sd() / prior.sd() / ratio - 1.0).abs() < 0.01, "{prior:?} {ratio}: {}", moments.sd());
        }
    }
}

#[test]
fn no_error_is_perfect_and_one_without_end_is_the_prior() {
    let prior = Distribution::Uniform { lower: 0.0, upper: 2.0 };
    assert_eq!(error_for(&prior, 0.001), 0.0);
    let sharpened_by = |error| Sharpened::new(&prior, &Known { parameter: 0, reading: 1.5, error });
    assert_eq!(sharpened_by(0.0).quantile(0.1), 1.5);
    assert!((sharpened_by(error_for(&prior, 1.0)).quantile(0.1) - 0.2).abs() < 1e-12);
}
