//! From model and measurements to a likelihood.

use std::sync::Arc;

use super::input_error::InputErrors;
use super::steady::SteadyPart;
use super::transient::TransientPart;
use super::{Datum, Definition, Likelihood, LikelihoodError, Part, SensorPart};
use crate::expression::{Symbol, Unit};
use crate::inference::likelihood::noise::Noise;
use crate::measurement::unknown::{Unknowns, Value, bias_name, sensor_name};
use crate::measurement::{Measurement, Rows, Uncertain};
use crate::random::Distribution;
use crate::thermal::{Model, Network};

/// A model reduced to the measured quantities, and the new position of each old one.
fn reduced(model: &Model, measurements: &[&Measurement]) -> (Model, Vec<Option<usize>>) {
    let mut position = vec![None; model.quantities.len()];
    let mut quantities = Vec::new();
    for sensor in measurements.iter().flat_map(|measurement| &measurement.sensors) {
        if position[sensor.quantity].is_none() {
            position[sensor.quantity] = Some(quantities.len());
            quantities.push(model.quantities[sensor.quantity].clone());
        }
    }
    (Model { quantities, ..model.clone() }, position)
}

fn symbol(place: usize, of: fn(u32) -> Symbol) -> Symbol {
    of(u32::try_from(place).unwrap_or(u32::MAX))
}

/// Builds the likelihood.
pub(super) fn build(definition: &Definition<'_>) -> Result<Likelihood, LikelihoodError> {
    let Definition { model, priors, parameters, measurements, input_errors } = *definition;
    let (model, position) = reduced(model, measurements);
    let mut unknowns = Unknowns::default();
    let base: Vec<f64> = (model.parameters.iter().enumerate())
        .map(|(index, parameter)| match priors.get(index) {
            Some(Distribution::Fixed(value)) => *value,
            _ => parameter.nominal,
        })
        .collect();
    let parameters: Vec<usize> =
        parameters.iter().copied().filter(|&p| priors.get(p).is_some_and(|prior| !prior.is_fixed())).collect();
    for &parameter in &parameters {
        let model_parameter = &model.parameters[parameter];
        unknowns.push(model_parameter.name.clone(), priors[parameter], &model_parameter.unit);
        unknowns.model.push(parameter);
    }
    let mut parts = Vec::new();
    let mut data: Vec<Datum> = Vec::new();
    for (index, measurement) in measurements.iter().enumerate() {
        let sensors = sensors(&model, &base, &position, measurement, &mut unknowns)?;
        match &measurement.rows {
            Rows::Steady(_) => {
                parts.push(Part::Steady(SteadyPart::new(measurement, index, sensors, &mut data)));
            }
            Rows::Transient { .. } => {
                parts.push(Part::Transient(TransientPart::new(
                    &model,
                    measurement,
                    index,
                    sensors,
                    &mut unknowns,
                    &mut data,
                )));
            }
        }
    }
    let mut biases = Vec::new();
    for (input, error) in input_errors.iter().enumerate().take(model.inputs.len()) {
        if let Some(prior) = error.bias.filter(|prior| !prior.is_fixed()) {
            let model_input = &model.inputs[input];
            let unit = Unit::parse(&model_input.unit)
                .map_or_else(|_| model_input.unit.clone(), |unit| unit.difference_text().to_owned());
            unknowns.push(bias_name(&model_input.name), prior, &unit);
            biases.push((input, unknowns.len() - 1));
        }
    }
    for (place, name) in unknowns.names.iter().enumerate() {
        if unknowns.names[..place].contains(name) {
            return Err(LikelihoodError::Twice { name: name.clone() });
        }
    }
    if data.is_empty() {
        return Err(LikelihoodError::NoData);
    }
    if unknowns.is_empty() {
        return Err(LikelihoodError::NoUnknowns);
    }
    let mut symbols: Vec<Symbol> = parameters.iter().map(|&p| symbol(p, Symbol::Parameter)).collect();
    symbols.extend(biases.iter().map(|&(input, _)| symbol(input, Symbol::Input)));
    let mut columns: Vec<usize> = (0..parameters.len()).collect();
    columns.extend(biases.iter().map(|&(_, place)| place));
    let noisy: Vec<(usize, f64)> = (input_errors.iter().enumerate().take(model.inputs.len()))
        .filter_map(|(input, error)| Some((input, error.sigma.filter(|sigma| *sigma > 0.0)?)))
        .collect();
    let mut known_errors = None;
    if !noisy.is_empty() {
        let symbols: Vec<Symbol> = noisy.iter().map(|&(input, _)| symbol(input, Symbol::Input)).collect();
        let sigmas = noisy.iter().map(|&(_, sigma)| sigma).collect();
        let errors = InputErrors::new(Network::compile(&model, &symbols)?, sigmas);
        for part in &mut parts {
            if let Part::Steady(part) = part {
                part.set_input_errors(&errors, &base)?;
            }
        }
        known_errors = Some(Arc::new(errors));
    }
    let network = Network::compile(&model, &symbols)?;
    let mut likelihood = Likelihood {
        unknowns,
        network,
        base,
        parameters,
        biases,
        columns,
        parts,
        data,
        known_errors,
        joint: Vec::new(),
        most_steps: Vec::new(),
        tolerance: 1.0,
    };
    let nominal: Vec<f64> = (likelihood.unknowns.priors.iter().enumerate())
        .map(|(place, prior)| match likelihood.parameters.get(place) {
            Some(&parameter) => likelihood.base[parameter],
            None if likelihood.biases.iter().any(|&(_, bias_place)| bias_place == place) => 0.0,
            None => prior.quantile(0.5),
        })
        .collect();
    likelihood.set_reference(&nominal);
    Ok(likelihood)
}

