//! Derivatives of effects along long transients, which order effects and need to be known to some per cent.
//!
//! `C dx/dt = (J - C' dT/dt) x + f`, with `x` the derivatives of the temperatures in an amplitude `a` and
//! `f = dr/da - dC/da dT/dt`, along the course of the model without effects (`course`): what takes part of an effect is a few
//! expressions (`bench`), however many effects there are. Over each step of the course, and each row, by the diagonally
//! implicit scheme of two stages that is L-stable, stiffly accurate and of order 2 (Alexander 1977, SIAM J. Numer. Anal. 14,
//! 1006), with the slopes at the step's end and `f` straight between its ends.

use std::collections::HashMap;

use rayon::prelude::*;

use super::Base;
use super::bench::{Bench, Slopes};
use super::course::{Course, Instant, Layout, Start, State, courses};
use super::extended::Solved;
use super::variant::Variant;
use crate::diagnosis::FitError;
use crate::math::listed_lu::ListedLu;
use crate::math::sparse::Pattern;
use crate::measurement::lag;
use crate::watch;

/// Variants that are solved together: their derivatives in 30 nodes are 30 KiB.
const TOGETHER: usize = 128;
/// Diagonal coefficient of the scheme, `1 - 1 / sqrt(2)`.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Added to the diagonal of rows that do not move at the start, W/K.
const HOLD_W_PER_K: f64 = 1e12;

/// The transients of a problem at its fit, with room for the matrices along them.
pub(super) struct Steps {
    layout: Layout,
    courses: Vec<Course>,
    parameters: Vec<f64>,
    pattern: Pattern,
    /// Position among the residuals of a reading: measurement, row, sensor.
    positions: HashMap<(usize, usize, usize), usize>,
}

/// A term of `f`: where it acts, and which output it is.
struct Term {
    row: usize,
    column: usize,
    output: usize,
    /// Node whose capacity it changes, so that it is to be multiplied by minus the rate of its temperature.
    of_capacity: Option<usize>,
}

/// A block of columns under way along a course.
struct Block<'a> {
    layout: &'a Layout,
    columns: usize,
    terms: Vec<Term>,
    lu: ListedLu<f64>,
    /// Derivatives of the temperatures, `rows x columns`.
    state: Vec<f64>,
    /// Room for those of a stage.
    stage: Vec<f64>,
}

impl Steps {
    /// `None` where derivatives are not linear along some course.
    pub fn new(base: &Base<'_>) -> Result<Option<Self>, FitError> {
        let Some((layout, courses, parameters)) = courses(base)? else { return Ok(None) };
        let Ok(pattern) = Pattern::new(layout.nodes.len(), &layout.entries) else { return Ok(None) };
        let data = base.likelihood.data().iter().enumerate();
        let positions =
            data.map(|(position, datum)| ((datum.measurement, datum.row, datum.sensor), position)).collect();
        Ok(Some(Self { layout, courses, parameters, pattern, positions }))
    }

