//! The beta distribution: what the error of an estimated quantile needs.

use crate::math::functions::{exp, ln, ln_1p, ln_gamma};

/// Probability below `x` (0 to 1) of the beta distribution with parameters above 0.
///
/// Continued fraction of the incomplete beta function (DLMF 8.17.22) by Lentz's method, to about 1e-13.
pub fn beta_cdf(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The fraction converges fast below the mean; above it the mirrored one does.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_cdf(b, a, 1.0 - x);
    }
    const TINY: f64 = 1e-300;
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    // The number of terms grows with the root of the larger parameter; 10 000 serve parameters up to 1e7.
    for k in 1..10_000 {
        let m = f64::from(k);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / away_from_zero(1.0 + even * d);
        c = away_from_zero(1.0 + even / c);
        fraction *= c * d;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / away_from_zero(1.0 + odd * d);
        c = away_from_zero(1.0 + odd / c);
        let change = c * d;
        fraction *= change;
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    let log_front = a * ln(x) + b * ln_1p(-x) + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) - ln(a);
    exp(log_front) * fraction
}

/// The value below which the beta distribution with parameters above 0 has this probability, by bisection.
pub fn beta_quantile(a: f64, b: f64, probability: f64) -> f64 {
    let (mut lower, mut upper) = (0.0, 1.0);
    // Fifty-three halvings leave the last digit of a number near one.
    for _ in 0..53 {
        let middle = 0.5 * (lower + upper);
        if beta_cdf(a, b, middle) < probability {
            lower = middle;
        } else {
            upper = middle;
        }
    }
    0.5 * (lower + upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{Beta, ContinuousCDF};

    #[test]
    fn agrees_with_closed_forms_and_an_independent_implementation() {
        // I_x(1, b) = 1 - (1 - x)^b; I_x(2, 2) = x^2 (3 - 2 x).
        assert!((beta_cdf(1.0, 3.0, 0.2) - (1.0 - 0.8_f64 * 0.8 * 0.8)).abs() < 1e-14);
        assert!((beta_cdf(2.0, 2.0, 0.7) - 0.49 * 1.6).abs() < 1e-14);
        for (a, b) in [(0.5, 0.7), (21.0, 381.0), (201.0, 201.0), (900.0, 12.5)] {
            let oracle = Beta::new(a, b).unwrap();
            for p in [1e-3, 0.158_655_3, 0.5, 0.841_344_7] {
                let x = beta_quantile(a, b, p);
                // statrs's log gamma is good to about 1e-11 here.
                assert!((oracle.cdf(x) - p).abs() < 1e-9, "{a} {b} {p} {}", oracle.cdf(x));
            }
        }
    }
}
