//! The linear systems of the solvers: dense factors for small networks, sparse ones for large, and in transients, which factor
//! one matrix after another, sparse ones by lists up to some hundred nodes.

use std::sync::Arc;

use crate::math::lanes::Lanes;
use crate::math::listed_lu::ListedLu;
use crate::math::sparse::Pattern;
use crate::math::sparse_lu::{SparseLu, SymbolicLu};

use super::equations::Equations;
use super::lanes_lu::LanesLu;
use super::network::NetworkError;

/// Networks of up to this many unknowns have dense factors.
const DENSE_UP_TO: usize = 32;

/// Most multiplications of a factorisation by lists: they take memory, and blocks are better at many.
const LISTED_UP_TO: f64 = 100_000.0;
/// Share of the multiplications of a dense factorisation up to which lists are better than passing over zeros.
const SHARE_LISTED: f64 = 0.25;
/// Sparse factors of all lanes side by side take about as long as those of one lane in so many, one after the other.
const SHARE_OF_LANES: usize = 2;
/// Most entries of the factors of all lanes, 32 MiB: beyond, nearly dense blocks gain nothing from company.
const MOST_ENTRIES: usize = 1 << 22;

/// Multiplications an entry of the factors from which a factorisation costs many times a solution.
const COSTLY_FROM: f64 = 30.0;

/// A factorisable matrix with the pattern of the network's slopes and a full diagonal.
#[derive(Clone, Debug)]
pub(super) enum Linear<V> {
    Dense { lu: LanesLu<V>, size: usize },
    Sparse(Box<Sparse<V>>),
    Listed(Box<ListedLu<V>>),
}

/// A sparse matrix and its factors.
#[derive(Clone, Debug)]
pub(super) struct Sparse<V> {
    values: Vec<V>,
    lu: SparseLu<V>,
}

impl<V: Lanes> Sparse<V> {
    fn new(pattern: Arc<SymbolicLu>) -> Self {
        Self { values: vec![V::splat(0.0); pattern.pattern().stored()], lu: SparseLu::new(pattern) }
    }

    fn pattern(&self) -> &Pattern {
        self.lu.symbolic().pattern()
    }

    /// Sets the values in the order of the pattern's entries, each of which occurs once, and 0 elsewhere.
    fn load(&mut self, slopes: impl Iterator<Item = V>) {
        self.values.fill(V::splat(0.0));
        for (slope, &slot) in slopes.zip(self.lu.symbolic().pattern().slots()) {
            self.values[slot] = slope;
        }
    }
}

/// The pattern of the slopes, entries in the equations' order.
fn pattern(equations: &Equations) -> Result<Pattern, NetworkError> {
    let entries: Vec<(usize, usize)> = equations.jacobian.iter().map(|e| (e.row, e.column)).collect();
    Pattern::new(equations.size(), &entries).map_err(|error| NetworkError::Matrix { reason: error.to_string() })
}

impl<V: Lanes> Linear<V> {
    pub fn new(equations: &Equations) -> Result<Self, NetworkError> {
        let size = equations.size();
        if size <= DENSE_UP_TO {
            return Ok(Self::Dense { lu: LanesLu::new(size), size });
        }
        let symbolic = SymbolicLu::new(pattern(equations)?);
        Ok(Self::Sparse(Box::new(Sparse::new(Arc::new(symbolic)))))
    }

    /// Room for one matrix after another, as transients factor them: for these the lists are worth their making.
    pub fn in_turn(&self, equations: &Equations) -> Self {
        let size = equations.size();
        let Ok(pattern) = pattern(equations) else { return self.clone() };
        let dense = (size * size * size) as f64 / 3.0;
        let most = if size <= DENSE_UP_TO { SHARE_LISTED * dense } else { LISTED_UP_TO };
        if SymbolicLu::new(pattern.clone()).multiplications() > most {
            return self.clone();
        }
        Self::Listed(Box::new(ListedLu::new(pattern)))
    }

    /// Whether a factorisation costs so many times a solution that factors should serve more than one step.
    pub fn is_costly(&self) -> bool {
        match self {
            Self::Dense { .. } | Self::Listed(_) => false,
            Self::Sparse(sparse) => {
                let symbolic = sparse.lu.symbolic();
                symbolic.multiplications() >= COSTLY_FROM * symbolic.factor_entries() as f64
            }
        }
    }

