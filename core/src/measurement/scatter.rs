//! Whether readings scatter less about a fit than their stated noise allows.
//!
//! Where `p` unknowns were fitted to `n` readings, the sum of squares of their residuals in units of the noise has a
//! chi-square distribution with at least `n - p` degrees of freedom (more where priors hold unknowns). A sum that this one puts
//! below the level [`LEVEL`] says that the stated standard deviation is too large. Residuals that the model gets wrong only
//! raise the sum.

use crate::math::special::chi_square_cdf;
use crate::measurement::Sensor;
use crate::measurement::total_sd;
use crate::thermal::Model;

/// Probability of so small a sum of squares below which the noise is said to be overstated.
pub const LEVEL: f64 = 1e-3;
/// Times by which the stated noise is at least larger than the scatter where it is worth a word.
const WORTH: f64 = 1.25;
/// Sensors that are named.
const MOST_NAMED: usize = 6;

/// The readings of a sensor about a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    /// The sensor.
    pub sensor: String,
    /// Its stated standard deviation, SI.
    pub sigma: f64,
    /// SI unit of that.
    pub unit: String,
    /// Sum of squares of the residuals in units of the noise.
    pub square: f64,
    /// Number of readings.
    pub readings: usize,
}

/// The scatter of sensors from whitened residuals, one an entry; those whose noise is inferred, or not stated, are left out,
/// and sensors of one name and noise are one.
pub fn of_stated<'s>(residuals: impl Iterator<Item = (&'s Sensor, f64)>, model: &Model) -> Vec<Scatter> {
    let mut sensors: Vec<Scatter> = Vec::new();
    for (sensor, residual) in residuals {
        let is_inferred = [&sensor.sigma, &sensor.white].into_iter().flatten().any(|part| part.prior().is_some());
        let Some(sigma) = sensor.sigma.as_ref().filter(|_| !is_inferred) else { continue };
        let white = sensor.white.as_ref().map_or(0.0, |white| white.nominal());
        let sigma = total_sd(sigma.nominal(), white);
        match sensors.iter_mut().find(|entry| entry.sensor == sensor.name && entry.sigma == sigma) {
            Some(entry) => {
                entry.square += residual * residual;
                entry.readings += 1;
            }
            None => {
                let unit = model.quantities[sensor.quantity].unit.clone();
                let (sensor, square) = (sensor.name.clone(), residual * residual);
                sensors.push(Scatter { sensor, sigma, unit, square, readings: 1 });
            }
        }
    }
    sensors
}

/// By how many times the noise is overstated, where a sum of squares is improbably small; `free` unknowns were fitted.
pub fn overstated(square: f64, readings: usize, free: usize) -> Option<f64> {
    let freedom = readings.checked_sub(free).filter(|freedom| *freedom > 0)? as f64;
    let times = (freedom / square).sqrt();
    (chi_square_cdf(square, freedom) < LEVEL && times >= WORTH).then_some(times)
}

/// What is said where the noise of all sensors together, or else of single ones, is overstated. Every sensor is tested at its
/// share of the level (Bonferroni), as if all unknowns had been fitted to it alone.
pub fn warning(sensors: &[Scatter], free: usize) -> Option<String> {
    let square: f64 = sensors.iter().map(|one| one.square).sum();
    let readings = sensors.iter().map(|one| one.readings).sum();
    let said = |named: &[(&Scatter, f64)]| {
        let one = |(scatter, times): &(&Scatter, f64)| {
            format!("{} {:.2} instead of {} {}", scatter.sensor, scatter.sigma / times, scatter.sigma, scatter.unit)
        };
        let mut text: Vec<String> = named.iter().take(MOST_NAMED).map(one).collect();
        if named.len() > MOST_NAMED {
            text.push(format!("{} more", named.len() - MOST_NAMED));
        }
        format!(
            "The stated noise (`sigma`) is too large: the readings scatter less about the fit than it allows. They look like {}. \
             With too large a `sigma` small effects go undetected, and stated uncertainties are too wide.",
            text.join(", ")
        )
    };
    if let Some(times) = overstated(square, readings, free) {
        let all: Vec<(&Scatter, f64)> = sensors.iter().map(|scatter| (scatter, times)).collect();
        return Some(said(&all));
    }
    let level = LEVEL / sensors.len().max(1) as f64;
    let single = sensors.iter().filter_map(|scatter| {
        let times = overstated(scatter.square, scatter.readings, free)?;
        let freedom = scatter.readings.saturating_sub(free) as f64;
        (chi_square_cdf(scatter.square, freedom) < level).then_some((scatter, times))
    });
    let single: Vec<(&Scatter, f64)> = single.collect();
    (!single.is_empty()).then(|| said(&single))
}
