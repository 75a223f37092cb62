//! Arithmetic nodes, and at the start those that begin in balance: their balances closed at given temperatures of the
//! diffusion nodes.
//!
//! Newton's method on the arithmetic rows alone. A diffusion row keeps its place in the matrix with an overwhelming
//! diagonal, so that pattern and factors stay those of the whole network and the diffusion nodes do not move.

use crate::thermal::equations::segment;
use crate::thermal::newton::{CLOSURE_RELATIVE, CLOSURE_W, HOLD_W_PER_K};
use crate::thermal::steady::SteadyError;

use super::TransientError;
use super::integrator::Integrator;

/// Iterations.
const ITERATIONS: u32 = 60;
/// Longest change of a temperature in an iteration, K.
const LONGEST_STEP_K: f64 = 60.0;

impl Integrator<'_> {
    /// Closes the arithmetic balances of a stage's temperatures at the instant set.
    pub(super) fn make_consistent(&mut self, stage: usize) -> Result<(), TransientError> {
        let Some(mut linear) = self.algebraic.take() else { return Ok(()) };
        let mut last_step = f64::INFINITY;
        let mut outcome = None;
        for iteration in 0..=ITERATIONS {
            self.evaluate(stage);
            self.equations.program.run(segment::BALANCE_SCALE, &mut self.file);
            let (mut worst, mut imbalance_w) = (None, 0.0);
            for row in (0..self.equations.size()).filter(|&row| self.follows(row)) {
                let heat = self.file[self.equations.residual[row].index()];
                let size = self.file[self.equations.balance_scale[row].index()];
                if !(heat.abs() <= CLOSURE_W + CLOSURE_RELATIVE * size)
                    && (worst.is_none() || heat.abs() > f64::abs(imbalance_w))
                {
                    (worst, imbalance_w) = (Some(row), heat);
                }
            }
            if worst.is_none() && (last_step <= 1e-4 || iteration == 0) {
                outcome = Some(Ok(()));
                break;
            }
            self.equations.program.run(segment::JACOBIAN, &mut self.file);
            self.hold_diffusion(&mut linear);
            for row in 0..self.step.len() {
                self.step[row] = if self.follows(row) { -self.file[self.equations.residual[row].index()] } else { 0.0 };
            }
            linear.solve(&mut self.step);
            self.stats.factorisations += 1;
            self.stats.solves += 1;
            let largest = self.step.iter().fold(0.0, |m: f64, s| if s.abs() <= m { m } else { s.abs() });
            if !largest.is_finite() || iteration == ITERATIONS {
                let row = worst.unwrap_or(0);
                let node = self.network.nodes[self.equations.unknowns[row]].clone();
                outcome = Some(Err(if largest.is_finite() {
                    SteadyError::NotConverged { node, imbalance_w, iterations: iteration }
                } else {
                    SteadyError::Singular { node }
                }));
                break;
            }
            let shortened = (largest / LONGEST_STEP_K).max(1.0);
            for row in 0..self.step.len() {
                if self.follows(row) {
                    let value = &mut self.stage_values[stage][row];
                    *value = (*value + self.step[row] / shortened).max(0.25 * *value);
                }
            }
            last_step = largest;
        }
        self.algebraic = Some(linear);
        outcome.unwrap_or(Ok(())).map_err(TransientError::from)
    }

    /// Loads the slopes in the file with the diffusion rows held, and factors.
    pub(super) fn hold_diffusion(&self, linear: &mut crate::thermal::linear::Linear<f64>) {
        linear.load(self.equations, &self.file);
        for row in (0..self.equations.size()).filter(|&row| !self.follows(row)) {
            linear.add_to_diagonal(row, -HOLD_W_PER_K);
        }
        linear.factor();
    }
}
