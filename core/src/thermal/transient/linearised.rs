//! A network linearised along a transient: what small heats into its nodes do to its temperatures.
//!
//! `C dT' = J dT + q` from known temperatures, by the L-stable method of two stages and second order with equal diagonal
//! `1 - 1/sqrt(2)` (Alexander 1977, SIAM J. Numer. Anal. 14, 1006). `C` and `J` are those of the middle of a step, so that a step
//! costs one factorisation whatever the number of heats.

use nalgebra::{Matrix2, Vector2};

use crate::thermal::equations::{Equations, segment};
use crate::thermal::linear::Linear;
use crate::thermal::network::Network;

use super::integrator::Integrator;
use super::{InitialState, InputTable, TransientError, TransientRequest};

/// Diagonal of the method: the instant of its first stage, as a share of a step.
pub const EARLY: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Weight of the first stage's slope in the base of the second.
pub(super) const OF_EARLY: f64 = (1.0 - EARLY) / EARLY;

/// Most numbers of all factors, 128 MiB.
const MOST_ENTRIES: usize = 1 << 24;

/// Adds the heats of a step, by its position, at its first stage and at its end.
pub type HeatsOfStep<'a> = dyn FnMut(usize, &mut [f64], &mut [f64]) + 'a;

/// A transient that is known.
#[derive(Clone, Copy, Debug)]
pub struct KnownCourse<'a> {
    /// Parameters, SI.
    pub parameters: &'a [f64],
    /// Inputs over time.
    pub inputs: &'a InputTable,
    /// Whether it begins in the steady state of its inputs; else at temperatures that heats do not change.
    pub from_steady: bool,
    /// Temperatures of all nodes at the instants of the inputs, `rows x nodes`, K; there may be fewer rows.
    pub temperatures: &'a [f64],
    /// Rows between which steps go, ascending, the first among them.
    pub rows: &'a [usize],
}

/// A node that the network lacks, joined by paths to one or two of its nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct AddedNode {
    /// Its heat capacity, J/K.
    pub capacity: f64,
    /// The one or two nodes that it is joined to, each with the conductance of the path, W/K.
    pub hosts: [Option<(usize, f64)>; 2],
    /// Conductance that is added between its two hosts, W/K: negative where a path is taken away.
    pub between: f64,
}

/// A network linearised along a transient.
#[derive(Clone, Debug)]
pub struct LinearisedTransient {
    /// Position among the unknowns, by node; `None` for boundaries.
    unknown_of: Vec<Option<usize>>,
    size: usize,
    steps: Vec<Step>,
    /// Slopes at the start, where it is a steady state.
    start: Option<Linear<f64>>,
    /// Quantity and unknown of each slope of a quantity in a temperature.
    observes: Vec<(usize, usize)>,
    /// Their values, by row.
    slopes: Vec<Vec<f64>>,
}

#[derive(Clone, Debug)]
struct Step {
    /// Its implicit part, s.
    implicit_s: f64,
    /// Capacity over the implicit part of the step, W/K; 0 for what stores no heat.
    storage: Vec<f64>,
    /// Factors of `J - C / (share x step)`.
    factors: Linear<f64>,
}

