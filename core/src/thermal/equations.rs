//! The equations of a network, compiled: every balance, slope and quantity as instructions of one program.
//!
//! For unknown node `i` the balance is `r_i = sum of the elements' heat into i` (W). Boundary temperatures are put in
//! as expressions, so that what depends on them alone is computed once, and derivatives pass through them. What
//! depends on parameters, inputs or time alone is hoisted into segments of its own.

use std::collections::HashMap;

use crate::expression::{Dependence, ExprId, Graph, Program, Register, Segment, Symbol, Term};

use super::element::heater::Switch;
use super::element::{Contribution, SignConstraint};
use super::model::{Model, NodeKind};
use super::network::NetworkError;

/// Segments of the program, in order.
pub(super) mod segment {
    /// What depends on parameters alone.
    pub const PARAMETERS: usize = 0;
    /// What depends on parameters and inputs.
    pub const INPUTS: usize = 1;
    /// What depends on time and on switches' modes besides.
    pub const INSTANT: usize = 2;
    /// Boundary temperatures and widths of controllers' bands, K; then values that have a sign.
    pub const BOUNDARY: usize = 3;
    /// Balance of each unknown node, W.
    pub const RESIDUAL: usize = 4;
    /// Sizes of the balances' terms, W; after the residual.
    pub const BALANCE_SCALE: usize = 5;
    /// Slopes of the balances in the unknown temperatures, W/K; after the residual.
    pub const JACOBIAN: usize = 6;
    /// Heat capacities, J/K.
    pub const CAPACITY: usize = 7;
    /// Slopes of the capacities in their own temperature, J/K2; after the capacities.
    pub const CAPACITY_SLOPE: usize = 8;
    /// Slopes of the balances in the differentiated symbols; after the residual.
    pub const RESIDUAL_TANGENT: usize = 9;
    /// Slopes of the capacities in the differentiated symbols; after the capacities.
    pub const CAPACITY_TANGENT: usize = 10;
    /// Quantities.
    pub const QUANTITY: usize = 11;
    /// Slopes of the quantities in temperatures and symbols; after the quantities.
    pub const QUANTITY_TANGENT: usize = 12;
    /// Switching functions, K.
    pub const SWITCH: usize = 13;
    /// Slopes of the switching functions; after them.
    pub const SWITCH_TANGENT: usize = 14;
    /// Net heat of the elements and heat into boundaries, W.
    pub const BALANCE: usize = 15;
    /// Slopes of the boundary temperatures in the differentiated symbols.
    pub const BOUNDARY_TANGENT: usize = 16;
    /// Discontinuities: functions of inputs and time at whose sign changes an expression has a corner or a jump, then those at
    /// which tables are read.
    pub const DISCONTINUITY: usize = 17;
}

/// One number of a sparse matrix, by the register that holds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub row: usize,
    pub column: usize,
    pub register: Register,
}

/// An element's heats, kept to name it when a number goes wrong.
#[derive(Clone, Debug)]
pub(super) struct NamedHeats {
    pub name: String,
    pub heats: Vec<ExprId>,
}

/// The compiled equations of one form (steady, or with switches).
#[derive(Clone, Debug)]
pub(super) struct Equations {
    pub program: Program,
    pub graph: Graph,
    pub parameters: usize,
    pub inputs: usize,
    /// Outputs of what answers for the model.
    pub outputs: usize,
    /// Node of each unknown.
    pub unknowns: Vec<usize>,
    /// Number of switched elements.
    pub modes: usize,
    /// Names of the switched elements.
    pub mode_names: Vec<String>,
    pub boundaries: Vec<(usize, Register)>,
    /// Width of each controller's band, with its element's name.
    pub bands: Vec<(String, Register)>,
    /// Values that have a sign, with their element's name; those that follow from parameters, inputs and time.
    pub signs: Vec<(String, SignConstraint, Register)>,
    pub residual: Vec<Register>,
    pub balance_scale: Vec<Register>,
    /// Slopes of the balances, by row then column, each position once.
    pub jacobian: Vec<Entry>,
    /// Capacity of each unknown; `None` for arithmetic nodes.
    pub capacity: Vec<Option<Register>>,
    pub capacity_slope: Vec<Option<Register>>,
    /// Whether any capacity depends on temperature.
    pub capacity_varies: bool,
    pub residual_tangent: Vec<Entry>,
    pub capacity_tangent: Vec<Entry>,
    pub quantity: Vec<Register>,
    /// Slopes of the quantities in unknown temperatures.
    pub quantity_temperature: Vec<Entry>,
    /// Slopes of the quantities in differentiated symbols.
    pub quantity_symbol: Vec<Entry>,
    /// `on` and `off` functions of each switch.
    pub switch: Vec<[Register; 2]>,
    /// Slopes of the `on` (row 2 k) and `off` (row 2 k + 1) functions in unknown temperatures.
    pub switch_temperature: Vec<Entry>,
    /// The same in differentiated symbols.
    pub switch_symbol: Vec<Entry>,
    /// Net heat of each element that is a source: its index in the model and the register.
    pub sources: Vec<(usize, Register)>,
    /// Heat into each boundary.
    pub into_boundary: Vec<(usize, Register)>,
    /// Rows are positions in `boundaries`.
    pub boundary_tangent: Vec<Entry>,
    pub discontinuities: Vec<Register>,
    /// Tables read at functions of inputs and time: the points at which each has corners, and where it is read.
    pub table_discontinuities: Vec<(Vec<f64>, Register)>,
    pub heats: Vec<NamedHeats>,
}

