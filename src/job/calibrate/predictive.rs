//! Predictive checks: what posterior and prior say that the sensors read, beside what they read.

use super::block::Predicted;
use super::output::{Coverage, PredictiveRow, SensorPredictive};
use crate::math::root::brent;
use crate::math::special::normal_cdf;
use crate::measurement::total_sd;
use crate::measurement::unknown::sensor_name;
use crate::measurement::{Measurement, Rows};
use crate::statistics::quantile::{quantile_sorted, sorted};
use crate::thermal::Model;

/// Most rows of a sensor that are written out; statistics are of all.
const MOST_ROWS: usize = 2000;
/// Bins of the probability integral transform.
const BINS: usize = 10;
/// Standard deviations of noise beyond which nothing is left of a band.
const BEYOND: f64 = 8.0;
/// Precision of a band's ends, in its whole extent.
const BAND_PRECISION: f64 = 1e-4;
/// Most steps to find a band's end.
const BAND_ITERATIONS: usize = 100;

/// Covariance that known errors of the inputs give to a row's readings (`sensors x sensors`), by measurement and row;
/// `None` where there is none.
pub(super) type InputSpread = Vec<Vec<Option<Vec<f64>>>>;

/// Draws of one kind with what they predict.
pub(super) struct Draws {
    /// Unknowns, SI, draw by draw.
    pub values: Vec<Vec<f64>>,
    /// Readings of all measurements, draw by draw.
    pub predicted: Predicted,
}

impl Draws {
    /// Predictions of one reading that are numbers, each with the standard deviation of the noise and of a further,
    /// independent error of this variance.
    fn of(&self, place: usize, sd: &[f64], variance: f64) -> Vec<(f64, f64)> {
        let width = self.predicted.readings.len() / self.values.len().max(1);
        let whole = |sd: f64| if variance > 0.0 { (sd * sd + variance).sqrt() } else { sd };
        (0..self.values.len())
            .map(|draw| (self.predicted.readings[draw * width + place], whole(sd[draw])))
            .filter(|(value, _)| value.is_finite())
            .collect()
    }

    /// Standard deviation of a sensor's noise at each draw, SI; 0 where it is not stated.
    pub fn noise(&self, measurement: &Measurement, sensor: usize, order: &[String]) -> Vec<f64> {
        let sensor_model = &measurement.sensors[sensor];
        let value = |draw: &[f64], what: &str, written: &Option<_>| -> f64 {
            let Some(written): &Option<crate::measurement::Uncertain> = written else { return 0.0 };
            let name = sensor_name(&measurement.name, &sensor_model.name, what);
            let place = order.iter().position(|unknown_name| *unknown_name == name);
            place.and_then(|place| draw.get(place)).copied().unwrap_or_else(|| written.nominal())
        };
        self.values
            .iter()
            .map(|draw| {
                let (sigma, white) =
                    (value(draw, "sigma", &sensor_model.sigma), value(draw, "white", &sensor_model.white));
                total_sd(sigma, white)
            })
            .collect()
    }
}

/// Share of the predictions with their noise, a mixture of normal distributions, that lies below a value.
fn share_below(predicted: &[(f64, f64)], x: f64) -> f64 {
    let below = |&(value, sd): &(f64, f64)| {
        if sd > 0.0 { normal_cdf((x - value) / sd) } else { f64::from(u8::from(value < x)) }
    };
    predicted.iter().map(below).sum::<f64>() / predicted.len() as f64
}

