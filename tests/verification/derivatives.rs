//! Derivatives against dual numbers (`num-dual`) that run through Newton's method and the scheme themselves.

use std::collections::HashMap;

use bmv::expression::{Binary, ExprId, Graph, Symbol, Term, Unary};
use bmv::thermal::transient::tableau::{COEFFICIENTS, GAMMA, NODES, STAGES};
use bmv::thermal::{
    InitialState, InputColumn, InputTable, Model, Network, NodeKind, Start, TransientOptions, TransientRequest,
};
use num_dual::{Dual64, DualNum};

use super::build::{Build, radiator, sxm};
use super::orbit::{network8, tight};

type Lookup<'a> = &'a dyn Fn(Symbol) -> Dual64;

/// Evaluates an expression on dual numbers; knows the functions that the models here use.
fn evaluate(graph: &Graph, id: ExprId, lookup: Lookup<'_>, memo: &mut HashMap<ExprId, Dual64>) -> Dual64 {
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let value = match graph.term(id) {
        Term::Number(bits) => Dual64::from(f64::from_bits(bits)),
        Term::Symbol(symbol) => lookup(symbol),
        Term::Unary(function, a) => {
            let a = evaluate(graph, a, lookup, memo);
            match function {
                Unary::Negate => -a,
                Unary::Sin => a.sin(),
                Unary::Cos => a.cos(),
                Unary::Exp => a.exp(),
                Unary::Abs if a.re < 0.0 => -a,
                Unary::Abs => a,
                other => panic!("{other:?} is not used here"),
            }
        }
        Term::Binary(function, a, b) => {
            let a = evaluate(graph, a, lookup, memo);
            let b = evaluate(graph, b, lookup, memo);
            match function {
                Binary::Add => a + b,
                Binary::Subtract => a - b,
                Binary::Multiply => a * b,
                Binary::Divide => a / b,
                Binary::Maximum => {
                    if a.re >= b.re {
                        a
                    } else {
                        b
                    }
                }
                Binary::Minimum => {
                    if a.re <= b.re {
                        a
                    } else {
                        b
                    }
                }
                Binary::AtLeast => Dual64::from(f64::from(u8::from(a.re >= b.re))),
                other => panic!("{other:?} is not used here"),
            }
        }
        other => panic!("{other:?} is not used here"),
    };
    memo.insert(id, value);
    value
}

/// A model evaluated on dual numbers straight from its elements.
struct Dual {
    graph: Graph,
    model: Model,
    heats: Vec<(usize, ExprId)>,
    unknowns: Vec<usize>,
    parameters: Vec<Dual64>,
    inputs: Vec<Dual64>,
}

impl Dual {
    fn new(model: &Model, parameters: &[f64], moved: Option<Symbol>) -> Self {
        let mut graph = model.graph.clone();
        let mut heats = Vec::new();
        for element in &model.elements {
            heats.extend(element.contribution(&mut graph, &mut Vec::new(), false).heat);
        }
        let seed = |symbol: Symbol, value: f64| {
            if moved == Some(symbol) { Dual64::from(value).derivative() } else { Dual64::from(value) }
        };
        Self {
            graph,
            heats,
            unknowns: (0..model.nodes.len())
                .filter(|&n| !matches!(model.nodes[n].kind, NodeKind::Boundary { .. }))
                .collect(),
            parameters: parameters.iter().enumerate().map(|(i, &p)| seed(Symbol::Parameter(i as u32), p)).collect(),
            inputs: model.inputs.iter().enumerate().map(|(i, p)| seed(Symbol::Input(i as u32), p.nominal)).collect(),
            model: model.clone(),
        }
    }

    fn at(&self, ids: &[ExprId], y: &[Dual64], time: f64) -> Vec<Dual64> {
        let given = |symbol: Symbol| match symbol {
            Symbol::Parameter(i) => self.parameters[i as usize],
            Symbol::Input(i) => self.inputs[i as usize],
            Symbol::Time => Dual64::from(time),
            other => panic!("{other:?} in a boundary"),
        };
        let mut all = vec![Dual64::from(0.0); self.model.nodes.len()];
        for (n, node) in self.model.nodes.iter().enumerate() {
            if let NodeKind::Boundary { temperature } = node.kind {
                all[n] = evaluate(&self.graph, temperature, &given, &mut HashMap::new());
            }
        }
        for (&n, &value) in self.unknowns.iter().zip(y) {
            all[n] = value;
        }
        let lookup = |symbol: Symbol| match symbol {
            Symbol::Node(n) => all[n as usize],
            other => given(other),
        };
        let mut memo = HashMap::new();
        ids.iter().map(|&id| evaluate(&self.graph, id, &lookup, &mut memo)).collect()
    }