/// Sparse sums of expressions by row and column.
#[derive(Default)]
struct Accumulator {
    terms: Vec<(usize, usize, ExprId)>,
}

impl Accumulator {
    /// Sums what falls on one position, in the order added.
    fn sum(mut self, graph: &mut Graph) -> Vec<(usize, usize, ExprId)> {
        self.terms.sort_by_key(|&(row, column, _)| (row, column));
        let mut out: Vec<(usize, usize, ExprId)> = Vec::with_capacity(self.terms.len());
        for (row, column, term) in self.terms {
            match out.last_mut() {
                Some(last) if last.0 == row && last.1 == column => last.2 = graph.add(last.2, term),
                _ => out.push((row, column, term)),
            }
        }
        out
    }
}

/// Finds the symbols of many expressions without allocating for each.
#[derive(Default)]
struct SymbolFinder {
    stamps: HashMap<ExprId, ()>,
    stack: Vec<ExprId>,
    found: Vec<Symbol>,
}

impl SymbolFinder {
    fn find(&mut self, graph: &Graph, root: ExprId) -> &[Symbol] {
        self.stamps.clear();
        self.found.clear();
        self.stack.push(root);
        while let Some(id) = self.stack.pop() {
            // Leaves and unshared terms need no memory of having been seen, only deep graphs do.
            match graph.term(id) {
                Term::Number(_) => {}
                Term::Symbol(symbol) => {
                    if !self.found.contains(&symbol) {
                        self.found.push(symbol);
                    }
                }
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => self.stack.push(a),
                Term::Binary(_, a, b) => {
                    if self.stamps.insert(id, ()).is_none() {
                        self.stack.extend([b, a]);
                    }
                }
            }
        }
        self.found.sort_unstable();
        &self.found
    }
}

/// All expressions of a form before compilation.
struct Forms {
    contributions: Vec<Contribution>,
    switches: Vec<Switch>,
    mode_names: Vec<String>,
    capacities: Vec<Option<ExprId>>,
    quantities: Vec<ExprId>,
}

/// Position of each differentiated symbol.
fn positions(symbols: &[Symbol]) -> HashMap<Symbol, usize> {
    symbols.iter().enumerate().map(|(position, &symbol)| (symbol, position)).collect()
}

