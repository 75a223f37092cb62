//! The periodic state of a cycle of inputs: the start temperatures to which a cycle returns.
//!
//! Small networks by shooting: Newton's method on `P(T) - T = 0`, where the cycle's map `P` and its matrix of
//! derivatives come from one integration. Large networks by cycles accelerated after Anderson (1965, J. ACM 12, 547)
//! in the form of Walker & Ni (2011, SIAM J. Numer. Anal. 49, 1715).

use crate::thermal::network::Network;
use crate::thermal::steady::Start;

use super::integrator::Integrator;
use super::{InitialState, Transient, TransientError, TransientRequest};

/// Largest number of diffusion nodes for which the matrix of the cycle is computed.
const SHOOTING_UP_TO: usize = 60;
/// Cycles before the search gives up.
const CYCLES: u64 = 200;
/// Earlier cycles that the acceleration remembers.
const MEMORY: usize = 6;

impl Network {
    /// Finds the periodic state, then integrates from it.
    pub(super) fn solve_periodic(&self, request: &TransientRequest<'_>) -> Result<Transient, TransientError> {
        let times = &request.inputs.times_s;
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
            return Err(TransientError::Request { what: "a periodic start needs a table of inputs; rows", value: 0.0 });
        };
        if !(last > first) {
            return Err(TransientError::Request {
                what: "a cycle must last longer than 0 s; it lasts",
                value: last - first,
            });
        }
        let small = self.steady.capacity.iter().flatten().count() <= SHOOTING_UP_TO;
        let (state, derivatives) =
            if small { self.shoot(request, first, last)? } else { self.accelerate(request, first, last)? };
        let mut start = *request;
        start.initial = InitialState::Temperatures(&state);
        start.seeds = &[];
        start.balanced = &[];
        let mut integrator = Integrator::new(self, &start)?;
        if let (Some(tangent), Some(derivatives)) = (&mut integrator.tangent, &derivatives) {
            tangent.set_state(derivatives);
        }
        integrator.start(&start)?;
        self.integrate(integrator, &start)
    }

    /// A first guess: the steady state of the inputs at the start of the cycle.
    fn cycle_guess(&self, request: &TransientRequest<'_>, first_s: f64) -> Result<Vec<f64>, TransientError> {
        let mut workspace = self.workspace();
        self.set_parameters(&mut workspace, request.parameters);
        let mut inputs = self.nominal_inputs.clone();
        for (slot, &value) in inputs.iter_mut().zip(&request.inputs.base) {
            *slot = value;
        }
        for column in &request.inputs.columns {
            if let (Some(slot), false) = (inputs.get_mut(column.input), column.values.is_empty()) {
                *slot = column.values.iter().sum::<f64>() / column.values.len() as f64;
            }
        }
        self.set_inputs(&mut workspace, &inputs);
        self.set_time(&mut workspace, first_s);
        self.solve_steady(&mut workspace, Start::Default)?;
        Ok(workspace.temperatures().to_vec())
    }

    /// Newton's method on the cycle's map. Returns the state and, if asked, its derivatives (`unknowns x columns`).
    fn shoot(
        &self,
        request: &TransientRequest<'_>,
        first_s: f64,
        last_s: f64,
    ) -> Result<(Vec<f64>, Option<Vec<f64>>), TransientError> {
        let mut state = self.cycle_guess(request, first_s)?;
        let rows: Vec<usize> = (0..self.steady.size()).filter(|&row| self.steady.capacity[row].is_some()).collect();
        let seeds: Vec<Vec<f64>> = rows
            .iter()
            .map(|&row| {
                let mut seed = vec![0.0; self.nodes.len()];
                seed[self.steady.unknowns[row]] = 1.0;
                seed
            })
            .collect();
        let n = rows.len();
        let symbols = self.differentiate.len();
        let mut worst = (0, f64::INFINITY);
        for _ in 0..CYCLES {
            let cycle = TransientRequest {
                initial: InitialState::Temperatures(&state),
                seeds: &seeds,
                balanced: &[],
                outputs_s: &[last_s],
                start_s: Some(first_s),
                end_s: None,
                sensitivities: true,
                temperatures: true,
                ..*request
            };
            let result = {
                let mut integrator = Integrator::new(self, &cycle)?;
                integrator.start(&cycle)?;
                self.integrate(integrator, &cycle)?
            };
            let columns = symbols + n;
            let mut matrix = vec![0.0; n * n];
            let mut change = vec![0.0; n];
            let slope = |row: usize, column: usize| {
                result.temperature_tangent[self.steady.unknowns[rows[row]] * columns + column]
            };
            for row in 0..n {
                let node = self.steady.unknowns[rows[row]];
                change[row] = result.end[node] - state[node];
                for column in 0..n {
                    let one = if row == column { 1.0 } else { 0.0 };
                    matrix[row * n + column] = one - slope(row, symbols + column);
                }
            }
            let mut lu = crate::thermal::lanes_lu::LanesLu::<f64>::new(n);
            lu.matrix.copy_from_slice(&matrix);
            lu.factor();
            lu.solve(&mut change);
            worst = (0, 0.0);
            for row in 0..n {
                let node = self.steady.unknowns[rows[row]];
                if !(change[row].abs() <= worst.1) {
                    worst = (node, change[row].abs());
                }
                let moved = state[node] + change[row];
                state[node] = if moved > 0.25 * state[node] { moved } else { 0.25 * state[node] };
            }
            if !worst.1.is_finite() {
                break;
            }
            let options = request.options;
            let size_k = state.get(worst.0).copied().unwrap_or(0.0);
            if worst.1 <= options.absolute_tolerance_k + options.relative_tolerance * size_k {
                let mut derivatives = None;
                if request.sensitivities {
                    // (1 - dP/dT) dT/dp = dP/dp at fixed start; start temperatures themselves have no influence.
                    let size = self.steady.size();
                    let mut field = vec![0.0; size * symbols];
                    for column in 0..symbols {
                        if matches!(self.differentiate[column], crate::expression::Symbol::Node(_)) {
                            continue;
                        }
                        let mut rhs: Vec<f64> = (0..n).map(|row| slope(row, column)).collect();
                        lu.solve(&mut rhs);
                        for (row, value) in rhs.into_iter().enumerate() {
                            field[rows[row] * symbols + column] = value;
                        }
                    }
                    derivatives = Some(field);
                }
                return Ok((state, derivatives));
            }
        }
        Err(TransientError::NotPeriodic { orbits: CYCLES, node: self.nodes[worst.0].clone(), change_k: worst.1 })
    }

    /// One cycle from a state, with derivatives carried along where asked.
    fn cycle(
        &self,
        request: &TransientRequest<'_>,
        (first_s, last_s): (f64, f64),
        state: &[f64],
        derivatives: Option<&[f64]>,
    ) -> Result<Transient, TransientError> {
        let cycle = TransientRequest {
            initial: InitialState::Temperatures(state),
            seeds: &[],
            balanced: &[],
            outputs_s: &[last_s],
            start_s: Some(first_s),
            end_s: None,
            sensitivities: derivatives.is_some(),
            temperatures: true,
            ..*request
        };
        let mut integrator = Integrator::new(self, &cycle)?;
        if let (Some(tangent), Some(derivatives)) = (&mut integrator.tangent, derivatives) {
            tangent.set_state(derivatives);
        }
        integrator.start(&cycle)?;
        self.integrate(integrator, &cycle)
    }

    /// Accelerated cycles, on the state and then on its derivatives.
    fn accelerate(
        &self,
        request: &TransientRequest<'_>,
        first_s: f64,
        last_s: f64,
    ) -> Result<(Vec<f64>, Option<Vec<f64>>), TransientError> {
        let guess = self.cycle_guess(request, first_s)?;
        let options = request.options;
        let allowed = options.absolute_tolerance_k + options.relative_tolerance * 300.0;
        let stored: Vec<usize> = (0..self.steady.size())
            .filter(|&row| self.steady.capacity[row].is_some())
            .map(|row| self.steady.unknowns[row])
            .collect();
        let mut full = guess.clone();
        let x: Vec<f64> = stored.iter().map(|&node| guess[node]).collect();
        let state = anderson(x, 0.2 * allowed, |x| {
            for (&node, &value) in stored.iter().zip(x) {
                full[node] = value.max(1.0);
            }
            let result = self.cycle(request, (first_s, last_s), &full, None)?;
            Ok(stored.iter().map(|&node| result.end[node]).collect())
        })
        .map_err(|failure| self.not_periodic(failure, &stored))?;
        for (&node, &value) in stored.iter().zip(&state) {
            full[node] = value;
        }
        if !request.sensitivities {
            return Ok((full, None));
        }
        let (size, symbols) = (self.steady.size(), self.differentiate.len());
        let scale = 1e-6;
        let derivatives = anderson(vec![0.0; size * symbols], scale, |field| {
            let result = self.cycle(request, (first_s, last_s), &full, Some(field))?;
            let mut out = vec![0.0; size * symbols];
            for (row, &node) in self.steady.unknowns.iter().enumerate() {
                if self.steady.capacity[row].is_none() {
                    continue;
                }
                for column in 0..symbols {
                    if !matches!(self.differentiate[column], crate::expression::Symbol::Node(_)) {
                        out[row * symbols + column] = result.temperature_tangent[node * symbols + column];
                    }
                }
            }
            Ok(out)
        })
        .map_err(|failure| self.not_periodic(failure, &stored))?;
        Ok((full, Some(derivatives)))
    }

    fn not_periodic(&self, failure: Failure, stored: &[usize]) -> TransientError {
        match failure {
            Failure::Solve(error) => error,
            Failure::Open { row, change } => {
                let node = stored.get(row % stored.len().max(1)).map_or_else(String::new, |&n| self.nodes[n].clone());
                TransientError::NotPeriodic { orbits: CYCLES, node, change_k: change }
            }
        }
    }
}