/// A 95 % band of predictions with their noise: quantiles of the mixture, to a ten-thousandth of its extent.
pub fn noisy_band(predicted: &[(f64, f64)]) -> [f64; 2] {
    let values: Vec<f64> = predicted.iter().map(|pair| pair.0).collect();
    let plain = band(&values);
    if predicted.iter().all(|pair| pair.1 <= 0.0) {
        return plain;
    }
    let end = |sign: f64| predicted.iter().map(move |(value, sd)| value + sign * BEYOND * sd);
    let (lower, upper) = (end(-1.0).fold(f64::INFINITY, f64::min), end(1.0).fold(f64::NEG_INFINITY, f64::max));
    let quantile = |probability: f64, otherwise: f64| {
        let excess = |x: f64| share_below(predicted, x) - probability;
        brent(excess, lower, upper, BAND_PRECISION * (upper - lower), BAND_ITERATIONS).unwrap_or(otherwise)
    };
    [quantile(0.025, plain[0]), quantile(0.975, plain[1])]
}

fn band(values: &[f64]) -> [f64; 2] {
    let values = sorted(values);
    [quantile_sorted(&values, 0.025), quantile_sorted(&values, 0.975)]
}

/// The checks of all sensors.
pub(super) fn checks(
    measurements: &[&Measurement],
    model: &Model,
    order: &[String],
    posterior: &Draws,
    prior: &Draws,
    spread: &InputSpread,
) -> Vec<SensorPredictive> {
    let mut checks = Vec::new();
    let mut first = 0;
    for (measurement, spread) in measurements.iter().zip(spread) {
        let width = measurement.sensors.len();
        for (sensor, sensor_model) in measurement.sensors.iter().enumerate() {
            let noise = posterior.noise(measurement, sensor, order);
            let prior_noise = prior.noise(measurement, sensor, order);
            let mut check = SensorPredictive {
                measurement: measurement.name.clone(),
                sensor: sensor_model.name.clone(),
                unit: model.quantities[sensor_model.quantity].unit.clone(),
                rows: Vec::new(),
                train: Coverage::default(),
                held_out: Coverage::default(),
                pit: vec![0; BINS],
            };
            let used: Vec<usize> = (0..measurement.len()).filter(|&row| !measurement.ignored(row)).collect();
            let every = used.len().div_ceil(MOST_ROWS).max(1);
            for (position, &row) in used.iter().enumerate() {
                let place = first + row * width + sensor;
                let variance = spread[row].as_ref().map_or(0.0, |covariance| covariance[sensor * (width + 1)]);
                let predicted = posterior.of(place, &noise, variance);
                if predicted.is_empty() {
                    continue;
                }
                let before = prior.of(place, &prior_noise, variance);
                let row = self::row(measurement, row, sensor, &predicted, &before);
                count(&mut check, &row, &predicted);
                if position % every == 0 {
                    check.rows.push(row);
                }
            }
            checks.push(check);
        }
        first += measurement.len() * width;
    }
    checks
}

fn row(
    measurement: &Measurement,
    row: usize,
    sensor: usize,
    predicted: &[(f64, f64)],
    before: &[(f64, f64)],
) -> PredictiveRow {
    let (phase, time_s) = match &measurement.rows {
        Rows::Steady(phases) => (Some(phases[row].name.clone()), None),
        Rows::Transient { inputs, .. } => (None, Some(inputs.times_s[row])),
    };
    let values: Vec<f64> = predicted.iter().map(|pair| pair.0).collect();
    PredictiveRow {
        phase,
        time_s,
        measured: measurement.reading(row, sensor),
        mean: values.iter().sum::<f64>() / values.len() as f64,
        band: band(&values),
        band_with_noise: noisy_band(predicted),
        prior_band: (!before.is_empty()).then(|| noisy_band(before)),
        held_out: measurement.held_out(row),
    }
}

/// Counts a reading in the statistics.
fn count(check: &mut SensorPredictive, row: &PredictiveRow, predicted: &[(f64, f64)]) {
    let Some(measured) = row.measured else { return };
    let within = |[lower, upper]: [f64; 2]| u64::from((lower..=upper).contains(&measured));
    let coverage = if row.held_out { &mut check.held_out } else { &mut check.train };
    coverage.count += 1;
    coverage.inside += within(row.band_with_noise);
    coverage.inside_prior += row.prior_band.map_or(0, within);
    if !row.held_out {
        let share = share_below(predicted, measured);
        check.pit[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
}