impl Network {
    /// Linearises along a known transient. `None` for a network with thermostats, whose switching such heats would move, and
    /// for one whose factors are too large to be held.
    ///
    /// # Errors
    /// [`TransientError`] for inputs that do not suit the network.
    pub fn linearised_along(&self, course: &KnownCourse<'_>) -> Result<Option<LinearisedTransient>, TransientError> {
        if self.switched.is_some() || course.rows.len() < 2 {
            return Ok(None);
        }
        let mut request = TransientRequest::new(course.parameters, course.inputs, InitialState::Steady, &[]);
        request.start_s = course.inputs.times_s.first().copied();
        let mut at = Integrator::new(self, &request)?;
        let equations = at.equations;
        if matches!(at.linear, Linear::Sparse(_))
            || equations.jacobian.len().saturating_mul(course.rows.len()) > MOST_ENTRIES
        {
            return Ok(None);
        }
        let nodes = self.nodes();
        let mut unknown_of = vec![None; nodes];
        for (position, &node) in equations.unknowns.iter().enumerate() {
            unknown_of[node] = Some(position);
        }
        let observes = equations.quantity_temperature.iter().map(|entry| (entry.row, entry.column)).collect();
        let mut linearised = LinearisedTransient {
            unknown_of,
            size: equations.size(),
            steps: Vec::with_capacity(course.rows.len() - 1),
            start: None,
            observes,
            slopes: Vec::with_capacity(course.rows.len()),
        };
        let times_s = &course.inputs.times_s;
        let temperatures = |row: usize| &course.temperatures[row * nodes..(row + 1) * nodes];
        for (place, &row) in course.rows.iter().enumerate() {
            at.put(times_s[row], temperatures(row).iter().copied());
            if place == 0 && course.from_steady {
                at.refresh_slopes(0);
                let mut start = at.linear.clone();
                start.load_values(equations, &at.matrix.jacobian);
                start.factor();
                linearised.start = Some(start);
            }
            linearised.slopes.push(at.quantity_slopes_in_temperatures());
            let Some(&next) = course.rows.get(place + 1) else { break };
            let middle = row + (next - row) / 2;
            let after = middle + (next - row) % 2;
            let time_s = 0.5 * (times_s[middle] + times_s[after]);
            let mean = temperatures(middle).iter().zip(temperatures(after)).map(|(a, b)| 0.5 * (a + b));
            at.put(time_s, mean);
            linearised.steps.push(at.linear_step(EARLY * (times_s[next] - times_s[row])));
        }
        Ok(Some(linearised))
    }
}

impl Integrator<'_> {
    /// Evaluates balances and capacities at an instant and temperatures of all nodes, K.
    fn put(&mut self, time_s: f64, temperatures: impl Iterator<Item = f64>) {
        let all: Vec<f64> = temperatures.collect();
        for (value, &node) in self.stage_values[0].iter_mut().zip(&self.equations.unknowns) {
            *value = all[node];
        }
        self.reader.enter(time_s);
        self.forget_instant();
        self.set_instant(time_s);
        self.evaluate(0);
        for row in 0..self.equations.size() {
            let rate = self.file[self.equations.residual[row].index()] / self.capacity(row);
            self.stage_slopes[0][row] = if rate.is_finite() { rate } else { 0.0 };
        }
    }

    /// The matrix of a step whose implicit part lasts so long, at what was put.
    fn linear_step(&mut self, implicit_s: f64) -> Step {
        self.refresh_slopes(0);
        let mut factors = self.linear.clone();
        factors.load_values(self.equations, &self.matrix.jacobian);
        let mut storage = vec![0.0; self.equations.size()];
        for (row, storage) in storage.iter_mut().enumerate() {
            if self.stores(row) {
                *storage = self.matrix.capacity[row] / implicit_s;
                factors.add_to_diagonal(row, -(*storage + self.matrix.capacity_rate[row]));
            }
        }
        factors.factor();
        Step { implicit_s, storage, factors }
    }

    /// Slopes of quantities in temperatures at what was put.
    fn quantity_slopes_in_temperatures(&mut self) -> Vec<f64> {
        let equations: &Equations = self.equations;
        equations.program.run(segment::QUANTITY, &mut self.file);
        equations.program.run(segment::QUANTITY_TANGENT, &mut self.file);
        equations.quantity_temperature.iter().map(|entry| self.file[entry.register.index()]).collect()
    }
}

impl LinearisedTransient {
    /// Number of unknown temperatures.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Position of a node among the unknowns; `None` for boundaries.
    pub fn unknown(&self, node: usize) -> Option<usize> {
        self.unknown_of.get(node).copied().flatten()
    }

