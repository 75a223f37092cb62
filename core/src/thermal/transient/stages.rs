//! The stages of a step: `C(Y) (Y - B) / (g h) = r(Y)` at diffusion nodes, `r(Y) = 0` at arithmetic ones.
//!
//! `B = T_n + h sum a_ij k_j` and `k_i = (Y_i - B) / (g h)`; the capacity multiplies the slope at the stage itself, so
//! heat is conserved where it depends on temperature. Simplified Newton: one matrix `J - C / (g h) - C' k` a step.

use crate::math::lanes::add_multiple;

use super::integrator::Integrator;
use super::tableau::{COEFFICIENTS, GAMMA, NODES};

/// Iterations of a stage.
const ITERATIONS: u32 = 8;
/// A step may differ by this share from the one for which the factors were made, where these are costly.
const STEP_MAY_DIFFER: f64 = 0.2;

impl Integrator<'_> {
    /// Makes the factors for a step, unless those at hand will do.
    pub(super) fn prepare_matrix(&mut self, step_s: f64) {
        if let Some(factored) = self.matrix.factored_for_s
            && (factored == step_s || (!self.linear.is_cheap() && (step_s / factored - 1.0).abs() <= STEP_MAY_DIFFER))
        {
            return;
        }
        self.linear.load_values(self.equations, &self.matrix.jacobian);
        let scale = 1.0 / (GAMMA * step_s);
        for row in 0..self.equations.size() {
            if self.stores(row) {
                let value = self.matrix.capacity[row] * scale + self.matrix.capacity_rate[row];
                self.linear.add_to_diagonal(row, -value);
            }
        }
        self.linear.factor();
        self.stats.factorisations += 1;
        self.matrix.factored_for_s = Some(step_s);
        // What was seen with the last matrix is trusted less with the next one (Hairer & Wanner 1996, IV.8).
        // Its power of 3/4, which roots give.
        let root = self.contraction.sqrt();
        self.contraction = root * root.sqrt();
    }

    /// The part of a stage that follows from the earlier ones.
    pub(super) fn stage_base(&mut self, stage: usize, step_s: f64) {
        self.base.copy_from_slice(&self.stage_values[0]);
        for earlier in 0..stage {
            let weight = step_s * COEFFICIENTS[stage][earlier];
            if weight != 0.0 {
                add_multiple(&mut self.base, weight, &self.stage_slopes[earlier]);
            }
        }
    }

    /// A first guess of a stage from the earlier ones.
    fn predict(&mut self, stage: usize, step_s: f64) {
        let (earlier_values, later_values) = self.stage_values.split_at_mut(stage);
        let earlier_slopes = &self.stage_slopes[..stage];
        let weights = &self.predictors[stage];
        let stage_values = &mut later_values[0];
        stage_values.copy_from_slice(&self.base);
        for (weight, slopes) in weights.iter().zip(earlier_slopes).filter(|(weight, _)| **weight != 0.0) {
            add_multiple(stage_values, GAMMA * step_s * weight, slopes);
        }
        if stage == 1
            && let Some(before) = self.previous_step_s
        {
            // The slope goes on as it went over the last step.
            let further = GAMMA * step_s * NODES[1] * step_s / before;
            add_multiple(stage_values, further, &earlier_slopes[0]);
            add_multiple(stage_values, -further, &self.previous_slope);
        }
        for &row in &self.arithmetic {
            stage_values[row] =
                weights.iter().zip(earlier_values.iter()).map(|(weight, values)| weight * values[row]).sum();
        }
        for (value, start) in stage_values.iter_mut().zip(&earlier_values[0]) {
            if !(*value > 0.0) {
                *value = *start;
            }
        }
    }

    /// Solves a stage; `false` if the iteration does not converge to positive temperatures.
    pub(super) fn solve_stage(&mut self, stage: usize, step_s: f64) -> bool {
        let rate = (GAMMA * step_s).recip();
        self.stage_base(stage, step_s);
        self.predict(stage, step_s);
        let time_s = self.time_s + NODES[stage] * step_s;
        self.set_instant(time_s);
        let mut last_size = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            self.evaluate(stage);
            let values = self.stage_values[stage].iter().zip(&self.base);
            let registers = self.equations.residual.iter().zip(&self.equations.capacity);
            for ((step, (value, base)), (heat, capacity)) in self.step.iter_mut().zip(values).zip(registers) {
                let stored = capacity.map_or(0.0, |capacity| self.file[capacity.index()] * (value - base) * rate);
                *step = stored - self.file[heat.index()];
            }
            self.linear.solve(&mut self.step);
            self.stats.solves += 1;
            let mut size: f64 = 0.0;
            for ((value, step), allowed) in self.stage_values[stage].iter_mut().zip(&self.step).zip(&self.allowed) {
                *value += step;
                let share = step.abs() * allowed;
                // Written so that a NaN stays.
                if !(share <= size) {
                    size = share;
                }
                if !(*value > 0.0) {
                    size = f64::NAN;
                }
            }
            if !size.is_finite() {
                return false;
            }
            if iteration > 0 {
                let contraction = size / last_size;
                if contraction > 0.9 && size > self.options.newton_share {
                    return false;
                }
                self.contraction = contraction.max(0.3 * self.contraction);
            }
            last_size = size;
            if size * self.contraction.min(1.0) <= self.options.newton_share {
                for row in 0..self.step.len() {
                    self.stage_slopes[stage][row] =
                        if self.stores(row) { (self.stage_values[stage][row] - self.base[row]) * rate } else { 0.0 };
                }
                return true;
            }
        }
        false
    }
}
