//! Tests of `diagnosis/src/diagnosis/odds/narrow_prior.rs`.

use bmv::diagnosis::odds::narrow_prior::*;
use bmv::math::functions::ln;
use bmv::random::Distribution;

#[test]
fn a_wider_prior_keeps_what_cannot_be_otherwise() {
    let uniform = |lower, upper| Distribution::Uniform { lower, upper };
    // The quantiles at 0.16 and 0.84 lie 0.68 of the width apart, and a standard deviation is 1.5 times that.
    let Some(Distribution::Normal { mean, sd, lower, upper }) = wider(&uniform(0.84, 0.88), "1", 1.0) else {
        panic!("normal")
    };
    assert!((mean - 0.86).abs() < 1e-12 && (sd - 1.5 * 0.68 * 0.04).abs() < 1e-12, "{mean} {sd}");
    assert_eq!((lower, upper), (Some(LEAST * mean), Some(1.0)), "an emittance");
    let of = |prior: &Distribution, unit: &str| match wider(prior, unit, 2.0) {
        Some(Distribution::Normal { lower, upper, .. }) => (lower.is_some(), upper.is_some()),
        other => panic!("{other:?}"),
    };
    assert_eq!(of(&uniform(0.2, 0.5), "W/K"), (true, false), "a conductance may be above 1 W/K");
    assert_eq!(of(&uniform(-3.0, 3.0), "K"), (false, false));
    let normal = Distribution::Normal { mean: 1.0, sd: 0.02, lower: None, upper: None };
    assert_eq!(of(&normal, "1"), (true, false), "a factor near 1 may be above it");
    assert_eq!(wider(&Distribution::Fixed(2.0), "1", 1.0), None);
    let logarithmic = wider(&Distribution::LogUniform { lower: 1.0, upper: 100.0 }, "W/K", 1.0);
    let Some(Distribution::LogNormal { median, factor }) = logarithmic else { panic!("lognormal") };
    assert!((median - 10.0).abs() < 1e-9 && (ln(factor) - 3.0 * 0.34 * ln(100.0)).abs() < 1e-9, "{factor}");
    let half = wider(&Distribution::HalfNormal { scale: 0.1 }, "W/K", 1.0);
    assert!(matches!(half, Some(Distribution::HalfNormal { scale }) if (scale - 0.3).abs() < 1e-12));
}