    fn residual(&self, y: &[Dual64], time: f64) -> Vec<Dual64> {
        let ids: Vec<ExprId> = self.heats.iter().map(|h| h.1).collect();
        let values = self.at(&ids, y, time);
        let mut out = vec![Dual64::from(0.0); y.len()];
        for (&(node, _), value) in self.heats.iter().zip(values) {
            if let Some(row) = self.unknowns.iter().position(|&n| n == node) {
                out[row] += value;
            }
        }
        out
    }

    /// Capacity of each unknown, `None` without storage.
    fn capacity(&self, y: &[Dual64], time: f64) -> Vec<Option<Dual64>> {
        self.unknowns
            .iter()
            .map(|&n| match self.model.nodes[n].kind {
                NodeKind::Diffusion { capacity } => Some(self.at(&[capacity], y, time)[0]),
                _ => None,
            })
            .collect()
    }
}

/// Solves `f(y) = 0` for dual `y` by Newton's method, slopes by duals on plain numbers (`plain` evaluates with
/// parameters at rest).
fn newton(
    mut y: Vec<Dual64>,
    f: &dyn Fn(&[Dual64]) -> Vec<Dual64>,
    plain: &dyn Fn(&[Dual64]) -> Vec<Dual64>,
) -> Vec<Dual64> {
    let n = y.len();
    for _ in 0..12 {
        let mut jacobian = nalgebra::DMatrix::zeros(n, n);
        for column in 0..n {
            let at: Vec<Dual64> = (0..n)
                .map(|i| if i == column { Dual64::from(y[i].re).derivative() } else { Dual64::from(y[i].re) })
                .collect();
            for (row, value) in plain(&at).into_iter().enumerate() {
                jacobian[(row, column)] = value.eps;
            }
        }
        let lu = jacobian.lu();
        let r = f(&y);
        let re = lu.solve(&nalgebra::DVector::from_iterator(n, r.iter().map(|v| v.re))).unwrap();
        let eps = lu.solve(&nalgebra::DVector::from_iterator(n, r.iter().map(|v| v.eps))).unwrap();
        for i in 0..n {
            y[i] -= Dual64::new(re[i], eps[i]);
        }
        if re.amax() < 1e-12 && eps.amax() <= 1e-13 * (1.0 + y.iter().fold(0.0, |m: f64, v| m.max(v.eps.abs()))) {
            break;
        }
    }
    y
}

fn check_steady(model: &Model, symbols: &[Symbol]) {
    let network = Network::compile(model, symbols).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let mut temperatures = vec![0.0; network.nodes() * symbols.len()];
    network.temperature_tangent(&mut ws, &mut temperatures).unwrap();
    let mut quantities = vec![0.0; network.quantities() * symbols.len()];
    network.quantity_tangent(&mut ws, &mut quantities).unwrap();
    let ids: Vec<ExprId> = model.quantities.iter().map(|q| q.value.expression()).collect();
    for (column, &symbol) in symbols.iter().enumerate() {
        let dual = Dual::new(model, network.nominal_parameters(), Some(symbol));
        let still = Dual::new(model, network.nominal_parameters(), None);
        let start = dual.unknowns.iter().map(|&n| Dual64::from(ws.temperatures()[n])).collect();
        let y = newton(start, &|y| dual.residual(y, 0.0), &|y| still.residual(y, 0.0));
        let scale = y.iter().fold(0.0, |m: f64, v| m.max(v.eps.abs()));
        for (&node, value) in dual.unknowns.iter().zip(&y) {
            let own = temperatures[node * symbols.len() + column];
            // The oracle solves the same equations; conditioning of the weakest node costs some digits of 16.
            assert!((own - value.eps).abs() <= 1e-9 * scale, "{symbol:?} node {node}: {own} {}", value.eps);
        }
        for (row, value) in dual.at(&ids, &y, 0.0).into_iter().enumerate() {
            let own = quantities[row * symbols.len() + column];
            let size = value.eps.abs().max(1e-6 * scale);
            assert!(
                (own - value.eps).abs() <= 1e-9 * size.max(scale * 1e-3),
                "{symbol:?} quantity {row}: {own} {}",
                value.eps
            );
        }
    }
}

