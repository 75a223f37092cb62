//! Exact derivatives of a steady state by the implicit function theorem.
//!
//! From `r(T(p), p) = 0`: `J dT/dp = -dr/dp`, with `J` factored once at the solution. A quantity `q(T, p)` has
//! `dq/dp = dq/dp|T + (dq/dT) dT/dp`; when there are fewer quantities than symbols the adjoint form is used,
//! `J' l = dq/dT`, `dq/dp = dq/dp|T - l' dr/dp`.

use crate::expression::Symbol;

use super::equations::segment;
use super::network::{Network, Workspace};
use super::newton;

/// Asked for derivatives without a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("derivatives need a solved steady state: solve first, after the last change of parameters or inputs")]
pub struct UnsolvedError;

impl Network {
    /// Evaluates slopes and factors at the solution.
    fn factor_at_solution(&self, workspace: &mut Workspace) -> Result<(), UnsolvedError> {
        if !workspace.solved {
            return Err(UnsolvedError);
        }
        if !workspace.factored {
            let file = &mut workspace.state.file;
            for part in [
                segment::RESIDUAL,
                segment::JACOBIAN,
                segment::RESIDUAL_TANGENT,
                segment::QUANTITY,
                segment::QUANTITY_TANGENT,
                segment::BOUNDARY_TANGENT,
            ] {
                self.steady.program.run(part, file);
            }
            workspace.linear.load(&self.steady, file);
            newton::hold(&mut workspace.linear, &workspace.held);
            workspace.linear.factor();
            workspace.factored = true;
        }
        Ok(())
    }

    /// `dT/dp` of the unknowns for one symbol, in the workspace's step.
    fn temperature_column(&self, workspace: &mut Workspace, symbol: usize) {
        let step = &mut workspace.state.step;
        step.fill(0.0);
        for entry in self.steady.residual_tangent.iter().filter(|entry| entry.column == symbol) {
            step[entry.row] -= workspace.state.file[entry.register.index()];
        }
        workspace.linear.solve(step);
    }

    /// Derivatives of all temperatures at the solution with respect to the differentiated symbols: `out` is
    /// `nodes x symbols`, row by row, K per SI unit. Start temperatures have no influence: their columns are 0.
    ///
    /// # Errors
    /// [`UnsolvedError`] without a solution for the present parameters and inputs.
    pub fn temperature_tangent(&self, workspace: &mut Workspace, out: &mut [f64]) -> Result<(), UnsolvedError> {
        self.factor_at_solution(workspace)?;
        let columns = self.differentiate.len();
        out.fill(0.0);
        for column in 0..columns {
            if matches!(self.differentiate[column], Symbol::Node(_)) {
                continue;
            }
            self.temperature_column(workspace, column);
            for (value, &node) in workspace.state.step.iter().zip(&self.steady.unknowns) {
                out[node * columns + column] = *value;
            }
        }
        for entry in &self.steady.boundary_tangent {
            let (node, _) = self.steady.boundaries[entry.row];
            out[node * columns + entry.column] = workspace.state.file[entry.register.index()];
        }
        Ok(())
    }

    /// Derivatives of all quantities at the solution with respect to the differentiated symbols: `out` is
    /// `quantities x symbols`, row by row, SI.
    ///
    /// # Errors
    /// [`UnsolvedError`] without a solution for the present parameters and inputs.
    pub fn quantity_tangent(&self, workspace: &mut Workspace, out: &mut [f64]) -> Result<(), UnsolvedError> {
        if let Some(external) = &self.external {
            return self.external_tangent(external, workspace, out);
        }
        self.factor_at_solution(workspace)?;
        let columns = self.differentiate.len();
        out.fill(0.0);
        for entry in &self.steady.quantity_symbol {
            out[entry.row * columns + entry.column] = workspace.state.file[entry.register.index()];
        }
        if self.steady.size() == 0 {
            return Ok(());
        }
        if self.quantities.len() < columns {
            self.quantity_rows(workspace, out);
            return Ok(());
        }
        for column in 0..columns {
            self.temperature_column(workspace, column);
            for entry in &self.steady.quantity_temperature {
                let slope = workspace.state.file[entry.register.index()];
                out[entry.row * columns + column] += slope * workspace.state.step[entry.column];
            }
        }
        Ok(())
    }

    /// Derivatives of `sum of weights times quantities` at the solution with respect to the differentiated symbols, SI:
    /// one solve by the adjoint, `J' l = sum w dq/dT`. `weights` has a number a quantity, `out` one a symbol.
    ///
    /// # Errors
    /// [`UnsolvedError`] without a solution for the present parameters and inputs.
    pub fn quantity_gradient(
        &self,
        workspace: &mut Workspace,
        weights: &[f64],
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        if let Some(external) = &self.external {
            return self.external_gradient(external, workspace, weights, out);
        }
        self.factor_at_solution(workspace)?;
        out.fill(0.0);
        let (file, step) = (&workspace.state.file, &mut workspace.state.step);
        for entry in &self.steady.quantity_symbol {
            out[entry.column] += weights[entry.row] * file[entry.register.index()];
        }
        if self.steady.size() == 0 {
            return Ok(());
        }
        step.fill(0.0);
        for entry in &self.steady.quantity_temperature {
            step[entry.column] += weights[entry.row] * file[entry.register.index()];
        }
        workspace.linear.solve_transposed(step);
        for entry in &self.steady.residual_tangent {
            out[entry.column] -= step[entry.row] * file[entry.register.index()];
        }
        Ok(())
    }

    /// Adds the part through the temperatures by the adjoint, a solve a quantity.
    fn quantity_rows(&self, workspace: &mut Workspace, out: &mut [f64]) {
        let columns = self.differentiate.len();
        for row in 0..self.quantities.len() {
            let step = &mut workspace.state.step;
            step.fill(0.0);
            for entry in self.steady.quantity_temperature.iter().filter(|entry| entry.row == row) {
                step[entry.column] += workspace.state.file[entry.register.index()];
            }
            workspace.linear.solve_transposed(step);
            for entry in &self.steady.residual_tangent {
                out[row * columns + entry.column] -= step[entry.row] * workspace.state.file[entry.register.index()];
            }
        }
    }

    /// Adjoints of quantities at the solution: `l` with `J' l = dq/dT`, `out` is `asked x nodes`, row by row, SI unit of
    /// the quantity a W, 0 at boundaries. A further heat `h` into the nodes that does not depend on temperature moves
    /// the quantity by `-l' h`.
    ///
    /// # Errors
    /// [`UnsolvedError`] without a solution for the present parameters and inputs.
    pub fn quantity_adjoint(
        &self,
        workspace: &mut Workspace,
        asked: &[usize],
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        self.factor_at_solution(workspace)?;
        out.fill(0.0);
        for (&quantity, out) in asked.iter().zip(out.chunks_exact_mut(self.nodes.len().max(1))) {
            let step = &mut workspace.state.step;
            step.fill(0.0);
            for entry in self.steady.quantity_temperature.iter().filter(|entry| entry.row == quantity) {
                step[entry.column] += workspace.state.file[entry.register.index()];
            }
            workspace.linear.solve_transposed(step);
            for (value, &node) in step.iter().zip(&self.steady.unknowns) {
                out[node] = *value;
            }
        }
        Ok(())
    }
}
