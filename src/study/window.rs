//! Statistics of a stretch of a time series: mean, slope, and how far both can be trusted.
//!
//! A straight line is fitted by least squares. The scatter is taken about a parabola (from six readings on, else about
//! the line), since an approach to equilibrium bends and what bends is no noise: `s^2 = SSE / (n - k)`. The standard
//! error of the slope is `s / sqrt(Sxx)` and that of the mean `s / sqrt(n)`; both are multiplied by
//! `sqrt((1 + r) / (1 - r))` where the correlation `r` of the scatter from one reading to the next is positive, since
//! neighbouring readings of a thermometer seldom err apart (Bartlett 1935, for a first-order process). An estimated `r`
//! is too small by about `(1 + 4 r) / n` (Kendall 1954, Marriott and Pope 1954), which is added. The slope is judged by
//! Student's t with `n (1 - r) / (1 + r) - k` degrees of freedom, at least one.

use crate::math::functions::sqrt;
use crate::math::special::student_t_cdf;

/// What a window says about one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Number of readings.
    pub count: usize,
    /// Mean reading.
    pub mean: f64,
    /// Standard error of the mean; from three readings on.
    pub mean_error: Option<f64>,
    /// Slope, unit of the reading a second; from two readings on.
    pub slope: Option<f64>,
    /// Standard error of the slope; from three readings on.
    pub slope_error: Option<f64>,
    /// Probability of so steep a slope, up or down, from the scatter alone; from three readings on.
    pub chance: Option<f64>,
}

/// Largest correlation allowed for: beyond it the series says next to nothing about its own noise.
const LARGEST_CORRELATION: f64 = 0.99;
/// Readings from which a parabola is fitted.
const PARABOLA_FROM: usize = 6;
/// A line that rises or falls by so many times the scatter about it, over as many readings at least as the second
/// number, is no scatter: noise as slow as the window itself is a drift.
const BEYOND_SCATTER: f64 = 6.0;
const BEYOND_SCATTER_FROM: usize = 8;

/// Statistics of the readings at these instants (s, strictly increasing); `None` without readings.
pub fn window(times_s: &[f64], readings: &[f64]) -> Option<Window> {
    let count = times_s.len().min(readings.len());
    if count == 0 {
        return None;
    }
    let n = count as f64;
    let mean = readings[..count].iter().sum::<f64>() / n;
    let mean_time = times_s[..count].iter().sum::<f64>() / n;
    let (mut sxx, mut sxxx, mut sxy) = (0.0, 0.0, 0.0);
    for i in 0..count {
        let dt = times_s[i] - mean_time;
        sxx += dt * dt;
        sxxx += dt * dt * dt;
        sxy += dt * (readings[i] - mean);
    }
    let slope = (count >= 2 && sxx > 0.0).then(|| sxy / sxx);
    let mut result = Window { count, mean, mean_error: None, slope, slope_error: None, chance: None };
    if let (Some(slope), true) = (slope, count >= 3) {
        let dt = |i: usize| times_s[i] - mean_time;
        let about_line: Vec<f64> = (0..count).map(|i| readings[i] - mean - slope * dt(i)).collect();
        let line_scatter = sqrt(about_line.iter().map(|d| d * d).sum::<f64>() / (n - 2.0));
        // The parabola that is orthogonal to the line.
        let bend = |i: usize| dt(i) * dt(i) - sxxx / sxx * dt(i) - sxx / n;
        let (mut bends, mut with_bend) = (0.0, 0.0);
        if count >= PARABOLA_FROM {
            for (i, d) in about_line.iter().enumerate() {
                bends += bend(i) * bend(i);
                with_bend += bend(i) * d;
            }
        }
        let (curvature, fitted) = if bends > 0.0 { (with_bend / bends, 3.0) } else { (0.0, 2.0) };
        let scatter: Vec<f64> = about_line.iter().enumerate().map(|(i, d)| d - curvature * bend(i)).collect();
        let sum: f64 = scatter.iter().map(|d| d * d).sum();
        let neighbours: f64 = scatter.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let estimated = if sum > 0.0 { (neighbours / sum).max(0.0) } else { 0.0 };
        let too_small = if estimated > 0.0 { (1.0 + 4.0 * estimated) / n } else { 0.0 };
        let correlation = (estimated + too_small).min(LARGEST_CORRELATION);
        let inflation = (1.0 + correlation) / (1.0 - correlation);
        let s = sqrt(sum / (n - fitted) * inflation);
        let slope_error = s / sqrt(sxx);
        let freedom = (n / inflation - fitted).max(1.0);
        let change = (slope * (times_s[count - 1] - times_s[0])).abs();
        let is_beyond = count >= BEYOND_SCATTER_FROM && change > BEYOND_SCATTER * line_scatter;
        result.mean_error = Some(s / sqrt(n));
        result.slope_error = Some(slope_error);
        result.chance = Some(if slope == 0.0 {
            1.0
        } else if is_beyond || slope_error == 0.0 {
            0.0
        } else {
            2.0 * student_t_cdf(-(slope / slope_error).abs(), freedom)
        });
    }
    Some(result)
}
