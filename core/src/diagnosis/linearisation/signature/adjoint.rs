//! Exact derivatives of steady phases: what an effect at amplitude 0 would do, from one solution of each phase.
//!
//! With the balances `r(T, a) = 0` and a reading `q(T, a)`: `dq/da = dq/da|T - l' dr/da`, `J' l = dq/dT`. The adjoints
//! `l` are those of the model without effects, a solve a reading; of each candidate only `dr/da` and `dq/da|T` are
//! wanted, a few expressions, evaluated at the solution. Effects are added one after another to one model and taken
//! out again, so that their number costs no more than itself.

use super::variant::{self, Variant};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::linear::Direction;
use crate::effect::{Instance, SensorChange, Site, apply};
use crate::expression::{ExprId, Program, Symbol};
use crate::inference::likelihood::{Likelihood, SteadyState};
use crate::inference::target::Rejected;
use crate::thermal::{Model, NodeKind};

/// The phases at the fit.
pub(super) struct Phases {
    states: Vec<SteadyState>,
    parameters: Vec<f64>,
}

/// What an amplitude does at fixed temperatures, as positions among the outputs of a program.
#[derive(Default)]
struct Slopes {
    /// Node and heat into it a unit.
    heats: Vec<(usize, usize)>,
    /// Quantity and its change a unit.
    quantities: Vec<(usize, usize)>,
    /// Sensor and the change of its reading a unit, in place of its quantity's.
    readings: Vec<(String, usize)>,
}

/// A model to which effects are added and from which they are taken again.
struct Bench<'a> {
    original: &'a Model,
    model: Model,
    outputs: Vec<ExprId>,
    /// Boundaries that effects added: node and temperature.
    surroundings: Vec<(usize, ExprId)>,
}

impl Phases {
    pub fn new(likelihood: &Likelihood, unknowns: &[f64]) -> Result<Self, Rejected> {
        let states = likelihood.steady_states(unknowns)?;
        Ok(Self { states, parameters: likelihood.full_parameters(unknowns) })
    }

