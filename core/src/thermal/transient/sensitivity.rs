//! Forward derivatives of the discrete solution, its steps held fixed.
//!
//! Each stage's equations are differentiated as they were solved: with the exact slopes at the stage,
//! `(J - C' k - C / (g h)) dY = -dr/dp + dC/dp k - C dB / (g h)`, `dk = (dY - dB) / (g h)`. At the switching of a
//! thermostat at `t*`, whose function `w` crosses zero, `dt*/dp = -(w_T dT/dp + w_p) / (w_T dT/dt)` and the derivative
//! jumps by `(dT/dt before - after) dt*/dp`. Thresholds that move in time are taken as resting at the switching.
//!
//! Where a few per cent will do, a step has one matrix, that of the mean slopes at its ends, and two solves, by the method of
//! [`super::linearised`].

use std::ops::Range;

use crate::expression::Symbol;
use crate::thermal::equations::{Entry, Equations, segment};
use crate::thermal::network::{Network, Workspace};
use crate::thermal::newton::HOLD_W_PER_K;

use super::Transient;
use super::events::hermite;
use super::integrator::Integrator;
use super::linearised::{EARLY, OF_EARLY};
use super::tableau::{COEFFICIENTS, GAMMA, NODES, STAGES};

/// Derivatives of the state: fields of `unknowns x columns`, so that a step of an elimination takes all columns of a row at
/// once.
pub(super) struct Tangent {
    size: usize,
    symbols: usize,
    columns: usize,
    /// Of the stages' temperatures; the first is the state's.
    values: Vec<Vec<f64>>,
    /// Of the stages' slopes.
    slopes: Vec<Vec<f64>>,
    base: Vec<f64>,
    /// Change of the instant of the switching under way, by column.
    shift: Vec<f64>,
    /// Where steps are coarse: the slopes at the start of the step, and room for those at its end.
    ends: Option<Box<[Ends; 2]>>,
    /// Rows on which quantities depend, and room for all at an output.
    seen_rows: Vec<usize>,
    seen: Vec<f64>,
}

/// Slopes of the balances at an end of a step, lists of entries in the order of the equations'.
struct Ends {
    /// Derivatives of the balances at fixed temperatures, `unknowns x columns`.
    heats: Vec<f64>,
    jacobian: Vec<f64>,
    capacity: Vec<f64>,
    /// Slope of each capacity in its temperature.
    capacity_slope: Vec<f64>,
    capacity_tangent: Vec<f64>,
}

impl Tangent {
    /// With `is_coarse` its steps are.
    pub fn new(network: &Network, equations: &Equations, seeds: &[Vec<f64>], is_coarse: bool) -> Self {
        let size = equations.size();
        let symbols = network.differentiate.len();
        let columns = symbols + seeds.len();
        let mut values = vec![vec![0.0; size * columns]; STAGES];
        for (column, symbol) in network.differentiate.iter().enumerate() {
            if let Symbol::Node(node) = symbol
                && let Some(row) = equations.unknowns.iter().position(|&unknown| unknown == *node as usize)
            {
                values[0][row * columns + column] = 1.0;
            }
        }
        for (seed, direction) in seeds.iter().enumerate() {
            for (row, &node) in equations.unknowns.iter().enumerate() {
                values[0][row * columns + symbols + seed] = direction.get(node).copied().unwrap_or(0.0);
            }
        }
        let mut seen_rows: Vec<usize> = equations.quantity_temperature.iter().map(|entry| entry.column).collect();
        seen_rows.sort_unstable();
        seen_rows.dedup();
        let end = || Ends {
            heats: vec![0.0; size * columns],
            jacobian: vec![0.0; equations.jacobian.len()],
            capacity: vec![0.0; size],
            capacity_slope: vec![0.0; size],
            capacity_tangent: vec![0.0; equations.capacity_tangent.len()],
        };
        Self {
            size,
            symbols,
            columns,
            slopes: vec![vec![0.0; size * columns]; STAGES],
            base: vec![0.0; size * columns],
            shift: vec![0.0; columns],
            ends: is_coarse.then(|| Box::new([end(), end()])),
            seen_rows,
            seen: vec![0.0; size * columns],
            values,
        }
    }

    /// Number of columns: differentiated symbols, then seeds.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Starts from given derivatives of the state, `unknowns x columns`.
    pub fn set_state(&mut self, state: &[f64]) {
        self.values[0].copy_from_slice(state);
    }

