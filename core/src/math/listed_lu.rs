//! Sparse LU of small matrices of one pattern, by lists of what each step subtracts from where.
//!
//! Elimination along the diagonal in a minimum degree order ([`super::ordering`]). The pattern is analysed once: of each step
//! the places of its pivot row and column, and of each product of the two the place from which it is subtracted (a code of
//! elimination in lists; Gustavson, Liniger & Willoughby 1970, J. ACM 17, 87). For networks of a few neighbours a node that
//! takes a tenth of a dense elimination, and less than one in blocks, whose blocks would be tiny. A multiplier above
//! [`LARGEST_MULTIPLIER`] means that a pivot is too small; the matrix is then factorised with partial pivoting. All sums have a
//! fixed order: same matrix, same bits, and matrices side by side have the bits that each would have alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::lanes::{Lanes, subtract_multiple};
use super::ordering::minimum_degree;
use super::pivoting_lu::PivotingLu;
use super::sparse::Pattern;
use super::sparse_lu::{LARGEST_MULTIPLIER, put_back};

/// A step of the elimination, and where its numbers lie: the pivot, the pivot row right of it, the column below it.
#[derive(Clone, Debug)]
struct Step {
    /// Row and column of the pivot.
    pivot: usize,
    first: usize,
    upper_end: usize,
    lower_end: usize,
    /// Where the targets of its products begin.
    targets: usize,
}

/// What the pattern alone decides.
#[derive(Debug)]
struct Lists {
    pattern: Pattern,
    steps: Vec<Step>,
    /// Of each entry right of a pivot its column, of each below one its row.
    indices: Vec<usize>,
    /// Place of each value slot.
    places: Vec<usize>,
    /// Of each product of an entry of a step's column and one of its row the place, counted from the step's end.
    targets: Vec<u32>,
}

/// Factors of a matrix (of one a lane), and the room to compute them again for other values.
#[derive(Clone, Debug)]
pub struct ListedLu<V> {
    lists: Arc<Lists>,
    /// Values of the matrix by slot of the pattern, to be set before a factorisation.
    pub values: Vec<V>,
    factors: Vec<V>,
    /// Factors of the lanes whose pivots are not on the diagonal; none where the matrix is singular.
    partial: Vec<(usize, Option<PivotingLu>)>,
}

impl Lists {
    fn new(pattern: Pattern) -> Self {
        let neighbours = pattern.symmetric_neighbours();
        let order = minimum_degree(neighbours.clone());
        let mut step_of = vec![0; order.len()];
        for (step, &index) in order.iter().enumerate() {
            step_of[index] = step;
        }
        // Of each step those that it still touches when it is eliminated, as steps.
        let mut later: Vec<BTreeSet<usize>> = (order.iter().enumerate())
            .map(|(step, &index)| neighbours[index].iter().map(|&other| step_of[other]).filter(|&s| s > step).collect())
            .collect();
        for step in 0..order.len() {
            let touched: Vec<usize> = later[step].iter().copied().collect();
            for (position, &one) in touched.iter().enumerate() {
                later[one].extend(&touched[position + 1..]);
            }
        }
        let mut steps: Vec<Step> = Vec::with_capacity(order.len());
        let mut indices = Vec::new();
        for (step, touched) in later.iter().enumerate() {
            let first = indices.len();
            let others = || touched.iter().map(|&other| order[other]);
            indices.push(order[step]);
            indices.extend(others());
            indices.extend(others());
            let (upper_end, lower_end) = (first + 1 + touched.len(), first + 1 + 2 * touched.len());
            steps.push(Step { pivot: order[step], first, upper_end, lower_end, targets: 0 });
        }
        let sorted: Vec<Vec<usize>> = later.iter().map(|touched| touched.iter().copied().collect()).collect();
        let place = |row: usize, column: usize| {
            let (step, other) = (row.min(column), row.max(column));
            let own = &steps[step];
            let position = sorted[step].partition_point(|&touched| touched < other);
            match row.cmp(&column) {
                std::cmp::Ordering::Equal => own.first,
                std::cmp::Ordering::Less => own.first + 1 + position,
                std::cmp::Ordering::Greater => own.upper_end + position,
            }
        };
        let (mut targets, mut starts) = (Vec::new(), Vec::with_capacity(steps.len()));
        for (step, touched) in sorted.iter().enumerate() {
            starts.push(targets.len());
            for &row in touched {
                let from = steps[step].lower_end;
                let of_row = touched.iter().map(|&column| place(row, column) - from);
                targets.extend(of_row.map(|target| u32::try_from(target).unwrap_or(u32::MAX)));
            }
        }
        let mut places = vec![0; pattern.stored()];
        for column in 0..pattern.size() {
            for slot in pattern.column(column) {
                places[slot] = place(step_of[pattern.rows()[slot]], step_of[column]);
            }
        }
        steps.iter_mut().zip(starts).for_each(|(step, start)| step.targets = start);
        Self { pattern, steps, indices, places, targets }
    }
}

