//! The course of a transient at the fit, as derivatives along it need it: instants with the state at each, slopes of the
//! balances, and what sensors see.

use std::collections::{BTreeMap, HashMap};

use super::Base;
use super::bench::symbols;
use crate::diagnosis::FitError;
use crate::expression::{ExprId, Graph, Program, Symbol};
use crate::measurement::unknown::with_unknowns;
use crate::measurement::{Initial, Measurement, Rows, Uncertain};
use crate::thermal::transient::{InitialState, TransientRequest};
use crate::thermal::{Model, Network, NodeKind, QuantityValue};

/// Instants nearer than this share of the whole time are one.
const SAME: f64 = 1e-9;
/// Share of a step after which the state right after a jump of the inputs is looked at.
const RIGHT_AFTER: f64 = 1e-6;

/// Where the unknown temperatures and the slopes of their balances stand.
pub(super) struct Layout {
    /// Node of each row.
    pub nodes: Vec<usize>,
    /// Row of each node; none of a boundary.
    pub rows: Vec<Option<usize>>,
    /// Row and column of each slope.
    pub entries: Vec<(usize, usize)>,
    /// Whether a row stores heat.
    pub stores: Vec<bool>,
}

/// Inputs, SI, and temperatures of all nodes, K.
pub(super) struct State {
    pub inputs: Vec<f64>,
    pub temperatures: Vec<f64>,
}

/// What is needed at an instant.
pub(super) struct Instant {
    pub time_s: f64,
    /// The state as it arrives there.
    pub before: State,
    /// The state from there on, where inputs jump.
    pub after: Option<State>,
    /// Slopes of the balances on arrival, W/K, in the layout's order.
    pub slopes: Vec<f64>,
    /// Capacity of each row, J/K, 0 where it stores nothing, and its slope, J/K2.
    pub capacity: Vec<f64>,
    pub capacity_slope: Vec<f64>,
    /// Of each sensor the rows that its reading depends on, with the slopes; empty between the rows of the measurement.
    pub seen: Vec<Vec<(usize, f64)>>,
}

/// How the derivatives begin.
pub(super) enum Start {
    /// At 0, but in the rows that start in balance with the others.
    Given {
        /// Whether a row starts in balance.
        balanced: Vec<bool>,
    },
    /// All in balance.
    Steady,
}

/// A transient at the fit.
pub(super) struct Course {
    /// Position of the measurement.
    pub measurement: usize,
    pub instants: Vec<Instant>,
    /// Instant of each row of the measurement.
    pub rows: Vec<usize>,
    pub times_s: Vec<f64>,
    /// Time constant of each sensor, s.
    pub lags_s: Vec<f64>,
    /// Name and quantity of each sensor.
    pub sensors: Vec<(String, usize)>,
    pub start: Start,
}

/// All transients with their layout, and the model's parameters, SI.
pub(super) type Courses = (Layout, Vec<Course>, Vec<f64>);

/// The slopes of a model without effects, compiled.
struct Slopes {
    program: Program,
    file: Vec<f64>,
    /// Quantity and row of each slope of a quantity, which come last.
    seen: Vec<(usize, usize)>,
    parameters: usize,
}

/// Sums by key, in the order of the keys.
fn sums<K: Ord + Copy>(graph: &mut Graph, terms: Vec<(K, ExprId)>) -> BTreeMap<K, ExprId> {
    let mut sums: BTreeMap<K, ExprId> = BTreeMap::new();
    for (key, term) in terms {
        let sum = match sums.get(&key) {
            Some(&sum) => graph.add(sum, term),
            None => term,
        };
        sums.insert(key, sum);
    }
    sums
}