    /// Starts from the derivatives of a steady state, or of one in which some temperatures are held.
    pub fn start_steady(&mut self, network: &Network, workspace: &mut Workspace) {
        let mut all = vec![0.0; network.nodes() * self.symbols];
        self.values[0].fill(0.0);
        if network.temperature_tangent(workspace, &mut all).is_ok() {
            for (row, &node) in network.steady.unknowns.iter().enumerate() {
                for column in 0..self.symbols {
                    self.values[0][row * self.columns + column] = all[node * self.symbols + column];
                }
            }
        }
    }

    /// The end of the step becomes its start.
    pub fn arrive(&mut self) {
        self.values.swap(0, STAGES - 1);
        self.slopes.swap(0, STAGES - 1);
    }

    /// Writes the derivatives of some rows at a share of the step just tried into a field of all rows.
    fn interpolate(&self, share: f64, step_s: f64, rows: Range<usize>, field: &mut [f64]) {
        let range = rows.start * self.columns..rows.end * self.columns;
        let [from, to] = [&self.values[0][range.clone()], &self.values[STAGES - 1][range.clone()]];
        let [first, last] = [&self.slopes[0][range.clone()], &self.slopes[STAGES - 1][range.clone()]];
        let field = &mut field[range];
        if share == 0.0 {
            field.copy_from_slice(from);
            return;
        }
        let weights = hermite(share);
        for (i, value) in field.iter_mut().enumerate() {
            *value =
                weights[0] * from[i] + weights[1] * to[i] + step_s * (weights[2] * first[i] + weights[3] * last[i]);
        }
    }

    /// Adds `weight` times the entries' registers to a field of columns.
    fn add(field: &mut [f64], columns: usize, entries: &[Entry], file: &[f64], weight: impl Fn(usize) -> f64) {
        for entry in entries {
            field[entry.row * columns + entry.column] += weight(entry.row) * file[entry.register.index()];
        }
    }
}

