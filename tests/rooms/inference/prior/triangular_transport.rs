//! Tests of `core/src/inference/prior/triangular_transport.rs`.

use bmv::inference::prior::transform::Transform;
use bmv::inference::prior::triangular_transport::*;
use bmv::random::Distribution;

fn uniform() -> Distribution {
    Distribution::Uniform { lower: 0.0, upper: 1.0 }
}

/// Two parameters correlated by 0.99, the first two standard deviations from its bound; a third without relation.
fn ridge() -> (Vec<Distribution>, Vec<Transform>, NormalApproximation) {
    let priors = vec![uniform(), uniform(), uniform()];
    let transforms = priors.iter().enumerate().map(|(i, prior)| Transform::new(prior, i).unwrap()).collect();
    let (a, b) = (0.01, 0.05);
    let covariance = vec![a * a, 0.99 * a * b, 0.0, 0.99 * a * b, b * b, 0.0, 0.0, 0.0, 0.0];
    (priors, transforms, NormalApproximation { mode: vec![0.5, 0.1, 0.3], covariance })
}

#[test]
fn the_parameter_beside_its_bound_comes_first_and_one_that_is_held_is_left_alone() {
    let (priors, transforms, normal) = ridge();
    let transport = Transport::new(&transforms, &priors, &normal).unwrap();
    assert_eq!([0, 1, 2].map(|place| transport.parameter(place)), [1, 0, 2]);
    // By hand: regression 0.99 * 0.01 / 0.05, over the logistic's slope of 1/4 at the middle; 0.2 is 0.1 above the mode.
    let factor = 0.99 * 0.01 / 0.05 / 0.25;
    assert!((transport.shift(1, &[0.9, 0.2, 0.9]) - 0.1 * factor).abs() < 1e-8, "{transport:?}");
    assert_eq!(transport.shift(1, &[0.9, 0.1, 0.9]), 0.0, "those after it move nothing");
    assert_eq!([0, 2].map(|place| transport.shift(place, &[0.9, 0.2, 0.9])), [0.0; 2]);
}

#[test]
fn the_coordinates_of_the_approximation_are_uncorrelated() {
    let (priors, transforms, normal) = ridge();
    let transport = Transport::new(&transforms, &priors, &normal).unwrap();
    let covariance = covariance_of_coordinates(&transforms, Some(&transport), &normal);
    // The rest of a regression has the variance (1 - 0.99^2) of the whole; slopes of the logistic 0.25 and 0.09.
    assert!((covariance[0] / ((1.0 - 0.99 * 0.99) * 0.01 * 0.01 / 0.0625) - 1.0).abs() < 1e-6, "{covariance:?}");
    assert!((covariance[4] - 0.05 * 0.05 / (0.09 * 0.09)).abs() < 1e-12);
    assert!(covariance[1].abs() < 1e-7 * (covariance[0] * covariance[4]).sqrt() + 1e-9, "{covariance:?}");
    let plain = covariance_of_coordinates(&transforms, None, &normal);
    assert!((plain[1] / (plain[0] * plain[4]).sqrt() - 0.99).abs() < 1e-12);
}

#[test]
fn parameters_as_wide_as_their_priors_shear_nothing() {
    let (priors, transforms, mut normal) = ridge();
    normal.covariance[4] = 0.2 * 0.2;
    assert_eq!(Transport::new(&transforms, &priors, &normal), None);
}
