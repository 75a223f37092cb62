//! Tests of `core/src/statistics/kolmogorov.rs`.

use bmv::statistics::kolmogorov::*;

#[test]
fn statistic_by_hand() {
    // Uniform: steps at 0.1, 0.4, 0.7; the largest gap is 1 - 0.7 after the last.
    assert!((statistic_sorted(&[0.1, 0.4, 0.7], |x| x) - 0.3).abs() < 1e-15);
    assert!((statistic_sorted(&[0.6], |x| x) - 0.6).abs() < 1e-15);
}

#[test]
fn limit_is_the_tabled_one() {
    // Smirnov (1948): critical values 1.224, 1.358, 1.628 at 10, 5 and 1 %; the last digit is worth 0.3 %.
    for (x, p) in [(1.224, 0.1), (1.358, 0.05), (1.628, 0.01)] {
        assert!((limit(x) / p - 1.0).abs() < 4e-3, "{x}: {}", limit(x));
    }
    assert!((limit(1.179_999_999) - limit(1.180_000_001)).abs() < 1e-8, "the series meet");
    assert_eq!((limit(0.0), limit(0.03)), (1.0, 1.0));
    // Exact critical value for n = 10 at 5 %: 0.409 (Miller 1956).
    assert!((p_value(0.409, 10) - 0.05).abs() < 0.003, "{}", p_value(0.409, 10));
}
