//! Statistics of measured minus predicted, as test reports give them.

use super::output::Deviation;
use super::readings::Row;
use crate::math::special::chi_square_quantile;

/// Statistics of some deviations (in order), with the share whose magnitude is at most `limit` (all, without one).
///
/// Mean, standard deviation about it with `n - 1`, root mean square, largest magnitude; zeros without a reading.
pub fn deviation(values: &[f64], limit: Option<f64>) -> Deviation {
    if values.is_empty() {
        return Deviation::default();
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let about_mean: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    let square: f64 = values.iter().map(|v| v * v).sum();
    let within = limit.map_or(values.len(), |limit| values.iter().filter(|v| v.abs() <= limit).count());
    Deviation {
        count: values.len() as u64,
        mean,
        sd: if values.len() > 1 { (about_mean / (count - 1.0)).sqrt() } else { 0.0 },
        rmse: (square / count).sqrt(),
        max: values.iter().fold(0.0, |largest: f64, v| largest.max(v.abs())),
        within_limit: within as f64 / count,
    }
}

/// The range in which the RMSE of `count` readings lies with 95 % probability when only white noise is at work.
pub fn noise_rmse(sigma: f64, count: u64) -> [f64; 2] {
    if count == 0 {
        return [0.0, 0.0];
    }
    let count = count as f64;
    [0.025, 0.975].map(|p| sigma * (chi_square_quantile(p, count) / count).sqrt())
}

/// The unit that limits in kelvin and statistics over several sensors are about.
pub const KELVIN: &str = "K";

/// The unit of the readings over which statistics of several sensors have a meaning: kelvin, or, where none is in kelvin, that
/// of the first. Kelvins and amperes have no mean.
pub fn common_unit<'r>(rows: impl Iterator<Item = Row<&'r str>>) -> &'r str {
    let mut first = None;
    for row in rows {
        if row.unit == KELVIN {
            return KELVIN;
        }
        first.get_or_insert(row.unit);
    }
    first.unwrap_or(KELVIN)
}
