//! Sample moments by compensated sums in index order, mergeable block by block.
//!
//! Merging follows Pebay (2008, Sandia report 2008-6212). Blocks merged in their order give the same bits for any
//! assignment of blocks to workers.

use crate::math::functions::sqrt;
use crate::math::sum::{CompensatedSum, compensated};

/// Count, mean and central sums of powers of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    second: f64,
    third: f64,
    fourth: f64,
}

impl Moments {
    /// Moments of a sample in two passes; a value that is not finite makes them NaN.
    pub fn of(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        let n = values.len() as f64;
        let rough = compensated(values.iter().copied()) / n;
        let mean = rough + compensated(values.iter().map(|x| x - rough)) / n;
        let mut sums = [CompensatedSum::default(); 3];
        for x in values {
            let d = x - mean;
            let square = d * d;
            sums[0].add(square);
            sums[1].add(square * d);
            sums[2].add(square * square);
        }
        let [second, third, fourth] = sums.map(|s| s.value());
        Self { count: values.len() as u64, mean, second, third, fourth }
    }

    /// Takes in the moments of a later block.
    pub fn merge(&mut self, other: &Self) {
        if self.count == 0 || other.count == 0 {
            if self.count == 0 {
                *self = *other;
            }
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let d = other.mean - self.mean;
        let (d_n, ab) = (d / n, a * b);
        let fourth = self.fourth
            + other.fourth
            + d * d_n * d_n * d_n * ab * (a * a - ab + b * b)
            + 6.0 * d_n * d_n * (a * a * other.second + b * b * self.second)
            + 4.0 * d_n * (a * other.third - b * self.third);
        let third =
            self.third + other.third + d * d_n * d_n * ab * (a - b) + 3.0 * d_n * (a * other.second - b * self.second);
        let second = self.second + other.second + d * d_n * ab;
        *self = Self { count: self.count + other.count, mean: self.mean + b * d_n, second, third, fourth };
    }

    /// Number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean; NaN without values.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Unbiased variance (divisor n - 1); NaN below two values.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.second / (self.count as f64 - 1.0) }
    }

    /// Square root of [`Moments::variance`].
    pub fn sd(&self) -> f64 {
        sqrt(self.variance())
    }

    /// Skewness `m3 / m2^1.5` with divisor n; NaN for equal values.
    pub fn skewness(&self) -> f64 {
        let n = self.count as f64;
        self.third / n / (self.second / n * sqrt(self.second / n))
    }

    /// Kurtosis `m4 / m2^2` with divisor n (3 for a normal distribution); NaN for equal values.
    pub fn kurtosis(&self) -> f64 {
        self.fourth * self.count as f64 / (self.second * self.second)
    }

    /// Standard error of the mean, for independent values.
    pub fn mean_standard_error(&self) -> f64 {
        sqrt(self.variance() / self.count as f64)
    }

    /// Standard error of the standard deviation, for independent values of any kurtosis: half the standard error of the
    /// variance, `sqrt((m4 - m2^2 (n - 3) / (n - 1)) / n)` (Cramer 1946, 27.4), over the standard deviation.
    pub fn sd_standard_error(&self) -> f64 {
        let n = self.count as f64;
        let variance = self.variance();
        if variance == 0.0 {
            return 0.0;
        }
        let of_variance = (self.fourth / n - variance * variance * (n - 3.0) / (n - 1.0)) / n;
        sqrt(of_variance.max(0.0)) / (2.0 * sqrt(variance))
    }
}

/// Unbiased covariance of two samples of one length (divisor n - 1); NaN below two pairs.
pub fn covariance(x: &[f64], y: &[f64]) -> f64 {
    debug_assert_eq!(x.len(), y.len());
    if x.len() < 2 {
        return f64::NAN;
    }
    let (mean_x, mean_y) = (Moments::of(x).mean, Moments::of(y).mean);
    compensated(x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y))) / (x.len() as f64 - 1.0)
}

/// Pearson's correlation of two samples of one length, within -1..=1; NaN where a sample does not vary.
pub fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let spread = Moments::of(x).sd() * Moments::of(y).sd();
    if spread > 0.0 { (covariance(x, y) / spread).clamp(-1.0, 1.0) } else { f64::NAN }
}