#[test]
fn steady_derivatives_are_those_of_dual_numbers() {
    check_steady(&radiator(), &(0..7).map(Symbol::Parameter).collect::<Vec<_>>());
    // 16 symbols and 11 quantities: the adjoint; then 3 symbols: forward.
    let all: Vec<Symbol> = (0..12).map(Symbol::Parameter).chain((0..4).map(Symbol::Input)).collect();
    check_steady(&sxm(), &all);
    check_steady(&sxm(), &[Symbol::Input(0), Symbol::Parameter(0), Symbol::Parameter(9)]);
}

/// Two diffusion nodes (one capacity grows with temperature and holds a parameter), an arithmetic node between them,
/// radiation to a boundary that swings in time.
/// Parameters: G, exchange area, capacity at 300 K, load.
fn mixed() -> Model {
    let mut b = Build::default();
    let g = b.parameter("G", 0.7);
    let area = b.parameter("area", 0.02);
    let c0 = b.parameter("c0", 150.0);
    let q = b.parameter("q", 12.0);
    let slope = b.n(0.4);
    let t0 = b.t(0);
    let rise = b.mul(slope, t0);
    let capacity = b.add(c0, rise);
    let a = b.diffusion_of("a", capacity);
    let z = b.arithmetic("z");
    let c = b.diffusion("c", 90.0);
    let time = b.time();
    let phase = b.scale(2.0 * std::f64::consts::PI / 900.0, time);
    let wave = b.sin(phase);
    let swing = b.scale(25.0, wave);
    let mean = b.n(260.0);
    let wall = b.add(mean, swing);
    let wall = b.boundary("wall", wall);
    b.conductor("az", [a, z], g);
    let half = b.n(0.4);
    b.conductor("zc", [z, c], half);
    b.radiation("z wall", [z, wall], area);
    let wide = b.n(0.03);
    b.radiation("c wall", [c, wall], wide);
    let link = b.n(0.05);
    b.conductor("a wall", [a, wall], link);
    b.load("q", a, q);
    b.temperature("Tz", z);
    let (ta, tc) = (b.t(a), b.t(c));
    let gap = b.sub(ta, tc);
    let heat = b.mul(g, gap);
    b.quantity("G gap", heat);
    b.model
}

/// The scheme on dual numbers over given steps; states at the steps' ends.
fn scheme(model: &Model, parameters: &[f64], moved: Symbol, start: &[f64], ends: &[f64]) -> Vec<Vec<Dual64>> {
    let dual = Dual::new(model, parameters, Some(moved));
    let still = Dual::new(model, parameters, None);
    let mut y: Vec<Dual64> = dual
        .unknowns
        .iter()
        .map(|&n| {
            let value = Dual64::from(start[n]);
            if moved == Symbol::Node(n as u32) { value.derivative() } else { value }
        })
        .collect();
    let stores: Vec<bool> = dual.capacity(&y, 0.0).iter().map(Option::is_some).collect();
    let n = y.len();
    let hold = |model: &Dual, x: &[Dual64], y: &[Dual64]| -> Vec<Dual64> {
        let r = model.residual(x, 0.0);
        (0..n).map(|i| if stores[i] { x[i] - y[i] } else { r[i] }).collect()
    };
    let begin = y.clone();
    let begin_still: Vec<Dual64> = y.iter().map(|v| Dual64::from(v.re)).collect();
    y = newton(y, &|x| hold(&dual, x, &begin), &|x| hold(&still, x, &begin_still));
    let r = dual.residual(&y, 0.0);
    let mut k1: Vec<Dual64> =
        dual.capacity(&y, 0.0).iter().zip(r).map(|(c, r)| c.map_or(Dual64::from(0.0), |c| r / c)).collect();
    let mut time = 0.0;
    let mut out = Vec::new();
    for &end in ends {
        let h = end - time;
        let mut values = vec![y.clone()];
        let mut slopes = vec![k1.clone()];
        for stage in 1..STAGES {
            let mut base = y.clone();
            for earlier in 0..stage {
                for i in 0..n {
                    base[i] += slopes[earlier][i] * (h * COEFFICIENTS[stage][earlier]);
                }
            }
            let t = time + NODES[stage] * h;
            let equations = |model: &Dual, x: &[Dual64], base: &[Dual64]| -> Vec<Dual64> {
                let r = model.residual(x, t);
                let c = model.capacity(x, t);
                (0..n).map(|i| c[i].map_or(r[i], |c| r[i] - c * (x[i] - base[i]) / (GAMMA * h))).collect()
            };
            let base_still: Vec<Dual64> = base.iter().map(|v| Dual64::from(v.re)).collect();
            let guess = values[stage - 1].clone();
            let value = newton(guess, &|x| equations(&dual, x, &base), &|x| equations(&still, x, &base_still));
            slopes.push(
                (0..n)
                    .map(|i| if stores[i] { (value[i] - base[i]) / (GAMMA * h) } else { Dual64::from(0.0) })
                    .collect(),
            );
            values.push(value);
        }
        y = values.pop().unwrap();
        k1 = slopes.pop().unwrap();
        time = end;
        out.push(y.clone());
    }
    out
}

