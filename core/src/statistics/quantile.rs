//! Quantiles of a sample and their standard errors.

use crate::math::functions::sqrt;
use crate::math::special::beta_regularised;
use crate::math::sum::CompensatedSum;

/// The values in rising order (NaN last).
pub fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Quantile of a sorted sample at probability p in 0..=1: linear between order statistics at (n - 1) p (Hyndman & Fan 1996,
/// type 7). NaN for an empty sample.
pub fn quantile_sorted(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let position = p.clamp(0.0, 1.0) * last as f64;
    let below = (position as usize).min(last);
    let share = position - below as f64;
    if share == 0.0 { sorted[below] } else { sorted[below] * (1.0 - share) + sorted[(below + 1).min(last)] * share }
}

/// Standard error of a quantile of a sorted sample of independent values (Maritz & Jarrett 1978): the spread of the order
/// statistic at (n + 1) p under the sample's own distribution. NaN below two values or for p outside (0, 1).
pub fn quantile_standard_error_sorted(sorted: &[f64], p: f64) -> f64 {
    let n = sorted.len() as f64;
    if sorted.len() < 2 || !(0.0 < p && p < 1.0) {
        return f64::NAN;
    }
    let (a, b) = ((n + 1.0) * p, (n + 1.0) * (1.0 - p));
    // Ranks further off carry less than 1e-15 of the weight.
    let reach = 9.0 * sqrt(n * p * (1.0 - p)) + 40.0;
    let first = (n * p - reach).max(0.0) as usize;
    let end = ((n * p + reach) as usize + 1).min(sorted.len());
    if sorted[first] == sorted[end - 1] {
        return 0.0;
    }
    let middle = quantile_sorted(sorted, p);
    // The weights change over sqrt(n p (1 - p)) ranks. Ranks closer than a fiftieth of that share their group's weight
    // evenly, which changes the error by less than 1e-4 of itself.
    let stride = ((sqrt(n * p * (1.0 - p)) / 50.0) as usize).max(1);
    let (mut mean, mut square) = (CompensatedSum::default(), CompensatedSum::default());
    let mut before = beta_regularised(a, b, first as f64 / n);
    let mut after = first;
    for group in sorted[first..end].chunks(stride) {
        after += group.len();
        let up_to = beta_regularised(a, b, after as f64 / n);
        let weight = (up_to - before) / group.len() as f64;
        before = up_to;
        for x in group {
            mean.add(weight * (x - middle));
            square.add(weight * (x - middle) * (x - middle));
        }
    }
    sqrt((square.value() - mean.value() * mean.value()).max(0.0))
}