    /// Responds to several heats at once. `at_start` adds those at the start, W, and `heat` those of a step at its first stage
    /// ([`EARLY`]) and at its end; they are linear in between. `give` receives the changes of the temperatures at each row, K. All fields are
    /// `unknowns x columns`.
    pub fn respond(
        &self,
        columns: usize,
        at_start: &mut dyn FnMut(&mut [f64]),
        heat: &mut HeatsOfStep<'_>,
        give: &mut dyn FnMut(usize, &[f64]),
    ) {
        let length = self.size * columns;
        let (mut state, mut early, mut late) = (vec![0.0; length], vec![0.0; length], vec![0.0; length]);
        if let Some(start) = &self.start {
            at_start(&mut state);
            state.iter_mut().for_each(|value| *value = -*value);
            start.solve_columns_shared(&mut state, columns);
        }
        give(0, &state);
        for (place, step) in self.steps.iter().enumerate() {
            early.fill(0.0);
            late.fill(0.0);
            heat(place, &mut early, &mut late);
            let rows = |row: usize| row * columns..(row + 1) * columns;
            for (row, &storage) in step.storage.iter().enumerate() {
                for (early, state) in early[rows(row)].iter_mut().zip(&state[rows(row)]) {
                    *early = -*early - storage * state;
                }
            }
            step.factors.solve_columns_shared(&mut early, columns);
            for (row, &storage) in step.storage.iter().enumerate() {
                let before = early[rows(row)].iter().zip(&state[rows(row)]);
                for (late, (early, state)) in late[rows(row)].iter_mut().zip(before) {
                    *late = -*late - storage * (state + OF_EARLY * (early - state));
                }
            }
            step.factors.solve_columns_shared(&mut late, columns);
            std::mem::swap(&mut state, &mut late);
            give(place + 1, &state);
        }
    }

    /// Responds to added nodes, each alone, as [`LinearisedTransient::respond`] does to heats. `at_start` is the temperature of a node of the
    /// network at the start, K, and `in_step` those of a node in a step, by its position, at the first stage and at the end; they are
    /// linear in between. An added node begins at the temperature of its first host that is no boundary, or in the steady state where the
    /// transient does.
    pub fn respond_to_nodes(
        &self,
        added: &[AddedNode],
        at_start: &dyn Fn(usize) -> f64,
        in_step: &dyn Fn(usize, usize) -> [f64; 2],
        give: &mut dyn FnMut(usize, &[f64]),
    ) {
        let columns = added.len();
        let mut hosts: Vec<usize> =
            added.iter().flat_map(|own| own.hosts).flatten().filter_map(|(node, _)| self.unknown(node)).collect();
        hosts.sort_unstable();
        hosts.dedup();
        let joined: Vec<Joined<'_>> = added.iter().map(|own| Joined::new(self, own, &hosts)).collect();
        let length = self.size * columns;
        let (mut state, mut early, mut late) = (vec![0.0; length], vec![0.0; length], vec![0.0; length]);
        let mut own: Vec<f64> = added
            .iter()
            .map(|own| {
                let mut hosts = own.hosts.iter().flatten();
                let first = hosts.clone().next();
                let host = hosts.find(|(node, _)| self.unknown(*node).is_some()).or(first);
                host.map_or(0.0, |&(node, _)| at_start(node))
            })
            .collect();
        let mut unit = vec![0.0; self.size * hosts.len()];
        let respond_to_units = |factors: &Linear<f64>, unit: &mut [f64]| {
            unit.fill(0.0);
            for (place, &host) in hosts.iter().enumerate() {
                unit[host * hosts.len() + place] = -1.0;
            }
            factors.solve_columns_shared(unit, hosts.len());
        };
        if let Some(start) = &self.start {
            respond_to_units(start, &mut unit);
            for (column, joined) in joined.iter().enumerate() {
                own[column] = joined.close(&unit, 0.0, own[column], at_start, &mut state, (column, columns));
            }
        }
        give(0, &state);
        for (place, step) in self.steps.iter().enumerate() {
            respond_to_units(&step.factors, &mut unit);
            let rows = |row: usize| row * columns..(row + 1) * columns;
            for (row, &storage) in step.storage.iter().enumerate() {
                for (early, state) in early[rows(row)].iter_mut().zip(&state[rows(row)]) {
                    *early = -storage * state;
                }
            }
            step.factors.solve_columns_shared(&mut early, columns);
            let mut own_early = own.clone();
            let at_early = |node: usize| in_step(place, node)[0];
            for (column, (joined, own)) in joined.iter().zip(&mut own_early).enumerate() {
                let storage = joined.added.capacity / step.implicit_s;
                *own = joined.close(&unit, storage, *own, &at_early, &mut early, (column, columns));
            }
            for (row, &storage) in step.storage.iter().enumerate() {
                let before = early[rows(row)].iter().zip(&state[rows(row)]);
                for (late, (early, state)) in late[rows(row)].iter_mut().zip(before) {
                    *late = -storage * (state + OF_EARLY * (early - state));
                }
            }
            step.factors.solve_columns_shared(&mut late, columns);
            let at_end = |node: usize| in_step(place, node)[1];
            for (column, (joined, (own, early))) in joined.iter().zip(own.iter_mut().zip(&own_early)).enumerate() {
                let storage = joined.added.capacity / step.implicit_s;
                let base = *own + OF_EARLY * (early - *own);
                *own = joined.close(&unit, storage, base, &at_end, &mut late, (column, columns));
            }
            std::mem::swap(&mut state, &mut late);
            give(place + 1, &state);
        }
    }

