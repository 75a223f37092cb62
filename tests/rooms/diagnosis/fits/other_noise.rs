//! Tests of `diagnosis/src/diagnosis/fits/other_noise.rs`.

use bmv::diagnosis::fits::other_noise::*;
use bmv::math::functions::{exp, ln};
use bmv::random::Distribution;

/// A parameter with a standard normal prior, read `n` times with unit noise, the readings' mean `y`: the evidence is
/// normal in closed form, whatever the noise.
#[test]
fn the_evidence_with_another_noise_is_that_of_a_new_fit() {
    let (n, y, square) = (5.0, 3.0, 52.0);
    let fit = |variance: f64| {
        let data: f64 = n / variance;
        let mode = data * y / (1.0 + data);
        let errors = square - 2.0 * mode * n * y + n * mode * mode;
        // Without the constants of the noise, which are those of the likelihood.
        (data, mode, errors, -0.5 * errors / variance - 0.5 * mode * mode - 0.5 * ln(1.0 + data))
    };
    let (data, away, errors, known) = fit(1.0);
    let directions = [Direction { data, away }];
    for times in [0.2, 1.0, 3.0, 100.0] {
        let at_fit = known + 0.5 * errors - 0.5 * errors / times;
        let expected = fit(times).3;
        assert!((at_fit + gain(&directions, times) - expected).abs() < 1e-12, "{times}");
    }
    assert!((determined(&directions, 5.0) - 0.5).abs() < 1e-12);
    let times = errors / n;
    let own = with_own_noise(known, errors, n, &directions);
    assert!(
        (own - (fit(times).3 - 0.5 * n * ln(times))).abs() < 1e-12,
        "the most likely variance, of a normal evidence"
    );
    assert_eq!(with_own_noise(known, errors, 0.0, &directions), known);
}

#[test]
fn directions_are_those_of_the_covariance_in_the_priors_units() {
    let normal = |mean: f64, sd: f64| Distribution::Normal { mean, sd, lower: None, upper: None };
    assert_eq!(scale(&normal(2.0, 0.5), 3.0), (2.0, 0.5));
    assert_eq!(scale(&Distribution::HalfNormal { scale: 4.0 }, 2.0), (0.5, 4.0));
    let log = Distribution::LogNormal { median: 10.0, factor: exp(0.5) };
    let (away, sd) = scale(&log, 10.0 * exp(1.0));
    assert!((away - 2.0).abs() < 1e-12 && (sd - 5.0 * exp(1.0)).abs() < 1e-12, "{away} {sd}");
    assert_eq!(scale(&Distribution::Uniform { lower: 0.0, upper: 6.0 }, 1.0).0, 0.0, "no pull");
}