impl<V: Lanes> ListedLu<V> {
    /// Room for factorisations of matrices of a pattern; holds no factors yet.
    pub fn new(pattern: Pattern) -> Self {
        let lists = Lists::new(pattern);
        Self {
            values: vec![V::splat(0.0); lists.pattern.stored()],
            factors: vec![V::splat(0.0); lists.indices.len()],
            lists: Arc::new(lists),
            partial: Vec::new(),
        }
    }

    /// Room for the same pattern in other lanes.
    pub fn in_lanes<W: Lanes>(&self) -> ListedLu<W> {
        ListedLu {
            lists: Arc::clone(&self.lists),
            values: vec![W::splat(0.0); self.values.len()],
            factors: vec![W::splat(0.0); self.factors.len()],
            partial: Vec::new(),
        }
    }

    /// Sets the values in the order of the pattern's entries, each of which occurs once, and 0 elsewhere.
    pub fn load(&mut self, entries: impl Iterator<Item = V>) {
        self.values.fill(V::splat(0.0));
        for (entry, &slot) in entries.zip(self.lists.pattern.slots()) {
            self.values[slot] = entry;
        }
    }

    /// Adds to the diagonal entry of a row of the values.
    pub fn add_to_diagonal(&mut self, row: usize, value: V) {
        let entry = &mut self.values[self.lists.pattern.diagonal()[row]];
        *entry = entry.zip(value, |a, b| a + b);
    }

    /// The pattern.
    pub fn pattern(&self) -> &Pattern {
        &self.lists.pattern
    }

    /// Factorises the matrix of the values. Solutions of a singular one are no numbers.
    pub fn factor(&mut self) {
        self.partial.clear();
        let unsound = self.eliminate();
        for lane in (0..V::COUNT).filter(|&lane| unsound.lane(lane) != 0.0) {
            let own: Vec<f64> = self.values.iter().map(|value| value.lane(lane)).collect();
            let order: Vec<usize> = self.lists.steps.iter().map(|step| step.pivot).collect();
            self.partial.push((lane, PivotingLu::new(&self.lists.pattern, &own, &order).ok()));
        }
    }

    /// Lanes whose rows were exchanged, as a pivot on the diagonal was too small.
    pub fn exchanged(&self) -> usize {
        self.partial.len()
    }

    /// Eliminates along the diagonal; not 0 in the lanes where a pivot is too small, whose factors are of no use.
    fn eliminate(&mut self) -> V {
        let lists = &*self.lists;
        self.factors.fill(V::splat(0.0));
        for (&place, value) in lists.places.iter().zip(&self.values) {
            self.factors[place] = *value;
        }
        // Written so that no number is too large.
        let judge = |unsound: f64, multiplier: f64| if multiplier.abs() <= LARGEST_MULTIPLIER { unsound } else { 1.0 };
        let mut unsound = V::splat(0.0);
        for step in &lists.steps {
            let (done, later) = self.factors.split_at_mut(step.lower_end);
            let (pivot_row, column) = done[step.first..].split_at_mut(step.upper_end - step.first);
            let (pivot, row) = pivot_row.split_at_mut(1);
            let reciprocal = pivot[0].map(|pivot| 1.0 / pivot);
            unsound = unsound.zip(reciprocal, |unsound, r| if r.is_finite() { unsound } else { 1.0 });
            pivot[0] = reciprocal;
            let targets = &lists.targets[step.targets..step.targets + row.len() * column.len()];
            for (entry, targets) in column.iter_mut().zip(targets.chunks_exact(row.len().max(1))) {
                let multiplier = entry.zip(reciprocal, |entry, reciprocal| entry * reciprocal);
                *entry = multiplier;
                unsound = unsound.zip(multiplier, judge);
                for (upper, &target) in row.iter().zip(targets) {
                    later[target as usize].subtract_product(&multiplier, upper);
                }
            }
        }
        unsound
    }

