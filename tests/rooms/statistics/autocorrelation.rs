//! Tests of `core/src/statistics/autocorrelation.rs`.

use bmv::statistics::autocorrelation::*;

#[test]
fn autocovariance_by_hand() {
    // Mean 2.5, deviations -1.5 -0.5 0.5 1.5.
    let values = [1.0, 2.0, 3.0, 4.0];
    assert_eq!(autocovariance(&values, 0), 1.25);
    assert_eq!(autocovariance(&values, 1), (0.75 - 0.25 + 0.75) / 4.0);
    assert_eq!(autocovariance(&values, 4), 0.0);
    assert_eq!((lag_one(&values), lag_one(&[2.0; 9])), (0.25, 0.0));
    assert_eq!(effective_size_lag_one(&values), 2.4);
}
