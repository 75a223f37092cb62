//! Noise of a sensor over time, and the whitening of its differences.
//!
//! White: `e_k = d_k / s`. Ornstein-Uhlenbeck on irregular instants, `phi = exp(-dt / tau)`:
//! `e_k = (d_k - phi d_(k-1)) / (s sqrt(1 - phi^2))`, the first row `d / s` (Uhlenbeck & Ornstein 1930). Both together:
//! the innovations of a scalar Kalman filter, whose derivatives are carried along.

use crate::inference::target::Rejected;
use crate::math::functions::{exp, exp_m1, ln};
use crate::measurement::total_sd;
use crate::measurement::unknown::Value;

/// Noise of a sensor: its numbers are known or unknowns of the likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation, SI; of the correlated part where there is one.
    pub sigma: Value,
    /// Correlation time, s; `None`: white.
    pub correlation_time_s: Option<Value>,
    /// Standard deviation of white noise beside it, SI.
    pub white: Option<Value>,
}

/// Differences of one sensor and what becomes of them, in place.
pub struct Series<'a> {
    /// Instants of the readings, s.
    pub times_s: &'a [f64],
    /// Differences, replaced by whitened residuals.
    pub values: &'a mut [f64],
    /// Derivatives of the differences, `readings x unknowns` (empty if not wanted), replaced by those of the residuals.
    pub jacobian: &'a mut [f64],
    /// Receives minus the logarithm of each reading's standard deviation given those before it.
    pub log_scales: &'a mut [f64],
    /// Receives, added, the derivatives of the sum of `log_scales` (empty if not wanted).
    pub scale_gradient: &'a mut [f64],
}

/// A function with its last value: most rows are as far apart as those before them.
struct Remembered<F> {
    function: F,
    at: f64,
    value: f64,
}

impl<F: Fn(f64) -> f64> Remembered<F> {
    fn new(function: F) -> Self {
        Self { function, at: f64::NAN, value: f64::NAN }
    }

    fn of(&mut self, at: f64) -> f64 {
        if at != self.at {
            (self.at, self.value) = (at, (self.function)(at));
        }
        self.value
    }
}

impl Noise {
    /// Standard deviation of one reading alone.
    pub fn total(&self, unknowns: &[f64]) -> f64 {
        let (sigma, white) = (self.sigma.at(unknowns), self.white.map_or(0.0, |white| white.at(unknowns)));
        total_sd(sigma, white)
    }

    /// Derivatives of [`Noise::total`]: place of the unknown and slope, of `sigma` and of `white`.
    pub fn total_slopes(&self, unknowns: &[f64]) -> [Option<(usize, f64)>; 2] {
        let total = self.total(unknowns);
        let slope = |value: Value| value.place().map(|place| (place, value.at(unknowns) / total));
        [slope(self.sigma), self.white.and_then(slope)]
    }

    /// Whitens a series.
    ///
    /// # Errors
    /// [`Rejected`] for a standard deviation or correlation time that is not above 0.
    pub fn whiten(&self, unknowns: &[f64], series: &mut Series<'_>) -> Result<(), Rejected> {
        let total = self.total(unknowns);
        let tau_s = self.correlation_time_s.map(|tau| tau.at(unknowns));
        if !(total > 0.0 && total.is_finite()) || tau_s.is_some_and(|tau| !(tau > 0.0 && tau.is_finite())) {
            return Err(Rejected::new("a sensor's noise is not above 0"));
        }
        match (self.correlation_time_s, self.white) {
            (None, _) => self.white_only(unknowns, series),
            (Some(tau), None) => self.correlated(unknowns, tau, series),
            (Some(tau), Some(white)) => self.filtered(unknowns, tau, white, series),
        }
        Ok(())
    }

    fn white_only(&self, unknowns: &[f64], series: &mut Series<'_>) {
        let total = self.total(unknowns);
        let count = series.values.len();
        let log_scale = -ln(total);
        series.log_scales.fill(log_scale);
        for value in series.values.iter_mut() {
            *value /= total;
        }
        if series.scale_gradient.is_empty() {
            return;
        }
        let n = series.scale_gradient.len();
        for value in series.jacobian.iter_mut() {
            *value /= total;
        }
        for (place, slope) in self.total_slopes(unknowns).into_iter().flatten() {
            series.scale_gradient[place] -= count as f64 * slope / total;
            for (row, value) in series.values.iter().enumerate() {
                series.jacobian[row * n + place] -= value * slope / total;
            }
        }
    }

