//! Tests of `src/report/ladder.rs`.

use bmv::job::compare::Deviation;
use bmv::report::ladder::*;

#[test]
fn a_sensor_counts_all_its_readings_by_their_number() {
    let part = |count, mean, rmse, max| Deviation { count, mean, rmse, max, ..Deviation::default() };
    let [square, mean, largest] = over_all([&part(3, 1.0, 2.0, 3.0), &part(1, -1.0, 4.0, 4.0)]).expect("four readings");
    // (3 * 4 + 16) / 4 and (3 - 1) / 4, exact in binary.
    assert_eq!([square, mean, largest], [7.0, 0.5, 4.0]);
    assert_eq!(over_all([&part(0, f64::NAN, f64::NAN, 0.0), &part(0, 0.0, 0.0, 0.0)]), None);
    assert!(Standing { kept: Some([1, 2]), ..Standing::default() }.fails());
}
