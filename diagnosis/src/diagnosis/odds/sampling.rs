//! How far chance decides between two sets that are both a little wrong.
//!
//! A log Bayes factor holds one of its models for true. Where none is, it says which of them stands nearer to these data, and other
//! data of the kind would give another one. The sum of the differences of log likelihoods has a standard error, which the
//! scatter between stretches of the data shows (Vuong 1989, Econometrica 57, 307, section 4; blocks instead of single readings, as
//! neighbours are alike).

use crate::math::special::student_t_cdf;

/// Standard error of the sum of the differences of two sets' log likelihoods, block by block, and its degrees of freedom; `None`
/// with fewer than two blocks, or where it is no number above 0.
pub fn standard_error(one: &[f64], other: &[f64]) -> Option<(f64, f64)> {
    let differences: Vec<f64> = one.iter().zip(other).map(|(one, other)| one - other).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let square: f64 = differences.iter().map(|difference| (difference - mean) * (difference - mean)).sum();
    let se = (count / (count - 1.0) * square).sqrt();
    (count > 1.0 && se.is_finite() && se > 0.0).then_some((se, count - 1.0))
}

/// Odds that a set which stands behind by a lag in log odds is the nearer one all the same, by chance alone; at most 1.
pub fn odds_by_chance(lag: f64, (se, freedom): (f64, f64)) -> f64 {
    let behind = student_t_cdf(-lag.max(0.0) / se, freedom);
    if behind.is_finite() { behind / (1.0 - behind) } else { 0.0 }
}
