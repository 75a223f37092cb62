//! Exact derivatives of several steady states side by side, as [`super::tangent`] has them of one, with the same bits.

use crate::math::lanes::Lanes;

use super::batch::Batch;
use super::equations::segment;
use super::network::Network;

impl Network {
    /// Derivatives of all quantities at the solutions of the batch's last solve with respect to the differentiated
    /// symbols: `out` is `quantities x symbols`, row by row, SI. Lanes without a solution get numbers without meaning.
    pub fn quantity_tangent_batch<const N: usize>(&self, batch: &mut Batch<N>, out: &mut [[f64; N]]) {
        if let Some(external) = &self.external {
            self.lane_external_tangent(external, batch, out);
            return;
        }
        let equations = &self.steady;
        let columns = self.differentiate.len();
        if batch.one_by_one {
            let mut lane_tangent = vec![0.0; out.len()];
            for lane in 0..batch.used() {
                let solved = self.quantity_tangent(&mut batch.own[lane], &mut lane_tangent).is_ok();
                for (out, &value) in out.iter_mut().zip(&lane_tangent) {
                    out[lane] = if solved { value } else { f64::NAN };
                }
            }
            return;
        }
        self.factor_batch(batch);
        let Some(linear) = &mut batch.linear else { return };
        let (file, step) = (&batch.state.file, &mut batch.state.step);
        out.fill([0.0; N]);
        for entry in &equations.quantity_symbol {
            out[entry.row * columns + entry.column] = file[entry.register.index()];
        }
        if equations.size() == 0 {
            return;
        }
        if self.quantities.len() < columns {
            for row in 0..self.quantities.len() {
                step.fill([0.0; N]);
                for entry in equations.quantity_temperature.iter().filter(|entry| entry.row == row) {
                    step[entry.column] = step[entry.column].zip(file[entry.register.index()], |a, b| a + b);
                }
                linear.solve_transposed(step);
                for entry in &equations.residual_tangent {
                    out[row * columns + entry.column].subtract_product(&step[entry.row], &file[entry.register.index()]);
                }
            }
            return;
        }
        for column in 0..columns {
            step.fill([0.0; N]);
            for entry in equations.residual_tangent.iter().filter(|entry| entry.column == column) {
                step[entry.row] = step[entry.row].zip(file[entry.register.index()], |a, b| a - b);
            }
            linear.solve(step);
            for entry in &equations.quantity_temperature {
                out[entry.row * columns + column].add_product(&file[entry.register.index()], &step[entry.column]);
            }
        }
    }

    /// Derivatives of `sum of weights times quantities`, lane by lane, at the solutions of the batch's last solve:
    /// `weights` has a number a quantity, `out` one a symbol. Lanes without a solution get numbers without meaning.
    pub fn quantity_gradient_batch<const N: usize>(
        &self,
        batch: &mut Batch<N>,
        weights: &[[f64; N]],
        out: &mut [[f64; N]],
    ) {
        if let Some(external) = &self.external {
            self.lane_external_gradient(external, batch, weights, out);
            return;
        }
        let equations = &self.steady;
        if batch.one_by_one {
            let (mut lane_gradient, mut lane_weights) = (vec![0.0; out.len()], vec![0.0; weights.len()]);
            for lane in 0..batch.used() {
                for (lane_weight, weight) in lane_weights.iter_mut().zip(weights) {
                    *lane_weight = weight[lane];
                }
                let solved = self.quantity_gradient(&mut batch.own[lane], &lane_weights, &mut lane_gradient).is_ok();
                for (out, &value) in out.iter_mut().zip(&lane_gradient) {
                    out[lane] = if solved { value } else { f64::NAN };
                }
            }
            return;
        }
        self.factor_batch(batch);
        let Some(linear) = &mut batch.linear else { return };
        let (file, step) = (&batch.state.file, &mut batch.state.step);
        out.fill([0.0; N]);
        for entry in &equations.quantity_symbol {
            out[entry.column].add_product(&weights[entry.row], &file[entry.register.index()]);
        }
        if equations.size() == 0 {
            return;
        }
        step.fill([0.0; N]);
        for entry in &equations.quantity_temperature {
            step[entry.column].add_product(&weights[entry.row], &file[entry.register.index()]);
        }
        linear.solve_transposed(step);
        for entry in &equations.residual_tangent {
            out[entry.column].subtract_product(&step[entry.row], &file[entry.register.index()]);
        }
    }

    /// Slopes and factors at the solutions. A solve ends with balances and quantities evaluated there.
    fn factor_batch<const N: usize>(&self, batch: &mut Batch<N>) {
        let file = &mut batch.state.file;
        for part in [segment::JACOBIAN, segment::RESIDUAL_TANGENT, segment::QUANTITY_TANGENT] {
            self.steady.program.run(part, file);
        }
        if let Some(linear) = &mut batch.linear {
            linear.load(&self.steady, file);
            linear.factor();
        }
    }
}