/// Sensors with what is inferred of them. Steady data know no lag and no correlation in time.
fn sensors(
    model: &Model,
    parameters: &[f64],
    position: &[Option<usize>],
    measurement: &Measurement,
    unknowns: &mut Unknowns,
) -> Result<Vec<SensorPart>, LikelihoodError> {
    let over_time = matches!(measurement.rows, Rows::Transient { .. });
    let mut parts = Vec::new();
    for (place, sensor) in measurement.sensors.iter().enumerate() {
        let quantity = position[sensor.quantity].unwrap_or(0);
        let unit = &model.quantities[quantity].unit;
        let names = |what: &str| sensor_name(&measurement.name, &sensor.name, what);
        let used = (0..measurement.len()).any(|row| is_used(measurement, row, place));
        let mut value = |written: Option<&Uncertain>, what: &str, unit: &str| -> Option<Value> {
            // Nothing is asked of a sensor without a reading to fit.
            let written = written?;
            let fixed = Value::Known(written.at(parameters));
            Some(if used { unknowns.add(names(what), written, unit, parameters) } else { fixed })
        };
        let sigma = value(sensor.sigma.as_ref(), "sigma", unit);
        let Some(sigma) = sigma.or_else(|| (!used).then_some(Value::Known(1.0))) else {
            let (measurement, sensor) = (measurement.name.clone(), sensor.name.clone());
            return Err(LikelihoodError::NoSigma { measurement, sensor });
        };
        if let Value::Known(sd) = sigma
            && !(sd > 0.0 && sd.is_finite())
        {
            let (measurement, sensor) = (measurement.name.clone(), sensor.name.clone());
            return Err(LikelihoodError::Sigma { measurement, sensor, value: sd });
        }
        let white = value(sensor.white.as_ref(), "white", unit);
        let bias = value(sensor.bias.as_ref(), "bias", unit);
        let (mut correlation_time_s, mut lag_s, mut behind_s) = (None, None, Vec::new());
        if over_time {
            correlation_time_s = value(sensor.correlation_time_s.as_ref(), "correlation_time", "s");
            lag_s = value(sensor.lag_s.as_ref(), "lag", "s");
            behind_s = sensor.behind_s.iter().filter_map(|one| value(Some(one), "clock_behind", "s")).collect();
        }
        parts.push(SensorPart { quantity, noise: Noise { sigma, correlation_time_s, white }, bias, lag_s, behind_s });
    }
    Ok(parts)
}

/// Whether a reading takes part in the fit.
pub(in crate::inference) fn is_used(measurement: &Measurement, row: usize, sensor: usize) -> bool {
    measurement.is_fitted(row) && measurement.reading(row, sensor).is_some()
}