    /// Room for the same pattern in other lanes; none where that would be too large to be of use, and where factors serve more
    /// than one step, since lanes would not all need new ones at once.
    pub fn in_lanes<W: Lanes>(&self) -> Option<Linear<W>> {
        match self {
            Self::Dense { size, .. } => Some(Linear::Dense { lu: LanesLu::new(*size), size: *size }),
            Self::Listed(lu) => Some(Linear::Listed(Box::new(lu.in_lanes()))),
            Self::Sparse(sparse) => {
                let symbolic = sparse.lu.symbolic();
                let fits = !self.is_costly() && symbolic.factor_entries().saturating_mul(W::COUNT) <= MOST_ENTRIES;
                fits.then(|| Linear::Sparse(Box::new(Sparse::new(Arc::clone(symbolic)))))
            }
        }
    }

    /// Whether factors cost so little that none needs to be kept for long.
    pub fn is_cheap(&self) -> bool {
        match self {
            Self::Dense { .. } => true,
            Self::Sparse(_) => false,
            Self::Listed(lu) => lu.pattern().size() <= DENSE_UP_TO,
        }
    }

    /// Whether so many lanes are better solved side by side than one after the other.
    pub fn is_worth_lanes(&self, used: usize) -> bool {
        match self {
            Self::Dense { .. } | Self::Listed(_) => true,
            Self::Sparse(_) => SHARE_OF_LANES * used >= V::COUNT,
        }
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
            Self::Sparse(sparse) => sparse.load(slopes.iter().copied()),
            Self::Listed(lu) => lu.load(slopes.iter().copied()),
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
            Self::Sparse(sparse) => sparse.load(equations.jacobian.iter().map(|entry| file[entry.register.index()])),
            Self::Listed(lu) => lu.load(equations.jacobian.iter().map(|entry| file[entry.register.index()])),
        }
    }

    /// Adds to the diagonal entry of a row before factorisation.
    pub fn add_to_diagonal(&mut self, row: usize, value: V) {
        match self {
            Self::Dense { lu, size } => {
                let entry = &mut lu.matrix[row * *size + row];
                *entry = entry.zip(value, |a, b| a + b);
            }
            Self::Sparse(sparse) => {
                let slot = sparse.pattern().diagonal()[row];
                sparse.values[slot] = sparse.values[slot].zip(value, |a, b| a + b);
            }
            Self::Listed(lu) => lu.add_to_diagonal(row, value),
        }
    }

    /// The diagonal entry of a row before factorisation.
    pub fn diagonal(&self, row: usize) -> V {
        match self {
            Self::Dense { lu, size } => lu.matrix[row * *size + row],
            Self::Sparse(sparse) => sparse.values[sparse.pattern().diagonal()[row]],
            Self::Listed(lu) => lu.values[lu.pattern().diagonal()[row]],
        }
    }

    /// Factors what was loaded.
    pub fn factor(&mut self) {
        match self {
            Self::Dense { lu, .. } => lu.factor(),
            Self::Sparse(sparse) => {
                // A singular lane has no numbers as its solution.
                sparse.lu.refactor(&sparse.values);
            }
            Self::Listed(lu) => lu.factor(),
        }
    }

    /// Replaces `rhs` by the solution; by non-numbers where the matrix is singular.
    pub fn solve(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve(rhs),
            Self::Sparse(sparse) => sparse.lu.solve(rhs),
            Self::Listed(lu) => lu.solve(rhs),
        }
    }

    /// Replaces `rhs` by the solution with the transposed matrix.
    pub fn solve_transposed(&mut self, rhs: &mut [V]) {
        match self {
            Self::Dense { lu, .. } => lu.solve_transposed(rhs),
            Self::Sparse(sparse) => sparse.lu.solve_transposed(rhs),
            Self::Listed(lu) => lu.solve_transposed(rhs),
        }
    }
}

impl Linear<f64> {
    /// As [`Linear::solve_columns`] with factors that are shared; sparse ones are copied, since they hold room of their own.
    pub fn solve_columns_shared(&self, rhs: &mut [f64], columns: usize) {
        match self {
            Self::Dense { lu, .. } => lu.solve_columns(rhs, columns),
            Self::Listed(lu) => lu.solve_columns(rhs, columns),
            Self::Sparse(_) => self.clone().solve_columns(rhs, columns),
        }
    }

    /// Replaces each of several right-hand sides, `unknowns x columns`, by its solution.
    pub fn solve_columns(&mut self, rhs: &mut [f64], columns: usize) {
        match self {
            Self::Dense { lu, .. } => lu.solve_columns(rhs, columns),
            Self::Listed(lu) => lu.solve_columns(rhs, columns),
            Self::Sparse(sparse) => {
                let mut one = vec![0.0; rhs.len() / columns.max(1)];
                for column in 0..columns {
                    for (value, row) in one.iter_mut().zip(rhs.chunks_exact(columns)) {
                        *value = row[column];
                    }
                    sparse.lu.solve(&mut one);
                    for (value, row) in one.iter().zip(rhs.chunks_exact_mut(columns)) {
                        row[column] = *value;
                    }
                }
            }
        }
    }
}
