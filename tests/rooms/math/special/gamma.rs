//! Tests of `core/src/math/special/gamma.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::special::gamma::*;
use statrs::function::gamma::{gamma_lr, gamma_ur};

fn close(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() <= relative * expected.abs()
}

#[test]
fn agrees_with_closed_forms() {
    // Q(1, x) = e^-x; Q(n, x) = e^-x sum x^k / k!; P(1/2, x) = erf(sqrt x).
    for x in [1e-6, 0.3, 1.0, 4.0, 30.0, 300.0_f64] {
        // Rounding of an exponent of size x.
        let relative = 5e-15 + 3e-16 * x;
        assert!(close(gamma_q(1.0, x), (-x).exp(), relative), "{x}");
        assert!(close(gamma_q(3.0, x), (-x).exp() * (1.0 + x + 0.5 * x * x), relative), "{x}");
        assert!(close(gamma_p(0.5, x), libm::erf(x.sqrt()), 1e-14), "{x}");
    }
    assert!(gamma_p(-1.0, 1.0).is_nan());
    assert_eq!((gamma_p(2.0, 0.0), gamma_q(2.0, f64::INFINITY)), (0.0, 0.0));
}

#[test]
fn agrees_with_forty_digit_values_for_large_arguments() {
    for (a, x, p, q) in GAMMA_REFERENCE {
        assert!(close(gamma_p(a, x), p, 2e-13), "P({a}, {x}) = {} against {p}", gamma_p(a, x));
        assert!(close(gamma_q(a, x), q, 2e-13), "Q({a}, {x}) = {} against {q}", gamma_q(a, x));
    }
}

const GAMMA_REFERENCE: [(f64, f64, f64, f64); 4] = [
    (100.0, 80.0, 0.017108313035133115, 0.9828916869648668),
    (1000.0, 1100.0, 0.99894067674607, 0.0010593232539299773),
    (10000.0, 10050.0, 0.6923424407025656, 0.30765755929743444),
    (2.5, 60.0, 1.0, 3.138579772755296e-24),
];

#[test]
fn agrees_with_statrs() {
    for a in [0.5, 1.5, 7.0, 40.0] {
        for x in [0.1, 1.0, 6.0, 39.0, 60.0] {
            assert!((gamma_p(a, x) - gamma_lr(a, x)).abs() < 1e-10);
            assert!((gamma_q(a, x) - gamma_ur(a, x)).abs() < 1e-10);
        }
    }
}

#[test]
fn quantiles_are_the_tabled_ones_and_invert() {
    // Abramowitz & Stegun, table 26.8.
    for (p, dof, expected) in [(0.95, 1.0, 3.84146), (0.99, 10.0, 23.2093), (0.005, 4.0, 0.206989), (0.5, 30.0, 29.336)]
    {
        assert!(close(chi_square_quantile(p, dof), expected, 4e-6), "{p} {dof}");
    }
    for dof in [0.3, 1.0, 2.0, 9.0, 1000.0, 1e6] {
        for p in [1e-12, 0.001, 0.3, 0.5, 0.9, 0.999_999] {
            let x = chi_square_quantile(p, dof);
            assert!(close(chi_square_cdf(x, dof), p, 1e-11), "{p} {dof} {x}");
            assert!((chi_square_cdf(x, dof) + chi_square_sf(x, dof) - 1.0).abs() < 1e-15);
        }
    }
}
