//! Tests of `src/job/fault.rs`.

use bmv::job::fault::*;

#[test]
fn the_first_parameters_are_stated() {
    let parameters: Vec<(String, f64)> = (0..10).map(|i| (format!("p{i}"), f64::from(i) / 2.0)).collect();
    assert_eq!(listed(&parameters[..2]), "p0 = 0, p1 = 0.5");
    assert!(listed(&parameters).ends_with("p7 = 3.5 and 2 more"));
}
