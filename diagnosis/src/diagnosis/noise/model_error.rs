//! Model error: what a model that is a little wrong everywhere owes beside every set of effects.
//!
//! A model error of standard deviation `s` adds `s^2` to the variance of every reading. It is the model's, not a run's: all
//! transients have one, and all steady phases. Otherwise runs that move little, in which any model errs little, would outvote the
//! others. It is estimated beside sets that were fitted: for each, the most likely size and the log likelihood with it, so that a plain set with a
//! larger model error stands against a larger set with a smaller one.
//!
//! A model's errors are no noise: in a transient they change slowly, in steady phases they follow the inputs and are alike
//! at neighbours. So `n` readings tell as much as `n / c` independent ones, and the likelihood counts so. In a transient
//! `c` is the integrated autocorrelation time of what the best set leaves, in readings (Sokal 1997), or what counts
//! errors that come again (Bartlett 1946), whichever is larger; in steady phases a constant.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::{exp, ln};
use crate::measurement::total_sd;
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

impl ModelError {
    /// Standard deviation of white noise that stands for it and an instrument's noise in steady phases, SI.
    pub fn in_steady_phases(self, noise: f64) -> f64 {
        total_sd(noise, self.sd * STEADY_READINGS_OF_ONE.sqrt())
    }
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
    /// What each reading adds to the log likelihood with a model error.
    pub fn of_readings(&self, sd: f64) -> Vec<f64> {
        let of = |(error, &noise): (&f64, &f64)| {
            OfOneNoise { noise, count: 1.0, square: error * error }.log_likelihood(sd, 1.0) / self.readings_of_one
        };
        self.errors.iter().zip(&self.noise).map(of).collect()
    }
}

/// Readings with one noise: what a log likelihood needs of them, however many they are.
#[derive(Clone, Copy, Debug)]
struct OfOneNoise {
    /// Standard deviation, SI.
    noise: f64,
    /// How many they are.
    count: f64,
    /// Sum of their squared errors.
    square: f64,
}

impl OfOneNoise {
    /// All readings of a measurement, by their noise.
    fn all(measurement: &Errors) -> Vec<Self> {
        let mut all: BTreeMap<u64, Self> = BTreeMap::new();
        for (error, &noise) in measurement.errors.iter().zip(&measurement.noise) {
            let own = all.entry(noise.to_bits()).or_insert(Self { noise, count: 0.0, square: 0.0 });
            own.count += 1.0;
            own.square += error * error;
        }
        all.into_values().collect()
    }

    /// Log likelihood with a model error; `freedom` is the share of the readings that the fit did not use up.
    fn log_likelihood(&self, sd: f64, freedom: f64) -> f64 {
        let variance = self.noise * self.noise + sd * sd;
        -0.5 * (self.count * ln(2.0 * std::f64::consts::PI * variance) + self.square / (freedom * variance))
    }
}

/// The most likely size of a model error that several measurements have in common, and the log likelihood with it.
pub fn most_likely(measurements: &[Errors], freedom: f64) -> (f64, f64) {
    let by_noise: Vec<(Vec<OfOneNoise>, f64)> =
        measurements.iter().map(|one| (OfOneNoise::all(one), one.readings_of_one)).collect();
    let all = || by_noise.iter().flat_map(|(own, _)| own);
    let square: f64 = all().map(|one| one.square).sum();
    let count: f64 = all().map(|one| one.count).sum();
    let rms = (square / (freedom * count.max(1.0))).sqrt();
    let log_likelihood = |sd: f64| -> f64 {
        let of = |(own, readings_of_one): &(Vec<OfOneNoise>, f64)| {
            own.iter().map(|one| one.log_likelihood(sd, freedom)).sum::<f64>() / readings_of_one
        };
        by_noise.iter().map(of).sum()
    };
    let ratio = ln(LARGEST / SMALLEST) / (SIZES - 1) as f64;
    let mut best = (0.0, log_likelihood(0.0));
    for sd in (0..SIZES).map(|k| rms * SMALLEST * exp(ratio * k as f64)).filter(|sd| *sd > 0.0) {
        let value = log_likelihood(sd);
        if value > best.1 {
            best = (sd, value);
        }
    }
    best
}

/// Readings of series with equal steps that are worth an independent one, of all series together: the larger of the
/// integrated autocorrelation time `1 + 2 sum rho(k)`, which counts slow errors, and of `1 + 2 sum rho(k)^2`, which also
/// counts those that come again with the orbit or the day (Bartlett 1946).
pub fn readings_of_one(series: &[Vec<f64>]) -> f64 {
    let longest = series.iter().map(Vec::len).max().unwrap_or(0);
    let total: usize = series.iter().map(Vec::len).sum();
    let product = |lag: usize| -> f64 {
        let of_series = |errors: &Vec<f64>| {
            let later = errors.get(lag..).unwrap_or_default();
            dot(&errors[..later.len()], later)
        };
        series.iter().map(of_series).sum()
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
