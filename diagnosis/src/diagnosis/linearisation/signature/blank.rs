//! Measurements whose residuals are predictions: readings of 0 with noise of 1.

use super::Base;
use crate::diagnosis::FitError;
use crate::diagnosis::thinned::last_fitted;
use crate::inference::likelihood::{Definition, InputError, Likelihood};
use crate::inference::target::{LeastSquares, Target};
use crate::measurement::{Measurement, Rows, Uncertain};

/// By measurement what each sensor reads in each row, `rows x sensors`, SI; 0 in rows that its residuals leave out.
pub(super) type Predictions = Vec<Vec<f64>>;

/// A measurement with a reading of 0 in every row up to the last that has one to fit.
pub(super) fn blank(measurement: &Measurement) -> Measurement {
    let mut blank = measurement.clone();
    let read = last_fitted(measurement).map_or(0, |last| last + 1) * blank.sensors.len();
    for (place, reading) in blank.readings.iter_mut().enumerate() {
        *reading = (place < read).then_some(0.0);
    }
    for sensor in &mut blank.sensors {
        sensor.sigma = Some(Uncertain::Known(1.0));
        sensor.correlation_time_s = None;
        sensor.white = None;
    }
    blank
}

/// A blank measurement of which all rows are fitted, where some are, and whose sensors show what happens when it does.
pub(super) fn blank_truth(measurement: &Measurement) -> Measurement {
    let mut blank = blank(measurement);
    for sensor in &mut blank.sensors {
        sensor.lag_s = None;
        sensor.behind_s.clear();
    }
    if last_fitted(measurement).is_some()
        && let Rows::Transient { held_out, ignored, .. } = &mut blank.rows
    {
        blank.readings.fill(Some(0.0));
        held_out.fill(false);
        ignored.fill(None);
    }
    blank
}

/// Predictions at the fit, as residuals of blank measurements.
pub(super) fn predictions(base: &Base<'_>, blank: Vec<Measurement>) -> Result<Predictions, FitError> {
    let problem = base.problem;
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
    // There may be more rows than those that are fitted.
    let likelihood = problem.informed(likelihood, &[]);
    let mut residuals = vec![0.0; likelihood.residual_count()];
    likelihood.residuals(&base.carried(&likelihood), &mut likelihood.workspace(), &mut residuals)?;
    let mut predictions: Vec<Vec<f64>> =
        blank.iter().map(|measurement| vec![0.0; measurement.len() * measurement.sensors.len()]).collect();
    for (datum, residual) in likelihood.data().iter().zip(residuals) {
        predictions[datum.measurement][datum.row * blank[datum.measurement].sensors.len() + datum.sensor] = -residual;
    }
    Ok(predictions)
}