impl Layout {
    /// The layout of a model with its slopes, compiled at parameters, SI; those of `quantities` among them.
    fn new(model: &Model, parameters: &[f64], quantities: &[usize]) -> (Self, Slopes) {
        let mut model = model.clone();
        let is_unknown = |node: &usize| !matches!(model.nodes[*node].kind, NodeKind::Boundary { .. });
        let nodes: Vec<usize> = (0..model.nodes.len()).filter(is_unknown).collect();
        let mut rows = vec![None; model.nodes.len()];
        nodes.iter().enumerate().for_each(|(row, &node)| rows[node] = Some(row));
        let row_of = |symbol: Symbol| match symbol {
            Symbol::Node(node) => rows.get(node as usize).copied().flatten(),
            _ => None,
        };
        let slopes_of = |graph: &mut Graph, expression: ExprId| -> Vec<(usize, ExprId)> {
            let symbols = graph.symbols(expression);
            let own = symbols.into_iter().filter_map(|symbol| Some((row_of(symbol)?, symbol)));
            own.map(|(row, symbol)| (row, graph.derivative(expression, symbol))).collect()
        };
        let Model { graph, elements, nodes: model_nodes, quantities: model_quantities, .. } = &mut model;
        let mut terms = Vec::new();
        for element in elements {
            for (into, heat) in element.contribution(graph, &mut Vec::new(), false).heat {
                let Some(row) = rows[into] else { continue };
                terms.extend(slopes_of(graph, heat).into_iter().map(|(column, slope)| ((row, column), slope)));
            }
        }
        let balances = sums(graph, terms);
        let mut outputs: Vec<ExprId> = balances.values().copied().collect();
        let zero = graph.number(0.0);
        let mut stores = Vec::with_capacity(nodes.len());
        for (row, &node) in nodes.iter().enumerate() {
            let (capacity, slope) = match model_nodes[node].kind {
                NodeKind::Diffusion { capacity } => {
                    let own = slopes_of(graph, capacity).into_iter().find(|(column, _)| *column == row);
                    (Some(capacity), own.map_or(zero, |(_, slope)| slope))
                }
                _ => (None, zero),
            };
            stores.push(capacity.is_some());
            outputs.extend([capacity.unwrap_or(zero), slope]);
        }
        let mut seen = Vec::new();
        for &quantity in quantities {
            for (row, slope) in slopes_of(graph, model_quantities[quantity].value.expression()) {
                seen.push((quantity, row));
                outputs.push(slope);
            }
        }
        let program = Program::compile(&model.graph, &symbols(&model), &[&outputs]);
        let mut file = program.registers();
        file[..parameters.len()].copy_from_slice(parameters);
        let slopes = Slopes { program, file, seen, parameters: model.parameters.len() };
        (Self { entries: balances.into_keys().collect(), nodes, rows, stores }, slopes)
    }
}

impl Slopes {
    fn at(&mut self, time_s: f64, state: &State) -> Vec<f64> {
        let first = self.parameters;
        let time = first + state.inputs.len();
        self.file[first..time].copy_from_slice(&state.inputs);
        self.file[time] = time_s;
        self.file[time + 1..time + 1 + state.temperatures.len()].copy_from_slice(&state.temperatures);
        self.program.run(0, &mut self.file);
        self.program.outputs(0).iter().map(|register| self.file[register.index()]).collect()
    }
}

/// The transients of a problem at its fit; `None` where one of them, or the model, is of a kind whose derivatives such steps do not
/// follow well: with switches, nodes without storage, inputs that change between rows, a cycle, extremes of time, or asked outside.
pub(super) fn courses(base: &Base<'_>) -> Result<Option<Courses>, FitError> {
    let (problem, likelihood) = (base.problem, base.likelihood);
    let model = &problem.model;
    let is_instant = |quantity: usize| matches!(model.quantities[quantity].value, QuantityValue::Instant(_));
    let is_plain = |measurement: &Measurement| {
        let is_transient = match &measurement.rows {
            Rows::Transient { initial, inputs, .. } => {
                let is_held = inputs.columns.iter().all(|column| column.hold);
                is_held && *initial != Initial::Periodic && inputs.base.len() == model.inputs.len()
            }
            Rows::Steady(_) => false,
        };
        is_transient && measurement.sensors.iter().all(|sensor| is_instant(sensor.quantity))
    };
    let switches = || model.elements.iter().any(|element| element.physics().is_switched());
    if model.external.is_some() || switches() || !problem.measurements.iter().all(is_plain) {
        return Ok(None);
    }
    let parameters = likelihood.full_parameters(base.unknowns);
    let mut quantities: Vec<usize> =
        problem.measurements.iter().flat_map(|m| m.sensors.iter().map(|sensor| sensor.quantity)).collect();
    quantities.sort_unstable();
    quantities.dedup();
    let (layout, mut slopes) = Layout::new(model, &parameters, &quantities);
    if layout.stores.contains(&false) {
        return Ok(None);
    }
    let network = Network::compile(model, &[])?;
    let names = &likelihood.unknowns().names;
    let values: HashMap<&str, f64> = names.iter().map(String::as_str).zip(base.unknowns.iter().copied()).collect();
    let inputs: Vec<String> = model.inputs.iter().map(|input| input.name.clone()).collect();
    let nodes: Vec<String> = model.nodes.iter().map(|node| node.name.clone()).collect();
    let mut courses = Vec::with_capacity(problem.measurements.len());
    for (position, measurement) in problem.measurements.iter().enumerate() {
        let fixed = with_unknowns(measurement, &inputs, &nodes, &|name| values.get(name).copied());
        let Some(course) = course(base, &network, &layout, &mut slopes, &parameters, position, &fixed) else {
            return Ok(None);
        };
        courses.push(course);
    }
    Ok(Some((layout, courses, parameters)))
}

