//! What the model predicts for a measurement's readings.

use crate::expression::Symbol;
use crate::thermal::transient::{InitialState, TransientRequest};
use crate::thermal::{Model, Network, NetworkError, NodeKind, Quantity, Start, Workspace};

use crate::measurement::{Initial, InputTable, Measurement, Rows};

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
    /// Predicted readings, `rows x sensors`, SI; not finite where the solution failed or the measured quantity has no number.
    pub readings: Vec<f64>,
    /// Temperatures, `rows x nodes`, K; NaN where the solution failed.
    pub temperatures: Vec<f64>,
    /// Heat from the row on; `None` where the solution failed, a heat has no number, or the network has switched heaters in a
    /// transient.
    pub heat: Vec<Option<RowHeat>>,
    /// The same just before the row: what differs is that a held input has not yet stepped.
    pub heat_before: Vec<Option<RowHeat>>,
    /// What failed and why, also where a quantity has no number: the row of a steady measurement, `None` for a transient.
    pub failures: Vec<(Option<usize>, String)>,
}

/// A network with the quantities that sensors measure, for predicting measurements.
#[derive(Debug)]
pub struct Predictor {
    network: Network,
    quantities: Vec<Quantity>,
    nodes: usize,
    capacities_switch: bool,
    /// Whether no node is without storage.
    stores_everywhere: bool,
    most_steps_a_row: Option<u64>,
}

impl Predictor {
    /// Compiles the model; `differentiate` lists the symbols whose derivatives will be asked.
    ///
    /// # Errors
    /// What is wrong with the network.
    pub fn new(model: &Model, differentiate: &[Symbol]) -> Result<Self, NetworkError> {
        let switched = model.elements.iter().any(|element| element.physics().is_switched());
        Ok(Self {
            network: Network::compile(model, differentiate)?,
            quantities: model.quantities.clone(),
            nodes: model.nodes.len(),
            stores_everywhere: !model.nodes.iter().any(|n| matches!(n.kind, NodeKind::Arithmetic)),
            most_steps_a_row: None,
            capacities_switch: switched && model.nodes.iter().any(|n| matches!(n.kind, NodeKind::Diffusion { .. })),
        })
    }

    /// The same with a number of attempted steps, times the rows of a transient, after which that has no prediction.
    pub fn with_most_steps_a_row(mut self, most_steps_a_row: Option<u64>) -> Self {
        self.most_steps_a_row = most_steps_a_row;
        self
    }

    /// The compiled network.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Room for predictions.
    pub fn workspace(&self) -> Workspace {
        self.network.workspace()
    }