    /// What is found of variants; of one that adds a switch, nothing.
    pub fn solve(&self, base: &Base<'_>, variants: &[Variant<'_>]) -> Vec<Option<Solved>> {
        variants.par_chunks(TOGETHER).flat_map_iter(|block| self.block(base, block)).collect()
    }

    fn block(&self, base: &Base<'_>, variants: &[Variant<'_>]) -> Vec<Option<Solved>> {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Result<Vec<Slopes>, FitError>> =
            variants.iter().map(|variant| bench.slopes(base, variant)).collect();
        let all: Vec<&Slopes> = slopes.iter().flatten().flatten().collect();
        let mut compiled = bench.compile(&self.parameters);
        let mut found = vec![vec![0.0; base.residuals.len()]; all.len()];
        for course in &self.courses {
            let mut at = |time_s: f64, state: &State| compiled.at(&state.inputs, time_s, &state.temperatures);
            self.along(course, &all, &mut at, &mut found);
        }
        let mut found = found.into_iter();
        let of_variant = |(variant, slopes): (&Variant<'_>, Result<Vec<Slopes>, FitError>)| {
            let slopes = match slopes {
                Ok(slopes) => slopes,
                Err(why) => return Some(Err(why)),
            };
            let columns: Vec<Vec<f64>> = found.by_ref().take(slopes.len()).collect();
            let is_linear = !slopes.iter().any(|slopes| slopes.switches);
            is_linear.then(|| variant.direction(base, columns.into_iter()))
        };
        variants.iter().zip(slopes).map(of_variant).collect()
    }

    /// Writes the derivatives of a transient's readings, column by column.
    fn along(
        &self,
        course: &Course,
        all: &[&Slopes],
        at: &mut dyn FnMut(f64, &State) -> Vec<f64>,
        found: &mut [Vec<f64>],
    ) {
        let Some(first) = course.instants.first() else { return };
        let mut block = Block::new(&self.layout, &self.pattern, all);
        let mut to = at(first.time_s, &first.before);
        block.start(&course.start, first, &to);
        let mut rows = course.rows.iter().copied().enumerate().peekable();
        let mut record = |block: &Block<'_>, place: usize, values: &[f64]| {
            while let Some((row, _)) = rows.next_if(|(_, own)| *own == place) {
                for (sensor, (name, quantity)) in course.sensors.iter().enumerate() {
                    let Some(&position) = self.positions.get(&(course.measurement, row, sensor)) else { continue };
                    let seen = &course.instants[place].seen[sensor];
                    for (column, (found, slopes)) in found.iter_mut().zip(all).enumerate() {
                        found[position] = block.reading(seen, column) + slopes.direct(name, *quantity, values);
                    }
                }
            }
        };
        record(&block, 0, &to);
        for (place, pair) in course.instants.windows(2).enumerate() {
            watch::check();
            let from = match &pair[0].after {
                Some(after) => at(pair[0].time_s, after),
                None => to,
            };
            to = at(pair[1].time_s, &pair[1].before);
            block.step(&pair[0], &pair[1], &from, &to);
            record(&block, place + 1, &to);
        }
        for (sensor, &lag_s) in course.lags_s.iter().enumerate().filter(|(_, lag_s)| **lag_s > 0.0) {
            let positions: Option<Vec<usize>> = (0..course.rows.len())
                .map(|row| self.positions.get(&(course.measurement, row, sensor)).copied())
                .collect();
            for (column, positions) in found.iter_mut().zip(positions.iter().cycle()) {
                let mut values: Vec<f64> = positions.iter().map(|&position| column[position]).collect();
                lag::apply(&course.times_s, &mut values, lag_s, None);
                positions.iter().zip(values).for_each(|(&position, value)| column[position] = value);
            }
        }
    }
}

impl<'a> Block<'a> {
    fn new(layout: &'a Layout, pattern: &Pattern, all: &[&Slopes]) -> Self {
        let mut terms = Vec::new();
        for (column, slopes) in all.iter().enumerate() {
            let heats = slopes.heats.iter().map(|&(node, output)| (node, output, None));
            let capacities = slopes.capacities.iter().map(|&(node, output)| (node, output, Some(node)));
            for (node, output, of_capacity) in heats.chain(capacities) {
                if let Some(row) = layout.rows.get(node).copied().flatten() {
                    terms.push(Term { row, column, output, of_capacity });
                }
            }
        }
        let (columns, size) = (all.len(), layout.nodes.len() * all.len());
        let lu = ListedLu::new(pattern.clone());
        Self { layout, columns, terms, lu, state: vec![0.0; size], stage: vec![0.0; size] }
    }

    /// Balances the rows that start in balance; the others are at 0.
    fn start(&mut self, start: &Start, first: &Instant, values: &[f64]) {
        let follows = |row: usize| match start {
            Start::Given { balanced } => balanced[row] || !self.layout.stores[row],
            Start::Steady => true,
        };
        let held: Vec<bool> = (0..self.layout.nodes.len()).map(|row| !follows(row)).collect();
        if held.iter().all(|held| *held) {
            return;
        }
        self.lu.load(first.slopes.iter().copied());
        for row in (0..held.len()).filter(|&row| held[row]) {
            self.lu.add_to_diagonal(row, -HOLD_W_PER_K);
        }
        self.lu.factor();
        // Nothing moves yet, so that capacities take no heat.
        for term in self.terms.iter().filter(|term| !held[term.row] && term.of_capacity.is_none()) {
            self.state[term.row * self.columns + term.column] -= values[term.output];
        }
        self.lu.solve_columns(&mut self.state, self.columns);
    }

