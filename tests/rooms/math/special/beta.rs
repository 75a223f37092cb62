//! Tests of `core/src/math/special/beta.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::special::beta::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};
use statrs::function::beta::beta_reg;

fn close(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() <= relative * expected.abs()
}

#[test]
fn agrees_with_closed_forms_and_symmetry() {
    for x in [1e-9, 0.1, 0.5, 0.83, 1.0 - 1e-9_f64] {
        assert!(close(beta_regularised(1.0, 1.0, x), x, 1e-14));
        assert!(close(beta_regularised(3.0, 1.0, x), x * x * x, 1e-14));
        // Arcsine law.
        let expected = 2.0 / std::f64::consts::PI * x.sqrt().asin();
        // The inverse sine itself loses digits near 1.
        assert!(close(beta_regularised(0.5, 0.5, x), expected, 1e-11), "{x}");
        let sum = beta_regularised(4.5, 700.0, x) + beta_regularised(700.0, 4.5, 1.0 - x);
        assert!((sum - 1.0).abs() < 1e-7, "{x}: 1 - x is rounded");
    }
    assert!(beta_regularised(0.0, 1.0, 0.5).is_nan() && beta_regularised(1.0, 1.0, 1.5).is_nan());
}

#[test]
fn agrees_with_forty_digit_values_for_large_arguments() {
    for (a, b, x, expected) in BETA_REFERENCE {
        let value = beta_regularised(a, b, x);
        assert!(close(value, expected, 1e-12), "I_{x}({a}, {b}) = {value} against {expected}");
    }
}

const BETA_REFERENCE: [(f64, f64, f64, f64); 4] = [
    (100.0, 200.0, 0.3, 0.10884306564490975),
    (5000.0, 3000.0, 0.62, 0.17773206624208332),
    (0.5, 4000.0, 0.0001, 0.6289036412667364),
    (30.0, 1.5, 0.5, 4.186158141976972e-09),
];

#[test]
fn agrees_with_statrs() {
    for (a, b) in [(0.5, 3.0), (2.0, 2.0), (12.0, 0.7)] {
        for x in [0.01, 0.4, 0.95] {
            assert!((beta_regularised(a, b, x) - beta_reg(a, b, x)).abs() < 1e-11);
        }
    }
    let (t, f) = (StudentsT::new(0.0, 1.0, 4.5).unwrap(), FisherSnedecor::new(3.0, 11.0).unwrap());
    for x in [0.1, 1.0, 2.5, 9.0] {
        assert!((student_t_cdf(x, 4.5) - t.cdf(x)).abs() < 1e-11);
        assert!((fisher_f_cdf(x, 3.0, 11.0) - f.cdf(x)).abs() < 1e-11);
        assert!((fisher_f_sf(x, 3.0, 11.0) - f.sf(x)).abs() < 1e-11);
    }
}

#[test]
fn quantiles_are_the_tabled_ones_and_invert() {
    // Abramowitz & Stegun, table 26.10.
    for (p, dof, expected) in [(0.975, 1.0, 12.706), (0.975, 10.0, 2.228), (0.995, 30.0, 2.750), (0.95, 5.0, 2.015)] {
        assert!((student_t_quantile(p, dof) - expected).abs() < 6e-4, "{p} {dof}");
    }
    // One degree of freedom: Cauchy.
    assert!(close(student_t_quantile(1e-10, 1.0), -1.0 / (std::f64::consts::PI * 1e-10), 1e-12));
    for dof in [0.5, 1.0, 3.3, 50.0, 1e5] {
        for p in [1e-8, 0.01, 0.3, 0.500_001] {
            let t = student_t_quantile(p, dof);
            assert!((student_t_cdf(t, dof) / p - 1.0).abs() < 1e-10, "{p} {dof} {t}");
        }
    }
    for (a, b) in [(0.5, 0.5), (3.0, 40.0), (1000.0, 2.0)] {
        for p in [1e-6, 0.2, 0.5, 0.99] {
            assert!(close(beta_regularised(a, b, beta_quantile(p, a, b)), p, 1e-10), "{p} {a} {b}");
        }
    }
    assert!(student_t_quantile(1.5, 3.0).is_nan());
}
