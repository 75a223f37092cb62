//! Estimates by Monte Carlo with their standard errors: whether two of the same quantity differ by more than these tell,
//! for a family of quantities at one level.
//!
//! A standard error is itself an estimate. Its degrees of freedom say how good: `2 / v`, where `v` is the relative variance
//! of its square. Two independent estimates are compared by Welch's (1947) `t = (b - a) / sqrt(s_a^2 + s_b^2)` with the
//! degrees of freedom of Satterthwaite (1946), a family of comparisons by Holm's (1979) step-down procedure, which needs no
//! independence.

use serde::{Deserialize, Serialize};

use crate::math::functions::sqrt;
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
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut rejected = vec![false; p.len()];
    for (position, &index) in order.iter().enumerate() {
        if !(p[index] * (p.len() - position) as f64 <= level) {
            break;
        }
        rejected[index] = true;
    }
    rejected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::StreamKey;

    #[test]
    fn the_degrees_of_freedom_are_those_of_satterthwaite() {
        let error = |s, degrees| StandardError::new(s, degrees).unwrap();
        let difference = error(3.0, Some(4.0)).of_difference(error(4.0, Some(9.0)));
        assert_eq!(difference.standard_error, 5.0);
        assert!((difference.degrees_of_freedom.unwrap() - 625.0 / (81.0 / 4.0 + 256.0 / 9.0)).abs() < 1e-12);
        assert_eq!(error(3.0, None).of_difference(error(4.0, None)).degrees_of_freedom, None);
        assert_eq!(error(1.0, Some(1e9)).degrees_of_freedom, None);
        assert!([f64::NAN, -1.0, f64::INFINITY].iter().all(|&s| StandardError::new(s, None).is_none()));
        assert!(StandardError::new(1.0, Some(0.0)).is_none());
    }

    #[test]
    fn p_is_that_of_student() {
        // Table of Student's distribution: t = 2.776 at 4 degrees of freedom is the two-sided 5 %.
        let error = StandardError::new(1.0, Some(4.0)).unwrap();
        assert!((error.two_sided_p(2.776_445) - 0.05).abs() < 1e-6);
        assert!((StandardError::new(2.0, None).unwrap().two_sided_p(-3.919_928) - 0.05).abs() < 1e-6);
        let exact = StandardError::new(0.0, None).unwrap();
        assert_eq!(Comparison::of((2.0, exact), (2.0, exact)).p, 1.0);
        assert_eq!(Comparison::of((2.0, exact), (2.0 + 1e-10, exact)).p, 1.0, "rounding");
        assert_eq!(Comparison::of((2.0, exact), (2.1, exact)).p, 0.0);
    }

    #[test]
    fn intervals_give_their_errors_back() {
        let interval = crate::statistics::Interval::normal(10.0, 2.0, 0.95);
        let error = StandardError::of_interval(interval.lower, interval.upper).unwrap();
        assert!((error.standard_error - 2.0).abs() < 1e-12);
        let replicates = [1.0, 2.0, 3.0, 4.0];
        let estimate = crate::statistics::sobol_indices::Estimate::of(&replicates);
        let error = StandardError::of_replicates(estimate.lower, estimate.upper, 4).unwrap();
        assert!((error.standard_error - (5.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(error.degrees_of_freedom, Some(3.0));
        assert!(StandardError::of_replicates(0.0, 1.0, 1).is_none());
    }

    #[test]
    fn holm_steps_down() {
        // 0.01 * 4 and 0.013 * 3 pass at 0.05, 0.03 * 2 does not, nor what follows.
        assert_eq!(holm(&[0.03, 0.01, 0.04, 0.013], 0.05), [false, true, false, true]);
        assert_eq!(holm(&[], 0.05), [false; 0]);
        assert_eq!(holm(&[f64::NAN, 0.001], 0.05), [false, true], "what has no p is not found to differ");
    }

    #[test]
    fn what_is_detectable_is_found_with_the_power_stated() {
        // Means of 8 normal numbers with the error from their scatter. Two errors of the share of 20000: 0.0042.
        let key = StreamKey::new(3, "monte carlo", "test");
        let mean = |index, shift: f64| {
            let mut stream = key.stream(index);
            let x: Vec<f64> = (0..8).map(|_| stream.normal() + shift).collect();
            let mean = x.iter().sum::<f64>() / 8.0;
            let square = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 7.0 / 8.0;
            (mean, StandardError::new(square.sqrt(), Some(7.0)).unwrap())
        };
        let known = StandardError::new(0.5, None).unwrap();
        let (mut found, mut wrong) = (0, 0);
        let (level, pairs) = (0.01, 20_000);
        for pair in 0..pairs {
            let shift = known.detectable(level, 0.9);
            let difference = key.stream(1_000_000 + pair).normal() * 0.5 + shift;
            found += u32::from(known.two_sided_p(difference) <= level);
            let comparison = Comparison::of(mean(2 * pair, 0.0), mean(2 * pair + 1, 0.0));
            wrong += u32::from(comparison.p <= level);
        }
        let share = |count: u32| f64::from(count) / pairs as f64;
        assert!((share(found) - 0.9).abs() < 0.0085, "{found}");
        assert!((share(wrong) - level).abs() < 0.0028, "{wrong}");
    }
}
