//! Roots of functions of one variable inside a bracket.

use thiserror::Error;

/// A root that cannot be found.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RootError {
    /// The function is not finite somewhere it was asked.
    #[error("the function is {value} at {at}, which is not finite")]
    NotFinite {
        /// Argument.
        at: f64,
        /// Value there.
        value: f64,
    },
    /// The ends do not enclose a change of sign.
    #[error("no change of sign between {lower} (value {at_lower}) and {upper} (value {at_upper})")]
    NoBracket {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
        /// Value at the lower end.
        at_lower: f64,
        /// Value at the upper end.
        at_upper: f64,
    },
    /// Too many steps.
    #[error("no root within {iterations} steps; the last argument was {at}")]
    NotConverged {
        /// Steps allowed.
        iterations: usize,
        /// Best argument so far.
        at: f64,
    },
}

/// A root of `f` between `lower` and `upper` to within `tolerance` (absolute; rounding adds `4 eps |x|`), by Brent's method
/// (Brent 1973, Algorithms for Minimization without Derivatives, chapter 4).
///
/// # Errors
/// A value that is not finite, ends of equal sign, or more than `iterations` steps.
pub fn brent<F: FnMut(f64) -> f64>(
    mut f: F,
    lower: f64,
    upper: f64,
    tolerance: f64,
    iterations: usize,
) -> Result<f64, RootError> {
    let mut evaluate = |at: f64| {
        let value = f(at);
        if value.is_finite() { Ok(value) } else { Err(RootError::NotFinite { at, value }) }
    };
    let (mut a, mut b) = (lower, upper);
    let (mut at_a, mut at_b) = (evaluate(a)?, evaluate(b)?);
    if at_a == 0.0 {
        return Ok(a);
    }
    if at_b != 0.0 && (at_a > 0.0) == (at_b > 0.0) {
        return Err(RootError::NoBracket { lower, upper, at_lower: at_a, at_upper: at_b });
    }
    // b is the best point, c the other end of the bracket, a the best point before.
    let (mut c, mut at_c) = (a, at_a);
    let mut step = b - a;
    let mut step_before = step;
    for _ in 0..iterations {
        if at_c.abs() < at_b.abs() {
            (a, b, c) = (b, c, b);
            (at_a, at_b, at_c) = (at_b, at_c, at_b);
        }
        let small = 2.0 * f64::EPSILON * b.abs() + 0.5 * tolerance;
        let half = 0.5 * (c - b);
        if half.abs() <= small || at_b == 0.0 {
            return Ok(b);
        }
        if step_before.abs() < small || at_a.abs() <= at_b.abs() {
            (step, step_before) = (half, half);
        } else {
            let s = at_b / at_a;
            let (mut p, mut q) = if a == c {
                (2.0 * half * s, 1.0 - s)
            } else {
                let (q, r) = (at_a / at_c, at_b / at_c);
                (s * (2.0 * half * q * (q - r) - (b - a) * (r - 1.0)), (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q;
            } else {
                p = -p;
            }
            if 2.0 * p < (3.0 * half * q - (small * q).abs()).min((step_before * q).abs()) {
                (step_before, step) = (step, p / q);
            } else {
                (step, step_before) = (half, half);
            }
        }
        (a, at_a) = (b, at_b);
        b += if step.abs() > small { step } else { small.copysign(half) };
        at_b = evaluate(b)?;
        if (at_b > 0.0) == (at_c > 0.0) {
            (c, at_c) = (a, at_a);
            step = b - a;
            step_before = step;
        }
    }
    Err(RootError::NotConverged { iterations, at: b })
}

/// The root of an increasing function given with its slope, by Newton's method kept inside `lower..upper` (halving where a
/// step would leave the bracket); stops when steps no longer move the argument by more than rounding.
///
/// # Errors
/// A value that is not a number, or more than `iterations` steps.
pub fn newton_increasing<F: FnMut(f64) -> (f64, f64)>(
    mut f: F,
    lower: f64,
    upper: f64,
    start: f64,
    iterations: usize,
) -> Result<f64, RootError> {
    let (mut low, mut high) = (lower, upper);
    let mut x = if low <= start && start <= high { start } else { 0.5 * (low + high) };
    for _ in 0..iterations {
        let (value, slope) = f(x);
        if value.is_nan() {
            return Err(RootError::NotFinite { at: x, value });
        }
        if value == 0.0 {
            return Ok(x);
        }
        if value > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let next = x - value / slope;
        let next = if low < next && next < high { next } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON * x.abs() || next == low || next == high {
            return Ok(next);
        }
        x = next;
    }
    Err(RootError::NotConverged { iterations, at: x })
}
