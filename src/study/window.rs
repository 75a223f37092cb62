//! Statistics of a stretch of a time series: mean, slope, and how far both can be trusted.
//!
//! A straight line is fitted by least squares. The standard error of its slope is `s / sqrt(Sxx)` and that of the
//! mean `s / sqrt(n)`, with `s` the residuals' standard deviation (n - 2); both are multiplied by
//! `sqrt((1 + r) / (1 - r))` where the residuals' correlation `r` from one reading to the next is positive, since
//! neighbouring readings of a thermometer seldom err apart (Bartlett 1935, for a first-order process).

/// What a window says about one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Number of readings.
    pub count: usize,
    /// Mean reading.
    pub mean: f64,
    /// Standard error of the mean about the line; from three readings on.
    pub mean_error: Option<f64>,
    /// Slope, unit of the reading a second; from two readings on.
    pub slope: Option<f64>,
    /// Standard error of the slope; from three readings on.
    pub slope_error: Option<f64>,
}

/// Largest correlation allowed for: beyond it the series says next to nothing about its own noise.
const LARGEST_CORRELATION: f64 = 0.99;

/// Statistics of the readings at these instants (s, strictly increasing); `None` without readings.
pub fn window(times_s: &[f64], readings: &[f64]) -> Option<Window> {
    let count = times_s.len().min(readings.len());
    if count == 0 {
        return None;
    }
    let n = count as f64;
    let mean = readings[..count].iter().sum::<f64>() / n;
    let mean_time = times_s[..count].iter().sum::<f64>() / n;
    let mut sxx = 0.0;
    let mut sxy = 0.0;
    for i in 0..count {
        let dt = times_s[i] - mean_time;
        sxx += dt * dt;
        sxy += dt * (readings[i] - mean);
    }
    let slope = (count >= 2 && sxx > 0.0).then(|| sxy / sxx);
    let mut result = Window { count, mean, mean_error: None, slope, slope_error: None };
    if let (Some(slope), true) = (slope, count >= 3) {
        let residual = |i: usize| readings[i] - mean - slope * (times_s[i] - mean_time);
        let mut sum = 0.0;
        let mut neighbours = 0.0;
        for i in 0..count {
            sum += residual(i) * residual(i);
            if i + 1 < count {
                neighbours += residual(i) * residual(i + 1);
            }
        }
        let correlation = if sum > 0.0 { (neighbours / sum).clamp(0.0, LARGEST_CORRELATION) } else { 0.0 };
        let s = (sum / (n - 2.0)).sqrt() * ((1.0 + correlation) / (1.0 - correlation)).sqrt();
        result.mean_error = Some(s / n.sqrt());
        result.slope_error = Some(s / sxx.sqrt());
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Residuals +1 +1 -1 -1 -1 -1 +1 +1: orthogonal to the line, SSE 8, neighbouring products 1 - 1 + 1 + 1 + 1 - 1
    /// + 1 = 3, r = 3/8, factor sqrt((11/8)/(5/8)) = sqrt(2.2); s = sqrt(8/6), n = 8.
    #[test]
    fn correlated_noise_widens_the_errors() {
        let times: Vec<f64> = (0..8).map(f64::from).collect();
        let window = window(&times, &[1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0]).expect("readings");
        let expected = (8.0_f64 / 6.0 * 2.2 / 8.0).sqrt();
        assert!((window.mean_error.expect("error") - expected).abs() < 1e-15);
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
