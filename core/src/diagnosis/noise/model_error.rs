//! Model error: what a model that is a little wrong everywhere owes beside every set of effects.
//!
//! A model error of standard deviation `s` adds `s^2` to the variance of every reading of a measurement. It is estimated
//! beside sets that were fitted: for each, the most likely size and the log likelihood with it, so that a plain set with a
//! larger model error stands against a larger set with a smaller one.
//!
//! A model's errors are no noise: in a transient they change slowly, in steady phases they follow the inputs and are alike
//! at neighbours. So `n` readings tell as much as `n / c` independent ones, and the likelihood counts so. In a transient
//! `c` is the integrated autocorrelation time of what the best set leaves, in readings (Sokal 1997), or what counts
//! errors that come again (Bartlett 1946), whichever is larger; in steady phases a constant.

use serde::{Deserialize, Serialize};

use crate::math::functions::{exp, ln};
use crate::watch;

/// Model error that is allowed for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// Its standard deviation, SI.
    pub sd: f64,
    /// Standard deviation of white noise that stands in the likelihood for it and the instrument's noise, SI: larger than
    /// both, since readings are not independent of one another.
    pub counts_as: f64,
}

/// Errors of the fitted readings of one measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Reading minus prediction, SI.
    pub errors: Vec<f64>,
    /// Standard deviations of the instruments' noise, SI, above 0.
    pub noise: Vec<f64>,
    /// Readings that are worth an independent one.
    pub readings_of_one: f64,
}

/// Steady readings that are worth an independent one where the model is wrong.
pub const STEADY_READINGS_OF_ONE: f64 = 3.0;
/// Sizes that are tried, beside 0, between these shares of the errors' root mean square.
const SIZES: usize = 48;
const SMALLEST: f64 = 0.03;
const LARGEST: f64 = 1.5;
/// The autocorrelation is summed up to so many times its sum (Sokal's window).
const WINDOW: f64 = 5.0;
/// Independent readings that a measurement is worth at least, whatever its errors are beside a set that is far off.
const LEAST_INDEPENDENT: f64 = 30.0;

impl Errors {
    /// Log likelihood with a model error; `freedom` is the share of the readings that the fit did not use up.
    fn log_likelihood(&self, sd: f64, freedom: f64) -> f64 {
        let one = |(error, noise): (&f64, &f64)| {
            let variance = noise * noise + sd * sd;
            -0.5 * (ln(2.0 * std::f64::consts::PI * variance) + error * error / (freedom * variance))
        };
        self.errors.iter().zip(&self.noise).map(one).sum::<f64>() / self.readings_of_one
    }

    /// The most likely size of the model error, and the log likelihood with it.
    pub fn most_likely(&self, freedom: f64) -> (f64, f64) {
        let square: f64 = self.errors.iter().map(|error| error * error).sum();
        let rms = (square / (freedom * self.errors.len().max(1) as f64)).sqrt();
        let ratio = ln(LARGEST / SMALLEST) / (SIZES - 1) as f64;
        let mut best = (0.0, self.log_likelihood(0.0, freedom));
        for sd in (0..SIZES).map(|k| rms * SMALLEST * exp(ratio * k as f64)).filter(|sd| *sd > 0.0) {
            let value = self.log_likelihood(sd, freedom);
            if value > best.1 {
                best = (sd, value);
            }
        }
        best
    }
}