    /// Adds the directions of variants to what was found of their candidates.
    pub fn directions(&self, base: &Base<'_>, variants: &[Variant<'_>], directions: &mut [Found]) {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Result<Vec<Slopes>, FitError>> =
            variants.iter().map(|variant| bench.slopes(base, variant)).collect();
        let values = self.evaluate(&bench);
        let mut column = vec![0.0; base.residuals.len()];
        for (variant, slopes) in variants.iter().zip(slopes) {
            let columns = slopes.and_then(|slopes| {
                let columns = slopes.iter().map(|slopes| {
                    self.column(base, slopes, &values, &mut column);
                    base.whitening.apply(&mut column)?;
                    Ok(column.clone())
                });
                columns.collect::<Result<Vec<Vec<f64>>, FitError>>()
            });
            let direction: Result<Option<Direction>, FitError> =
                columns.and_then(|columns| variant.direction(base, columns.into_iter()));
            variant::put(&mut directions[variant.asked], direction);
        }
    }

    /// Whitened columns of the heat that elements carry.
    pub fn heats_of_elements(&self, base: &Base<'_>, elements: &[usize]) -> Result<Vec<Vec<f64>>, FitError> {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Slopes> = elements
            .iter()
            .map(|&element| {
                let mut slopes = Slopes::default();
                for (node, heat) in bench.heats(element) {
                    bench.output(heat).into_iter().for_each(|output| slopes.heats.push((node, output)));
                }
                slopes
            })
            .collect();
        let values = self.evaluate(&bench);
        let column = |slopes: &Slopes| {
            let mut column = vec![0.0; base.residuals.len()];
            self.column(base, slopes, &values, &mut column);
            base.whitening.apply(&mut column)?;
            Ok(column)
        };
        slopes.iter().map(column).collect()
    }

    /// Values of the outputs, phase by phase.
    fn evaluate(&self, bench: &Bench<'_>) -> Vec<Vec<f64>> {
        let model = &bench.model;
        let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
        let symbols: Vec<Symbol> = (0..model.parameters.len())
            .map(|i| Symbol::Parameter(number(i)))
            .chain((0..model.inputs.len()).map(|i| Symbol::Input(number(i))))
            .chain([Symbol::Time])
            .chain((0..model.nodes.len()).map(|i| Symbol::Node(number(i))))
            .collect();
        let first_input = model.parameters.len();
        let first_node = first_input + model.inputs.len() + 1;
        let temperatures: Vec<ExprId> = bench.surroundings.iter().map(|&(_, temperature)| temperature).collect();
        // Apart: a temperature of surroundings is a symbol for the slopes.
        let before = Program::compile(&model.graph, &symbols, &[&temperatures]);
        let program = Program::compile(&model.graph, &symbols, &[&bench.outputs]);
        let mut early: Vec<f64> = before.registers();
        let mut file: Vec<f64> = program.registers();
        let phases = self.states.iter().map(|state| {
            for file in [&mut early, &mut file] {
                file[..self.parameters.len()].copy_from_slice(&self.parameters);
                for (slot, parameter) in file.iter_mut().zip(&model.parameters).skip(self.parameters.len()) {
                    *slot = parameter.nominal;
                }
                file[first_input..first_input + state.inputs.len()].copy_from_slice(&state.inputs);
                file[first_node..first_node + state.temperatures.len()].copy_from_slice(&state.temperatures);
            }
            before.run(0, &mut early);
            for (&(node, _), register) in bench.surroundings.iter().zip(before.outputs(0)) {
                file[first_node + node] = early[register.index()];
            }
            program.run(0, &mut file);
            program.outputs(0).iter().map(|register| file[register.index()]).collect()
        });
        phases.collect()
    }

    /// Changes of the predictions a unit of an amplitude.
    fn column(&self, base: &Base<'_>, slopes: &Slopes, values: &[Vec<f64>], column: &mut [f64]) {
        column.fill(0.0);
        let data = base.likelihood.data();
        for (state, values) in self.states.iter().zip(values) {
            let nodes = state.temperatures.len();
            for (position, adjoint) in state.adjoint.chunks_exact(nodes.max(1)).enumerate() {
                let row = state.first + position;
                let mut change = 0.0;
                for &(node, output) in &slopes.heats {
                    if let Some(adjoint) = adjoint.get(node) {
                        change -= adjoint * values[output];
                    }
                }
                if !slopes.quantities.is_empty() || !slopes.readings.is_empty() {
                    let sensor = &base.problem.measurements[data[row].measurement].sensors[data[row].sensor];
                    let reading_slope =
                        slopes.readings.iter().find(|(name, _)| *name == sensor.name).map(|&(_, output)| output);
                    let direct = || slopes.quantities.iter().find(|(quantity, _)| *quantity == sensor.quantity);
                    change += reading_slope
                        .or_else(|| direct().map(|&(_, output)| output))
                        .map_or(0.0, |output| values[output]);
                }
                column[row] = change;
            }
        }
    }
}

impl<'a> Bench<'a> {
    fn new(original: &'a Model) -> Self {
        Self { original, model: original.clone(), outputs: Vec::new(), surroundings: Vec::new() }
    }

    /// Adds a variant, takes down the slopes of its amplitudes and takes it out again.
    fn slopes(&mut self, base: &Base<'_>, variant: &Variant<'_>) -> Result<Vec<Slopes>, FitError> {
        let candidate = &base.problem.candidates[variant.candidate];
        let name = format!("{} ({})", candidate.id, self.model.parameters.len());
        let instance = Instance {
            name: &name,
            effect: variant.effect,
            site: candidate.site.clone(),
            bound: candidate.bound.clone(),
            parameters: variant.parameters.clone(),
            switch: None,
        };
        let first_node = self.model.nodes.len();
        let answer = apply(&mut self.model, &instance);
        let slopes = answer.map(|applied| {
            for node in first_node..self.model.nodes.len() {
                if let NodeKind::Boundary { temperature } = self.model.nodes[node].kind {
                    self.surroundings.push((node, temperature));
                }
            }
            let amplitudes = (variant.parameters.iter().enumerate()).filter(|(_, parameter)| parameter.amplitude);
            let symbols = amplitudes.map(|(offset, _)| {
                Symbol::Parameter(u32::try_from(applied.first_parameter + offset).unwrap_or(u32::MAX))
            });
            symbols.map(|symbol| self.slopes_of(symbol, &candidate.site, &applied.sensors)).collect()
        });
        self.restore(&candidate.site);
        Ok(slopes?)
    }

