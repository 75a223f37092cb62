//! The linear systems of the solvers: dense factors for small networks.

use crate::expression::Lanes;

use super::equations::Equations;
use super::lanes_lu::LanesLu;
use super::network::NetworkError;

/// A factorisable matrix with the pattern of the network's slopes and a full diagonal.
#[derive(Clone, Debug)]
pub(super) enum Linear<V> {
    Dense { lu: LanesLu<V>, size: usize },
}

impl<V: Lanes> Linear<V> {
    pub fn new(equations: &Equations) -> Result<Self, NetworkError> {
        let size = equations.size();
        Ok(Self::Dense { lu: LanesLu::new(size), size })
    }

    /// Room for the same pattern in other lanes.
    pub fn in_lanes<W: Lanes>(&self) -> Linear<W> {
        match self {
            Self::Dense { size, .. } => Linear::Dense { lu: LanesLu::new(*size), size: *size },
        }
    }

    /// Whether the factors are dense.
    pub fn is_dense(&self) -> bool {
        matches!(self, Self::Dense { .. })
    }

    /// Puts the slopes of the balances into the matrix.
    pub fn load(&mut self, equations: &Equations, file: &[V]) {
        match self {
            Self::Dense { lu, size } => {
                lu.matrix.fill(V::splat(0.0));
                for entry in &equations.jacobian {
                    lu.matrix[entry.row * *size + entry.column] = file[entry.register.index()];
                }
            }
        }
    }

    /// The diagonal entry of a row before factorisation.
    pub fn diagonal(&mut self, row: usize) -> &mut V {
        match self {
            Self::Dense { lu, size } => &mut lu.matrix[row * *size + row],
        }
    }

    /// Factors what was loaded.
    pub fn factor(&mut self) {
        match self {
            Self::Dense { lu, .. } => lu.factor(),
        }
    }

    /// Replaces `rhs` by the solution.
    pub fn solve(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve(rhs),
        }
    }

    /// Replaces `rhs` by the solution with the transposed matrix.
    pub fn solve_transposed(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve_transposed(rhs),
        }
    }
}
