//! Tests of `core/src/inference/prior/transform.rs`.

use bmv::inference::prior::transform::*;
use bmv::math::functions::{exp, ln};
use bmv::random::Distribution;

/// One prior of every kind that can be inferred.
pub(crate) fn every_kind() -> Vec<Distribution> {
    vec![
        Distribution::Uniform { lower: -2.0, upper: 5.0 },
        Distribution::Normal { mean: 3.0, sd: 0.7, lower: None, upper: None },
        Distribution::Normal { mean: 3.0, sd: 0.7, lower: Some(2.5), upper: None },
        Distribution::Normal { mean: 3.0, sd: 0.7, lower: None, upper: Some(3.5) },
        Distribution::Normal { mean: 3.0, sd: 0.7, lower: Some(2.0), upper: Some(3.5) },
        Distribution::LogNormal { median: 0.03, factor: 2.0 },
        Distribution::LogUniform { lower: 1e-3, upper: 10.0 },
        Distribution::HalfNormal { scale: 4.0 },
        Distribution::Triangular { lower: 0.0, mode: 0.2, upper: 1.0 },
    ]
}

// Central differences with a step of 1e-5 are good to about 1e-9 relative on functions of order one.
const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-7;

#[test]
fn slopes_agree_with_central_differences() {
    for (index, prior) in every_kind().iter().enumerate() {
        let transform = Transform::new(prior, index).unwrap();
        for z in [-3.1, -0.4, 0.0, 0.9, 2.7] {
            let (at, above, below) = (transform.at(z), transform.at(z + STEP), transform.at(z - STEP));
            let slope = (above.value - below.value) / (2.0 * STEP);
            assert!((slope - at.slope).abs() < TOLERANCE * slope.abs().max(1e-2), "{prior:?} {z} {slope} {at:?}");
            assert!((ln(at.slope.abs()) - at.log_slope).abs() < 1e-12, "{prior:?}");
            let bend = (above.log_slope - below.log_slope) / (2.0 * STEP);
            assert!((bend - at.log_slope_slope).abs() < TOLERANCE, "{prior:?} {bend} {at:?}");
            assert!((transform.coordinate(at.value) - z).abs() < 1e-9, "{prior:?} {z}");
        }
    }
}

#[test]
fn the_density_of_the_coordinate_integrates_to_one() {
    for (index, prior) in every_kind().iter().enumerate() {
        let transform = Transform::new(prior, index).unwrap();
        let mut sum = 0.0;
        let width = 1e-3;
        for i in -40_000..40_000 {
            let image = transform.at(f64::from(i) * width + 0.5 * width);
            let log_density = prior.log_density(image.value) + image.log_slope;
            sum += exp(log_density) * width;
        }
        // The midpoint rule at 1e-3 is exact to 1e-7 here, but for the kink of the triangle.
        assert!((sum - 1.0).abs() < 1e-6, "{prior:?} {sum}");
    }
}

#[test]
fn extreme_coordinates_stay_finite_and_within_bounds() {
    for (index, prior) in every_kind().iter().enumerate() {
        let transform = Transform::new(prior, index).unwrap();
        let (lower, upper) = prior.support();
        for z in [-300.0, -40.0, 40.0, 300.0] {
            let image = transform.at(z);
            assert!(image.log_slope.is_finite(), "{prior:?}");
            assert!(image.value >= lower && image.value <= upper, "{prior:?} {z} {image:?}");
        }
        assert!(transform.coordinate(lower.max(-1e6)).is_finite());
        assert!(transform.coordinate(upper.min(1e6)).is_finite());
    }
}

#[test]
fn fixed_values_and_empty_intervals_are_refused() {
    assert!(matches!(
        Transform::new(&Distribution::Fixed(2.0), 3),
        Err(TransformError::Fixed { index: 3, value: 2.0 })
    ));
    assert!(matches!(
        Transform::new(&Distribution::Uniform { lower: 1.0, upper: 1.0 }, 0),
        Err(TransformError::Empty { .. })
    ));
}