/// One of them; `None` where it has no solution.
fn course(
    base: &Base<'_>,
    network: &Network,
    layout: &Layout,
    slopes: &mut Slopes,
    parameters: &[f64],
    position: usize,
    measurement: &Measurement,
) -> Option<Course> {
    let Rows::Transient { inputs, initial, .. } = &measurement.rows else { return None };
    let temperatures: Vec<f64>;
    let (initial, balanced): (_, &[usize]) = match initial {
        Initial::Temperatures { values, balanced, .. } => {
            temperatures = values.iter().map(Uncertain::nominal).collect();
            (InitialState::Temperatures(&temperatures), balanced)
        }
        Initial::Steady | Initial::Periodic => (InitialState::Steady, &[]),
    };
    let start = match initial {
        InitialState::Temperatures(_) => {
            Start::Given { balanced: layout.nodes.iter().map(|node| balanced.contains(node)).collect() }
        }
        _ => Start::Steady,
    };
    let mut request = TransientRequest::new(parameters, inputs, initial, &inputs.times_s);
    request.balanced = balanced;
    request.options.relative_tolerance *= base.problem.tolerance;
    request.options.absolute_tolerance_k *= base.problem.tolerance;
    let limit = base.problem.most_steps.get(position).copied();
    request.options.most_steps = limit.unwrap_or(request.options.most_steps);
    let step_ends = network.solve_transient(&TransientRequest { temperatures: false, ..request }).ok()?.step_ends_s;
    let is_jump = |time_s: f64| inputs.at(time_s, true) != inputs.at(time_s, false);
    let (times_s, rows) = merged(&inputs.times_s, &step_ends);
    // A table of instants and of what comes right after jumps there.
    let jumps: Vec<bool> = times_s.iter().map(|&time| is_jump(time)).collect();
    let mut outputs_s = Vec::with_capacity(2 * times_s.len());
    for (place, &time_s) in times_s.iter().enumerate() {
        outputs_s.push(time_s);
        if let (true, Some(next)) = (jumps[place], times_s.get(place + 1)) {
            outputs_s.push(time_s + RIGHT_AFTER * (next - time_s));
        }
    }
    let solution = network.solve_transient(&TransientRequest { outputs_s: &outputs_s, ..request }).ok()?;
    let mut states = solution.temperatures.chunks_exact(network.nodes());
    let mut is_row = vec![false; times_s.len()];
    rows.iter().for_each(|&place| is_row[place] = true);
    let mut instants = Vec::with_capacity(times_s.len());
    for (place, &time_s) in times_s.iter().enumerate() {
        let before = State { inputs: inputs.at(time_s, true), temperatures: states.next()?.to_vec() };
        let after = if jumps[place] && place + 1 < times_s.len() {
            Some(State { inputs: inputs.at(time_s, false), temperatures: states.next()?.to_vec() })
        } else {
            None
        };
        let mut values = slopes.at(time_s, &before);
        let of_quantities = values.split_off(layout.entries.len() + 2 * layout.nodes.len());
        let capacities = values.split_off(layout.entries.len());
        let of_sensor = |quantity: usize| -> Vec<(usize, f64)> {
            let all = slopes.seen.iter().zip(&of_quantities);
            all.filter(|((seen, _), _)| *seen == quantity).map(|(&(_, row), &slope)| (row, slope)).collect()
        };
        let seen = if is_row[place] {
            measurement.sensors.iter().map(|sensor| of_sensor(sensor.quantity)).collect()
        } else {
            Vec::new()
        };
        instants.push(Instant {
            time_s,
            before,
            after,
            slopes: values,
            capacity: capacities.iter().step_by(2).copied().collect(),
            capacity_slope: capacities.iter().skip(1).step_by(2).copied().collect(),
            seen,
        });
    }
    Some(Course {
        measurement: position,
        instants,
        rows,
        times_s: inputs.times_s.clone(),
        lags_s: measurement.sensors.iter().map(|s| s.lag_s.as_ref().map_or(0.0, |lag| lag.at(parameters))).collect(),
        sensors: measurement.sensors.iter().map(|sensor| (sensor.name.clone(), sensor.quantity)).collect(),
        start,
    })
}

/// Rows and ends of steps in one order, and the place of each row.
fn merged(rows_s: &[f64], step_ends_s: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let span = rows_s.last().copied().unwrap_or(0.0) - rows_s.first().copied().unwrap_or(0.0);
    let (mut times_s, mut places) = (Vec::with_capacity(rows_s.len() + step_ends_s.len()), Vec::new());
    let mut ends = step_ends_s.iter().copied().peekable();
    for &row in rows_s {
        while let Some(end) = ends.next_if(|end| *end < row - SAME * span) {
            if times_s.last().is_none_or(|last| end > last + SAME * span) {
                times_s.push(end);
            }
        }
        while ends.next_if(|end| *end <= row + SAME * span).is_some() {}
        places.push(times_s.len());
        times_s.push(row);
    }
    (times_s, places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_steps_at_rows_are_the_rows() {
        let (times_s, places) = merged(&[0.0, 10.0, 20.0], &[4.0, 10.0 - 1e-9, 15.0, 20.0, 25.0]);
        assert_eq!(times_s, [0.0, 4.0, 10.0, 15.0, 20.0]);
        assert_eq!(places, [0, 2, 4]);
    }
}
