//! Sparse LU of an unsymmetric matrix whose pattern is nearly symmetric, for many matrices of one pattern.
//!
//! Multifrontal elimination (Duff & Reid 1983, ACM TOMS 9, 302) along the diagonal in a minimum degree order:
//! the pattern is analysed once, each refactorisation runs in dense blocks without allocation. A multiplier above
//! [`LARGEST_MULTIPLIER`] means that a pivot is too small for its column; the matrix is then factorised with
//! partial pivoting instead (see [`super::pivoting_lu`]). All sums have a fixed order: same matrix, same bits, and
//! several matrices of the pattern are eliminated side by side, each with the bits that it would have alone.

use std::sync::Arc;

use super::dense::SingularError;
use super::elimination::{Block, Elimination};
use super::lanes::{Lanes, dot};
use super::pivoting_lu::PivotingLu;
use super::sparse::Pattern;

/// Largest `|l|` for which pivots along the diagonal are accepted (a threshold of 0.001 on pivot over column maximum).
pub const LARGEST_MULTIPLIER: f64 = 1e3;

/// The analysis of a pattern, shared by all factorisations of matrices with it.
#[derive(Clone, Debug)]
pub struct SymbolicLu {
    pattern: Pattern,
    elimination: Elimination,
}

impl SymbolicLu {
    /// Analyses a pattern: order, fill, blocks. The one part that allocates.
    pub fn new(pattern: Pattern) -> Self {
        let elimination = Elimination::new(&pattern);
        Self { pattern, elimination }
    }

    /// The pattern analysed.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Entries stored for `L` and `U`.
    pub fn factor_entries(&self) -> usize {
        self.elimination.factor_entries
    }

    /// Multiplications of one factorisation along the diagonal.
    pub fn multiplications(&self) -> f64 {
        self.elimination.multiplications
    }
}

/// How a matrix was factorised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pivoting {
    /// Pivots along the diagonal, no allocation.
    Diagonal,
    /// Partial pivoting, because a pivot on the diagonal was too small.
    Partial,
}

/// Factors of a matrix (of one a lane), and the room to compute them again for other values.
#[derive(Clone, Debug)]
pub struct SparseLu<V> {
    symbolic: Arc<SymbolicLu>,
    factors: Vec<V>,
    stack: Vec<V>,
    work: Vec<V>,
    /// How each lane was factorised.
    outcomes: Vec<Result<Pivoting, SingularError>>,
    /// Factors of the lanes whose pivots are not on the diagonal.
    partial: Vec<(usize, PivotingLu)>,
}

impl<V: Lanes> SparseLu<V> {
    /// Room for factorisations of matrices of an analysed pattern; holds no factors yet.
    pub fn new(symbolic: Arc<SymbolicLu>) -> Self {
        let size = symbolic.pattern.size();
        Self {
            factors: vec![V::splat(0.0); symbolic.elimination.factor_entries],
            stack: vec![V::splat(0.0); symbolic.elimination.stack_entries],
            work: vec![V::splat(0.0); size],
            outcomes: vec![Ok(Pivoting::Diagonal); V::COUNT],
            partial: Vec::new(),
            symbolic,
        }
    }

    /// The analysis in use.
    pub fn symbolic(&self) -> &Arc<SymbolicLu> {
        &self.symbolic
    }

    /// Factorises the matrices with the given values (by slot of the pattern). No allocation while pivots on the diagonal
    /// do. Says of each lane how, or in which column no pivot was found; its solutions are then no numbers.
    pub fn refactor(&mut self, values: &[V]) -> &[Result<Pivoting, SingularError>] {
        debug_assert_eq!(values.len(), self.symbolic.pattern.stored());
        self.outcomes.fill(Ok(Pivoting::Diagonal));
        self.partial.clear();
        let unsound = self.eliminate_all(values);
        for lane in (0..V::COUNT).filter(|&lane| unsound.lane(lane) != 0.0) {
            let own: Vec<f64> = values.iter().map(|value| value.lane(lane)).collect();
            let partial = PivotingLu::new(&self.symbolic.pattern, &own, &self.symbolic.elimination.order);
            self.outcomes[lane] = partial.map(|partial| {
                self.partial.push((lane, partial));
                Pivoting::Partial
            });
        }
        &self.outcomes
    }

