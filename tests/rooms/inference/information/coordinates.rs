//! Tests of `core/src/inference/information/coordinates.rs`.

use bmv::inference::information::coordinates::*;
use bmv::random::Distribution;

#[test]
fn slopes_are_those_of_the_values() {
    let priors = [
        Distribution::Uniform { lower: 0.78, upper: 0.92 },
        Distribution::Normal { mean: 3.0, sd: 0.5, lower: None, upper: None },
        Distribution::LogUniform { lower: 1e-4, upper: 1e-1 },
        Distribution::Triangular { lower: 0.0, mode: 0.3, upper: 1.0 },
    ];
    for prior in priors {
        for u in [-2.5, -0.7, 0.0, 0.4, 1.9] {
            // Central differences of step 1e-5: error of 1e-10 relative to curvature, 1e-11 by rounding.
            let difference = (value(&prior, u + 1e-5) - value(&prior, u - 1e-5)) / 2e-5;
            assert!((slope(&prior, u) / difference - 1.0).abs() < 1e-6, "{prior:?} {u}");
        }
        assert!(value(&prior, 40.0).is_finite() && value(&prior, -40.0).is_finite());
    }
}

#[test]
fn a_normal_prior_is_only_scaled() {
    let prior = Distribution::Normal { mean: 3.0, sd: 0.5, lower: None, upper: None };
    assert!((value(&prior, 1.5) - 3.75).abs() < 1e-12 && (slope(&prior, 1.5) - 0.5).abs() < 1e-12);
}
