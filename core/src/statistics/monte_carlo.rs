//! Estimates by Monte Carlo with their standard errors: whether two of the same quantity differ by more than these tell,
//! for a family of quantities at one level.
//!
//! A standard error is itself an estimate. Its degrees of freedom say how good: `2 / v`, where `v` is the relative variance
//! of its square. Two independent estimates are compared by Welch's (1947) `t = (b - a) / sqrt(s_a^2 + s_b^2)` with the
//! degrees of freedom of Satterthwaite (1946), a family of comparisons by Holm's (1979) step-down procedure, which needs no
//! independence.

use serde::{Deserialize, Serialize};

use crate::math::functions::sqrt;
use crate::math::sort::sort_by;
use crate::math::special::{normal_cdf, normal_quantile, student_t_cdf, student_t_quantile};

/// Relative differences up to this are rounding, or where a solver stops, whatever the standard errors say.
const ROUNDING: f64 = 1e-9;
/// From here on Student's t is a normal distribution to the accuracy that matters.
const NORMAL: f64 = 1e6;

/// A standard error and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StandardError {
    /// In the unit of what it is the error of; 0 or more.
    pub standard_error: f64,
    /// Degrees of freedom of its square, above 0; `null` where it is known well enough for a normal distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
}

impl StandardError {
    /// Nothing where it is no number or negative, or has no degree of freedom.
    pub fn new(standard_error: f64, degrees_of_freedom: Option<f64>) -> Option<Self> {
        let is_known = degrees_of_freedom.is_none_or(|degrees| degrees > 0.0);
        (standard_error >= 0.0 && standard_error.is_finite() && is_known).then_some(Self {
            standard_error,
            degrees_of_freedom: degrees_of_freedom.filter(|degrees| *degrees < NORMAL),
        })
    }

    /// Of an estimate with a 95 % interval of normal form: half its width by the normal quantile.
    pub fn of_interval(lower: f64, upper: f64) -> Option<Self> {
        Self::new(0.5 * (upper - lower) / -normal_quantile(0.025), None)
    }

    /// Of a mean of independent replicates with Student's 95 % interval from their scatter.
    pub fn of_replicates(lower: f64, upper: f64, replicates: u64) -> Option<Self> {
        let degrees = replicates.checked_sub(1).filter(|degrees| *degrees > 0)? as f64;
        Self::new(0.5 * (upper - lower) / student_t_quantile(0.975, degrees), Some(degrees))
    }

    /// Error of the difference of two independent estimates.
    pub fn of_difference(self, other: Self) -> Self {
        let squares = [self, other].map(|error| error.standard_error * error.standard_error);
        let both = squares[0] + squares[1];
        let part = |square: f64, degrees: Option<f64>| degrees.map_or(0.0, |degrees| square * square / degrees);
        let parts = part(squares[0], self.degrees_of_freedom) + part(squares[1], other.degrees_of_freedom);
        Self {
            standard_error: sqrt(both),
            degrees_of_freedom: (parts > 0.0).then(|| both * both / parts).filter(|degrees| *degrees < NORMAL),
        }
    }

    /// Probability of a difference of at least this size, either way, where there is none.
    pub fn two_sided_p(self, difference: f64) -> f64 {
        if difference == 0.0 {
            return 1.0;
        }
        let t = -(difference / self.standard_error).abs();
        2.0 * self.degrees_of_freedom.map_or_else(|| normal_cdf(t), |degrees| student_t_cdf(t, degrees))
    }

    /// The smallest difference, as this is the error of, that a two-sided test at a level finds with a probability of
    /// `power` (both in 0..1): the quantile at which it is found and that of the power beyond it, times the error. The
    /// second is of the central distribution, which is exact for a known error.
    pub fn detectable(self, level: f64, power: f64) -> f64 {
        let quantile = |probability: f64| {
            let of_student = |degrees| student_t_quantile(probability, degrees);
            self.degrees_of_freedom.map_or_else(|| normal_quantile(probability), of_student)
        };
        self.standard_error * (quantile(power) - quantile(0.5 * level))
    }
}

/// How two estimates of one quantity differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Second less first.
    pub difference: f64,
    /// Error of the difference.
    pub error: StandardError,
    /// Probability of a difference of at least this size, either way, where there is none.
    pub p: f64,
}

impl Comparison {
    /// Compares two independent estimates, each with its error.
    pub fn of(before: (f64, StandardError), after: (f64, StandardError)) -> Self {
        let (difference, error) = (after.0 - before.0, before.1.of_difference(after.1));
        let is_rounding = difference.abs() <= ROUNDING * before.0.abs().max(after.0.abs());
        Self { difference, error, p: if is_rounding { 1.0 } else { error.two_sided_p(difference) } }
    }
}

/// Which hypotheses are rejected at a family-wise level (Holm 1979): in rising order of `p`, the k-th of m (from 0) as long as
/// `p (m - k)` is at most the level.
pub fn holm(p: &[f64], level: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    sort_by(&mut order, |&a, &b| p[a].total_cmp(&p[b]));
    let mut rejected = vec![false; p.len()];
    for (position, &index) in order.iter().enumerate() {
        if !(p[index] * (p.len() - position) as f64 <= level) {
            break;
        }
        rejected[index] = true;
    }
    rejected
}