#[test]
fn transient_derivatives_are_those_of_the_scheme_on_dual_numbers() {
    let model = mixed();
    let symbols: Vec<Symbol> = (0..4).map(Symbol::Parameter).chain([Symbol::Node(0), Symbol::Node(2)]).collect();
    let network = Network::compile(&model, &symbols).unwrap();
    let start = vec![290.0, 280.0, 270.0, 0.0];
    let inputs = InputTable::default();
    let options = TransientOptions {
        relative_tolerance: 1e-6,
        absolute_tolerance_k: 1e-4,
        newton_share: 1e-9,
        ..TransientOptions::default()
    };
    let run = |outputs: &[f64]| {
        let request = TransientRequest {
            options,
            sensitivities: true,
            end_s: Some(600.0),
            ..TransientRequest::new(network.nominal_parameters(), &inputs, InitialState::Temperatures(&start), outputs)
        };
        network.solve_transient(&request).unwrap()
    };
    let ends = run(&[]).step_ends_s;
    let result = run(&ends);
    assert_eq!(result.step_ends_s, ends, "outputs do not change the steps");
    assert!(ends.len() > 10);
    let columns = symbols.len();
    for (column, &symbol) in symbols.iter().enumerate() {
        let states = scheme(&model, network.nominal_parameters(), symbol, &start, &ends);
        for (output, state) in states.iter().enumerate() {
            for (node, value) in state.iter().enumerate() {
                let temperature = result.temperatures[output * 4 + node];
                assert!((temperature - value.re).abs() < 1e-8, "{temperature} {}", value.re);
                let own = result.temperature_tangent[(output * 4 + node) * columns + column];
                let scale = state.iter().fold(0.0, |m: f64, v| m.max(v.eps.abs()));
                // Stages are solved to 1e-13 K, slopes differ by as little.
                assert!((own - value.eps).abs() <= 1e-8 * scale, "{symbol:?} {output} {node}: {own} {}", value.eps);
            }
        }
    }
}

/// Richardson's extrapolation of central differences of a tight solution.
fn richardson(f: &dyn Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let central = |h: f64| -> Vec<f64> { f(h).iter().zip(f(-h)).map(|(up, down)| (up - down) / (2.0 * h)).collect() };
    central(h / 2.0).iter().zip(central(h)).map(|(fine, coarse)| (4.0 * fine - coarse) / 3.0).collect()
}

#[test]
fn transient_derivatives_agree_with_differences_between_outputs_and_through_kinks() {
    let model = network8();
    let symbols: Vec<Symbol> = (0..4).map(Symbol::Parameter).collect();
    let network = Network::compile(&model, &symbols).unwrap();
    let start = vec![290.0; 10];
    let inputs = InputTable::default();
    let outputs = [777.0, 2001.0, 4950.0, 5400.0];
    let run = |parameters: &[f64], sensitivities: bool| {
        let request = TransientRequest {
            options: tight(),
            sensitivities,
            ..TransientRequest::new(parameters, &inputs, InitialState::Temperatures(&start), &outputs)
        };
        network.solve_transient(&request).unwrap()
    };
    let result = run(network.nominal_parameters(), true);
    for column in 0..4 {
        let nominal = network.nominal_parameters()[column];
        let moved = |delta: f64| {
            let mut p = network.nominal_parameters().to_vec();
            p[column] += delta * nominal;
            run(&p, false).quantities
        };
        let differences = richardson(&moved, 1e-3);
        let scale = differences.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for (i, difference) in differences.iter().enumerate() {
            let own = result.quantity_tangent[i * 4 + column] * nominal;
            assert!((own - difference).abs() < 1e-4 * scale, "{column} {i}: {own} {difference}");
        }
    }
}

