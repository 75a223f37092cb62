//! Two sensors whose channels are exchanged: each reads what the other would.

use super::blank::blank;
use super::probe::share;
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::effect::Site;
use crate::inference::likelihood::{Definition, InputError, Likelihood};
use crate::inference::target::{LeastSquares, Target};
use crate::measurement::Measurement;

/// Predictions of every sensor at every row, found when first asked for.
#[derive(Default)]
pub(super) struct Swaps {
    /// By measurement, `rows x sensors`, SI; or why there are none.
    predictions: Option<Result<Vec<Vec<f64>>, FitError>>,
}

impl Swaps {
    /// The direction of a pair of sensors: amplitude 1 is the exchange.
    pub fn direction(&mut self, base: &Base<'_>, position: usize) -> Found {
        let predictions = self.predictions.get_or_insert_with(|| predictions(base)).as_ref().map_err(Clone::clone)?;
        let Site::Sensors(sensors) = &base.problem.candidates[position].site else {
            return Err(NoDirection::NoSensors.into());
        };
        let [a, b] = sensors.as_slice() else { return Err(NoDirection::NotTwoSensors.into()) };
        let pairs: Vec<Option<[usize; 2]>> = (base.problem.measurements.iter())
            .map(|measurement| {
                let find = |name: &str| measurement.sensors.iter().position(|sensor| sensor.name == name);
                Some([find(&a.name)?, find(&b.name)?])
            })
            .collect();
        let mut column = vec![0.0; base.residuals.len()];
        for (value, datum) in column.iter_mut().zip(base.likelihood.data()) {
            let Some([a, b]) = pairs[datum.measurement] else { continue };
            let other = match datum.sensor {
                sensor if sensor == a => b,
                sensor if sensor == b => a,
                _ => continue,
            };
            let count = base.problem.measurements[datum.measurement].sensors.len();
            let at = |sensor: usize| predictions[datum.measurement][datum.row * count + sensor];
            *value = at(other) - at(datum.sensor);
        }
        if column.iter().all(|value| *value == 0.0) {
            return Err(NoDirection::NoDifference.into());
        }
        base.whitening.apply(&mut column)?;
        column.resize(base.rows, 0.0);
        Ok(vec![share(position, column, Vec::new())])
    }
}

/// Predictions at the fit, as residuals of readings of 0 with noise of 1.
fn predictions(base: &Base<'_>) -> Result<Vec<Vec<f64>>, FitError> {
    let problem = base.problem;
    let blank: Vec<Measurement> = problem.measurements.iter().map(blank).collect();
    let measurements: Vec<&Measurement> = blank.iter().collect();
    let input_errors: Vec<InputError> =
        problem.input_errors.iter().map(|error| InputError { sigma: None, ..*error }).collect();
    let definition = Definition {
        model: &problem.model,
        priors: &problem.priors,
        parameters: &problem.parameters,
        measurements: &measurements,
        input_errors: &input_errors,
    };
    let likelihood = Likelihood::new(&definition)?;
    let likelihood = problem.informed(likelihood, &problem.most_steps);
    let mut residuals = vec![0.0; likelihood.residual_count()];
    likelihood.residuals(&base.carried(&likelihood), &mut likelihood.workspace(), &mut residuals)?;
    let mut predictions: Vec<Vec<f64>> =
        blank.iter().map(|measurement| vec![0.0; measurement.len() * measurement.sensors.len()]).collect();
    for (datum, residual) in likelihood.data().iter().zip(residuals) {
        predictions[datum.measurement][datum.row * blank[datum.measurement].sensors.len() + datum.sensor] = -residual;
    }
    Ok(predictions)
}