impl Equations {
    /// Builds and compiles the equations. `switched` asks for the transient form with modes.
    pub fn compile(model: &Model, differentiate: &[Symbol], switched: bool) -> Result<Self, NetworkError> {
        let mut graph = model.graph.clone();
        let forms = expressions(model, &mut graph, switched)?;
        let unknowns: Vec<usize> =
            (0..model.nodes.len()).filter(|&n| !matches!(model.nodes[n].kind, NodeKind::Boundary { .. })).collect();
        let mut unknown_of = vec![None; model.nodes.len()];
        for (position, &node) in unknowns.iter().enumerate() {
            unknown_of[node] = Some(position);
        }
        let column_of = |symbol: Symbol| match symbol {
            Symbol::Node(node) => unknown_of.get(node as usize).copied().flatten(),
            _ => None,
        };
        let wanted = positions(differentiate);
        let symbol_of = |symbol: Symbol| match symbol {
            // A node stands for its start temperature, on which no equation depends.
            Symbol::Node(_) => None,
            _ => wanted.get(&symbol).copied(),
        };
        let mut finder = SymbolFinder::default();
        let zero = graph.number(0.0);
        let mut residual = vec![zero; unknowns.len()];
        let mut balance_scale = vec![zero; unknowns.len()];
        let mut jacobian = Accumulator::default();
        let mut residual_tangent = Accumulator::default();
        let mut into_boundary: Vec<(usize, ExprId)> = Vec::new();
        let mut sources = Vec::new();
        let mut heats = Vec::new();
        for (index, contribution) in forms.contributions.iter().enumerate() {
            for &(node, heat) in &contribution.heat {
                let Some(row) = unknown_of[node] else {
                    match into_boundary.iter_mut().find(|(boundary, _)| *boundary == node) {
                        Some((_, total)) => *total = graph.add(*total, heat),
                        None => into_boundary.push((node, heat)),
                    }
                    continue;
                };
                residual[row] = graph.add(residual[row], heat);
                for &symbol in finder.find(&graph, heat) {
                    if let Some(column) = column_of(symbol) {
                        let slope = graph.derivative(heat, symbol);
                        jacobian.terms.push((row, column, slope));
                    } else if let Some(column) = symbol_of(symbol) {
                        let slope = graph.derivative(heat, symbol);
                        residual_tangent.terms.push((row, column, slope));
                    }
                }
            }
            for &(node, size) in &contribution.balance_scale {
                if let Some(row) = unknown_of[node] {
                    balance_scale[row] = graph.add(balance_scale[row], size);
                }
            }
            let passes_on = match contribution.heat[..] {
                [(_, a), (_, b)] => graph.negate(a) == b || graph.negate(b) == a,
                _ => false,
            };
            if !passes_on {
                let all: Vec<ExprId> = contribution.heat.iter().map(|&(_, heat)| heat).collect();
                sources.push((index, graph.sum(&all)));
            }
            heats.push(NamedHeats {
                name: model.elements[index].name.clone(),
                heats: contribution.heat.iter().map(|&(_, heat)| heat).collect(),
            });
        }
        into_boundary.sort_by_key(|&(node, _)| node);
        let jacobian = jacobian.sum(&mut graph);
        let residual_tangent = residual_tangent.sum(&mut graph);

        let mut capacity = vec![None; unknowns.len()];
        let mut capacity_slope = vec![None; unknowns.len()];
        let mut capacity_tangent = Vec::new();
        for (row, &node) in unknowns.iter().enumerate() {
            let Some(expression) = forms.capacities[node] else { continue };
            capacity[row] = Some(expression);
            for &symbol in finder.find(&graph, expression) {
                match (column_of(symbol), symbol_of(symbol)) {
                    (Some(column), _) if column == row => {
                        capacity_slope[row] = Some(graph.derivative(expression, symbol));
                    }
                    (Some(column), _) => {
                        return Err(NetworkError::CapacityDependsOnOther {
                            node: model.nodes[node].name.clone(),
                            other: model.nodes[unknowns[column]].name.clone(),
                        });
                    }
                    (None, Some(column)) => {
                        capacity_tangent.push((row, column, graph.derivative(expression, symbol)));
                    }
                    (None, None) => {}
                }
            }
        }
        let mut slopes = |graph: &mut Graph, values: &[ExprId]| {
            let (mut by_temperature, mut by_symbol) = (Vec::new(), Vec::new());
            for (row, &value) in values.iter().enumerate() {
                for &symbol in finder.find(graph, value) {
                    if let Some(column) = column_of(symbol) {
                        by_temperature.push((row, column, graph.derivative(value, symbol)));
                    } else if let Some(column) = symbol_of(symbol) {
                        by_symbol.push((row, column, graph.derivative(value, symbol)));
                    }
                }
            }
            (by_temperature, by_symbol)
        };
        let (quantity_temperature, quantity_symbol) = slopes(&mut graph, &forms.quantities);
        let switch: Vec<ExprId> = forms.switches.iter().flat_map(|s| [s.on, s.off]).collect();
        let (switch_temperature, switch_symbol) = slopes(&mut graph, &switch);
        let (boundary_nodes, boundary): (Vec<usize>, Vec<ExprId>) = model
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(node, n)| match n.kind {
                NodeKind::Boundary { temperature } => Some((node, temperature)),
                _ => None,
            })
            .unzip();
        let (_, boundary_tangent) = slopes(&mut graph, &boundary);
        let balances: Vec<ExprId> = residual.iter().copied().chain(capacity.iter().copied().flatten()).collect();
        let given = Dependence::PARAMETER.union(Dependence::INPUT).union(Dependence::TIME);
        let discontinuities = graph.discontinuities(&balances, given);
        let table_discontinuities = graph.table_discontinuities(&balances, given);

