//! Tests of `core/src/math/cholesky.rs`.

use bmv::math::cholesky::*;
use bmv::math::functions::ln;

#[test]
fn factor_products_and_solutions_agree() {
    let a = [4.0, 2.0, -1.0, 2.0, 5.0, 0.5, -1.0, 0.5, 3.0];
    let mut l = a;
    factor(&mut l, 3).unwrap();
    // det by the rule of Sarrus.
    let det: f64 = 4.0 * (15.0 - 0.25) - 2.0 * (6.0 + 0.5) - 1.0 * (1.0 + 5.0);
    assert!((log_determinant(&l, 3) - ln(det)).abs() < 1e-14);
    let inverse = inverse(&l, 3);
    for i in 0..3 {
        for j in 0..3 {
            let product: f64 = (0..3).map(|k| a[i * 3 + k] * inverse[k * 3 + j]).sum();
            assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-14);
        }
    }
    let mut product = [0.0; 3];
    multiply(&l, &[1.0, -2.0, 0.5], &mut product);
    solve_lower(&l, &mut product);
    assert!((product[1] + 2.0).abs() < 1e-14);
}

#[test]
fn indefinite_and_undefined_matrices_are_refused() {
    assert_eq!(factor(&mut [1.0, 0.0, 2.0, 1.0], 2).unwrap_err().index, 1);
    assert!(factor(&mut [f64::NAN], 1).is_err());
}