    /// Eliminates along the diagonal; not 0 in the lanes where a pivot is too small, whose factors are of no use.
    fn eliminate_all(&mut self, values: &[V]) -> V {
        let elimination = &self.symbolic.elimination;
        self.factors.fill(V::splat(0.0));
        for (&place, &value) in elimination.places.iter().zip(values) {
            self.factors[place] = value;
        }
        let mut unsound = V::splat(0.0);
        let mut top = 0;
        for block in &elimination.blocks {
            let below = block.front - block.pivots;
            let end = block.factor_start + block.pivots * (block.front + below);
            let factors = &mut self.factors[block.factor_start..end];
            let (upper, lower) = factors.split_at_mut(block.pivots * block.front);
            let (used, free) = self.stack.split_at_mut(top);
            let complement = &mut free[..below * below];
            complement.fill(V::splat(0.0));
            let mut base = top;
            for &child in block.children.iter().rev() {
                let child = &elimination.blocks[child];
                let entries = child.in_parent.len() * child.in_parent.len();
                base -= entries;
                extend_add(child, &used[base..base + entries], block, upper, lower, complement);
            }
            eliminate(block, upper, lower, complement, &mut unsound);
            if (0..V::COUNT).all(|lane| unsound.lane(lane) != 0.0) {
                return unsound;
            }
            self.stack.copy_within(top..top + below * below, base);
            top = base + below * below;
        }
        unsound
    }

    /// Solves `A x = b` in place for the matrices of the last [`SparseLu::refactor`].
    pub fn solve(&mut self, rhs: &mut [V]) {
        let apart = self.solve_apart(rhs, PivotingLu::solve);
        let elimination = &self.symbolic.elimination;
        let x = &mut self.work;
        for (x, &original) in x.iter_mut().zip(&elimination.order) {
            *x = rhs[original];
        }
        for block in &elimination.blocks {
            let (p, upper, lower, below) = parts(elimination, &self.factors, block);
            let (block_values, later) = x[block.first..].split_at_mut(p);
            for (i, line) in upper.chunks_exact(block.front).enumerate() {
                let sum = dot(&line[..i], &block_values[..i]);
                block_values[i] = block_values[i].zip(sum, |x, sum| x - sum);
            }
            for (line, &row) in lower.chunks_exact(p).zip(below) {
                let (value, sum) = (&mut later[row - block.first - p], dot(line, block_values));
                *value = value.zip(sum, |x, sum| x - sum);
            }
        }
        for block in elimination.blocks.iter().rev() {
            let (p, upper, _, below) = parts(elimination, &self.factors, block);
            let (block_values, later) = x[block.first..].split_at_mut(p);
            for (i, line) in upper.chunks_exact(block.front).enumerate().rev() {
                let (inside, outside) = line.split_at(p);
                let product = dot(&inside[i + 1..], &block_values[i + 1..]);
                let mut sum = block_values[i].zip(product, |x, product| x - product);
                for (u, &row) in outside.iter().zip(below) {
                    sum.subtract_product(u, &later[row - block.first - p]);
                }
                block_values[i] = sum.zip(inside[i], |sum, pivot| sum / pivot);
            }
        }
        for (x, &original) in x.iter().zip(&elimination.order) {
            rhs[original] = *x;
        }
        put_back(rhs, &apart);
    }

