//! Tolerance limits: what holds a share of a population with a stated confidence, from a sample of it.
//!
//! Normal populations: `mean +/- k s` with Howe's factor (W. G. Howe 1969, J. Am. Statist. Assoc. 64, 610), as in the NIST/SEMATECH
//! e-Handbook, 7.2.6.3. Any population: an order statistic (S. S. Wilks 1941, Ann. Math. Statist. 12, 91).

use crate::math::functions::sqrt;
use crate::math::root::brent;
use crate::math::special::{beta_regularised, chi_square_quantile, normal_cdf, normal_quantile};

/// Precision of a margin, in standard deviations.
const PRECISION: f64 = 1e-12;
/// Most steps to find one.
const ITERATIONS: usize = 200;

/// The smallest `m >= 0` with `P(|x| <= m) = share` for a normal `x` of this mean and standard deviation (`sd >= 0`), `share` in 0..1.
pub fn symmetric_normal_margin(mean: f64, sd: f64, share: f64) -> f64 {
    let offset = mean.abs();
    if !(sd > 0.0) {
        return offset;
    }
    let excess = |z: f64| normal_cdf(z - offset / sd) - normal_cdf(-z - offset / sd) - share;
    // At the upper end the half beyond the far side alone is less than what may lie outside.
    let upper = offset / sd + normal_quantile(0.5 + 0.5 * share) + 1.0;
    brent(excess, 0.0, upper, PRECISION, ITERATIONS).map_or(f64::NAN, |z| z * sd)
}

/// Howe's factor `k`: of a normal population `mean +/- k s` holds at least `share` with this confidence, where mean and `s` are those of
/// `count` values. `None` for fewer than two.
pub fn howe_factor(count: usize, share: f64, confidence: f64) -> Option<f64> {
    let freedom = count.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
    let chi_square = chi_square_quantile(1.0 - confidence, freedom);
    Some(normal_quantile(0.5 + 0.5 * share) * sqrt(freedom * (1.0 + 1.0 / count as f64) / chi_square))
}

/// The rank (from 1) of the smallest of `count` values in ascending order that is above the quantile of `share` of any population with
/// this confidence: `P(Bin(count, share) < rank) >= confidence`. `None` where not even the largest is.
pub fn order_statistic(count: usize, share: f64, confidence: f64) -> Option<usize> {
    let is_enough = |rank: usize| {
        let at_least = beta_regularised(rank as f64, (count - rank + 1) as f64, share);
        1.0 - at_least >= confidence
    };
    // It grows with the rank.
    let ranks: Vec<usize> = (1..=count).collect();
    ranks.get(ranks.partition_point(|&rank| !is_enough(rank))).copied()
}

/// Fewest values of which the largest is above the quantile of `share` with this confidence: `1 - share^n >= confidence`.
pub fn fewest_for_order_statistic(share: f64, confidence: f64) -> u64 {
    let fewest = crate::math::functions::ln(1.0 - confidence) / crate::math::functions::ln(share);
    fewest.ceil() as u64
}
