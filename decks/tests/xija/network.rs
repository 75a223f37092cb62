//! The rates of a deck's temperatures, and their integration.

use std::collections::HashMap;

use bmv_decks::{CouplingKind, Deck, NodeKind, Value};

use super::expression::{Expression, Reader};

/// A deck ready to be integrated.
pub struct Network {
    deck: Deck,
    /// Inputs, parameters, then `t`, `T`, `Ta`, `Tb`.
    values: Vec<f64>,
    time: usize,
    /// Capacity or boundary temperature of each node.
    nodes: Vec<Expression>,
    couplings: Vec<Expression>,
    loads: Vec<Expression>,
}

impl Network {
    /// Reads all expressions of a deck of diffusion and boundary nodes.
    ///
    /// # Errors
    /// An expression that does not parse.
    pub fn new(deck: Deck) -> Result<Self, String> {
        let inputs = deck.inputs.iter().map(|input| (input.name.clone(), si(&input.unit, input.nominal)));
        let parameters = deck.parameters.iter().map(|parameter| (parameter.name.clone(), parameter.nominal));
        let special = ["t", "T", "Ta", "Tb"].map(|name| (name.to_owned(), 0.0));
        let (names, values): (Vec<String>, Vec<f64>) = inputs.chain(parameters).chain(special).unzip();
        let time = names.len() - 4;
        let names: HashMap<String, usize> = names.into_iter().zip(0..).collect();
        let reader = Reader { names: &names, tables: &deck.tables };
        let read = |value: &Value| match value {
            Value::Number(number) => Ok(Expression::Number(*number)),
            Value::Scaled { parameter, factor } => reader.read(&format!("{parameter} * {factor}")),
            Value::Expression(text) => reader.read(text).map_err(|error| format!("{error} in `{text}`")),
        };
        let node = |node: &bmv_decks::Node| match &node.kind {
            NodeKind::Diffusion { capacity } => read(capacity),
            NodeKind::Boundary { temperature } => read(temperature),
            NodeKind::Arithmetic => Err(format!("{} is arithmetic", node.name)),
        };
        let nodes = deck.nodes.iter().map(node).collect::<Result<_, _>>()?;
        let couplings = deck.couplings.iter().map(|coupling| read(&coupling.value)).collect::<Result<_, _>>()?;
        let loads = deck.loads.iter().map(|load| read(&load.power)).collect::<Result<_, _>>()?;
        Ok(Self { values, time, nodes, couplings, loads, deck })
    }

    /// Rates in K/s of all nodes at a time, with inputs in their units; temperatures of boundaries are put in.
    pub fn rates(&mut self, time_s: f64, inputs: &[f64], temperatures_k: &mut [f64]) -> Vec<f64> {
        for (at, (input, value)) in self.deck.inputs.iter().zip(inputs).enumerate() {
            self.values[at] = si(&input.unit, *value);
        }
        self.values[self.time] = time_s;
        let tables = &self.deck.tables;
        for (at, node) in self.deck.nodes.iter().enumerate() {
            if matches!(node.kind, NodeKind::Boundary { .. }) {
                temperatures_k[at] = self.nodes[at].value(&self.values, tables);
            }
        }
        let mut heats_w = vec![0.0; temperatures_k.len()];
        for (coupling, value) in self.deck.couplings.iter().zip(&self.couplings) {
            let [from, to] = coupling.between;
            let (warm, cold) = (temperatures_k[from], temperatures_k[to]);
            (self.values[self.time + 2], self.values[self.time + 3]) = (warm, cold);
            let heat_w = value.value(&self.values, tables) * (warm - cold);
            heats_w[to] += heat_w;
            if coupling.kind == CouplingKind::Linear {
                heats_w[from] -= heat_w;
            }
        }
        for (load, value) in self.deck.loads.iter().zip(&self.loads) {
            self.values[self.time + 1] = temperatures_k[load.into];
            heats_w[load.into] += value.value(&self.values, tables);
        }
        for (at, node) in self.deck.nodes.iter().enumerate() {
            heats_w[at] = match node.kind {
                NodeKind::Boundary { .. } => 0.0,
                _ => heats_w[at] / self.nodes[at].value(&self.values, tables),
            };
        }
        heats_w
    }

    /// Temperatures in K at all times (rows) by the classical Runge-Kutta rule, at least `steps` to an interval.
    pub fn transient(&mut self, times_s: &[f64], inputs: &Inputs, start_k: &[f64], steps: usize) -> Vec<Vec<f64>> {
        let mut state = start_k.to_vec();
        self.rates(times_s[0], &inputs.at(0, 0.0), &mut state);
        let mut rows = vec![state.clone()];
        for (row, pair) in times_s.windows(2).enumerate() {
            let h = (pair[1] - pair[0]) / steps as f64;
            for step in 0..steps {
                let mut rate = |share: f64, from: &[f64], along: &[f64], length: f64| {
                    let mut there: Vec<f64> = from.iter().zip(along).map(|(x, slope)| x + length * slope).collect();
                    let share = (step as f64 + share) / steps as f64;
                    self.rates(pair[0] + share * (pair[1] - pair[0]), &inputs.at(row, share), &mut there)
                };
                let k1 = rate(0.0, &state, &state, 0.0);
                let k2 = rate(0.5, &state, &k1, 0.5 * h);
                let k3 = rate(0.5, &state, &k2, 0.5 * h);
                let k4 = rate(1.0, &state, &k3, h);
                for at in 0..state.len() {
                    state[at] += h / 6.0 * (k1[at] + 2.0 * (k2[at] + k3[at]) + k4[at]);
                }
            }
            rows.push(state.clone());
        }
        rows
    }
}

/// A rule by which xija advances the temperatures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// `evolve_method` 1: from row `j` with the rates `f0` there and `f1` at the temperatures `h f0 / 2` further and the
    /// inputs of row `j + 1`, row `j + 2` is `h f0 / 2 + h f1` warmer, `h` being the time between the two.
    Pairs,
    /// `evolve_method` 2: the midpoint rule from row to row, with the mean of both rows' heats in the middle.
    Midpoint,
    /// `evolve_method` 2 with `rk4`: the classical rule, likewise.
    Classical,
}

/// Inputs over the rows of a record, in the order of the deck's.
pub struct Inputs {
    /// `columns[input][row]`, in the input's unit.
    pub columns: Vec<Vec<f64>>,
    /// Whether counts and states keep a row's value until the next; else all inputs are linear between rows.
    pub holds_states: bool,
}

impl Inputs {
    /// Values at a share of the interval behind a row.
    fn at(&self, row: usize, share: f64) -> Vec<f64> {
        let value = |column: &Vec<f64>| {
            let next = column.get(row + 1).copied().unwrap_or(column[row]);
            let is_held = self.holds_states && column.iter().all(|value| value.fract() == 0.0);
            if is_held { column[row] } else { column[row] + share * (next - column[row]) }
        };
        self.columns.iter().map(value).collect()
    }
}

/// A value of an input in SI, as expressions see it.
fn si(unit: &str, value: f64) -> f64 {
    if unit == "deg" { value.to_radians() } else { value }
}