    /// The slopes of an amplitude that was just added.
    fn slopes_of(&mut self, symbol: Symbol, site: &Site, sensors: &[SensorChange]) -> Slopes {
        let mut slopes = Slopes::default();
        let mut touched: Vec<usize> = (self.original.elements.len()..self.model.elements.len()).collect();
        if let Site::Elements(elements) = site {
            touched.extend(elements);
        }
        for element in touched {
            let heats = self.heats(element);
            for (node, heat) in heats {
                let slope = self.model.graph.derivative(heat, symbol);
                self.output(slope).into_iter().for_each(|output| slopes.heats.push((node, output)));
            }
        }
        if let Site::Nodes(nodes) = site {
            for &(node, _) in nodes {
                if let NodeKind::Boundary { temperature } = self.model.nodes[node].kind {
                    self.through_boundary(symbol, node, temperature, &mut slopes);
                }
            }
        }
        for (quantity, original) in self.original.quantities.iter().enumerate() {
            let expression = self.model.quantities[quantity].value.expression();
            if expression != original.value.expression() {
                let slope = self.model.graph.derivative(expression, symbol);
                self.output(slope).into_iter().for_each(|output| slopes.quantities.push((quantity, output)));
            }
        }
        for change in sensors {
            if let SensorChange::Reading { sensor, to, .. } = change {
                let expression = self.model.quantities[*to].value.expression();
                let slope = self.model.graph.derivative(expression, symbol);
                self.output(slope).into_iter().for_each(|output| slopes.readings.push((sensor.clone(), output)));
            }
        }
        slopes
    }

    /// What a boundary's temperature does to heats and quantities that know it.
    fn through_boundary(&mut self, symbol: Symbol, node: usize, temperature: ExprId, slopes: &mut Slopes) {
        let rise = self.model.graph.derivative(temperature, symbol);
        let node_symbol = Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX));
        for element in 0..self.model.elements.len() {
            for (into, heat) in self.heats(element) {
                let slope = self.model.graph.derivative(heat, node_symbol);
                let product = self.model.graph.multiply(slope, rise);
                self.output(product).into_iter().for_each(|output| slopes.heats.push((into, output)));
            }
        }
        for quantity in 0..self.original.quantities.len() {
            let expression = self.model.quantities[quantity].value.expression();
            let slope = self.model.graph.derivative(expression, node_symbol);
            let product = self.model.graph.multiply(slope, rise);
            self.output(product).into_iter().for_each(|output| slopes.quantities.push((quantity, output)));
        }
    }

    fn heats(&mut self, element: usize) -> Vec<(usize, ExprId)> {
        let Model { graph, elements, .. } = &mut self.model;
        elements[element].contribution(graph, &mut Vec::new(), false).heat
    }

    /// Position of an expression among the outputs; none for 0.
    fn output(&mut self, expression: ExprId) -> Option<usize> {
        if self.model.graph.constant(expression) == Some(0.0) {
            return None;
        }
        self.outputs.push(expression);
        Some(self.outputs.len() - 1)
    }

    /// Takes the effect out; its parameters, and boundaries that it added, stay without use.
    fn restore(&mut self, site: &Site) {
        let original = self.original;
        self.model.elements.truncate(original.elements.len());
        self.model.quantities.truncate(original.quantities.len());
        match site {
            Site::Elements(elements) => {
                for &element in elements {
                    self.model.elements[element] = original.elements[element].clone();
                }
                self.model.quantities.clone_from(&original.quantities);
            }
            Site::Nodes(nodes) => {
                for &(node, _) in nodes {
                    self.model.nodes[node].kind = original.nodes[node].kind;
                }
            }
            Site::Pair(_) | Site::Sensors(_) | Site::Parameter(_) => {}
        }
    }
}
