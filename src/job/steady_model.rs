//! The steady state of a network as a function of vectors: parameters, and inputs where the model has some, give the
//! quantities of an instant. All numbers are in SI units; derivatives are exact (implicit function theorem).

use super::JobError;
use crate::expression::{Symbol, Unit};
use crate::thermal::{Model, Network, QuantityValue, Start, Workspace};

/// An entry of a vector.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Entry {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Nominal value, SI; of a quantity `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
}

/// A network, ready to be evaluated from many threads.
#[derive(Debug)]
pub struct SteadyModel {
    network: Network,
    /// Entries of each vector that is given: parameters; inputs.
    inputs: Vec<Vec<Entry>>,
    /// Entries of the vector that comes out.
    outputs: Vec<Entry>,
    /// Positions in the model of the quantities that come out.
    quantities: Vec<usize>,
}

impl SteadyModel {
    /// Compiles a model. Quantities over time have no value in a steady state and are left out.
    ///
    /// # Errors
    /// A network that cannot be compiled or has no path to a boundary; no quantity, or no parameter.
    pub fn new(model: &Model) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let symbols: Vec<Symbol> = (0_u32..)
            .zip(&model.parameters)
            .map(|(place, _)| Symbol::Parameter(place))
            .chain((0_u32..).zip(&model.inputs).map(|(place, _)| Symbol::Input(place)))
            .collect();
        let network = Network::compile(model, &symbols).map_err(|error| failed(error.to_string()))?;
        if let Some(external) = network.external() {
            external.ready().map_err(failed)?;
        }
        if let Some(nodes) = network.isolated_nodes() {
            return Err(failed(format!("no steady state: {} have no path to a boundary", nodes.join(", "))));
        }
        let entry = |name: &str, unit: &str, nominal: f64| {
            let unit = Unit::parse(unit).map_or_else(|_| unit.to_owned(), |unit| Unit::si(unit.dimension).text);
            Entry { name: name.to_owned(), unit, nominal: Some(nominal) }
        };
        let mut inputs: Vec<Vec<Entry>> = vec![
            model.parameters.iter().map(|own| entry(&own.name, &own.unit, own.nominal)).collect(),
            model.inputs.iter().map(|own| entry(&own.name, &own.unit, own.nominal)).collect(),
        ];
        if inputs[0].is_empty() {
            return Err(failed("the model has no parameter that could be given".to_owned()));
        }
        inputs.retain(|entries| !entries.is_empty());
        let is_instant = |place: &usize| matches!(model.quantities[*place].value, QuantityValue::Instant(_));
        let quantities: Vec<usize> = (0..model.quantities.len()).filter(is_instant).collect();
        if quantities.is_empty() {
            return Err(failed("the model has no quantity that could be asked for: give it `quantities`".to_owned()));
        }
        let outputs = quantities.iter().map(|&place| {
            let quantity = &model.quantities[place];
            Entry { name: quantity.name.clone(), unit: quantity.unit.clone(), nominal: None }
        });
        Ok(Self { outputs: outputs.collect(), network, inputs, quantities })
    }

    /// Whether it has exact derivatives: it does not where it is asked outside.
    pub fn has_derivatives(&self) -> bool {
        self.network.external().is_none()
    }

    /// Entries of each vector that is given.
    pub fn inputs(&self) -> &[Vec<Entry>] {
        &self.inputs
    }

    /// Entries of the vector that comes out.
    pub fn outputs(&self) -> &[Entry] {
        &self.outputs
    }

    /// Solves at vectors that are as long as [`SteadyModel::inputs`] says.
    fn solved(&self, at: &[Vec<f64>]) -> Result<Workspace, JobError> {
        let mut workspace = self.network.workspace();
        if let Some(parameters) = at.first() {
            self.network.set_parameters(&mut workspace, parameters);
        }
        if let Some(inputs) = at.get(1) {
            self.network.set_inputs(&mut workspace, inputs);
        }
        let solved = self.network.solve_steady(&mut workspace, Start::Default);
        solved.map_err(|error| JobError::Failed(error.to_string()))?;
        Ok(workspace)
    }

    /// Where the derivatives by a vector's entries stand among those by all symbols.
    fn columns(&self, input: usize) -> std::ops::Range<usize> {
        let first = self.inputs.iter().take(input).map(Vec::len).sum();
        first..first + self.inputs.get(input).map_or(0, Vec::len)
    }

    /// The quantities.
    ///
    /// # Errors
    /// No steady state there, or a quantity that is no finite number.
    pub fn evaluate(&self, at: &[Vec<f64>]) -> Result<Vec<f64>, JobError> {
        let workspace = self.solved(at)?;
        finite(self.quantities.iter().map(|&quantity| self.network.quantity(&workspace, quantity)).collect())
    }

    /// The derivative of the quantities' sum with these weights by the entries of a vector: one adjoint solve.
    ///
    /// # Errors
    /// As [`SteadyModel::evaluate`].
    pub fn gradient(&self, at: &[Vec<f64>], input: usize, weights: &[f64]) -> Result<Vec<f64>, JobError> {
        let mut workspace = self.solved(at)?;
        let mut of_all = vec![0.0; self.network.quantities()];
        for (&quantity, weight) in self.quantities.iter().zip(weights) {
            of_all[quantity] = *weight;
        }
        let mut gradient = vec![0.0; self.network.differentiated().len()];
        let done = self.network.quantity_gradient(&mut workspace, &of_all, &mut gradient);
        done.map_err(|error| JobError::Failed(error.to_string()))?;
        finite(gradient.get(self.columns(input)).unwrap_or_default().to_vec())
    }

    /// The derivative of every quantity along a direction of a vector.
    ///
    /// # Errors
    /// As [`SteadyModel::evaluate`].
    pub fn apply_jacobian(&self, at: &[Vec<f64>], input: usize, direction: &[f64]) -> Result<Vec<f64>, JobError> {
        let mut workspace = self.solved(at)?;
        let symbols = self.network.differentiated().len();
        let mut tangent = vec![0.0; self.network.quantities() * symbols];
        let done = self.network.quantity_tangent(&mut workspace, &mut tangent);
        done.map_err(|error| JobError::Failed(error.to_string()))?;
        let columns = self.columns(input);
        let along = |quantity: &usize| {
            let slopes = tangent.get(quantity * symbols + columns.start..quantity * symbols + columns.end);
            slopes.unwrap_or_default().iter().zip(direction).map(|(slope, part)| slope * part).sum()
        };
        finite(self.quantities.iter().map(along).collect())
    }
}

/// Numbers that are all finite.
fn finite(values: Vec<f64>) -> Result<Vec<f64>, JobError> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(values)
    } else {
        Err(JobError::Failed("a value is no finite number there".to_owned()))
    }
}
