//! Tests of `src/report/section/margins/bought.rs`.

use bmv::math::special::normal_cdf;
use bmv::report::section::margins::bought::*;

#[test]
fn probabilities_between_points_of_a_sweep_are_those_of_a_normal_curve() {
    let points: Vec<(f64, f64)> = (0..5).map(|x| (f64::from(x), normal_cdf(f64::from(x) - 2.0))).collect();
    let at = between(&points, 2.5, 1_000_000_000).expect("within");
    assert!((at - normal_cdf(0.5)).abs() < 1e-9, "{at}");
    assert_eq!(between(&points, 4.5, 100), None);
    assert_eq!(between(&[(0.0, 1.0), (1.0, 1.0)], 0.5, 100), Some(1.0));
}
