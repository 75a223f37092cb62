//! Tests of `core/src/inference/estimate/box_probability.rs`.

use bmv::inference::estimate::box_probability::*;

#[test]
fn orthants_and_slabs_have_their_known_probabilities() {
    let infinite = f64::INFINITY;
    // Orthant of two variables with correlation r: 1/4 + asin(r) / (2 pi); r = 1/2 gives 1/3.
    let two = log_box_probability(&[1.0, 0.5, 0.5, 1.0], &[0.0, 0.0], &[infinite, infinite]).unwrap();
    assert!((libm::exp(two) - 1.0 / 3.0).abs() < 1e-3, "{}", libm::exp(two));
    // Three variables, all correlations 1/2: 1/8 + 3 asin(1/2) / (4 pi) = 1/4.
    let c = [1.0, 0.5, 0.5, 0.5, 1.0, 0.5, 0.5, 0.5, 1.0];
    let three = log_box_probability(&c, &[0.0; 3], &[infinite; 3]).unwrap();
    assert!((libm::exp(three) - 0.25).abs() < 1e-3);
    // One variable far above its mean: the upper tail beyond 5 is 2.866515719e-7.
    let one = log_box_probability(&[4.0], &[10.0], &[infinite]).unwrap();
    assert!((libm::exp(one) / 2.866_515_719e-7 - 1.0).abs() < 1e-8);
    // Bounds that are far away leave everything.
    assert_eq!(log_box_probability(&[1.0], &[-100.0], &[infinite]), Some(0.0));
    assert_eq!(log_box_probability(&[-1.0], &[0.0], &[1.0]), None);
}
