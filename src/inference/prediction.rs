//! What the model predicts for a measurement's readings.

use crate::expression::Symbol;
use crate::thermal::transient::{InitialState, TransientRequest};
use crate::thermal::{Model, Network, NetworkError, NodeKind, Start, Workspace};

use super::measurement::{Initial, InputTable, Measurement, Rows};

/// Heat of the model in one row, W.
#[derive(Clone, Debug, PartialEq)]
pub struct RowHeat {
    /// Heat of the sources.
    pub sources_w: f64,
    /// Heat into each boundary: node index and W.
    pub into_boundaries_w: Vec<(usize, f64)>,
    /// Heat stored.
    pub stored_w: f64,
}

/// A prediction for every row and sensor of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Predicted readings, `rows x sensors`, SI; NaN where the solution failed.
    pub readings: Vec<f64>,
    /// Temperatures, `rows x nodes`, K; NaN where the solution failed.
    pub temperatures: Vec<f64>,
    /// Heat by row; `None` where the solution failed or the network has switched heaters in a transient.
    pub heat: Vec<Option<RowHeat>>,
    /// What failed and why: the row of a steady measurement, `None` for a transient.
    pub failures: Vec<(Option<usize>, String)>,
}

/// A network with the quantities that sensors measure, for predicting measurements.
#[derive(Debug)]
pub struct Predictor {
    network: Network,
    nodes: usize,
    capacities_switch: bool,
}

impl Predictor {
    /// Compiles the model; `differentiate` lists the symbols whose derivatives will be asked.
    ///
    /// # Errors
    /// What is wrong with the network.
    pub fn new(model: &Model, differentiate: &[Symbol]) -> Result<Self, NetworkError> {
        let switched = model.elements.iter().any(|element| element.is_switched());
        Ok(Self {
            network: Network::compile(model, differentiate)?,
            nodes: model.nodes.len(),
            capacities_switch: switched && model.nodes.iter().any(|n| matches!(n.kind, NodeKind::Diffusion { .. })),
        })
    }

    /// The compiled network.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Room for predictions.
    pub fn workspace(&self) -> Workspace {
        self.network.workspace()
    }

    /// Predicts all rows of a measurement at given parameters (SI, in the model's order), with each sensor's bias and
    /// lag at their known or median values, or at the parameter that they are.
    pub fn predict(&self, workspace: &mut Workspace, measurement: &Measurement, parameters: &[f64]) -> Prediction {
        let rows = measurement.len();
        let mut prediction = Prediction {
            readings: vec![f64::NAN; rows * measurement.sensors.len()],
            temperatures: vec![f64::NAN; rows * self.nodes],
            heat: vec![None; rows],
            failures: Vec::new(),
        };
        match &measurement.rows {
            Rows::Steady(_) => self.predict_steady(workspace, measurement, parameters, &mut prediction),
            Rows::Transient { .. } => self.predict_transient(workspace, measurement, parameters, &mut prediction),
        }
        for (position, sensor) in measurement.sensors.iter().enumerate() {
            if let Some(bias) = &sensor.bias {
                for row in 0..rows {
                    prediction.readings[row * measurement.sensors.len() + position] += bias.at(parameters);
                }
            }
        }
        prediction
    }

    fn predict_steady(
        &self,
        workspace: &mut Workspace,
        measurement: &Measurement,
        parameters: &[f64],
        prediction: &mut Prediction,
    ) {
        let Rows::Steady(phases) = &measurement.rows else { return };
        let sensors = &measurement.sensors;
        self.network.set_parameters(workspace, parameters);
        self.network.set_time(workspace, 0.0);
        for (row, phase) in phases.iter().enumerate().filter(|(_, phase)| phase.ignored.is_none()) {
            self.network.set_inputs(workspace, &phase.inputs);
            if let Err(error) = self.network.solve_steady(workspace, Start::Default) {
                prediction.failures.push((Some(row), error.to_string()));
                continue;
            }
            for (position, sensor) in sensors.iter().enumerate() {
                prediction.readings[row * sensors.len() + position] = self.network.quantity(workspace, sensor.quantity);
            }
            prediction.temperatures[row * self.nodes..(row + 1) * self.nodes].copy_from_slice(workspace.temperatures());
            prediction.heat[row] = Some(self.row_heat(workspace));
        }
    }