    /// Predicts all rows of a measurement at given parameters (SI, in the model's order), with each sensor's bias, lag
    /// and clock at their known or median values, or at the parameter that they are.
    pub fn predict(&self, workspace: &mut Workspace, measurement: &Measurement, parameters: &[f64]) -> Prediction {
        let rows = measurement.len();
        let mut prediction = Prediction {
            readings: vec![f64::NAN; rows * measurement.sensors.len()],
            temperatures: vec![f64::NAN; rows * self.nodes],
            heat: vec![None; rows],
            heat_before: vec![None; rows],
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
                let value = self.network.quantity(workspace, sensor.quantity);
                prediction.readings[row * sensors.len() + position] = value;
                if let Some(fault) = self.quantities[sensor.quantity].fault(value) {
                    prediction.failures.push((Some(row), format!("sensor `{}`: {fault}", sensor.name)));
                }
            }
            prediction.temperatures[row * self.nodes..(row + 1) * self.nodes].copy_from_slice(workspace.temperatures());
            prediction.heat[row] = self.row_heat(workspace);
            prediction.heat_before[row].clone_from(&prediction.heat[row]);
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
        let (sensors, rows) = (&measurement.sensors, inputs.times_s.len());
        let start: Vec<f64>;
        let (initial, in_balance): (_, &[usize]) = match initial {
            Initial::Temperatures { values, balanced, .. } => {
                start = values.iter().map(crate::measurement::Uncertain::nominal).collect();
                (InitialState::Temperatures(&start), balanced)
            }
            Initial::Steady => (InitialState::Steady, &[]),
            Initial::Periodic => (InitialState::Periodic, &[]),
        };
        let mut request = TransientRequest::new(parameters, inputs, initial, &inputs.times_s);
        request.balanced = in_balance;
        if let Some(most) = self.most_steps_a_row {
            request.options.most_steps = most.saturating_mul(rows as u64).min(request.options.most_steps);
        }
        let transient = match self.network.solve_transient(&request) {
            Ok(transient) => transient,
            Err(error) => {
                prediction.failures.push((None, error.to_string()));
                return;
            }
        };
        let quantities = self.network.quantities();
        for (position, sensor) in sensors.iter().enumerate() {
            let truth: Vec<f64> =
                (0..rows).map(|row| transient.quantities[row * quantities + sensor.quantity]).collect();
            let fault = |(&time_s, &value): (&f64, &f64)| {
                let fault = self.quantities[sensor.quantity].fault(value)?;
                Some(format!("sensor `{}`: {fault} at {time_s} s", sensor.name))
            };
            let fault = inputs.times_s.iter().zip(&truth).find_map(fault);
            prediction.failures.extend(fault.map(|fault| (None, fault)));
            let read = sensor.timing(parameters).reading(&inputs.times_s, &truth);
            for (row, value) in read.into_iter().enumerate() {
                prediction.readings[row * sensors.len() + position] = value;
            }
        }
        prediction.temperatures.copy_from_slice(&transient.temperatures);
        if !self.capacities_switch {
            self.network.set_parameters(workspace, parameters);
            for row in 0..rows {
                let temperatures = &transient.temperatures[row * self.nodes..(row + 1) * self.nodes];
                let mut heat_with = |values: &[f64]| {
                    self.network.set_inputs(workspace, values);
                    self.network.set_time(workspace, inputs.times_s[row]);
                    self.network.set_temperatures(workspace, temperatures);
                    self.row_heat(workspace)
                };
                let (before, from) = (inputs_before(inputs, row), inputs_from(inputs, row));
                let heat_before = heat_with(&before);
                let heat = if before == from || self.stores_everywhere { heat_with(&from) } else { None };
                prediction.heat_before[row] = heat_before;
                prediction.heat[row] = heat;
            }
            // Nodes without storage jump at a step, and the temperatures are those before it: the heat at the end of
            // the interval stands for that at its start.
            for row in 0..rows {
                if prediction.heat[row].is_none() {
                    prediction.heat[row] = prediction.heat_before[(row + 1).min(rows - 1)].clone();
                }
            }
        }
    }

    fn row_heat(&self, workspace: &mut Workspace) -> Option<RowHeat> {
        if self.network.external().is_some() {
            // Nobody knows the heat of a model that is asked outside.
            return None;
        }
        let balance = self.network.heat_balance(workspace);
        let numbers =
            balance.into_boundaries.iter().map(|boundary| boundary.1).chain([balance.source_w, balance.stored_w]);
        numbers.fold(0.0, |sum, heat| sum + heat).is_finite().then_some(RowHeat {
            sources_w: balance.source_w,
            into_boundaries_w: balance.into_boundaries,
            stored_w: balance.stored_w,
        })
    }
}

/// Every input from a row of the table on.
fn inputs_from(table: &InputTable, row: usize) -> Vec<f64> {
    (0..table.base.len()).map(|input| table.in_row(row, input)).collect()
}

/// Every input at a row, held ones as they are until there.
fn inputs_before(table: &InputTable, row: usize) -> Vec<f64> {
    let mut values = inputs_from(table, row);
    for column in table.columns.iter().filter(|column| column.hold) {
        values[column.input] = column.values[row.saturating_sub(1)];
    }
    values
}