/// Readings of series with equal steps that are worth an independent one, of all series together: the larger of the
/// integrated autocorrelation time `1 + 2 sum rho(k)`, which counts slow errors, and of `1 + 2 sum rho(k)^2`, which also
/// counts those that come again with the orbit or the day (Bartlett 1946).
pub fn readings_of_one(series: &[Vec<f64>]) -> f64 {
    let longest = series.iter().map(Vec::len).max().unwrap_or(0);
    let total: usize = series.iter().map(Vec::len).sum();
    let product = |lag: usize| -> f64 {
        series.iter().map(|errors| errors.iter().zip(errors.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()).sum()
    };
    let square = product(0);
    if !(square > 0.0) {
        return 1.0;
    }
    let (mut slow, mut again) = (1.0, 1.0);
    let mut is_open = true;
    for lag in 1..longest {
        watch::check();
        let rho = product(lag) / square;
        if is_open {
            slow += 2.0 * rho;
            is_open = (lag as f64) < WINDOW * slow;
        }
        // Less what white noise has by chance.
        again += 2.0 * (rho * rho - (1.0 - lag as f64 / longest as f64) / total as f64);
    }
    slow.max(again).clamp(1.0, (total as f64 / LEAST_INDEPENDENT).max(1.0))
}

/// Standard deviation of white noise from the median difference of neighbours, which slow errors do not reach and jumps
/// do not spoil.
pub fn quiet_scatter(series: &[f64]) -> f64 {
    let mut steps: Vec<f64> = series.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    steps.sort_by(f64::total_cmp);
    // The median of |x| is 0.6745 standard deviations; a difference has twice the variance.
    steps.get(steps.len() / 2).map_or(0.0, |median| median / 0.6745 / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::StreamKey;

    fn draws(count: usize, seed: u64) -> Vec<f64> {
        let mut stream = StreamKey::new(seed, "model error", "test").stream(0);
        (0..count).map(|_| stream.normal()).collect()
    }

    /// An autoregressive series of standard deviation 1.
    fn slow(count: usize, phi: f64, seed: u64) -> Vec<f64> {
        let mut state = 0.0;
        let next = |draw: f64| {
            state = phi * state + (1.0 - phi * phi).sqrt() * draw;
            state
        };
        draws(count, seed).into_iter().map(next).collect()
    }

    #[test]
    fn the_size_beside_known_noise_is_found() {
        let count = 2000;
        // 0.3 K of noise and 0.4 K of model error are 0.5 K together.
        let errors: Vec<f64> = draws(count, 1).iter().map(|draw| 0.5 * draw).collect();
        let measurement_errors = Errors { errors, noise: vec![0.3; count], readings_of_one: 1.0 };
        let (sd, value) = measurement_errors.most_likely(1.0);
        // 0.5 K is known to 0.5 / sqrt(4000) = 0.008 K, the size to 0.008 * 0.5 / 0.4; 3.5 of them, and half a step of 8 %.
        assert!((sd - 0.4).abs() < 0.035 + 0.017, "{sd}");
        assert!(value > measurement_errors.log_likelihood(0.0, 1.0));
        let white =
            Errors { errors: draws(count, 2).iter().map(|draw| 0.3 * draw).collect(), ..measurement_errors.clone() };
        assert!(white.most_likely(1.0).0 < 0.1, "noise alone leaves no model error");
        let few = Errors { readings_of_one: 10.0, ..measurement_errors };
        assert!((few.most_likely(1.0).1 - value / 10.0).abs() < 1e-9, "dependent readings tell less of the same");
    }

    #[test]
    fn slow_errors_and_those_that_come_again_are_worth_few_readings() {
        let white = readings_of_one(&[draws(2000, 3), draws(2000, 4)]);
        assert!(white < 1.6, "{white}");
        // (1 + phi) / (1 - phi) = 19; its relative error is sqrt(2 (2 * 95 + 1) / 8000) = 0.22 (Sokal 1997, window of 5 times 19).
        let dependence = readings_of_one(&[slow(4000, 0.9, 5), slow(4000, 0.9, 6)]);
        assert!((13.0..30.0).contains(&dependence), "{dependence}");
        // Twenty orbits with the same pattern sum up to 0 over each.
        let orbit = slow(100, 0.5, 7);
        let again: Vec<f64> = (0..2000).map(|k| orbit[k % 100]).collect();
        assert!(readings_of_one(&[again]) > 15.0);
        assert_eq!(readings_of_one(&[vec![0.0; 50]]), 1.0, "no errors");
        assert_eq!(readings_of_one(&[]), 1.0, "no readings");
        assert!(readings_of_one(&[vec![1.0; 600]]) <= 20.0, "a record is worth 30 readings at least");
    }

    #[test]
    fn quiet_stretches_show_the_noise_beneath_slow_errors() {
        let noise = draws(3000, 8);
        let mixed: Vec<f64> =
            slow(3000, 0.999, 9).iter().zip(&noise).map(|(slow, noise)| 5.0 * slow + 0.1 * noise).collect();
        // The slow part adds 5 sqrt(1 - 0.999^2) = 0.22 K a step, as much as 0.16 K of noise.
        let scatter = quiet_scatter(&mixed);
        assert!((0.15..0.22).contains(&scatter), "{scatter}");
        let mut jumps: Vec<f64> = noise.iter().map(|noise| 0.1 * noise).collect();
        (0..3000).step_by(50).for_each(|row| jumps[row] += 40.0);
        assert!((quiet_scatter(&jumps) - 0.1).abs() < 0.01, "spikes in 2 % of the rows");
        assert_eq!(quiet_scatter(&[1.0]), 0.0);
    }
}
