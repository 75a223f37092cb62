//! The baseline model, or one with effects, fitted to readings that are given.

use crate::diagnosis::{FitError, Hypothesis, Problem};
use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::estimate::optimise::{Effort, Minimum, free_variables, minimise};
use crate::inference::likelihood::{Definition, Likelihood};
use crate::inference::target::Target;
use crate::measurement::Measurement;

use super::inject::InjectError;

/// Steps of a fit.
const EFFORT: Effort = Effort { most_iterations: 60, least_gain: 1e-6, ceiling: f64::INFINITY };

/// A fit in natural coordinates.
#[derive(Clone, Debug)]
pub struct Refit {
    /// Unknowns, SI: chosen parameters, then what is inferred of the data.
    pub unknowns: Vec<f64>,
    /// Names of the unknowns.
    pub names: Vec<String>,
    /// Number of readings.
    pub readings: usize,
    /// Whitened residuals `r`: readings, then rows of the priors.
    pub residuals: Vec<f64>,
    /// Columns of `-dr/dx` that are not held at a bound, each over all rows.
    pub free: Vec<Vec<f64>>,
}

impl Refit {
    /// Sum of squares of the readings' residuals.
    pub fn chi_square(&self) -> f64 {
        self.residuals[..self.readings].iter().map(|r| r * r).sum()
    }

    /// Root mean square of the readings' residuals.
    pub fn size(&self) -> f64 {
        (self.chi_square() / self.readings.max(1) as f64).sqrt()
    }

    /// Sum of squares of all residuals, those of the priors included.
    pub fn total(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }
}

/// Measurements with other readings where there are any; `readings` by measurement, then `rows x sensors`.
pub fn with_readings(measurements: &[Measurement], readings: &[Vec<f64>]) -> Vec<Measurement> {
    let mut changed = measurements.to_vec();
    for (measurement, values) in changed.iter_mut().zip(readings) {
        for (reading, value) in measurement.readings.iter_mut().zip(values) {
            *reading = reading.map(|_| *value);
        }
    }
    changed
}

/// The problem's own likelihood for readings.
///
/// # Errors
/// [`InjectError`] where there is none.
pub fn likelihood(problem: &Problem, readings: &[Vec<f64>]) -> Result<Likelihood, InjectError> {
    let measurements = with_readings(&problem.measurements, readings);
    let measurements: Vec<&Measurement> = measurements.iter().collect();
    Likelihood::new(&Definition {
        model: &problem.model,
        priors: &problem.priors,
        parameters: &problem.parameters,
        measurements: &measurements,
        input_errors: &problem.input_errors,
    })
    .map_err(|error| InjectError::Hypothesis(FitError::Likelihood(error)))
}

/// The likelihood of a hypothesis for readings.
///
/// # Errors
/// As [`likelihood`].
pub fn hypothesis_likelihood(
    problem: &Problem,
    hypothesis: &Hypothesis,
    readings: &[Vec<f64>],
) -> Result<Likelihood, InjectError> {
    let measurements = with_readings(&hypothesis.measurements, readings);
    let hypothesis = Hypothesis { measurements, ..hypothesis.clone() };
    hypothesis.likelihood(problem).map_err(InjectError::Hypothesis)
}

/// The best of the fits from starts given in SI, the earliest of equals.
///
/// # Errors
/// [`InjectError::Fit`] where no start can be evaluated.
pub fn fit(likelihood: &Likelihood, starts: &[Vec<f64>]) -> Result<Refit, InjectError> {
    let mut objective = NaturalObjective::new(likelihood).map_err(|error| InjectError::Fit(error.to_string()))?;
    let bounds = objective.bounds();
    let mut best: Option<Minimum> = None;
    for start in starts {
        let from = objective.coordinates(start);
        if let Some(minimum) = minimise(&mut objective, &from, &bounds, EFFORT)
            && best.as_ref().is_none_or(|lowest| minimum.value < lowest.value)
        {
            best = Some(minimum);
        }
    }
    let best = best.ok_or_else(|| InjectError::Fit("no start can be evaluated".to_owned()))?;
    let n = best.x.len();
    let free = free_variables(&best.x, &best.gradient, &bounds);
    let column = |variable: usize| best.jacobian.iter().skip(variable).step_by(n).map(|slope| -slope).collect();
    Ok(Refit {
        unknowns: objective.parameters(&best.x),
        names: likelihood.names().to_vec(),
        readings: objective.data_rows(),
        free: free.into_iter().map(column).collect(),
        residuals: best.residuals,
    })
}

/// Medians of a likelihood's priors with some unknowns set by name.
pub fn start(likelihood: &Likelihood, values: &[(String, f64)]) -> Vec<f64> {
    let mut start: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    for (name, value) in values {
        if let Some(place) = likelihood.names().iter().position(|unknown| unknown == name) {
            start[place] = *value;
        }
    }
    start
}
