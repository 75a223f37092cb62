//! What effects do at given temperatures: the slopes of heats, capacities and readings in their amplitudes.
//!
//! Effects are added one after another to one model and taken out again, so that their number costs no more than itself.

use super::Base;
use super::variant::Variant;
use crate::diagnosis::FitError;
use crate::effect::{Instance, SensorChange, Site, apply};
use crate::expression::{ExprId, Program, Symbol};
use crate::thermal::{Model, NodeKind};

/// What an amplitude does at fixed temperatures, as positions among the outputs of a program.
#[derive(Default)]
pub(super) struct Slopes {
    /// Node and heat into it a unit.
    pub heats: Vec<(usize, usize)>,
    /// Node and its capacity a unit.
    pub capacities: Vec<(usize, usize)>,
    /// Quantity and its change a unit.
    pub quantities: Vec<(usize, usize)>,
    /// Sensor and the change of its reading a unit, in place of its quantity's.
    pub readings: Vec<(String, usize)>,
    /// Whether it adds an element that switches, which has no slope at a fixed temperature.
    pub switches: bool,
}

/// A model to which effects are added and from which they are taken again.
pub(super) struct Bench<'a> {
    original: &'a Model,
    model: Model,
    outputs: Vec<ExprId>,
    /// Boundaries that effects added: node and temperature.
    surroundings: Vec<(usize, ExprId)>,
}

/// What was taken down, ready to be evaluated at one state after another.
pub(super) struct Compiled {
    before: Program,
    program: Program,
    early: Vec<f64>,
    file: Vec<f64>,
    surroundings: Vec<usize>,
    first_input: usize,
    time: usize,
}

impl Slopes {
    /// What it does to a sensor's reading at fixed temperatures, given the values of all outputs.
    pub fn direct(&self, sensor: &str, quantity: usize, values: &[f64]) -> f64 {
        let reading = self.readings.iter().find(|(name, _)| name == sensor).map(|(_, output)| output);
        let quantity = || self.quantities.iter().find(|(own, _)| *own == quantity).map(|(_, output)| output);
        reading.or_else(quantity).map_or(0.0, |&output| values[output])
    }
}

/// The symbols of a model's expressions, in the order of a program's first registers: parameters, inputs, time, nodes.
pub(super) fn symbols(model: &Model) -> Vec<Symbol> {
    let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    let parameters = (0..model.parameters.len()).map(|i| Symbol::Parameter(number(i)));
    let inputs = (0..model.inputs.len()).map(|i| Symbol::Input(number(i)));
    let nodes = (0..model.nodes.len()).map(|i| Symbol::Node(number(i)));
    parameters.chain(inputs).chain([Symbol::Time]).chain(nodes).collect()
}

impl Compiled {
    /// The values at a state of the model without effects: inputs, SI, instant, s, and temperatures of all nodes, K.
    pub fn at(&mut self, inputs: &[f64], time_s: f64, temperatures: &[f64]) -> Vec<f64> {
        let (first, time) = (self.first_input, self.time);
        for file in [&mut self.early, &mut self.file] {
            file[first..first + inputs.len()].copy_from_slice(inputs);
            file[time] = time_s;
            file[time + 1..time + 1 + temperatures.len()].copy_from_slice(temperatures);
        }
        self.before.run(0, &mut self.early);
        for (&node, register) in self.surroundings.iter().zip(self.before.outputs(0)) {
            self.file[time + 1 + node] = self.early[register.index()];
        }
        self.program.run(0, &mut self.file);
        self.program.outputs(0).iter().map(|register| self.file[register.index()]).collect()
    }
}

impl<'a> Bench<'a> {
    /// A bench for a model.
    pub fn new(original: &'a Model) -> Self {
        Self { original, model: original.clone(), outputs: Vec::new(), surroundings: Vec::new() }
    }

    /// All that was taken down, compiled, at the model's parameters, SI; those of the effects are nominal.
    pub fn compile(&self, parameters: &[f64]) -> Compiled {
        let model = &self.model;
        let symbols = symbols(model);
        let temperatures: Vec<ExprId> = self.surroundings.iter().map(|&(_, temperature)| temperature).collect();
        // Apart: a temperature of surroundings is a symbol for the slopes.
        let before = Program::compile(&model.graph, &symbols, &[&temperatures]);
        let program = Program::compile(&model.graph, &symbols, &[&self.outputs]);
        let (mut early, mut file): (Vec<f64>, Vec<f64>) = (before.registers(), program.registers());
        for file in [&mut early, &mut file] {
            file[..parameters.len()].copy_from_slice(parameters);
            for (slot, parameter) in file.iter_mut().zip(&model.parameters).skip(parameters.len()) {
                *slot = parameter.nominal;
            }
        }
        let first_input = model.parameters.len();
        let time = first_input + model.inputs.len();
        let surroundings = self.surroundings.iter().map(|&(node, _)| node).collect();
        Compiled { before, program, early, file, surroundings, first_input, time }
    }
    /// Adds a variant, takes down the slopes of its amplitudes and takes it out again.
    pub fn slopes(&mut self, base: &Base<'_>, variant: &Variant<'_>) -> Result<Vec<Slopes>, FitError> {
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
        slopes.switches = touched.iter().any(|&element| self.model.elements[element].physics().is_switched());
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
                match self.model.nodes[node].kind {
                    NodeKind::Boundary { temperature } => {
                        self.through_boundary(symbol, node, temperature, &mut slopes);
                    }
                    NodeKind::Diffusion { capacity }
                        if self.original.nodes[node].kind != self.model.nodes[node].kind =>
                    {
                        let slope = self.model.graph.derivative(capacity, symbol);
                        self.output(slope).into_iter().for_each(|output| slopes.capacities.push((node, output)));
                    }
                    NodeKind::Diffusion { .. } | NodeKind::Arithmetic => {}
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