    /// Solves `A' x = b` in place for the matrices of the last [`SparseLu::refactor`].
    pub fn solve_transposed(&mut self, rhs: &mut [V]) {
        let apart = self.solve_apart(rhs, PivotingLu::solve_transposed);
        let elimination = &self.symbolic.elimination;
        let x = &mut self.work;
        for (x, &original) in x.iter_mut().zip(&elimination.order) {
            *x = rhs[original];
        }
        for block in &elimination.blocks {
            let (p, upper, _, below) = parts(elimination, &self.factors, block);
            let (block_values, later) = x[block.first..].split_at_mut(p);
            for (i, line) in upper.chunks_exact(block.front).enumerate() {
                let (inside, outside) = line.split_at(p);
                let value = block_values[i].zip(inside[i], |x, pivot| x / pivot);
                block_values[i] = value;
                for (x, u) in block_values[i + 1..].iter_mut().zip(&inside[i + 1..]) {
                    x.subtract_product(u, &value);
                }
                for (u, &row) in outside.iter().zip(below) {
                    later[row - block.first - p].subtract_product(u, &value);
                }
            }
        }
        for block in elimination.blocks.iter().rev() {
            let (p, upper, lower, below) = parts(elimination, &self.factors, block);
            let (block_values, later) = x[block.first..].split_at_mut(p);
            for (line, &row) in lower.chunks_exact(p).zip(below) {
                let value = later[row - block.first - p];
                for (x, l) in block_values.iter_mut().zip(line) {
                    x.subtract_product(l, &value);
                }
            }
            for (i, line) in upper.chunks_exact(block.front).enumerate().rev() {
                let value = block_values[i];
                for (x, l) in block_values[..i].iter_mut().zip(line) {
                    x.subtract_product(l, &value);
                }
            }
        }
        for (x, &original) in x.iter().zip(&elimination.order) {
            rhs[original] = *x;
        }
        put_back(rhs, &apart);
    }

    /// Solutions of the lanes that have no factors along the diagonal, no numbers where the matrix is singular.
    fn solve_apart(&self, rhs: &[V], solve: impl Fn(&PivotingLu, &mut [f64], &mut [f64])) -> Vec<(usize, Vec<f64>)> {
        let singular = self.outcomes.iter().enumerate().filter(|(_, outcome)| outcome.is_err());
        let mut apart: Vec<_> = singular.map(|(lane, _)| (lane, vec![f64::NAN; rhs.len()])).collect();
        for (lane, partial) in &self.partial {
            let mut own: Vec<f64> = rhs.iter().map(|value| value.lane(*lane)).collect();
            solve(partial, &mut own, &mut vec![0.0; rhs.len()]);
            apart.push((*lane, own));
        }
        apart
    }
}

impl SparseLu<f64> {
    /// One step of iterative refinement of a solution of `A x = b` (Skeel 1980): solves for the residual and adds the result.
    /// Returns the largest absolute residual before the step.
    pub fn refine(&mut self, values: &[f64], rhs: &[f64], solution: &mut [f64]) -> f64 {
        let mut residual = vec![0.0; rhs.len()];
        self.symbolic.pattern.multiply(values, solution, &mut residual);
        let mut largest = 0.0_f64;
        for (r, b) in residual.iter_mut().zip(rhs) {
            *r = b - *r;
            largest = largest.max(r.abs());
        }
        self.solve(&mut residual);
        for (x, correction) in solution.iter_mut().zip(&residual) {
            *x += correction;
        }
        largest
    }
}

/// Replaces the solutions of lanes.
pub(super) fn put_back<V: Lanes>(rhs: &mut [V], apart: &[(usize, Vec<f64>)]) {
    for (lane, own) in apart {
        for (value, &own) in rhs.iter_mut().zip(own) {
            value.set_lane(*lane, own);
        }
    }
}

/// A block's pivot count, pivot rows, `L` below them, and the steps of the rows below.
fn parts<'a, V>(
    elimination: &'a Elimination,
    factors: &'a [V],
    block: &Block,
) -> (usize, &'a [V], &'a [V], &'a [usize]) {
    let (p, m) = (block.pivots, block.front);
    let factors = &factors[block.factor_start..block.factor_start + p * (2 * m - p)];
    let (upper, lower) = factors.split_at(p * m);
    (p, upper, lower, &elimination.rows[block.rows_start + p..block.rows_start + m])
}

