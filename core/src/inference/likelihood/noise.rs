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

/// The whitening of any series of one sensor at given values of its noise: what does not depend on the series, once.
#[derive(Clone, Debug)]
pub enum Filter {
    /// White noise: the standard deviation.
    White(f64),
    /// An Ornstein-Uhlenbeck process: by reading, what is left of the one before, and the standard deviation given that.
    Correlated(Vec<[f64; 2]>),
    /// The same with white noise beside it: by reading, what is left of the state, the standard deviation given those before, and the
    /// gain of the Kalman filter.
    Filtered(Vec<[f64; 3]>),
}

impl Filter {
    /// Whitens a series, in place, to the bit as [`Noise::whiten`].
    pub fn apply(&self, values: &mut [f64]) {
        match self {
            Self::White(sd) => values.iter_mut().for_each(|value| *value /= sd),
            Self::Correlated(_) | Self::Filtered(_) => {
                let mut state = 0.0;
                for (position, value) in values.iter_mut().enumerate() {
                    *value = self.step(position, *value, &mut state);
                }
            }
        }
    }

    /// Whitens the value at a position, given the state that those before it have left; it is 0 at the beginning.
    pub fn step(&self, position: usize, value: f64, state: &mut f64) -> f64 {
        match self {
            Self::White(sd) => value / sd,
            Self::Correlated(steps) => {
                let [phi, scale] = steps[position];
                let before = std::mem::replace(state, value);
                (value - phi * before) / scale
            }
            Self::Filtered(steps) => {
                let [phi, scale, gain] = steps[position];
                let mean = *state * phi;
                let innovation = value - mean;
                *state = mean + gain * innovation;
                innovation / scale
            }
        }
    }
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
        self.checked(unknowns)?;
        match (self.correlation_time_s, self.white) {
            (None, _) => self.white_only(unknowns, series),
            (Some(tau), None) => self.correlated(unknowns, tau, series),
            (Some(tau), Some(white)) => self.filtered(unknowns, tau, white, series),
        }
        Ok(())
    }

    /// The whitening at these instants, s.
    ///
    /// # Errors
    /// [`Rejected`] for a standard deviation or correlation time that is not above 0.
    pub fn filter(&self, unknowns: &[f64], times_s: &[f64]) -> Result<Filter, Rejected> {
        let (total, tau_s) = self.checked(unknowns)?;
        let Some(tau_s) = tau_s else { return Ok(Filter::White(total)) };
        let sigma = self.sigma.at(unknowns);
        let step = |row: usize| (times_s[row] - times_s[row - 1]) / tau_s;
        let mut decay = Remembered::new(exp);
        let Some(white) = self.white else {
            let mut loss = Remembered::new(exp_m1);
            let of = |row: usize| match row {
                0 => [0.0, sigma],
                _ => [decay.of(-step(row)), sigma * (-loss.of(-2.0 * step(row))).sqrt()],
            };
            return Ok(Filter::Correlated((0..times_s.len()).map(of).collect()));
        };
        let white_sd = white.at(unknowns);
        let mut variance = sigma * sigma;
        let of = |row: usize| {
            let mut phi = 1.0;
            if row > 0 {
                phi = decay.of(-step(row));
                variance = sigma * sigma + phi * phi * (variance - sigma * sigma);
            }
            let total = variance + white_sd * white_sd;
            let gain = variance / total;
            variance = gain * white_sd * white_sd;
            [phi, total.sqrt(), gain]
        };
        Ok(Filter::Filtered((0..times_s.len()).map(of).collect()))
    }

    /// Standard deviation and correlation time, where both are above 0.
    fn checked(&self, unknowns: &[f64]) -> Result<(f64, Option<f64>), Rejected> {
        let total = self.total(unknowns);
        let tau_s = self.correlation_time_s.map(|tau| tau.at(unknowns));
        if !(total > 0.0 && total.is_finite()) || tau_s.is_some_and(|tau| !(tau > 0.0 && tau.is_finite())) {
            return Err(Rejected::new("a sensor's noise is not above 0"));
        }
        Ok((total, tau_s))
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
