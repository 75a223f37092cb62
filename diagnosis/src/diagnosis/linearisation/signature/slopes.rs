//! What an amplitude does at fixed temperatures: heats, quantities and storage a unit of it, as outputs of one program.
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
}

impl Slopes {
    /// Position of what changes a sensor's reading at fixed temperatures.
    pub fn of_sensor(&self, name: &str, quantity: usize) -> Option<usize> {
        let of_reading = self.readings.iter().find(|(own, _)| own == name).map(|&(_, output)| output);
        let of_quantity = || self.quantities.iter().find(|(own, _)| *own == quantity).map(|&(_, output)| output);
        of_reading.or_else(of_quantity)
    }
}

/// A model to which effects are added and from which they are taken again.
pub(super) struct Bench<'a> {
    original: &'a Model,
    model: Model,
    outputs: Vec<ExprId>,
    /// Boundaries that effects added: node and temperature.
    surroundings: Vec<(usize, ExprId)>,
}

/// The outputs of a bench as a program.
pub(super) struct Outputs {
    /// Temperatures of surroundings; apart, since each is a symbol for the slopes.
    before: Program,
    program: Program,
    /// Nodes of the surroundings.
    surroundings: Vec<usize>,
    /// All parameters, SI.
    parameters: Vec<f64>,
    first_input: usize,
    first_node: usize,
}

/// Room for evaluations.
pub(super) struct Room {
    early: Vec<f64>,
    file: Vec<f64>,
}

impl Outputs {
    /// Room at the parameters.
    pub fn room(&self) -> Room {
        let (mut early, mut file) = (self.before.registers(), self.program.registers());
        for file in [&mut early, &mut file] {
            file[..self.parameters.len()].copy_from_slice(&self.parameters);
        }
        Room { early, file }
    }

    /// Evaluates at inputs, an instant and temperatures of all nodes; gives the values to `each` in their order.
    pub fn evaluate(
        &self,
        room: &mut Room,
        inputs: &[f64],
        time_s: f64,
        temperatures: &[f64],
        each: &mut dyn FnMut(usize, f64),
    ) {
        let Room { early, file } = room;
        for file in [&mut *early, &mut *file] {
            file[self.first_input..self.first_input + inputs.len()].copy_from_slice(inputs);
            file[self.first_node - 1] = time_s;
            file[self.first_node..self.first_node + temperatures.len()].copy_from_slice(temperatures);
        }
        self.before.run(0, early);
        for (&node, register) in self.surroundings.iter().zip(self.before.outputs(0)) {
            file[self.first_node + node] = early[register.index()];
        }
        self.program.run(0, file);
        for (output, register) in self.program.outputs(0).iter().enumerate() {
            each(output, file[register.index()]);
        }
    }
}

impl<'a> Bench<'a> {
    pub fn new(original: &'a Model) -> Self {
        Self { original, model: original.clone(), outputs: Vec::new(), surroundings: Vec::new() }
    }

    /// What was taken down as a program, at parameters of the original model, SI; those that effects added are 0 or fixed.
    pub fn into_outputs(self, parameters: &[f64]) -> Outputs {
        let model = &self.model;
        let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
        let symbols: Vec<Symbol> = (0..model.parameters.len())
            .map(|i| Symbol::Parameter(number(i)))
            .chain((0..model.inputs.len()).map(|i| Symbol::Input(number(i))))
            .chain([Symbol::Time])
            .chain((0..model.nodes.len()).map(|i| Symbol::Node(number(i))))
            .collect();
        let (nodes, temperatures): (Vec<usize>, Vec<ExprId>) = self.surroundings.iter().copied().unzip();
        let added = model.parameters.iter().skip(parameters.len()).map(|parameter| parameter.nominal);
        Outputs {
            before: Program::compile(&model.graph, &symbols, &[&temperatures]),
            program: Program::compile(&model.graph, &symbols, &[&self.outputs]),
            surroundings: nodes,
            parameters: parameters.iter().copied().chain(added).collect(),
            first_input: model.parameters.len(),
            first_node: model.parameters.len() + model.inputs.len() + 1,
        }
    }

    /// Number of outputs so far.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
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
            reference_k: base.problem.reference_k(candidate),
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
            touched.extend(elements.iter());
        }
        for element in touched {
            let heats = self.heats(element);
            for (node, heat) in heats {
                let slope = self.model.graph.derivative(heat, symbol);
                self.output(slope).into_iter().for_each(|output| slopes.heats.push((node, output)));
            }
        }
        if let Site::Nodes(nodes) = site {
            for &(node, _) in nodes.iter() {
                match self.model.nodes[node].kind {
                    NodeKind::Boundary { temperature } => self.through_boundary(symbol, node, temperature, &mut slopes),
                    NodeKind::Diffusion { capacity } => {
                        let slope = self.model.graph.derivative(capacity, symbol);
                        self.output(slope).into_iter().for_each(|output| slopes.capacities.push((node, output)));
                    }
                    NodeKind::Arithmetic => {}
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

    /// The heats of an element as they are.
    pub fn heats_of(&mut self, element: usize) -> Slopes {
        let mut slopes = Slopes::default();
        for (node, heat) in self.heats(element) {
            self.output(heat).into_iter().for_each(|output| slopes.heats.push((node, output)));
        }
        slopes
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
                for &element in elements.iter() {
                    self.model.elements[element] = original.elements[element].clone();
                }
                self.model.quantities.clone_from(&original.quantities);
            }
            Site::Nodes(nodes) => {
                for &(node, _) in nodes.iter() {
                    self.model.nodes[node].kind = original.nodes[node].kind;
                }
            }
            Site::Pair(_) | Site::Sensors(_) | Site::Parameter(_) => {}
        }
    }
}
