//! The gamma family: regularised incomplete gamma functions, chi-square probabilities and quantiles.
//!
//! Series and continued fraction (Abramowitz & Stegun 6.5.29 and 6.5.31); the common factor by Loader's (2000) saddle
//! point form, whose relative error does not grow with the arguments as that of differences of logarithms does.

use super::normal::normal_quantile;
use crate::math::functions::{exp, ln, ln_gamma, pow, sqrt};
use crate::math::root::newton_increasing;

const LN_SQRT_TWO_PI: f64 = 0.918_938_533_204_672_7;
/// Enough for shapes up to 1e8, which need some ten square roots of the shape.
const LARGEST_TERMS: usize = 200_000;

/// `ln(gamma(a + 1))` less Stirling's formula `(a + 1/2) ln a - a + ln(2 pi) / 2`, for a > 0.
pub(super) fn stirling_error(a: f64) -> f64 {
    if a < 15.0 {
        return ln_gamma(a + 1.0) - (a + 0.5) * ln(a) + a - LN_SQRT_TWO_PI;
    }
    // Abramowitz & Stegun 6.1.41.
    let s = 1.0 / (a * a);
    (1.0 / 12.0
        - s * (1.0 / 360.0 - s * (1.0 / 1260.0 - s * (1.0 / 1680.0 - s * (1.0 / 1188.0 - s * 691.0 / 360_360.0)))))
        / a
}

/// `a ln(a / m) + m - a`, without cancellation for m near a (Loader 2000).
pub(super) fn deviance(a: f64, m: f64) -> f64 {
    let x = (m - a) / a;
    if x.abs() > 0.1 {
        return a * ln(a / m) + (m - a);
    }
    // ln(1 + x) = 2 (r + r^3 / 3 + r^5 / 5 ...) with r = x / (2 + x).
    let r = x / (2.0 + x);
    let square = r * r;
    let (mut sum, mut power) = (0.0, 1.0);
    for k in 1..12 {
        sum += power / f64::from(2 * k + 1);
        power *= square;
    }
    a * (x * r - 2.0 * r * square * sum)
}

/// `x^a e^-x / gamma(a + 1)`.
fn common_factor(a: f64, x: f64) -> f64 {
    exp(-stirling_error(a) - deviance(a, x) - LN_SQRT_TWO_PI) / sqrt(a)
}

/// Regularised lower incomplete gamma function P(a, x), for a > 0 and x >= 0 (NaN elsewhere).
pub fn gamma_p(a: f64, x: f64) -> f64 {
    both(a, x).0
}

/// Regularised upper incomplete gamma function Q(a, x) = 1 - P(a, x), accurate where it is small.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    both(a, x).1
}

fn both(a: f64, x: f64) -> (f64, f64) {
    if a.is_nan() || x.is_nan() || a <= 0.0 || x < 0.0 || a.is_infinite() {
        return (f64::NAN, f64::NAN);
    }
    if x == 0.0 || x == f64::INFINITY {
        return if x == 0.0 { (0.0, 1.0) } else { (1.0, 0.0) };
    }
    let factor = common_factor(a, x);
    if x < a + 1.0 {
        let (mut sum, mut term) = (1.0, 1.0);
        for k in 1..LARGEST_TERMS {
            term *= x / (a + k as f64);
            sum += term;
            if term < 1e-17 * sum {
                break;
            }
        }
        let p = (factor * sum).min(1.0);
        (p, 1.0 - p)
    } else {
        // Lentz's evaluation of 1 / (x + 1 - a - 1 (1 - a) / (x + 3 - a - ...)).
        let mut b = x + 1.0 - a;
        let (mut c, mut d) = (1e300, 1.0 / b);
        let mut value = d;
        for k in 1..LARGEST_TERMS {
            let k = k as f64;
            let numerator = -k * (k - a);
            b += 2.0;
            d = 1.0 / nonzero(numerator * d + b);
            c = nonzero(b + numerator / c);
            value *= d * c;
            if (d * c - 1.0).abs() < 1e-16 {
                break;
            }
        }
        let q = (factor * a * value).min(1.0);
        (1.0 - q, q)
    }
}

/// Lentz's guard against a zero denominator.
pub(super) fn nonzero(x: f64) -> f64 {
    if x.abs() < 1e-300 { 1e-300 } else { x }
}

/// Probability that a chi-square variable with `dof` degrees of freedom is at most x.
pub fn chi_square_cdf(x: f64, dof: f64) -> f64 {
    if x <= 0.0 { 0.0 } else { gamma_p(0.5 * dof, 0.5 * x) }
}

/// Probability that a chi-square variable with `dof` degrees of freedom exceeds x.
pub fn chi_square_sf(x: f64, dof: f64) -> f64 {
    if x <= 0.0 { 1.0 } else { gamma_q(0.5 * dof, 0.5 * x) }
}

/// The x that a chi-square variable with `dof` degrees of freedom stays below with the given probability in (0, 1).
pub fn chi_square_quantile(probability: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&probability) || dof.is_nan() || dof <= 0.0 {
        return f64::NAN;
    }
    if probability == 0.0 || probability == 1.0 {
        return if probability == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let a = 0.5 * dof;
    // Wilson & Hilferty (1931), or the first term of the series for a small probability.
    let c = 2.0 / (9.0 * dof);
    let root = 1.0 - c + normal_quantile(probability) * sqrt(c);
    let start =
        if root > 0.2 { a * root * root * root } else { pow(probability, 1.0 / a) * exp(ln_gamma(a + 1.0) / a) };
    let mut upper = 2.0 * start.max(f64::MIN_POSITIVE) + 1.0;
    while gamma_p(a, upper) < probability && gamma_q(a, upper) > 0.0 {
        upper *= 2.0;
    }
    let f = |x: f64| {
        let (p, q) = both(a, x);
        let excess = if probability < 0.5 { p - probability } else { (1.0 - probability) - q };
        (excess, common_factor(a, x) * a / x)
    };
    2.0 * newton_increasing(f, 0.0, upper, start, 2000).unwrap_or(f64::NAN)
}