        let bands: Vec<(String, ExprId)> = (model.elements.iter().zip(&forms.contributions))
            .filter_map(|(element, contribution)| Some((element.name.clone(), contribution.band?)))
            .filter(|(_, band)| graph.dependence(*band).within(given))
            .collect();

        let is_kept = |sign: &SignConstraint| {
            model.keeps_signs && graph.constant(sign.value).is_none() && graph.dependence(sign.value).within(given)
        };
        let signs: Vec<(String, SignConstraint)> = (model.elements.iter())
            .flat_map(|element| {
                element.physics().sign_constraints().into_iter().map(|sign| (element.name.clone(), sign))
            })
            .filter(|(_, sign)| is_kept(sign))
            .collect();

        // One list of outputs a segment; `take` reads the registers back in the same order.
        let ids = |entries: &[(usize, usize, ExprId)]| entries.iter().map(|e| e.2).collect::<Vec<_>>();
        let some = |list: &[Option<ExprId>]| list.iter().copied().flatten().collect::<Vec<_>>();
        let join = |a: Vec<ExprId>, b: Vec<ExprId>| a.into_iter().chain(b).collect::<Vec<_>>();
        let outputs: Vec<Vec<ExprId>> = vec![
            (boundary.iter().copied())
                .chain(bands.iter().map(|&(_, band)| band))
                .chain(signs.iter().map(|(_, sign)| sign.value))
                .collect(),
            residual,
            balance_scale,
            ids(&jacobian),
            some(&capacity),
            some(&capacity_slope),
            ids(&residual_tangent),
            ids(&capacity_tangent),
            forms.quantities,
            join(ids(&quantity_temperature), ids(&quantity_symbol)),
            switch,
            join(ids(&switch_temperature), ids(&switch_symbol)),
            sources.iter().map(|s| s.1).chain(into_boundary.iter().map(|b| b.1)).collect(),
            ids(&boundary_tangent),
            discontinuities.iter().copied().chain(table_discontinuities.iter().map(|&(_, at)| at)).collect(),
        ];
        let roots: Vec<ExprId> = outputs.iter().flatten().copied().collect();
        if let Some(&bad) = roots.iter().find(|&&id| graph.dependence(id).intersects(Dependence::LOCAL)) {
            return Err(NetworkError::UnboundValue {
                symbols: graph
                    .symbols(bad)
                    .iter()
                    .filter(|s| matches!(s, Symbol::Local(_)))
                    .map(|s| format!("{s:?}"))
                    .collect::<Vec<_>>()
                    .join(", "),
            });
        }
        let parameter = Dependence::PARAMETER;
        let input = parameter.union(Dependence::INPUT);
        let instant = input.union(Dependence::TIME).union(Dependence::MODE);
        let hoisted: Vec<Vec<ExprId>> =
            [parameter, input, instant].iter().map(|&allowed| graph.frontier(&roots, allowed)).collect();
        let after: Vec<&[usize]> = vec![
            &[],
            &[0],
            &[0, 1],
            &[0, 1, 2],
            &[0, 1, 2],
            &[0, 1, 2, segment::RESIDUAL],
            &[0, 1, 2, segment::RESIDUAL],
            &[0, 1, 2],
            &[0, 1, 2, segment::CAPACITY],
            &[0, 1, 2, segment::RESIDUAL],
            &[0, 1, 2, segment::CAPACITY],
            &[0, 1, 2],
            &[0, 1, 2, segment::QUANTITY],
            &[0, 1, 2],
            &[0, 1, 2, segment::SWITCH],
            &[0, 1, 2],
            &[0, 1, 2],
            &[0, 1, 2],
        ];
        let segments: Vec<Segment<'_>> =
            hoisted.iter().chain(&outputs).zip(after).map(|(outputs, after)| Segment { after, outputs }).collect();
        let symbols = symbol_order(model, &unknowns, forms.switches.len());
        let program = Program::compile_branches(&graph, &symbols, &segments);