    /// Goes over a step, given the outputs at its ends.
    fn step(&mut self, start: &Instant, end: &Instant, from: &[f64], to: &[f64]) {
        let step_s = end.time_s - start.time_s;
        let departure = start.after.as_ref().unwrap_or(&start.before);
        let rate = |node: usize| (end.before.temperatures[node] - departure.temperatures[node]) / step_s;
        self.lu.load(end.slopes.iter().copied());
        // C / (gamma h) by row.
        let storage: Vec<f64> = end.capacity.iter().map(|capacity| capacity / (GAMMA * step_s)).collect();
        for (row, &node) in self.layout.nodes.iter().enumerate() {
            self.lu.add_to_diagonal(row, -(storage[row] + end.capacity_slope[row] * rate(node)));
        }
        self.lu.factor();
        let columns = self.columns.max(1);
        for ((stage, state), storage) in
            self.stage.chunks_exact_mut(columns).zip(self.state.chunks_exact(columns)).zip(&storage)
        {
            stage.iter_mut().zip(state).for_each(|(stage, state)| *stage = -storage * state);
        }
        self.subtract_terms(&rate, |output| from[output] + GAMMA * (to[output] - from[output]));
        self.lu.solve_columns(&mut self.stage, self.columns);
        // The second stage begins from x + (1 - gamma) h k, with k = (Y - x) / (gamma h).
        let share = (1.0 - GAMMA) / GAMMA;
        for ((stage, state), storage) in
            self.stage.chunks_exact_mut(columns).zip(self.state.chunks_exact(columns)).zip(&storage)
        {
            stage
                .iter_mut()
                .zip(state)
                .for_each(|(stage, state)| *stage = -storage * (state + share * (*stage - state)));
        }
        self.subtract_terms(&rate, |output| to[output]);
        self.lu.solve_columns(&mut self.stage, self.columns);
        std::mem::swap(&mut self.stage, &mut self.state);
    }

    /// Subtracts `f` from the right-hand sides.
    fn subtract_terms(&mut self, rate: &impl Fn(usize) -> f64, value: impl Fn(usize) -> f64) {
        for term in &self.terms {
            let weight = term.of_capacity.map_or(1.0, |node| -rate(node));
            self.stage[term.row * self.columns + term.column] -= weight * value(term.output);
        }
    }

    /// What a sensor sees of a column's temperatures.
    fn reading(&self, seen: &[(usize, f64)], column: usize) -> f64 {
        seen.iter().map(|&(row, slope)| slope * self.state[row * self.columns + column]).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::blank::blank;
    use super::super::form::{Form, Forms};
    use super::super::variant::variants;
    use super::super::{Found, extended};
    use super::*;
    use crate::document::Diagnostics;
    use crate::effect::Catalogue;
    use crate::inference::target::Target;
    use crate::math::lanes::dot;
    use crate::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

    /// All smooth effects on the nodes of a network that steps through loads, against sensitivities. A score knows of a
    /// direction the angle alone: it is off by the angle's squared sine. What differs are effects that change within a step:
    /// thresholds, dates, and pulses that the model does not feel.
    #[test]
    fn scores_by_steps_are_those_by_sensitivities_within_three_per_cent() {
        let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
        let recipe = Recipe::of(Topology::Star, TestKind::Steps, InjectionRequest::default());
        let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
        problem.measurements.iter_mut().for_each(|measurement| *measurement = blank(measurement));
        let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
        let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
        let base = Base::new(&problem, &likelihood, &unknowns).unwrap();
        let forms = Forms::new(&problem);
        let on_nodes = |&position: &usize| {
            use crate::effect::Site::{Elements, Nodes, Pair};
            matches!(problem.candidates[position].site, Nodes(_) | Pair(_) | Elements(_))
        };
        let all: Vec<(usize, Form<'_>)> = (0..problem.candidates.len())
            .filter(on_nodes)
            .map(|position| (position, forms.of(&problem, position)))
            .filter(|(_, form)| matches!(form, Form::Smooth { .. }))
            .collect();
        let asked: Vec<(usize, &Form<'_>)> = all.iter().map(|(position, form)| (*position, form)).collect();
        let variants = variants(&base, &asked);
        let steps = Steps::new(&base).unwrap().expect("a course without switches");
        let by_steps = steps.solve(&base, &variants);
        let mut exact: Vec<Found> = asked.iter().map(|_| Ok(Vec::new())).collect();
        extended::solve(&base, &variants, &mut exact);
        let mut of_asked = vec![0; asked.len()];
        let (mut compared, mut far, mut worst) = (0, 0, 0.0_f64);
        for (variant, found) in variants.iter().zip(by_steps) {
            let Some(Ok(Some(found))) = found else { continue };
            let exact = exact[variant.asked].as_ref().unwrap();
            let place = of_asked[variant.asked];
            of_asked[variant.asked] += 1;
            let Some(exact) = exact.get(place).filter(|exact| exact.shape == found.shape) else { continue };
            for amplitude in 0..found.amplitudes() {
                let (a, b) = (found.column(amplitude), exact.column(amplitude));
                let (square_a, square_b, product) = (dot(a, a), dot(b, b), dot(a, b));
                compared += 1;
                far += usize::from(square_a - 2.0 * product + square_b > 0.02 * 0.02 * square_b);
                worst = worst.max(1.0 - product * product / (square_a * square_b));
            }
        }
        assert!(compared > 50, "{compared} of {}", variants.len());
        assert!(worst < 0.03 && 10 * far < compared, "{worst}, {far} of {compared}");
    }
}