    fn predict_transient(
        &self,
        workspace: &mut Workspace,
        measurement: &Measurement,
        parameters: &[f64],
        prediction: &mut Prediction,
    ) {
        let Rows::Transient { inputs, initial, .. } = &measurement.rows else { return };
        let sensors = &measurement.sensors;
        let start: Vec<f64>;
        let initial = match initial {
            Initial::Temperatures(values) => {
                start = values.iter().map(super::measurement::Uncertain::nominal).collect();
                InitialState::Temperatures(&start)
            }
            Initial::Steady => InitialState::Steady,
            Initial::Periodic => InitialState::Periodic,
        };
        let request = TransientRequest::new(parameters, inputs, initial, &inputs.times_s);
        let transient = match self.network.solve_transient(&request) {
            Ok(transient) => transient,
            Err(error) => {
                prediction.failures.push((None, error.to_string()));
                return;
            }
        };
        let rows = inputs.times_s.len();
        let quantities = self.network.quantities();
        for (position, sensor) in sensors.iter().enumerate() {
            let truth: Vec<f64> =
                (0..rows).map(|row| transient.quantities[row * quantities + sensor.quantity]).collect();
            let tau_s = sensor.lag_s.as_ref().map_or(0.0, |lag| lag.at(parameters));
            let read = lagged(&inputs.times_s, &truth, tau_s);
            for (row, value) in read.into_iter().enumerate() {
                prediction.readings[row * sensors.len() + position] = value;
            }
        }
        prediction.temperatures.copy_from_slice(&transient.temperatures);
        if !self.capacities_switch {
            self.network.set_parameters(workspace, parameters);
            for row in 0..rows {
                self.network.set_inputs(workspace, &inputs_at(inputs, row));
                self.network.set_time(workspace, inputs.times_s[row]);
                self.network
                    .set_temperatures(workspace, &transient.temperatures[row * self.nodes..(row + 1) * self.nodes]);
                prediction.heat[row] = Some(self.row_heat(workspace));
            }
        }
    }

    fn row_heat(&self, workspace: &mut Workspace) -> RowHeat {
        let balance = self.network.heat_balance(workspace);
        RowHeat { sources_w: balance.source_w, into_boundaries_w: balance.into_boundaries, stored_w: balance.stored_w }
    }
}

/// Every input in a row of the table.
fn inputs_at(table: &InputTable, row: usize) -> Vec<f64> {
    let mut values = table.base.clone();
    for column in &table.columns {
        values[column.input] = column.values[row];
    }
    values
}

/// Reading of a sensor that follows the truth with a time constant: `tau ds/dt = truth - s`, started at the truth,
/// exact for a truth that is linear between rows.
fn lagged(times_s: &[f64], truth: &[f64], tau_s: f64) -> Vec<f64> {
    if tau_s <= 0.0 || truth.is_empty() {
        return truth.to_vec();
    }
    let mut reading = truth[0];
    let mut readings = vec![reading];
    for row in 1..truth.len() {
        let step_s = times_s[row] - times_s[row - 1];
        let slope = (truth[row] - truth[row - 1]) / step_s;
        // Solution for a ramp: it runs behind the ramp by slope x tau, which an initial difference decays to.
        let decay = crate::math::functions::exp(-step_s / tau_s);
        let behind = reading - (truth[row - 1] - slope * tau_s);
        reading = truth[row] - slope * tau_s + behind * decay;
        readings.push(reading);
    }
    readings
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn a_lagging_sensor_follows_a_ramp_one_time_constant_behind() {
        let times: Vec<f64> = (0..200).map(f64::from).collect();
        let truth: Vec<f64> = times.iter().map(|t| 0.5 * t).collect();
        let read = lagged(&times, &truth, 14.0);
        // s(t) = a (t - tau) + a tau exp(-t / tau), the closed form.
        for (t, s) in times.iter().zip(&read) {
            let expected = 0.5 * (t - 14.0) + 0.5 * 14.0 * crate::math::functions::exp(-t / 14.0);
            assert!((s - expected).abs() < 1e-10, "{t}: {s} {expected}");
        }
    }

    #[test]
    fn no_lag_reads_the_truth() {
        assert_eq!(lagged(&[0.0, 1.0], &[3.0, 4.0], 0.0), [3.0, 4.0]);
    }
}
