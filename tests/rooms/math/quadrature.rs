//! Tests of `core/src/math/quadrature.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::quadrature::*;

#[test]
fn legendre_rule_of_five_points_is_the_published_one() {
    // Abramowitz & Stegun, table 25.4.
    let rule = gauss_legendre(5);
    let expected = [(0.0, 0.568_888_888_888_889), (0.538_469_310_105_683, 0.478_628_670_499_366)];
    for (k, (x, w)) in expected.into_iter().enumerate() {
        assert!((rule.nodes[2 + k] - x).abs() < 1e-15 && (rule.weights[2 + k] - w).abs() < 1e-15);
        assert!((rule.nodes[2 - k] + x).abs() < 1e-15 && (rule.weights[2 - k] - w).abs() < 1e-15);
    }
    assert!((rule.nodes[4] - 0.906_179_845_938_664).abs() < 1e-15);
}

#[test]
fn legendre_rules_are_exact_for_their_degree() {
    for points in [1, 2, 3, 8, 16, 33, 64] {
        let rule = gauss_legendre(points);
        for degree in [0, 2 * points - 2] {
            let expected = 2.0 / (degree as f64 + 1.0);
            let value = rule.apply(|x| x.powi(degree as i32));
            assert!((value - expected).abs() < 1e-13, "{points} points, degree {degree}: {value}");
        }
        assert!(rule.nodes.is_sorted());
    }
    let value = gauss_legendre(12).integrate(0.0, 2.0, f64::exp);
    assert!((value - (1_f64.exp().powi(2) - 1.0)).abs() < 1e-13);
}

#[test]
fn hermite_rules_give_normal_moments() {
    for points in [1_usize, 2, 3, 10, 21, 64, 100] {
        let rule = gauss_hermite(points);
        assert_eq!(rule.nodes.len(), points);
        assert!(rule.nodes.is_sorted(), "{points}: {:?}", rule.nodes);
        // Moments of a standard normal variable: 1, 1, 3, 15, 105.
        for (half_degree, expected) in [(0, 1.0), (1, 1.0), (2, 3.0), (3, 15.0), (4, 105.0)] {
            if half_degree < points {
                let value = rule.apply(|x| x.powi(2 * half_degree as i32));
                assert!((value - expected).abs() < 1e-11 * expected, "{points}, {half_degree}: {value}");
            }
        }
    }
    // Mean of cos: exp(-1/2).
    assert!((gauss_hermite(20).apply(f64::cos) - (-0.5_f64).exp()).abs() < 1e-13);
    // Physicists' table for 3 points, scaled by sqrt(2): sqrt(3).
    assert!((gauss_hermite(3).nodes[2] - 3_f64.sqrt()).abs() < 1e-15);
}