/// Adds a child's Schur complement to its parent's front.
fn extend_add<V: Lanes>(
    child: &Block,
    from: &[V],
    parent: &Block,
    upper: &mut [V],
    lower: &mut [V],
    complement: &mut [V],
) {
    let (p, m) = (parent.pivots, parent.front);
    let targets = &child.in_parent;
    let inside = targets.partition_point(|&t| t < p);
    for (line, &row) in from.chunks_exact(targets.len().max(1)).zip(targets) {
        if row < p {
            scatter_add(&mut upper[row * m..(row + 1) * m], line, targets, 0);
        } else {
            let (left, right) = line.split_at(inside);
            scatter_add(&mut lower[(row - p) * p..(row - p + 1) * p], left, &targets[..inside], 0);
            scatter_add(&mut complement[(row - p) * (m - p)..(row - p + 1) * (m - p)], right, &targets[inside..], p);
        }
    }
}

/// Adds values at some columns, counted from `first`.
#[inline]
fn scatter_add<V: Lanes>(to: &mut [V], line: &[V], columns: &[usize], first: usize) {
    for (value, &column) in line.iter().zip(columns) {
        let to = &mut to[column - first];
        *to = to.zip(*value, |a, b| a + b);
    }
}

/// Eliminates a block's pivots in its front. Makes the lanes not 0 in which a pivot is too small; in a lane by itself the
/// rest is then left out.
fn eliminate<V: Lanes>(block: &Block, upper: &mut [V], lower: &mut [V], complement: &mut [V], unsound: &mut V) {
    let (p, m) = (block.pivots, block.front);
    // Written so that no number is too large.
    let judge = |unsound: f64, multiplier: f64| if multiplier.abs() <= LARGEST_MULTIPLIER { unsound } else { 1.0 };
    for k in 0..p {
        let (done, rest) = upper.split_at_mut((k + 1) * m);
        let pivot_row = &done[k * m..];
        let pivot = pivot_row[k];
        *unsound = unsound.zip(pivot, |unsound, pivot| if pivot != 0.0 && pivot.is_finite() { unsound } else { 1.0 });
        let reciprocal = pivot.map(|pivot| 1.0 / pivot);
        for line in rest.chunks_exact_mut(m) {
            let multiplier = line[k].zip(reciprocal, |entry, reciprocal| entry * reciprocal);
            line[k] = multiplier;
            *unsound = unsound.zip(multiplier, judge);
            subtract(&mut line[k + 1..], &multiplier, &pivot_row[k + 1..]);
        }
    }
    if V::COUNT == 1 && unsound.lane(0) != 0.0 {
        return;
    }
    for (line, target) in lower.chunks_exact_mut(p).zip(complement.chunks_exact_mut((m - p).max(1))) {
        for (k, pivot_row) in upper.chunks_exact(m).enumerate() {
            let multiplier = line[k].zip(pivot_row[k], |entry, pivot| entry / pivot);
            line[k] = multiplier;
            *unsound = unsound.zip(multiplier, judge);
            subtract(&mut line[k + 1..], &multiplier, &pivot_row[k + 1..p]);
        }
        subtract_product(target, line, upper, m);
    }
}

/// `x -= factor * y`.
#[inline]
fn subtract<V: Lanes>(x: &mut [V], factor: &V, y: &[V]) {
    for (x, y) in x.iter_mut().zip(y) {
        x.subtract_product(factor, y);
    }
}

/// `target -= sum over k of line[k] * (the last entries of pivot row k)`, four rows at a time to spare memory traffic.
#[inline]
fn subtract_product<V: Lanes>(target: &mut [V], line: &[V], upper: &[V], front: usize) {
    let tail = front - target.len();
    let mut fours = line.chunks_exact(4);
    let mut rows = upper.chunks_exact(4 * front);
    for (l, four) in (&mut fours).zip(&mut rows) {
        let (a, rest) = four.split_at(front);
        let (b, rest) = rest.split_at(front);
        let (c, d) = rest.split_at(front);
        let pairs = a[tail..].iter().zip(&b[tail..]).zip(c[tail..].iter().zip(&d[tail..]));
        for (x, ((a, b), (c, d))) in target.iter_mut().zip(pairs) {
            x.subtract_four_products([&l[0], &l[1], &l[2], &l[3]], [a, b, c, d]);
        }
    }
    for (l, row) in fours.remainder().iter().zip(rows.remainder().chunks_exact(front)) {
        subtract(target, l, &row[tail..]);
    }
}