#[test]
fn derivatives_pass_through_the_switching_of_a_thermostat() {
    let mut b = Build::default();
    let power = b.parameter("power", 20.0);
    let on = b.parameter("on", 290.0);
    let off = b.parameter("off", 295.0);
    let loss = b.parameter("G", 0.5);
    let node = b.diffusion("tank", 300.0);
    let wall = b.n(270.0);
    let wall = b.boundary("wall", wall);
    b.conductor("loss", [node, wall], loss);
    b.thermostat("heater", node, power, on, off);
    b.temperature("T", node);
    let symbols: Vec<Symbol> = (0..4).map(Symbol::Parameter).chain([Symbol::Node(0)]).collect();
    let network = Network::compile(&b.model, &symbols).unwrap();
    let inputs = InputTable::default();
    let run = |parameters: &[f64], start: f64, sensitivities: bool| {
        let start = [start, 0.0];
        let request = TransientRequest {
            options: tight(),
            sensitivities,
            ..TransientRequest::new(parameters, &inputs, InitialState::Temperatures(&start), &[1000.0])
        };
        network.solve_transient(&request).unwrap()
    };
    let result = run(network.nominal_parameters(), 293.0, true);
    assert!(result.events.len() >= 4, "{:?}", result.events);
    for column in 0..5 {
        let nominal = network.nominal_parameters().get(column).copied().unwrap_or(293.0);
        let moved = |delta: f64| {
            let mut p = network.nominal_parameters().to_vec();
            let mut start = 293.0;
            match p.get_mut(column) {
                Some(value) => *value += delta * nominal,
                None => start += delta * nominal,
            }
            run(&p, start, false).quantities
        };
        let difference = richardson(&moved, 1e-5)[0];
        let own = result.quantity_tangent[column] * nominal;
        assert!((own - difference).abs() < 1e-4 * difference.abs(), "{column}: {own} {difference}");
    }
}

#[test]
fn a_node_that_starts_in_balance_does_so_with_its_derivatives() {
    let mut b = Build::default();
    let inner = b.parameter("inner", 0.2);
    let outer = b.parameter("outer", 0.1);
    let node = b.diffusion("box", 400.0);
    let blanket = b.diffusion("blanket", 150.0);
    let wall = b.n(200.0);
    let wall = b.boundary("wall", wall);
    b.conductor("inner", [node, blanket], inner);
    b.conductor("outer", [blanket, wall], outer);
    b.temperature("T box", node);
    b.temperature("T blanket", blanket);
    let symbols: Vec<Symbol> = (0..2).map(Symbol::Parameter).collect();
    let network = Network::compile(&b.model, &symbols).unwrap();
    let inputs = InputTable::default();
    let seeds = [vec![1.0, 0.0, 0.0]];
    let outputs = [0.0, 700.0];
    let run = |values: &[f64], sensitivities: bool| {
        let start = [values[2], 333.0, 0.0];
        let request = TransientRequest {
            options: tight(),
            sensitivities,
            seeds: &seeds,
            balanced: &[blanket],
            ..TransientRequest::new(&values[..2], &inputs, InitialState::Temperatures(&start), &outputs)
        };
        network.solve_transient(&request).unwrap()
    };
    let at = [0.2, 0.1, 300.0];
    let result = run(&at, true);
    // G1 (T_box - T) = G2 (T - T_wall), and its derivatives by hand: by G1, G2 and the box's start.
    assert!((result.quantities[1] - 80.0 / 0.3).abs() < 1e-9, "{}", result.quantities[1]);
    let by_hand = [0.1 * 100.0 / 0.09, -0.2 * 100.0 / 0.09, 0.2 / 0.3];
    for (column, slope) in by_hand.iter().enumerate() {
        assert!((result.quantity_tangent[3 + column] - slope).abs() < 1e-9 * slope.abs());
        let moved = |delta: f64| {
            let mut values = at;
            values[column] *= 1.0 + delta;
            run(&values, false).quantities
        };
        for (i, difference) in richardson(&moved, 1e-4).iter().enumerate() {
            let own = result.quantity_tangent[i * 3 + column] * at[column];
            assert!((own - difference).abs() < 1e-6 * difference.abs().max(1.0), "{column} {i}: {own} {difference}");
        }
    }
}