    fn correlated(&self, unknowns: &[f64], tau: Value, series: &mut Series<'_>) {
        let (sigma, tau_s) = (self.sigma.at(unknowns), tau.at(unknowns));
        let n = series.scale_gradient.len();
        let (mut decay, mut loss, mut log) = (Remembered::new(exp), Remembered::new(exp_m1), Remembered::new(ln));
        // Backwards, so that the difference before is still there.
        for row in (0..series.values.len()).rev() {
            let (mut phi, mut phi_slope, mut scale) = (0.0, 0.0, sigma);
            let mut log_slope = 0.0;
            if row > 0 {
                let step = (series.times_s[row] - series.times_s[row - 1]) / tau_s;
                phi = decay.of(-step);
                phi_slope = phi * step / tau_s;
                let left = -loss.of(-2.0 * step);
                scale = sigma * left.sqrt();
                // d ln(scale) / d tau.
                log_slope = -phi * phi_slope / left;
            }
            let before = if row > 0 { series.values[row - 1] } else { 0.0 };
            let whitened = (series.values[row] - phi * before) / scale;
            series.values[row] = whitened;
            series.log_scales[row] = -log.of(scale);
            if n == 0 {
                continue;
            }
            let (earlier, current) = series.jacobian.split_at_mut(row * n);
            let earlier = if row > 0 { &earlier[(row - 1) * n..] } else { &[] };
            for column in 0..n {
                let behind = earlier.get(column).copied().unwrap_or(0.0);
                current[column] = (current[column] - phi * behind) / scale;
            }
            if let Some(place) = self.sigma.place() {
                current[place] -= whitened / sigma;
                series.scale_gradient[place] -= 1.0 / sigma;
            }
            if let Some(place) = tau.place() {
                current[place] += -phi_slope * before / scale - whitened * log_slope;
                series.scale_gradient[place] -= log_slope;
            }
        }
    }