impl Integrator<'_> {
    /// Runs the segments of derivatives at the last evaluation.
    fn evaluate_slopes(&mut self) {
        let program = &self.equations.program;
        for part in [segment::JACOBIAN, segment::RESIDUAL_TANGENT, segment::CAPACITY_SLOPE, segment::CAPACITY_TANGENT] {
            program.run(part, &mut self.file);
        }
        self.stats.jacobians += 1;
    }

    /// Derivatives through the step just tried.
    pub(super) fn step_tangent(&mut self, step_s: f64) {
        let Some(mut tangent) = self.tangent.take() else { return };
        if let Some(mut ends) = tangent.ends.take() {
            self.coarse_step(&mut tangent, &mut ends, step_s);
            tangent.ends = Some(ends);
            self.matrix.factored_for_s = None;
            self.tangent = Some(tangent);
            return;
        }
        let implicit = GAMMA * step_s;
        let (size, columns) = (tangent.size, tangent.columns);
        for stage in 1..STAGES {
            self.set_instant(self.time_s + NODES[stage] * step_s);
            self.evaluate(stage);
            self.evaluate_slopes();
            self.linear.load(self.equations, &self.file);
            for row in 0..size {
                if self.stores(row) {
                    let rate = self.equations.capacity_slope[row]
                        .map_or(0.0, |r| self.file[r.index()] * self.stage_slopes[stage][row]);
                    self.linear.add_to_diagonal(row, -(self.capacity(row) / implicit + rate));
                }
            }
            self.linear.factor();
            self.stats.factorisations += 1;
            tangent.base.copy_from_slice(&tangent.values[0]);
            for earlier in 0..stage {
                let weight = step_s * COEFFICIENTS[stage][earlier];
                for (base, slope) in tangent.base.iter_mut().zip(&tangent.slopes[earlier]) {
                    *base += weight * slope;
                }
            }
            let stage_tangent = &mut tangent.values[stage];
            stage_tangent.fill(0.0);
            Tangent::add(stage_tangent, columns, &self.equations.residual_tangent, &self.file, |_| -1.0);
            let slopes = &self.stage_slopes[stage];
            Tangent::add(stage_tangent, columns, &self.equations.capacity_tangent, &self.file, |row| slopes[row]);
            for (row, rhs) in stage_tangent.chunks_exact_mut(columns.max(1)).enumerate() {
                let base = &tangent.base[row * columns..(row + 1) * columns];
                if let Some(register) = self.equations.capacity[row] {
                    let capacity = self.file[register.index()];
                    for (rhs, base) in rhs.iter_mut().zip(base) {
                        *rhs -= capacity * base / implicit;
                    }
                }
            }
            self.linear.solve_columns(stage_tangent, columns);
            self.stats.solves += columns as u64;
            let slopes = &mut tangent.slopes[stage];
            for (row, slopes) in slopes.chunks_exact_mut(columns.max(1)).enumerate() {
                let range = row * columns..(row + 1) * columns;
                if self.equations.capacity[row].is_some() {
                    for (slope, (value, base)) in
                        slopes.iter_mut().zip(stage_tangent[range.clone()].iter().zip(&tangent.base[range]))
                    {
                        *slope = (value - base) / implicit;
                    }
                } else {
                    slopes.fill(0.0);
                }
            }
        }
        self.matrix.factored_for_s = None;
        self.tangent = Some(tangent);
    }

    /// Takes the slopes that were evaluated last.
    fn take_slopes(&self, columns: usize, end: &mut Ends) {
        let equations = self.equations;
        end.heats.fill(0.0);
        Tangent::add(&mut end.heats, columns, &equations.residual_tangent, &self.file, |_| 1.0);
        for (value, entry) in end.jacobian.iter_mut().zip(&equations.jacobian) {
            *value = self.file[entry.register.index()];
        }
        for (value, entry) in end.capacity_tangent.iter_mut().zip(&equations.capacity_tangent) {
            *value = self.file[entry.register.index()];
        }
        for row in 0..equations.size() {
            end.capacity[row] = self.capacity(row);
            end.capacity_slope[row] = equations.capacity_slope[row].map_or(0.0, |register| self.file[register.index()]);
        }
    }

    /// Derivatives through the step just tried by the method of two stages of [`super::linearised`]: what acts at fixed temperatures is
    /// linear over the step. What a capacity takes goes by the mean slope of its temperature: after a jump the slope at the start lasts
    /// for much less than a step.
    fn coarse_step(&mut self, tangent: &mut Tangent, ends: &mut [Ends; 2], step_s: f64) {
        const LAST: usize = STAGES - 1;
        let (columns, implicit) = (tangent.columns, EARLY * step_s);
        self.set_instant(self.time_s + step_s);
        self.evaluate(LAST);
        self.evaluate_slopes();
        let mean_slopes: Vec<f64> = (self.stage_values[0].iter().zip(&self.stage_values[LAST]))
            .map(|(from, to)| (to - from) / step_s)
            .collect();
        let [from, to] = ends;
        self.take_slopes(columns, to);
        let mean = |from: &[f64], to: &[f64]| -> Vec<f64> { from.iter().zip(to).map(|(a, b)| 0.5 * (a + b)).collect() };
        let capacity = mean(&from.capacity, &to.capacity);
        let capacity_slope = mean(&from.capacity_slope, &to.capacity_slope);
        let capacity_tangent = mean(&from.capacity_tangent, &to.capacity_tangent);
        let mut stored = vec![0.0; tangent.size * columns];
        for (entry, value) in self.equations.capacity_tangent.iter().zip(&capacity_tangent) {
            stored[entry.row * columns + entry.column] += value * mean_slopes[entry.row];
        }
        self.linear.load_values(self.equations, &mean(&from.jacobian, &to.jacobian));
        for row in 0..tangent.size {
            if self.stores(row) {
                let rate = capacity_slope[row] * mean_slopes[row];
                self.linear.add_to_diagonal(row, -(capacity[row] / implicit + rate));
            }
        }
        self.linear.factor();
        self.stats.factorisations += 1;
        tangent.base.copy_from_slice(&tangent.values[0]);
        for share in [EARLY, 1.0] {
            let value = &mut tangent.values[LAST];
            for (row, value) in value.chunks_exact_mut(columns.max(1)).enumerate() {
                let range = row * columns..(row + 1) * columns;
                let heats = from.heats[range.clone()].iter().zip(&to.heats[range.clone()]);
                let storage = capacity[row] / implicit;
                let known = heats.zip(&stored[range.clone()]).zip(&tangent.base[range]);
                for (value, (((from, to), stored), base)) in value.iter_mut().zip(known) {
                    *value = stored - (from + share * (to - from)) - storage * base;
                }
            }
            self.linear.solve_columns(value, columns);
            self.stats.solves += columns as u64;
            if share < 1.0 {
                for (base, early) in tangent.base.iter_mut().zip(&*value) {
                    *base += OF_EARLY * (early - *base);
                }
            }
        }
        let slopes = &mut tangent.slopes[LAST];
        for (row, slopes) in slopes.chunks_exact_mut(columns.max(1)).enumerate() {
            let range = row * columns..(row + 1) * columns;
            let of_row = tangent.values[LAST][range.clone()].iter().zip(&tangent.base[range]);
            for (slope, (value, base)) in slopes.iter_mut().zip(of_row) {
                *slope = if self.stores(row) { (value - base) / implicit } else { 0.0 };
            }
        }
        ends.swap(0, 1);
    }

    /// Derivatives of arithmetic nodes and of the slopes at the present state.
    pub(super) fn restart_tangent(&mut self) {
        let Some(mut tangent) = self.tangent.take() else { return };
        let columns = tangent.columns;
        self.set_instant(self.time_s);
        self.evaluate(0);
        self.evaluate_slopes();
        if let Some(ends) = &mut tangent.ends {
            self.take_slopes(columns, &mut ends[0]);
        }
        self.close_tangent(&mut tangent.values[0], columns);
        let slopes = &mut tangent.slopes[0];
        slopes.fill(0.0);
        Tangent::add(slopes, columns, &self.equations.residual_tangent, &self.file, |_| 1.0);
        for entry in &self.equations.jacobian {
            let slope = self.file[entry.register.index()];
            let values = &tangent.values[0][entry.column * columns..(entry.column + 1) * columns];
            for (out, value) in slopes[entry.row * columns..(entry.row + 1) * columns].iter_mut().zip(values) {
                *out += slope * value;
            }
        }
        let first_slopes = &self.stage_slopes[0];
        Tangent::add(slopes, columns, &self.equations.capacity_tangent, &self.file, |row| -first_slopes[row]);
        for (row, slopes) in slopes.chunks_exact_mut(columns.max(1)).enumerate() {
            let capacity = self.capacity(row);
            if !(capacity > 0.0) {
                slopes.fill(0.0);
                continue;
            }
            let rate = self.equations.capacity_slope[row].map_or(0.0, |r| self.file[r.index()] * first_slopes[row]);
            for (slope, value) in slopes.iter_mut().zip(&tangent.values[0][row * columns..(row + 1) * columns]) {
                *slope = (*slope - rate * value) / capacity;
            }
        }
        self.tangent = Some(tangent);
    }

    /// Replaces the arithmetic rows of a field by what closes their differentiated balances; the file holds slopes
    /// and derivatives of the balances at the state.
    fn close_tangent(&mut self, field: &mut [f64], columns: usize) {
        let Some(mut linear) = self.algebraic.take() else { return };
        self.hold_diffusion(&mut linear);
        for (row, values) in field.chunks_exact_mut(columns.max(1)).enumerate() {
            if self.follows(row) {
                values.fill(0.0);
            } else {
                for value in values {
                    *value *= -HOLD_W_PER_K;
                }
            }
        }
        for entry in self.equations.residual_tangent.iter().filter(|e| self.follows(e.row)) {
            field[entry.row * columns + entry.column] -= self.file[entry.register.index()];
        }
        linear.solve_columns(field, columns);
        self.stats.factorisations += 1;
        self.stats.solves += columns as u64;
        self.algebraic = Some(linear);
    }

    /// How the instant of a switching moves, from the function that crosses zero; before the mode changes.
    pub(super) fn switch_shift(&mut self, mode: usize) {
        let Some(mut tangent) = self.tangent.take() else { return };
        self.equations.program.run(segment::SWITCH_TANGENT, &mut self.file);
        let on = self.file[self.equations.modes().start + mode] > 0.5;
        let row = 2 * mode + usize::from(on);
        let mut rate = 0.0;
        tangent.shift.fill(0.0);
        for entry in self.equations.switch_temperature.iter().filter(|entry| entry.row == row) {
            let slope = self.file[entry.register.index()];
            rate += slope * self.stage_slopes[0][entry.column];
            for column in 0..tangent.columns {
                tangent.shift[column] += slope * tangent.values[0][entry.column * tangent.columns + column];
            }
        }
        for entry in self.equations.switch_symbol.iter().filter(|entry| entry.row == row) {
            tangent.shift[entry.column] += self.file[entry.register.index()];
        }
        for shift in &mut tangent.shift {
            *shift = if rate == 0.0 { 0.0 } else { -*shift / rate };
        }
        self.tangent = Some(tangent);
    }

    /// The derivative's jump at a switching, from the slopes before it; after the restart.
    pub(super) fn jump_tangent(&mut self, before: &[f64]) {
        let Some(mut tangent) = self.tangent.take() else { return };
        for (row, values) in tangent.values[0].chunks_exact_mut(tangent.columns.max(1)).enumerate() {
            if self.stores(row) {
                for (value, shift) in values.iter_mut().zip(&tangent.shift) {
                    *value += (before[row] - self.stage_slopes[0][row]) * shift;
                }
            }
        }
        self.tangent = Some(tangent);
        self.restart_tangent();
    }

    /// Derivatives of the temperatures at a share of the step just tried, at the state in the file; `unknowns x
    /// columns`.
    fn tangent_at(&mut self, share: f64, step_s: f64) -> (Vec<f64>, usize) {
        let Some(tangent) = self.tangent.take() else { return (Vec::new(), 0) };
        let columns = tangent.columns;
        let mut field = vec![0.0; tangent.size * columns];
        tangent.interpolate(share, step_s, 0..tangent.size, &mut field);
        if self.algebraic.is_some() {
            self.equations.program.run(segment::RESIDUAL, &mut self.file);
            self.equations.program.run(segment::JACOBIAN, &mut self.file);
            self.equations.program.run(segment::RESIDUAL_TANGENT, &mut self.file);
            self.close_tangent(&mut field, columns);
        }
        self.tangent = Some(tangent);
        (field, columns)
    }

    /// Derivatives of the quantities at a share of the step just tried, `quantities x columns`; the file holds the
    /// state there and the quantities have been evaluated.
    pub(super) fn quantity_tangent_at(&mut self, share: f64, step_s: f64) -> Vec<f64> {
        if self.algebraic.is_some() {
            // All rows: the balances of arithmetic nodes join them.
            let (field, columns) = self.tangent_at(share, step_s);
            self.equations.program.run(segment::QUANTITY, &mut self.file);
            return self.quantity_slopes(&field, columns);
        }
        let Some(mut tangent) = self.tangent.take() else { return Vec::new() };
        let columns = tangent.columns;
        let mut field = std::mem::take(&mut tangent.seen);
        for &row in &tangent.seen_rows {
            tangent.interpolate(share, step_s, row..row + 1, &mut field);
        }
        let slopes = self.quantity_slopes(&field, columns);
        tangent.seen = field;
        self.tangent = Some(tangent);
        slopes
    }

    /// Derivatives of the quantities, as evaluated last, from those of the temperatures.
    fn quantity_slopes(&mut self, field: &[f64], columns: usize) -> Vec<f64> {
        self.equations.program.run(segment::QUANTITY_TANGENT, &mut self.file);
        let mut out = vec![0.0; self.network.quantities() * columns];
        for entry in &self.equations.quantity_temperature {
            let slope = self.file[entry.register.index()];
            for column in 0..columns {
                out[entry.row * columns + column] += slope * field[entry.column * columns + column];
            }
        }
        for entry in &self.equations.quantity_symbol {
            out[entry.row * columns + entry.column] += self.file[entry.register.index()];
        }
        out
    }

    /// Appends the derivatives at an output to the result.
    pub(super) fn output_tangent(&mut self, share: f64, step_s: f64, temperatures: bool, result: &mut Transient) {
        if self.tangent.is_none() {
            return;
        }
        if !temperatures {
            result.quantity_tangent.extend(self.quantity_tangent_at(share, step_s));
            return;
        }
        let (field, columns) = self.tangent_at(share, step_s);
        self.equations.program.run(segment::QUANTITY, &mut self.file);
        let quantities = self.quantity_slopes(&field, columns);
        result.quantity_tangent.extend(quantities);
        let nodes = self.network.nodes.len();
        let from = result.temperature_tangent.len();
        result.temperature_tangent.resize(from + nodes * columns, 0.0);
        let out = &mut result.temperature_tangent[from..];
        for (row, &node) in self.equations.unknowns.iter().enumerate() {
            out[node * columns..(node + 1) * columns].copy_from_slice(&field[row * columns..(row + 1) * columns]);
        }
        self.equations.program.run(segment::BOUNDARY_TANGENT, &mut self.file);
        for entry in &self.equations.boundary_tangent {
            let (node, _) = self.equations.boundaries[entry.row];
            out[node * columns + entry.column] = self.file[entry.register.index()];
        }
    }
}
