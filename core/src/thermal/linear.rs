//! The linear systems of the solvers: dense factors for small networks, sparse ones for large.

use std::sync::Arc;

use crate::expression::Lanes;
use crate::math::sparse::Pattern;
use crate::math::sparse_lu::{SparseLu, SymbolicLu};

use super::equations::Equations;
use super::lanes_lu::LanesLu;
use super::network::NetworkError;

/// Networks of up to this many unknowns have dense factors.
const DENSE_UP_TO: usize = 32;

/// A factorisable matrix with the pattern of the network's slopes and a full diagonal.
#[derive(Clone, Debug)]
pub(super) enum Linear<V> {
    Dense { lu: LanesLu<V>, size: usize },
    Sparse(Box<Sparse>),
}

/// A sparse matrix and its factors.
#[derive(Clone, Debug)]
pub(super) struct Sparse {
    pattern: Arc<SymbolicLu>,
    values: Vec<f64>,
    lu: SparseLu,
    usable: bool,
}

impl<V: Lanes> Linear<V> {
    pub fn new(equations: &Equations) -> Result<Self, NetworkError> {
        let size = equations.size();
        if size <= DENSE_UP_TO {
            return Ok(Self::Dense { lu: LanesLu::new(size), size });
        }
        let entries: Vec<(usize, usize)> = equations.jacobian.iter().map(|e| (e.row, e.column)).collect();
        let pattern =
            Pattern::new(size, &entries).map_err(|error| NetworkError::Matrix { reason: error.to_string() })?;
        let pattern = Arc::new(SymbolicLu::new(pattern));
        let values = vec![0.0; pattern.pattern().stored()];
        Ok(Self::Sparse(Box::new(Sparse { lu: SparseLu::new(Arc::clone(&pattern)), pattern, values, usable: false })))
    }

    /// Room for the same pattern in other lanes (sparse factors know one lane only).
    pub fn in_lanes<W: Lanes>(&self) -> Linear<W> {
        match self {
            Self::Dense { size, .. } => Linear::Dense { lu: LanesLu::new(*size), size: *size },
            Self::Sparse(sparse) => Linear::Sparse(sparse.clone()),
        }
    }

    /// Whether the factors are dense.
    pub fn is_dense(&self) -> bool {
        matches!(self, Self::Dense { .. })
    }

    /// Puts remembered slopes of the balances into the matrix, in the order of the equations' entries.
    pub fn load_values(&mut self, equations: &Equations, slopes: &[V]) {
        match self {
            Self::Dense { lu, size } => {
                lu.matrix.fill(V::splat(0.0));
                for (entry, &slope) in equations.jacobian.iter().zip(slopes) {
                    lu.matrix[entry.row * *size + entry.column] = slope;
                }
            }
            Self::Sparse(sparse) => {
                sparse.values.fill(0.0);
                for (&slope, &slot) in slopes.iter().zip(sparse.pattern.pattern().slots()) {
                    sparse.values[slot] = slope.lane(0);
                }
            }
        }
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
            Self::Sparse(sparse) => {
                // Every position of the slopes occurs once, so a slot is set, not added to.
                sparse.values.fill(0.0);
                for (entry, &slot) in equations.jacobian.iter().zip(sparse.pattern.pattern().slots()) {
                    sparse.values[slot] = file[entry.register.index()].lane(0);
                }
            }
        }
    }

    /// Adds to the diagonal entry of a row before factorisation.
    pub fn add_to_diagonal(&mut self, row: usize, value: V) {
        match self {
            Self::Dense { lu, size } => {
                let entry = &mut lu.matrix[row * *size + row];
                *entry = entry.zip(value, |a, b| a + b);
            }
            Self::Sparse(sparse) => sparse.values[sparse.pattern.pattern().diagonal()[row]] += value.lane(0),
        }
    }

    /// The diagonal entry of a row before factorisation.
    pub fn diagonal(&self, row: usize) -> V {
        match self {
            Self::Dense { lu, size } => lu.matrix[row * *size + row],
            Self::Sparse(sparse) => V::splat(sparse.values[sparse.pattern.pattern().diagonal()[row]]),
        }
    }

    /// Factors what was loaded.
    pub fn factor(&mut self) {
        match self {
            Self::Dense { lu, .. } => lu.factor(),
            Self::Sparse(sparse) => sparse.usable = sparse.lu.refactor(&sparse.values).is_ok(),
        }
    }

    /// Replaces `rhs` by the solution; by non-numbers where the matrix is singular.
    pub fn solve(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve(rhs),
            Self::Sparse(sparse) => sparse.solve(rhs, false),
        }
    }

    /// Replaces `rhs` by the solution with the transposed matrix.
    pub fn solve_transposed(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve_transposed(rhs),
            Self::Sparse(sparse) => sparse.solve(rhs, true),
        }
    }
}

impl Linear<f64> {
    /// Replaces each of several right-hand sides, `unknowns x columns`, by its solution.
    pub fn solve_columns(&mut self, rhs: &mut [f64], columns: usize) {
        match self {
            Self::Dense { lu, .. } => lu.solve_columns(rhs, columns),
            Self::Sparse(sparse) => {
                let mut one = vec![0.0; rhs.len() / columns.max(1)];
                for column in 0..columns {
                    for (value, row) in one.iter_mut().zip(rhs.chunks_exact(columns)) {
                        *value = row[column];
                    }
                    sparse.solve(&mut one, false);
                    for (value, row) in one.iter().zip(rhs.chunks_exact_mut(columns)) {
                        row[column] = *value;
                    }
                }
            }
        }
    }
}

impl Sparse {
    fn solve<V: Lanes>(&mut self, rhs: &mut [V], transposed: bool) {
        if !self.usable {
            rhs.fill(V::splat(f64::NAN));
            return;
        }
        // The values have been taken into the factors and are loaded anew before the next ones: room for one lane.
        let room = &mut self.values[..rhs.len()];
        for (slot, value) in room.iter_mut().zip(rhs.iter()) {
            *slot = value.lane(0);
        }
        if transposed {
            self.lu.solve_transposed(room);
        } else {
            self.lu.solve(room);
        }
        for (value, &slot) in rhs.iter_mut().zip(room.iter()) {
            *value = V::splat(slot);
        }
    }
}
