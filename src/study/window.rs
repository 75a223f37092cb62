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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::functions::exp;
    use crate::random::StreamKey;

    #[test]
    fn a_straight_line_has_its_slope_and_no_error() {
        let times: Vec<f64> = (0..11).map(f64::from).collect();
        let readings: Vec<f64> = times.iter().map(|t| 290.0 + 0.25 * t).collect();
        let window = window(&times, &readings).expect("readings");
        assert_eq!((window.count, window.mean, window.slope), (11, 291.25, Some(0.25)));
        assert_eq!((window.mean_error, window.slope_error), (Some(0.0), Some(0.0)));
    }

    /// Residuals +1, -1, -1, +1 about a flat line at t = 0, 1, 2, 3: slope 0, SSE 4, s = sqrt(2), Sxx = 5;
    /// neighbouring products -1 + 1 - 1 = -1, so no correction.
    #[test]
    fn alternating_noise_has_the_textbook_errors() {
        let window = window(&[0.0, 1.0, 2.0, 3.0], &[6.0, 4.0, 4.0, 6.0]).expect("readings");
        assert_eq!((window.mean, window.slope), (5.0, Some(0.0)));
        assert!((window.mean_error.expect("error") - (2.0_f64 / 4.0).sqrt()).abs() < 1e-15);
        assert!((window.slope_error.expect("error") - (2.0_f64 / 5.0).sqrt()).abs() < 1e-15);
    }

    /// About its parabola a bent approach has no scatter, however much about its line.
    #[test]
    fn what_bends_is_no_noise() {
        let times: Vec<f64> = (0..8).map(f64::from).collect();
        let readings: Vec<f64> = times.iter().map(|t| 290.0 + 3.0 * t - 0.2 * t * t).collect();
        let window = window(&times, &readings).expect("readings");
        assert!((window.slope.expect("a slope") - 1.6).abs() < 1e-12);
        assert!(window.slope_error.expect("an error") < 1e-12 && window.chance.expect("a chance") < 1e-6);
    }

    /// Noise of a first-order process, with the correlation from one reading to the next.
    fn noise(seed: u64, count: usize, correlation: f64) -> Vec<f64> {
        let mut stream = StreamKey::new(seed, "window", "noise").stream(0);
        let mut value = stream.normal();
        (0..count)
            .map(|_| {
                let now = value;
                value = correlation * value + (1.0 - correlation * correlation).sqrt() * stream.normal();
                now
            })
            .collect()
    }

    /// In a thousand windows of pure noise the slope looks real at 1 % in about ten: no more than 2 % of them where the
    /// noise is white, and no more than 8 % where neighbours agree by 0.5 and there are few readings.
    #[test]
    fn noise_is_seldom_a_drift() {
        for (count, correlation, most) in [(8, 0.0, 20), (30, 0.0, 20), (120, 0.0, 20), (30, 0.5, 80), (120, 0.5, 40)] {
            let times: Vec<f64> = (0..count).map(|i| 60.0 * i as f64).collect();
            let detected = (0..1000)
                .filter(|&seed| window(&times, &noise(seed, count, correlation)).is_some_and(|w| w.chance < Some(0.01)))
                .count();
            assert!(detected <= most, "{detected} of 1000 with {count} readings and a correlation of {correlation}");
        }
    }

    /// An approach to equilibrium by one scatter a time constant is seen, over windows of a third of it to three.
    #[test]
    fn an_approach_to_equilibrium_is_a_drift() {
        for lengths in [0.3, 1.0, 3.0] {
            let times: Vec<f64> = (0..60).map(f64::from).collect();
            let detected = (0..100)
                .filter(|&seed| {
                    let scatter = noise(seed, 60, 0.0);
                    let reading = |(t, e): (&f64, &f64)| 20.0 * exp(-t / 59.0 * lengths) + e;
                    let readings: Vec<f64> = times.iter().zip(&scatter).map(reading).collect();
                    window(&times, &readings).is_some_and(|w| w.chance < Some(0.01))
                })
                .count();
            assert!(detected >= 99, "{detected} of 100 over {lengths} time constants");
        }
    }

    #[test]
    fn few_readings_say_less() {
        assert_eq!(window(&[], &[]), None);
        let one = window(&[5.0], &[2.0]).expect("a reading");
        assert_eq!((one.mean, one.slope, one.mean_error), (2.0, None, None));
        let two = window(&[0.0, 2.0], &[1.0, 2.0]).expect("readings");
        assert_eq!((two.slope, two.slope_error), (Some(0.5), None));
    }
}
