//! The beta family: regularised incomplete beta function, Student's t and Fisher's F.
//!
//! Continued fraction of Abramowitz & Stegun 26.5.8; the common factor by Loader's (2000) saddle point form.

use super::gamma::{deviance, nonzero, stirling_error};
use super::normal::normal_quantile;
use crate::math::functions::{exp, ln, ln_1p, ln_gamma, pow, sqrt};
use crate::math::root::newton_increasing;

/// Regularised incomplete beta function I_x(a, b), for a, b > 0 and x in 0..=1 (NaN elsewhere).
pub fn beta_regularised(a: f64, b: f64, x: f64) -> f64 {
    pair(a, b, x, 1.0 - x).0
}

/// `x^a y^b / B(a, b)` with y = 1 - x.
fn common_factor(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let n = a + b;
    let exponent = stirling_error(n) - stirling_error(a) - stirling_error(b) - deviance(a, n * x) - deviance(b, n * y);
    exp(exponent) * sqrt(a * b / (2.0 * std::f64::consts::PI * n))
}

/// I_x(a, b) and its complement, from x and y = 1 - x, so that neither loses digits near 0.
fn pair(a: f64, b: f64, x: f64, y: f64) -> (f64, f64) {
    let valid = a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite() && x >= 0.0 && y >= 0.0;
    if !valid {
        return (f64::NAN, f64::NAN);
    }
    if x == 0.0 || y == 0.0 {
        return if x == 0.0 { (0.0, 1.0) } else { (1.0, 0.0) };
    }
    let factor = common_factor(a, b, x, y);
    if x <= (a + 1.0) / (a + b + 2.0) {
        let value = (factor * fraction(a, b, x) / a).min(1.0);
        (value, 1.0 - value)
    } else {
        let value = (factor * fraction(b, a, y) / b).min(1.0);
        (1.0 - value, value)
    }
}

/// Lentz's evaluation of the continued fraction.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    let mut c = 1.0;
    let mut d = 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for m in 1..100_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / nonzero(1.0 + even * d);
        c = nonzero(1.0 + even / c);
        value *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / nonzero(1.0 + odd * d);
        c = nonzero(1.0 + odd / c);
        value *= d * c;
        if (d * c - 1.0).abs() < 1e-16 {
            break;
        }
    }
    value
}

/// The x with I_x(a, b) equal to the given probability in 0..=1.
pub fn beta_quantile(probability: f64, a: f64, b: f64) -> f64 {
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    if probability == 0.0 || probability == 1.0 {
        return probability;
    }
    let f = |x: f64| {
        let (p, q) = pair(a, b, x, 1.0 - x);
        let excess = if probability < 0.5 { p - probability } else { (1.0 - probability) - q };
        (excess, common_factor(a, b, x, 1.0 - x) / (x * (1.0 - x)))
    };
    newton_increasing(f, 0.0, 1.0, a / (a + b), 2000).unwrap_or(f64::NAN)
}

/// Probability that Student's t with `dof` degrees of freedom is at most t; accurate in the lower tail.
pub fn student_t_cdf(t: f64, dof: f64) -> f64 {
    if t.is_infinite() {
        return f64::from(t > 0.0);
    }
    let total = dof + t * t;
    let tail = 0.5 * pair(0.5 * dof, 0.5, dof / total, t * t / total).0;
    if t > 0.0 { 1.0 - tail } else { tail }
}

/// The t that Student's t with `dof` degrees of freedom stays below with the given probability in (0, 1).
pub fn student_t_quantile(probability: f64, dof: f64) -> f64 {
    let valid = 0.0 < probability && probability < 1.0 && dof > 0.0 && dof.is_finite();
    if !valid {
        return f64::NAN;
    }
    if probability > 0.5 {
        return -student_t_quantile(1.0 - probability, dof);
    }
    if probability == 0.5 {
        return 0.0;
    }
    let ln_density_at_zero = ln_gamma(0.5 * dof + 0.5) - ln_gamma(0.5 * dof) - 0.5 * ln(dof * std::f64::consts::PI);
    let f = |t: f64| {
        let density = exp(ln_density_at_zero - 0.5 * (dof + 1.0) * ln_1p(t * t / dof));
        (student_t_cdf(t, dof) - probability, density)
    };
    // The far tail is a power of t; the quantile lies between twice its inverse and zero.
    let start = normal_quantile(probability);
    let mut lower = 2.0 * start - sqrt(dof) * pow(probability, -1.0 / dof);
    while student_t_cdf(lower, dof) > probability {
        lower *= 4.0;
    }
    newton_increasing(f, lower, 0.0, start, 2000).unwrap_or(f64::NAN)
}

/// Probability that Fisher's F with the given degrees of freedom is at most x.
pub fn fisher_f_cdf(x: f64, numerator_dof: f64, denominator_dof: f64) -> f64 {
    fisher_f(x, numerator_dof, denominator_dof).0
}

/// Probability that Fisher's F with the given degrees of freedom exceeds x.
pub fn fisher_f_sf(x: f64, numerator_dof: f64, denominator_dof: f64) -> f64 {
    fisher_f(x, numerator_dof, denominator_dof).1
}

fn fisher_f(x: f64, numerator_dof: f64, denominator_dof: f64) -> (f64, f64) {
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    let total = numerator_dof * x + denominator_dof;
    pair(0.5 * numerator_dof, 0.5 * denominator_dof, numerator_dof * x / total, denominator_dof / total)
}
