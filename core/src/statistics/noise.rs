//! The noise of a series that is read row by row.

use super::quantile::{quantile_sorted, sorted};
use crate::math::functions::sqrt;

/// A normal distribution's standard deviation over its median absolute deviation (P. J. Rousseeuw, C. Croux, J. Am. Stat.
/// Assoc. 88, 1273, 1993).
pub const OF_MEDIAN: f64 = 1.4826;
/// Second differences below which nothing is said.
const FEWEST: usize = 8;

/// Standard deviation of what is not smooth in a series, in its unit: of its second differences, whose variance is six
/// times that of independent noise, by their median. 0 where most of them are 0. None below ten values.
pub fn noise(values: &[f64]) -> Option<f64> {
    let second: Vec<f64> = values.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs()).collect();
    (second.len() >= FEWEST).then(|| OF_MEDIAN * quantile_sorted(&sorted(&second), 0.5) / sqrt(6.0))
}