        let entries = |segment: usize, from: usize, list: &[(usize, usize, ExprId)]| -> Vec<Entry> {
            list.iter()
                .zip(&program.outputs(segment)[from..])
                .map(|(&(row, column, _), &register)| Entry { row, column, register })
                .collect()
        };
        let optional = |segment: usize, list: &[Option<ExprId>]| -> Vec<Option<Register>> {
            let mut registers = program.outputs(segment).iter().copied();
            list.iter().map(|entry| entry.and_then(|_| registers.next())).collect()
        };
        let balance = program.outputs(segment::BALANCE);
        let after_bands = boundary_nodes.len() + bands.len();
        Ok(Self {
            parameters: model.parameters.len(),
            inputs: model.inputs.len(),
            outputs: model.external.as_ref().map_or(0, |external| external.outputs),
            modes: forms.switches.len(),
            mode_names: forms.mode_names,
            boundaries: boundary_nodes
                .iter()
                .copied()
                .zip(program.outputs(segment::BOUNDARY).iter().copied())
                .collect(),
            bands: (bands.into_iter().zip(&program.outputs(segment::BOUNDARY)[boundary_nodes.len()..]))
                .map(|((name, _), &register)| (name, register))
                .collect(),
            signs: (signs.into_iter().zip(&program.outputs(segment::BOUNDARY)[after_bands..]))
                .map(|((name, sign), &register)| (name, sign, register))
                .collect(),
            residual: program.outputs(segment::RESIDUAL).to_vec(),
            balance_scale: program.outputs(segment::BALANCE_SCALE).to_vec(),
            jacobian: entries(segment::JACOBIAN, 0, &jacobian),
            capacity: optional(segment::CAPACITY, &capacity),
            capacity_varies: capacity_slope.iter().any(Option::is_some),
            capacity_slope: optional(segment::CAPACITY_SLOPE, &capacity_slope),
            residual_tangent: entries(segment::RESIDUAL_TANGENT, 0, &residual_tangent),
            capacity_tangent: entries(segment::CAPACITY_TANGENT, 0, &capacity_tangent),
            quantity: program.outputs(segment::QUANTITY).to_vec(),
            quantity_temperature: entries(segment::QUANTITY_TANGENT, 0, &quantity_temperature),
            quantity_symbol: entries(segment::QUANTITY_TANGENT, quantity_temperature.len(), &quantity_symbol),
            switch: program.outputs(segment::SWITCH).chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
            switch_temperature: entries(segment::SWITCH_TANGENT, 0, &switch_temperature),
            switch_symbol: entries(segment::SWITCH_TANGENT, switch_temperature.len(), &switch_symbol),
            sources: sources.iter().map(|s| s.0).zip(balance.iter().copied()).collect(),
            into_boundary: into_boundary.iter().map(|b| b.0).zip(balance[sources.len()..].iter().copied()).collect(),
            boundary_tangent: entries(segment::BOUNDARY_TANGENT, 0, &boundary_tangent),
            discontinuities: program.outputs(segment::DISCONTINUITY)[..discontinuities.len()].to_vec(),
            table_discontinuities: table_discontinuities
                .iter()
                .zip(&program.outputs(segment::DISCONTINUITY)[discontinuities.len()..])
                .map(|(&(table, _), &at)| (graph.tables()[table as usize].x.clone(), at))
                .collect(),
            heats,
            unknowns,
            program,
            graph,
        })
    }

    /// Number of unknown temperatures.
    pub fn size(&self) -> usize {
        self.unknowns.len()
    }

    /// Registers of the unknown temperatures.
    pub fn temperatures(&self) -> std::ops::Range<usize> {
        let first = self.time() + 1;
        first..first + self.unknowns.len()
    }

    /// Register of time.
    pub fn time(&self) -> usize {
        self.parameters + self.inputs + self.outputs
    }

    /// Registers of the outputs of what answers for the model.
    pub fn given_outputs(&self) -> std::ops::Range<usize> {
        self.parameters + self.inputs..self.time()
    }

    /// Registers of the modes.
    pub fn modes(&self) -> std::ops::Range<usize> {
        let first = self.temperatures().end;
        first..first + self.modes
    }
}

