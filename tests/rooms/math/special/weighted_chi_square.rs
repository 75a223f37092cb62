//! Tests of `core/src/math/special/weighted_chi_square.rs`.

use bmv::math::functions::exp;
use bmv::math::special::weighted_chi_square::*;
use bmv::math::special::{chi_square_sf, fisher_f_sf};

fn close(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() <= relative * expected.abs()
}

#[test]
fn equal_weights_give_chi_square_and_f() {
    for k in [1_usize, 2, 3, 7, 40] {
        for x in [0.01, 0.5, 1.0, 4.0, 30.0, 90.0, 400.0] {
            let value = weighted_chi_square_sf(2.5 * x, &vec![2.5; k], None);
            assert!(close(value, chi_square_sf(x, k as f64), 1e-8), "{k} {x}: {value}");
            for d in [4.0, 11.5, 300.0] {
                let value = weighted_chi_square_sf(2.5 * x, &vec![2.5; k], Some(d));
                let expected = fisher_f_sf(x / k as f64, k as f64, d);
                assert!(close(value, expected, 1e-7), "{k} {x} {d}: {value} {expected}");
            }
        }
    }
}

#[test]
fn pairs_of_weights_give_sums_of_exponentials() {
    // Two weights a > b, each twice: (a e^(-x / 2a) - b e^(-x / 2b)) / (a - b).
    for (a, b) in [(1.0, 0.5), (1.0, 0.01), (3.0, 1e-5)] {
        for x in [0.1, 1.0, 5.0, 40.0, 300.0] {
            let expected = (a * exp(-0.5 * x / a) - b * exp(-0.5 * x / b)) / (a - b);
            let value = weighted_chi_square_sf(x, &[a, b, a, b], None);
            assert!(close(value, expected, 1e-8), "{a} {b} {x}: {value} {expected}");
        }
    }
    // Imhof (1961), table 1, printed to four places.
    for (x, expected) in [(0.1, 0.9458), (0.7, 0.5064), (2.0, 0.1240)] {
        let value = weighted_chi_square_sf(x, &[0.6, 0.3, 0.1], None);
        assert!((value - expected).abs() < 6e-5, "{x}: {value}");
    }
}

#[test]
fn values_exceeded_invert_the_tail() {
    for p in [0.9, 0.3, 1e-3, 1e-12, 1e-200] {
        for degrees in [None, Some(9.0)] {
            let weights = [0.9, 0.4, 0.05];
            let x = weighted_chi_square_upper(p, &weights, degrees);
            assert!(close(weighted_chi_square_sf(x, &weights, degrees), p, 1e-8), "{p} {degrees:?} {x}");
        }
    }
    assert_eq!(weighted_chi_square_sf(1.0, &[], None), 0.0);
    assert_eq!(weighted_chi_square_sf(-1.0, &[1.0], None), 1.0);
}