/// Coarse derivatives are those of a step of second order: with the steps of rows of a minute a per cent of the largest, with
/// capacities that vary, nodes without storage and a wall that moves, and with a start that is fitted.
#[test]
fn coarse_derivatives_are_within_a_per_cent() {
    let model = mixed();
    let symbols: Vec<Symbol> = (0..4).map(Symbol::Parameter).collect();
    let network = Network::compile(&model, &symbols).unwrap();
    let (start, seeds) = (vec![300.0; 4], [vec![1.0; 4]]);
    let times_s: Vec<f64> = (0..60).map(|row| 60.0 * f64::from(row)).collect();
    let inputs = InputTable { times_s: times_s.clone(), ..InputTable::default() };
    let run = |coarse_derivatives: bool| {
        let options = TransientOptions { coarse_derivatives, longest_step_s: 60.0, ..TransientOptions::default() };
        let initial = InitialState::Temperatures(&start);
        let request = TransientRequest {
            seeds: &seeds,
            sensitivities: true,
            options,
            ..TransientRequest::new(network.nominal_parameters(), &inputs, initial, &times_s)
        };
        network.solve_transient(&request).unwrap()
    };
    let (exact, coarse) = (run(false), run(true));
    assert_eq!(exact.quantities, coarse.quantities);
    assert!(coarse.stats.factorisations < exact.stats.factorisations);
    let columns = 5;
    for column in 0..columns {
        let of = |result: &[f64], quantity: usize| -> Vec<f64> {
            result.iter().skip(quantity * columns + column).step_by(2 * columns).copied().collect()
        };
        for quantity in 0..2 {
            let (exact, coarse) = (of(&exact.quantity_tangent, quantity), of(&coarse.quantity_tangent, quantity));
            let largest = exact.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let off = exact.iter().zip(&coarse).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            assert!(largest > 0.0 && off < 0.01 * largest, "{quantity} {column}: {off} of {largest}");
        }
    }
}

/// A foil that follows its heater within seconds stores little: after every step of the heater, what its capacity takes goes by the
/// change of its temperature, not by the slope that it has for a moment.
#[test]
fn coarse_derivatives_of_the_capacity_of_a_quick_node_are_of_the_right_size() {
    let mut b = Build::default();
    let c = b.parameter("c", 2.0);
    let q = b.input("Q", 0.0);
    let foil = b.diffusion_of("foil", c);
    let plate = b.diffusion("plate", 500.0);
    let path = b.n(0.5);
    b.conductor("foil plate", [foil, plate], path);
    let room = b.n(293.0);
    let room = b.boundary("room", room);
    let loss = b.n(0.3);
    b.conductor("plate room", [plate, room], loss);
    b.load("Q", foil, q);
    b.temperature("plate", plate);
    let network = Network::compile(&b.model, &[Symbol::Parameter(0)]).unwrap();
    let times_s: Vec<f64> = (0..200).map(|row| 60.0 * f64::from(row)).collect();
    let values = (0..200).map(|row| if row / 5 % 2 == 0 { 2.0 } else { 0.0 }).collect();
    let columns = vec![InputColumn { input: 0, values, hold: true }];
    let inputs = InputTable { times_s: times_s.clone(), columns, base: vec![0.0] };
    let start = vec![293.0; 3];
    let run = |coarse_derivatives: bool| {
        let default = TransientOptions::default();
        let options = TransientOptions {
            coarse_derivatives,
            relative_tolerance: 10.0 * default.relative_tolerance,
            absolute_tolerance_k: 10.0 * default.absolute_tolerance_k,
            ..default
        };
        let initial = InitialState::Temperatures(&start);
        let request = TransientRequest {
            sensitivities: true,
            options,
            ..TransientRequest::new(network.nominal_parameters(), &inputs, initial, &times_s)
        };
        network.solve_transient(&request).unwrap().quantity_tangent
    };
    let (exact, coarse) = (run(false), run(true));
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let size = norm(&mut exact.iter().copied());
    let off = norm(&mut exact.iter().zip(&coarse).map(|(a, b)| a - b));
    assert!(size > 0.0 && off < 0.01 * size, "{off} of {size}");
}