/// Why a fixed point was not found.
enum Failure {
    Solve(TransientError),
    Open { row: usize, change: f64 },
}

/// Fixed point of a map by Anderson's acceleration, to a change below `allowed` (relative to 1 + the largest entry
/// over 300, so that a temperature's share is about itself).
fn anderson(
    mut x: Vec<f64>,
    allowed: f64,
    mut map: impl FnMut(&[f64]) -> Result<Vec<f64>, TransientError>,
) -> Result<Vec<f64>, Failure> {
    let mut history: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let mut last: Option<(Vec<f64>, Vec<f64>)> = None;
    let mut worst = (0, f64::INFINITY);
    for _ in 0..CYCLES {
        let image = map(&x).map_err(Failure::Solve)?;
        let residual: Vec<f64> = image.iter().zip(&x).map(|(a, b)| a - b).collect();
        worst = (0, 0.0);
        for (row, r) in residual.iter().enumerate() {
            if !(r.abs() <= worst.1) {
                worst = (row, r.abs());
            }
        }
        let size = image.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if worst.1 <= allowed * (1.0 + size / 300.0) {
            return Ok(image);
        }
        if let Some((image_before, residual_before)) = last.take() {
            let dg: Vec<f64> = image.iter().zip(&image_before).map(|(a, b)| a - b).collect();
            let df: Vec<f64> = residual.iter().zip(&residual_before).map(|(a, b)| a - b).collect();
            history.push((dg, df));
            if history.len() > MEMORY {
                history.remove(0);
            }
        }
        // Least squares for the residual from its remembered differences, by normal equations with a slight ridge.
        let m = history.len();
        let mut next = image.clone();
        if m > 0 {
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let mut lu = crate::thermal::lanes_lu::LanesLu::<f64>::new(m);
            let mut weights = vec![0.0; m];
            for i in 0..m {
                for j in 0..m {
                    lu.matrix[i * m + j] = dot(&history[i].1, &history[j].1);
                }
                lu.matrix[i * m + i] *= 1.0 + 1e-12;
                weights[i] = dot(&history[i].1, &residual);
            }
            lu.factor();
            lu.solve(&mut weights);
            if weights.iter().all(|w| w.is_finite() && w.abs() < 1e3) {
                for (weight, (dg, _)) in weights.iter().zip(&history) {
                    for (value, d) in next.iter_mut().zip(dg) {
                        *value -= weight * d;
                    }
                }
            } else {
                history.clear();
            }
        }
        last = Some((image, residual));
        x = next;
    }
    Err(Failure::Open { row: worst.0, change: worst.1 })
}
