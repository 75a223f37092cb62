//! Tests of `core/src/statistics/regression.rs`.

use bmv::statistics::regression::*;

#[test]
fn anscombes_first_set() {
    // Anscombe (1973): y = 3.00 + 0.500 x, standard error of the slope 0.118.
    let x = [10.0, 8.0, 13.0, 9.0, 11.0, 14.0, 6.0, 4.0, 12.0, 7.0, 5.0];
    let y = [8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68];
    let line = Line::fit(&x, &y).unwrap();
    assert!((line.intercept - 3.0001).abs() < 1e-4 && (line.slope - 0.5001).abs() < 1e-4);
    assert!((line.slope_standard_error - 0.1179).abs() < 1e-4);
    assert!(line.residuals(&x, &y).iter().sum::<f64>().abs() < 1e-12);
    assert!(Line::fit(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0]).is_none() && Line::fit(&x[..2], &y[..2]).is_none());
}
