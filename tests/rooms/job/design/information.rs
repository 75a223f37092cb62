//! Tests of `src/job/design/information.rs`.

use bmv::job::design::information::*;
use bmv::math::special::normal_quantile;

#[test]
fn shifts_stay_inside_and_one_of_them_is_none() {
    assert_eq!((shifted(0.3, 0, 1), shifted(0.3, 8, 8)), (0.3, 0.3));
    assert!((shifted(0.3, 5, 8) - 0.925).abs() < 1e-15 && (shifted(0.3, 7, 8) - 0.175).abs() < 1e-15);
    let ends = [shifted(0.125, 7, 8), shifted(1.0 - f64::EPSILON / 2.0, 0, 8)];
    assert!(ends.iter().all(|u| normal_quantile(*u).is_finite()), "{ends:?}");
}