    /// Solves `A x = b` in place.
    pub fn solve(&self, rhs: &mut [V]) {
        let apart = self.solve_apart(rhs, PivotingLu::solve);
        let lists = &*self.lists;
        for step in &lists.steps {
            let value = rhs[step.pivot];
            let range = step.upper_end..step.lower_end;
            for (factor, &row) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                rhs[row].subtract_product(factor, &value);
            }
        }
        for step in lists.steps.iter().rev() {
            let mut sum = rhs[step.pivot];
            let range = step.first + 1..step.upper_end;
            for (factor, &column) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                sum.subtract_product(factor, &rhs[column]);
            }
            rhs[step.pivot] = sum.zip(self.factors[step.first], |sum, reciprocal| sum * reciprocal);
        }
        put_back(rhs, &apart);
    }

    /// Solves `A' x = b` in place.
    pub fn solve_transposed(&self, rhs: &mut [V]) {
        let apart = self.solve_apart(rhs, PivotingLu::solve_transposed);
        let lists = &*self.lists;
        for step in &lists.steps {
            let value = rhs[step.pivot].zip(self.factors[step.first], |x, reciprocal| x * reciprocal);
            rhs[step.pivot] = value;
            let range = step.first + 1..step.upper_end;
            for (factor, &column) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                rhs[column].subtract_product(factor, &value);
            }
        }
        for step in lists.steps.iter().rev() {
            let mut sum = rhs[step.pivot];
            let range = step.upper_end..step.lower_end;
            for (factor, &row) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                sum.subtract_product(factor, &rhs[row]);
            }
            rhs[step.pivot] = sum;
        }
        put_back(rhs, &apart);
    }

    /// Solutions of the lanes that have no factors along the diagonal, no numbers where the matrix is singular.
    fn solve_apart(&self, rhs: &[V], solve: impl Fn(&PivotingLu, &mut [f64], &mut [f64])) -> Vec<(usize, Vec<f64>)> {
        let own = |(lane, partial): &(usize, Option<PivotingLu>)| {
            let Some(partial) = partial else { return (*lane, vec![f64::NAN; rhs.len()]) };
            let mut own: Vec<f64> = rhs.iter().map(|value| value.lane(*lane)).collect();
            solve(partial, &mut own, &mut vec![0.0; rhs.len()]);
            (*lane, own)
        };
        self.partial.iter().map(own).collect()
    }
}

impl ListedLu<f64> {
    /// Replaces each of several right-hand sides, `size x columns`, by its solution, with the bits that it would have alone.
    pub fn solve_columns(&self, rhs: &mut [f64], columns: usize) {
        if !self.partial.is_empty() {
            let mut one = vec![0.0; self.lists.steps.len()];
            for column in 0..columns {
                one.iter_mut().zip(rhs.chunks_exact(columns)).for_each(|(value, row)| *value = row[column]);
                self.solve(&mut one);
                one.iter().zip(rhs.chunks_exact_mut(columns)).for_each(|(value, row)| row[column] = *value);
            }
            return;
        }
        let lists = &*self.lists;
        for step in &lists.steps {
            let range = step.upper_end..step.lower_end;
            for (factor, &row) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                let (to, from) = two_rows(rhs, columns, row, step.pivot);
                subtract_multiple(to, *factor, from);
            }
        }
        for step in lists.steps.iter().rev() {
            let range = step.first + 1..step.upper_end;
            for (factor, &column) in self.factors[range.clone()].iter().zip(&lists.indices[range]) {
                let (to, from) = two_rows(rhs, columns, step.pivot, column);
                subtract_multiple(to, *factor, from);
            }
            let reciprocal = self.factors[step.first];
            rhs[step.pivot * columns..(step.pivot + 1) * columns].iter_mut().for_each(|value| *value *= reciprocal);
        }
    }
}

/// One row to change and another to read.
#[inline]
fn two_rows(rhs: &mut [f64], columns: usize, to: usize, from: usize) -> (&mut [f64], &[f64]) {
    if to < from {
        let (before, after) = rhs.split_at_mut(from * columns);
        (&mut before[to * columns..(to + 1) * columns], &after[..columns])
    } else {
        let (before, after) = rhs.split_at_mut(to * columns);
        (&mut after[..columns], &before[from * columns..(from + 1) * columns])
    }
}
