//! Residuals at draws of a posterior, as linear functions of its unknowns.

use serde::{Deserialize, Serialize};

use crate::math::cholesky;
use crate::math::dense::square;
use crate::measurement::{Measurement, Rows};

/// Added to the correlations of the unknowns, so that those that move together leave them positive definite.
const RIDGE: f64 = 1e-8;

/// A reading of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Reading {
    /// Position of the measurement in the pass's list.
    pub measurement: usize,
    /// Row.
    pub row: usize,
    /// Position of the sensor in the measurement.
    pub sensor: usize,
    /// Position of its name in the settings.
    pub name: usize,
    /// Kept from calibration and law.
    pub held_out: bool,
}

/// All readings of these sensors, in the order of the data.
pub(super) fn readings(measurements: &[Measurement], data: &[usize], sensors: &[String]) -> Vec<Reading> {
    let mut readings = Vec::new();
    for &index in data {
        let measurement = &measurements[index];
        if !matches!(measurement.rows, Rows::Steady(_)) {
            continue;
        }
        for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
            for (position, sensor) in measurement.sensors.iter().enumerate() {
                let Some(name) = sensors.iter().position(|name| *name == sensor.name) else { continue };
                if measurement.reading(row, position).is_some() {
                    let held_out = measurement.held_out(row);
                    readings.push(Reading { measurement: index, row, sensor: position, name, held_out });
                }
            }
        }
    }
    readings
}

/// Residuals as linear functions of the unknowns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Means of the unknowns over the draws.
    pub means: Vec<f64>,
    /// Their covariance (row after row).
    pub covariance: Vec<f64>,
    /// Residuals at the means.
    pub at_mean: Vec<f64>,
    /// Their standard deviations over the draws.
    pub sds: Vec<f64>,
    /// Slopes with the unknowns, reading by reading.
    pub slopes: Vec<Vec<f64>>,
    /// Root mean square of what the slopes leave of each residual over the draws.
    #[serde(alias = "bent")]
    pub nonlinear: Vec<f64>,
    /// Draws that were used, and those without a solution.
    pub draws: [u64; 2],
}

impl Residuals {
    /// From the residuals at the means and those at draws (each reading by reading), of which those that are not finite are
    /// left out.
    pub fn new(means: Vec<f64>, at_mean: Vec<f64>, draws: &[Vec<f64>], residuals: &[Vec<f64>]) -> Self {
        let used: Vec<usize> = (0..draws.len()).filter(|&d| residuals[d].iter().all(|r| r.is_finite())).collect();
        let (p, count) = (means.len(), used.len() as f64);
        let mean = |of: &dyn Fn(usize) -> f64| used.iter().map(|&d| of(d)).sum::<f64>() / count.max(1.0);
        let centres: Vec<f64> = (0..p).map(|a| mean(&|d| draws[d][a])).collect();
        let covariance = square(p, |a, b| mean(&|d| (draws[d][a] - centres[a]) * (draws[d][b] - centres[b])));
        let sds: Vec<f64> = (0..p).map(|a| covariance[a * p + a].sqrt()).collect();
        let varied: Vec<usize> = (0..p).filter(|&a| sds[a] > 0.0).collect();
        let k = varied.len();
        let mut factor = square(k, |a, b| {
            let (a, b) = (varied[a], varied[b]);
            covariance[a * p + b] / (sds[a] * sds[b]) + if a == b { RIDGE } else { 0.0 }
        });
        let is_regular = cholesky::factor(&mut factor, k).is_ok();
        let mut found =
            Self { at_mean, draws: [used.len() as u64, (draws.len() - used.len()) as u64], ..Self::default() };
        for reading in 0..found.at_mean.len() {
            let centre = mean(&|d| residuals[d][reading]);
            let mut slopes = vec![0.0; p];
            if is_regular {
                let mut side: Vec<f64> = varied
                    .iter()
                    .map(|&a| mean(&|d| (draws[d][a] - centres[a]) / sds[a] * (residuals[d][reading] - centre)))
                    .collect();
                cholesky::solve(&factor, &mut side);
                varied.iter().zip(side).for_each(|(&a, slope)| slopes[a] = slope / sds[a]);
            }
            let nonlinear = mean(&|d| {
                let along: f64 = (0..p).map(|a| slopes[a] * (draws[d][a] - centres[a])).sum();
                let left = residuals[d][reading] - centre - along;
                left * left
            });
            let square = |d: usize| (residuals[d][reading] - centre) * (residuals[d][reading] - centre);
            found.sds.push(mean(&square).sqrt());
            found.slopes.push(slopes);
            found.nonlinear.push(nonlinear.sqrt());
        }
        found.means = means;
        found.covariance = covariance;
        found
    }
}
