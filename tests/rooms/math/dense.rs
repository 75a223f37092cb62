//! Tests of `core/src/math/dense.rs`.

use bmv::math::dense::*;
use proptest::prelude::*;

fn multiply(a: &[f64], x: &[f64]) -> Vec<f64> {
    a.chunks_exact(x.len()).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

fn transpose(a: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|k| a[(k % n) * n + k / n]).collect()
}

#[test]
fn solves_a_system_that_needs_row_exchanges() {
    // By hand: x = (1, 2, 3); the first pivot is zero.
    let a = [0.0, 2.0, 1.0, 1.0, -1.0, 1.0, 4.0, 0.0, -2.0];
    let (mut factors, mut pivots) = (a, [0; 3]);
    factor(&mut factors, &mut pivots).unwrap();
    let mut x = [7.0, 2.0, -2.0];
    solve(&factors, &pivots, &mut x);
    for (x, expected) in x.iter().zip([1.0, 2.0, 3.0]) {
        assert!((x - expected).abs() < 1e-14, "{x} against {expected}");
    }
}

#[test]
fn names_the_singular_column() {
    let mut a = [1.0, 2.0, 3.0, 2.0, 4.0, 1.0, 3.0, 6.0, 5.0];
    assert_eq!(factor(&mut a, &mut [0; 3]).unwrap_err().column, 1);
    let mut a = [1.0, f64::NAN, 3.0, 4.0];
    assert_eq!(factor(&mut a, &mut [0; 2]).unwrap_err().column, 1);
    assert_eq!(factor(&mut [], &mut []), Ok(()));
    solve(&[], &[], &mut []);
}

proptest! {
    /// The backward error of partial pivoting stays near rounding: 1e-11 leaves room for growth at n = 50.
    #[test]
    fn residuals_are_small(n in 1_usize..50, seed in 0_u64..1000) {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let a: Vec<f64> = (0..n * n).map(|_| next()).collect();
        let b: Vec<f64> = (0..n).map(|_| next()).collect();
        let (mut factors, mut pivots) = (a.clone(), vec![0; n]);
        prop_assume!(factor(&mut factors, &mut pivots).is_ok());
        let scale = |x: &[f64]| 1.0 + x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut x = b.clone();
        solve(&factors, &pivots, &mut x);
        for (left, right) in multiply(&a, &x).iter().zip(&b) {
            prop_assert!((left - right).abs() < 1e-11 * scale(&x));
        }
        let mut x = b.clone();
        solve_transposed(&factors, &pivots, &mut x);
        for (left, right) in multiply(&transpose(&a, n), &x).iter().zip(&b) {
            prop_assert!((left - right).abs() < 1e-11 * scale(&x));
        }
    }
}