    /// Ornstein-Uhlenbeck and white noise together: state `x`, variance `P`; reading `d = x + white noise`.
    fn filtered(&self, unknowns: &[f64], tau: Value, white: Value, series: &mut Series<'_>) {
        let (sigma, tau_s, white_sd) = (self.sigma.at(unknowns), tau.at(unknowns), white.at(unknowns));
        let n = series.scale_gradient.len();
        let (mut mean, mut variance) = (0.0, sigma * sigma);
        let mut mean_slopes = vec![0.0; n];
        let mut variance_slopes = vec![0.0; n];
        let variance_of_sigma = 2.0 * sigma;
        let (mut decay, mut log) = (Remembered::new(exp), Remembered::new(ln));
        if let (Some(place), true) = (self.sigma.place(), n > 0) {
            variance_slopes[place] = variance_of_sigma;
        }
        for row in 0..series.values.len() {
            if row > 0 {
                let step = (series.times_s[row] - series.times_s[row - 1]) / tau_s;
                let phi = decay.of(-step);
                let excess = variance - sigma * sigma;
                for column in 0..n {
                    let variance_slope = if self.sigma.place() == Some(column) { variance_of_sigma } else { 0.0 };
                    let phi_slope = if tau.place() == Some(column) { phi * step / tau_s } else { 0.0 };
                    mean_slopes[column] = phi * mean_slopes[column] + phi_slope * mean;
                    variance_slopes[column] = variance_slope
                        + phi * phi * (variance_slopes[column] - variance_slope)
                        + 2.0 * phi * phi_slope * excess;
                }
                mean *= phi;
                variance = sigma * sigma + phi * phi * excess;
            }
            let total = variance + white_sd * white_sd;
            let scale = total.sqrt();
            let innovation = series.values[row] - mean;
            let gain = variance / total;
            series.values[row] = innovation / scale;
            series.log_scales[row] = -log.of(scale);
            for column in 0..n {
                let white_slope = if white.place() == Some(column) { 2.0 * white_sd } else { 0.0 };
                let total_slope = variance_slopes[column] + white_slope;
                let gain_slope = (variance_slopes[column] - gain * total_slope) / total;
                let slot = &mut series.jacobian[row * n + column];
                let innovation_slope = *slot - mean_slopes[column];
                *slot = innovation_slope / scale - 0.5 * innovation / scale * total_slope / total;
                series.scale_gradient[column] -= 0.5 * total_slope / total;
                mean_slopes[column] += gain_slope * innovation + gain * innovation_slope;
                // P (1 - K), as K white^2.
                variance_slopes[column] = gain_slope * white_sd * white_sd + gain * white_slope;
            }
            mean += gain * innovation;
            variance = gain * white_sd * white_sd;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::cholesky;

    const TIMES: [f64; 6] = [0.0, 1.0, 1.5, 4.0, 9.0, 9.2];
    const VALUES: [f64; 6] = [0.3, 0.5, 0.1, -0.7, 0.2, 0.4];

    fn run(noise: &Noise, unknowns: &[f64]) -> (f64, Vec<f64>) {
        let n = unknowns.len();
        let mut values = VALUES;
        let mut jacobian = vec![0.0; 6 * n];
        // The differences themselves depend on the last unknown.
        for row in 0..6 {
            jacobian[row * n + n - 1] = 1.0 + row as f64;
            values[row] += (1.0 + row as f64) * unknowns[n - 1];
        }
        let (mut scales, mut gradient) = ([0.0; 6], vec![0.0; n]);
        let mut series = Series {
            times_s: &TIMES,
            values: &mut values,
            jacobian: &mut jacobian,
            log_scales: &mut scales,
            scale_gradient: &mut gradient,
        };
        noise.whiten(unknowns, &mut series).unwrap();
        let value = scales.iter().sum::<f64>() - 0.5 * values.iter().map(|e| e * e).sum::<f64>();
        for row in 0..6 {
            for column in 0..n {
                gradient[column] -= values[row] * jacobian[row * n + column];
            }
        }
        (value, gradient)
    }

    /// The same from the dense covariance of all readings.
    fn dense(sigma: f64, tau: Option<f64>, white: f64, shift: f64) -> f64 {
        let mut covariance = vec![0.0; 36];
        for i in 0..6 {
            for j in 0..6 {
                let apart = (TIMES[i] - TIMES[j]).abs();
                let correlation = tau.map_or(if i == j { 1.0 } else { 0.0 }, |tau| exp(-apart / tau));
                covariance[i * 6 + j] = sigma * sigma * correlation + if i == j { white * white } else { 0.0 };
            }
        }
        cholesky::factor(&mut covariance, 6).unwrap();
        let mut d: Vec<f64> = (0..6).map(|row| VALUES[row] + (1.0 + row as f64) * shift).collect();
        cholesky::solve_lower(&covariance, &mut d);
        -0.5 * cholesky::log_determinant(&covariance, 6) - 0.5 * d.iter().map(|e| e * e).sum::<f64>()
    }

    #[test]
    fn whitening_agrees_with_the_dense_covariance_and_its_derivatives_with_differences() {
        let u = Value::Unknown;
        let at = [0.4, 2.0, 0.3, 0.05];
        let cases = [
            (Noise { sigma: u(0), correlation_time_s: None, white: None }, dense(0.4, None, 0.0, 0.05)),
            (Noise { sigma: u(0), correlation_time_s: None, white: Some(u(2)) }, dense(0.4, None, 0.3, 0.05)),
            (Noise { sigma: u(0), correlation_time_s: Some(u(1)), white: None }, dense(0.4, Some(2.0), 0.0, 0.05)),
            (
                Noise { sigma: u(0), correlation_time_s: Some(u(1)), white: Some(u(2)) },
                dense(0.4, Some(2.0), 0.3, 0.05),
            ),
        ];
        for (noise, expected) in cases {
            let (value, gradient) = run(&noise, &at);
            assert!((value - expected).abs() < 1e-12, "{noise:?}: {value} {expected}");
            for place in 0..4 {
                let moved = |by: f64| {
                    let mut point = at;
                    point[place] += by;
                    run(&noise, &point).0
                };
                let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((difference - gradient[place]).abs() < 1e-7, "{noise:?} {place}: {difference} {gradient:?}");
            }
        }
    }

    #[test]
    fn noise_that_is_not_above_zero_is_refused() {
        let noise = Noise { sigma: Value::Known(0.0), correlation_time_s: None, white: None };
        let mut values = [1.0];
        let mut series = Series {
            times_s: &[0.0],
            values: &mut values,
            jacobian: &mut [],
            log_scales: &mut [0.0],
            scale_gradient: &mut [],
        };
        assert!(noise.whiten(&[], &mut series).is_err());
    }
}
