//! The true model of a case: the baseline one with what is hidden added, and the readings that it gives without noise.

use super::inject::InjectError;
use super::truth::Outside;
use crate::diagnosis::{Hypothesis, Problem};
use crate::expression::{Names, Scope, Symbol, parse};
use crate::measurement::prediction::Predictor;
use crate::measurement::{InputColumn, Rows};
use crate::thermal::element::{Element, ElementKind, Load};
use crate::thermal::{Input, Parameter};

/// Temperatures outside are no test that anybody made, K.
const PLAUSIBLE_K: [f64; 2] = [2.0, 900.0];

/// The true model with the values of all its parameters.
#[derive(Clone, Debug)]
pub struct World {
    /// The model with what is hidden, and the measurements as it sees them.
    pub hypothesis: Hypothesis,
    /// All parameters of the model, SI.
    pub parameters: Vec<f64>,
    /// Index of the parameter that sizes physics outside the catalogue, if there is any.
    pub outside: Option<usize>,
    /// Index of the resistance within the nodes of a finer network, K/W, if it is one.
    pub coarseness: Option<usize>,
}

/// An element of a chosen name.
fn named(name: &str, kind: ElementKind) -> Element {
    Element { name: name.to_owned(), kind }
}

impl World {
    /// The baseline model with effects of the problem's candidates, at these values of its own parameters and of the
    /// effects' (in their order).
    ///
    /// # Errors
    /// [`InjectError::Hypothesis`] for effects that do not go together.
    pub fn new(
        problem: &Problem,
        effects: &[usize],
        model_parameters: &[f64],
        values: &[f64],
    ) -> Result<Self, InjectError> {
        let hypothesis = problem.hypothesis(effects, 1.0).map_err(InjectError::Hypothesis)?;
        let parameters = model_parameters.iter().chain(values).copied().collect();
        Ok(Self { hypothesis, parameters, outside: None, coarseness: None })
    }

    pub(super) fn add_parameter(&mut self, name: &str, value: f64) -> usize {
        self.hypothesis.model.parameters.push(Parameter {
            name: name.to_owned(),
            unit: String::new(),
            nominal: value,
            description: String::new(),
            source: String::new(),
        });
        self.parameters.push(value);
        self.parameters.len() - 1
    }

    /// Adds physics that the catalogue lacks, of 0 W. `switch` has the states of what nobody logged, by measurement and
    /// row; it is read for [`Outside::Unlogged`] only.
    ///
    /// # Errors
    /// [`InjectError::NoPlace`] for a node or input that is not there.
    pub fn add_outside(&mut self, outside: &Outside, phase: f64, switch: &[Vec<f64>]) -> Result<(), InjectError> {
        let power = self.add_parameter("hidden.power", 0.0);
        self.outside = Some(power);
        let model = &mut self.hypothesis.model;
        let symbol = |place: usize, of: fn(u32) -> Symbol| of(u32::try_from(place).unwrap_or(u32::MAX));
        let mut names = Names::default();
        let id = model.graph.symbol(symbol(power, Symbol::Parameter));
        names.values.insert("power".to_owned(), id);
        let (node, text) = match outside {
            Outside::Root { node, input } => {
                let input = model
                    .inputs
                    .iter()
                    .position(|model_input| model_input.name == *input)
                    .ok_or(InjectError::NoPlace)?;
                let [lower, upper] = crate::effect::Bound::Input(input).range(model);
                let id = model.graph.symbol(symbol(input, Symbol::Input));
                names.values.insert("x".to_owned(), id);
                (node, format!("power * sqrt(max(0, (x - ({lower})) / ({})))", upper - lower))
            }
            Outside::Swing { node, period_s } => {
                (node, format!("power * sin({} * t + {phase})", core::f64::consts::TAU / period_s))
            }
            Outside::Unlogged { node } => {
                let input = model.inputs.len();
                model.inputs.push(Input {
                    name: "hidden.switch".to_owned(),
                    unit: "1".to_owned(),
                    nominal: 0.0,
                    range: Some([0.0, 1.0]),
                    settable: false,
                    description: String::new(),
                });
                let id = model.graph.symbol(symbol(input, Symbol::Input));
                names.values.insert("switch".to_owned(), id);
                for (measurement, states) in self.hypothesis.measurements.iter_mut().zip(switch) {
                    match &mut measurement.rows {
                        Rows::Steady(phases) => {
                            for (phase, state) in phases.iter_mut().zip(states) {
                                phase.inputs.push(*state);
                            }
                        }
                        Rows::Transient { inputs, .. } => {
                            inputs.base.push(0.0);
                            inputs.columns.push(InputColumn { input, values: states.clone(), hold: true });
                        }
                    }
                }
                (node, "power * switch".to_owned())
            }
        };
        let into = model.nodes.iter().position(|model_node| model_node.name == *node).ok_or(InjectError::NoPlace)?;
        let power =
            parse(&text, &mut model.graph, &Scope::new(&names)).map_err(|error| InjectError::Fit(error.message))?;
        model.elements.push(named("hidden heat", ElementKind::Load(Load { into, power })));
        Ok(())
    }

    /// The readings without noise: by measurement, `rows x sensors`, SI; NaN where nothing was read.
    ///
    /// # Errors
    /// [`InjectError::Implausible`] where the model has no solution or one at temperatures that nobody tests.
    pub fn readings(&self) -> Result<Vec<Vec<f64>>, InjectError> {
        let predictor =
            Predictor::new(&self.hypothesis.model, &[]).map_err(|error| InjectError::Fit(error.to_string()))?;
        let mut workspace = predictor.workspace();
        let mut all = Vec::new();
        for measurement in &self.hypothesis.measurements {
            let prediction = predictor.predict(&mut workspace, measurement, &self.parameters);
            let sensors = measurement.sensors.len();
            let plausible = |kelvin: &f64| (PLAUSIBLE_K[0]..PLAUSIBLE_K[1]).contains(kelvin);
            let nodes = self.hypothesis.model.nodes.len();
            for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
                let temperatures = &prediction.temperatures[row * nodes..(row + 1) * nodes];
                let read = &prediction.readings[row * sensors..(row + 1) * sensors];
                if !temperatures.iter().all(plausible) || !read.iter().all(|value| value.is_finite()) {
                    return Err(InjectError::Implausible);
                }
            }
            all.push(prediction.readings);
        }
        Ok(all)
    }
}