/// The symbols of the first registers: parameters, inputs, outputs of what answers for the model, time, unknown
/// temperatures, modes.
fn symbol_order(model: &Model, unknowns: &[usize], modes: usize) -> Vec<Symbol> {
    let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    (0..model.parameters.len())
        .map(|i| Symbol::Parameter(number(i)))
        .chain((0..model.inputs.len()).map(|i| Symbol::Input(number(i))))
        .chain((0..model.external.as_ref().map_or(0, |external| external.outputs)).map(|i| Symbol::Output(number(i))))
        .chain([Symbol::Time])
        .chain(unknowns.iter().map(|&i| Symbol::Node(number(i))))
        .chain((0..modes).map(|i| Symbol::Mode(number(i))))
        .collect()
}

/// The elements' contributions and the quantities with boundary temperatures put in.
fn expressions(model: &Model, graph: &mut Graph, switched: bool) -> Result<Forms, NetworkError> {
    let given = Dependence::PARAMETER.union(Dependence::INPUT).union(Dependence::TIME);
    let mut replacements = HashMap::new();
    for (index, node) in model.nodes.iter().enumerate() {
        match node.kind {
            NodeKind::Boundary { temperature } => {
                if !graph.dependence(temperature).within(given) {
                    return Err(NetworkError::BoundaryNotGiven { node: node.name.clone() });
                }
                let symbol = graph.symbol(Symbol::Node(u32::try_from(index).unwrap_or(u32::MAX)));
                replacements.insert(symbol, temperature);
            }
            NodeKind::Diffusion { capacity } => {
                if let Some(value) = graph.constant(capacity)
                    && !(value > 0.0 && value.is_finite())
                {
                    return Err(NetworkError::Capacity { node: node.name.clone(), capacity: value });
                }
            }
            NodeKind::Arithmetic => {}
        }
    }
    let mut switches = Vec::new();
    let mut mode_names = Vec::new();
    let mut contributions = Vec::with_capacity(model.elements.len());
    let mut steady_duties = HashMap::new();
    for element in &model.elements {
        if let Some(reason) = element.physics().fault() {
            let (kind, element) = (element.physics().kind(), element.name.clone());
            return Err(NetworkError::Malformed { kind, element, reason });
        }
        let contribution = element.contribution(graph, &mut switches, switched);
        if switches.len() > mode_names.len() {
            mode_names.resize(switches.len(), element.name.clone());
            // Quantities were written with the steady duty; in a transient they mean the present state.
            let steady = element.contribution(graph, &mut Vec::new(), false);
            if let (Some(steady), Some(present)) = (steady.duty, contribution.duty) {
                steady_duties.insert(steady, present);
            }
        }
        for &(node, _) in contribution.heat.iter().chain(&contribution.balance_scale) {
            if node >= model.nodes.len() {
                return Err(NetworkError::UnknownNode {
                    element: element.name.clone(),
                    node,
                    nodes: model.nodes.len(),
                });
            }
        }
        contributions.push(contribution);
    }
    let quantities: Vec<ExprId> = model.quantities.iter().map(|q| q.value.expression()).collect();
    let quantities = graph.substitute(&quantities, &steady_duties);
    let capacities: Vec<Option<ExprId>> = model
        .nodes
        .iter()
        .map(|node| match node.kind {
            NodeKind::Diffusion { capacity } => Some(capacity),
            _ => None,
        })
        .collect();

    let mut roots = quantities;
    let quantity_count = roots.len();
    roots.extend(capacities.iter().flatten());
    roots.extend(switches.iter().flat_map(|s| [s.on, s.off]));
    for contribution in &contributions {
        roots.extend(contribution.heat.iter().chain(&contribution.balance_scale).map(|&(_, id)| id));
    }
    let renewed = graph.substitute(&roots, &replacements);
    let mut next = renewed[quantity_count..].iter().copied();
    let mut renew = |id: &mut ExprId| {
        if let Some(new) = next.next() {
            *id = new;
        }
    };
    let mut capacities = capacities;
    capacities.iter_mut().flatten().for_each(&mut renew);
    for switch in &mut switches {
        renew(&mut switch.on);
        renew(&mut switch.off);
    }
    for contribution in &mut contributions {
        contribution.heat.iter_mut().for_each(|(_, id)| renew(id));
        contribution.balance_scale.iter_mut().for_each(|(_, id)| renew(id));
    }
    Ok(Forms { contributions, switches, mode_names, capacities, quantities: renewed[..quantity_count].to_vec() })
}