    /// Changes of a quantity at a row, for each column, from those of the temperatures there.
    pub fn observe(&self, place: usize, quantity: usize, columns: usize, field: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (&(own, unknown), &slope) in self.observes.iter().zip(&self.slopes[place]) {
            if own == quantity && slope != 0.0 {
                for (out, value) in out.iter_mut().zip(&field[unknown * columns..(unknown + 1) * columns]) {
                    *out += slope * value;
                }
            }
        }
    }
}

/// An added node with the places of its hosts.
struct Joined<'a> {
    added: &'a AddedNode,
    /// Of each host its unknown, and its place among all hosts; `None` for a boundary, and without a second host.
    places: [Option<(usize, usize)>; 2],
    /// Number of all hosts.
    hosts: usize,
}

impl<'a> Joined<'a> {
    fn new(linearised: &LinearisedTransient, added: &'a AddedNode, hosts: &[usize]) -> Self {
        let place = |host: Option<(usize, f64)>| {
            let unknown = linearised.unknown(host?.0)?;
            hosts.binary_search(&unknown).ok().map(|place| (unknown, place))
        };
        Self { added, places: added.hosts.map(place), hosts: hosts.len() }
    }

    /// Closes the balance of the added node, and those of its hosts with what it adds to them, at a stage. `unit` is what 1 W into each
    /// host does to all unknowns, `storage` the capacity over the implicit part of the step, W/K, `base` the temperature from which
    /// that starts, K, `temperature` that of a node of the network without it. `field` has what the network changes by itself, and gets what
    /// it changes with the node. Gives the temperature of the node, K.
    ///
    /// With `y` the temperatures of the hosts, `g` the conductances and `D = storage + sum g` the heats into the hosts are `M y + m`,
    /// `M = g g' / D - diag(g)` with `between` beside it, `m = g storage base / D`; and `y` is what it is without them and
    /// `B (M y + m)`, `B` the part of `unit` at the hosts.
    fn close(
        &self,
        unit: &[f64],
        storage: f64,
        base: f64,
        temperature: &dyn Fn(usize) -> f64,
        field: &mut [f64],
        (column, columns): (usize, usize),
    ) -> f64 {
        let hosts = &self.added.hosts;
        let conductance = Vector2::from_fn(|a, _| hosts[a].map_or(0.0, |(_, conductance)| conductance));
        let sum = storage + conductance.sum();
        let between = Matrix2::new(-1.0, 1.0, 1.0, -1.0) * self.added.between;
        let heat = conductance * conductance.transpose() / sum - Matrix2::from_diagonal(&conductance) + between;
        let constant = conductance * (storage * base / sum);
        let response = Matrix2::from_fn(|a, b| match (self.places[a], self.places[b]) {
            (Some((unknown, _)), Some((_, place))) => unit[unknown * self.hosts + place],
            _ => 0.0,
        });
        let without = Vector2::from_fn(|a, _| {
            let change = self.places[a].map_or(0.0, |(unknown, _)| field[unknown * columns + column]);
            hosts[a].map_or(0.0, |(node, _)| temperature(node)) + change
        });
        let matrix = Matrix2::identity() - response * heat;
        let Some(inverse) = matrix.try_inverse() else { return f64::NAN };
        let at_hosts = inverse * (without + response * constant);
        let heats = heat * at_hosts + constant;
        for (heat, place) in heats.iter().zip(self.places) {
            let Some((_, place)) = place else { continue };
            for (field, unit) in field.chunks_exact_mut(columns).zip(unit.chunks_exact(self.hosts)) {
                field[column] += heat * unit[place];
            }
        }
        (storage * base + conductance.dot(&at_hosts)) / sum
    }
}
