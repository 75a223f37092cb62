//! The best pairs of single-column directions, of all pairs.
//!
//! With the scores `z` and the correlation `c` of two projected columns the free pair has the likelihood ratio
//! `(z_j^2 + z_k^2 - 2 c z_j z_k) / (1 - c^2)` and amplitudes of the signs of `z_j - c z_k` and `z_k - c z_j`. A pair of which
//! an amplitude would have a sign that its bounds forbid is no better than one of its members alone, and is left out.
//! The best of these are fitted between all bounds ([`Prepared::fit`]).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use crate::diagnosis::Direction;
use crate::diagnosis::screening::multi_column::Projected;
use crate::diagnosis::screening::score::{Column, Prepared, Score};
use crate::inference::null_maximum::Side;
use crate::math::dense::dot_of_columns as dot;
use crate::math::sort::sort_by;
use crate::watch;

/// Pairs with less than this left of one given the other (`1 - c^2`) are one direction.
const COLLINEAR: f64 = 1e-6;
/// Columns taken together, so that they stay in the processor's cache.
const TILE: usize = 16;

/// Two directions together.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Position of the first among the directions.
    pub first: usize,
    /// Position of the second, above the first.
    pub second: usize,
    /// The fall of the sum of squares between all bounds.
    pub likelihood_ratio: f64,
    /// What it exceeds that of the better one alone by.
    pub gain: f64,
    /// Correlation of the projected columns.
    pub correlation: f64,
    /// Amplitudes between their bounds, SI.
    pub amplitudes: [f64; 2],
}

/// A pair as screened: no bounds but the signs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screened {
    /// Position of the first among the columns.
    pub first: usize,
    /// Position of the second, above the first.
    pub second: usize,
    /// Likelihood ratio of the free pair.
    pub likelihood_ratio: f64,
    /// Correlation of the columns.
    pub correlation: f64,
}

impl Eq for Screened {}

impl Ord for Screened {
    /// The better one is less, so that a heap's top is the worst; ties by position.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .likelihood_ratio
            .total_cmp(&self.likelihood_ratio)
            .then(self.first.cmp(&other.first))
            .then(self.second.cmp(&other.second))
    }
}

impl PartialOrd for Screened {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The `count` best pairs of columns of length 1 (one after the other in `units`, `rows` long) with the scores `z` and the
/// signs allowed, the best first, ties by position. Cost: columns^2 x rows; memory for the answer only.
pub fn screen(units: &[f64], rows: usize, z: &[f64], sides: &[Side], count: usize) -> Vec<Screened> {
    let n = z.len();
    let unit = |k: usize| &units[k * rows..(k + 1) * rows];
    let allowed = |side: Side, amplitude: f64| side.fold(amplitude) > 0.0;
    let best_of_tile = |first_tile: usize| {
        let mut heap: BinaryHeap<Screened> = BinaryHeap::with_capacity(count + 1);
        let mut worst = f64::NEG_INFINITY;
        for second_tile in (first_tile..n).step_by(TILE) {
            watch::check();
            for j in first_tile..(first_tile + TILE).min(n) {
                for k in second_tile.max(j + 1)..(second_tile + TILE).min(n) {
                    let c = dot(unit(j), unit(k));
                    let left = 1.0 - c * c;
                    if !(left >= COLLINEAR) {
                        continue;
                    }
                    let likelihood_ratio = (z[j] * z[j] + z[k] * z[k] - 2.0 * c * z[j] * z[k]) / left;
                    if likelihood_ratio < worst
                        || !allowed(sides[j], z[j] - c * z[k])
                        || !allowed(sides[k], z[k] - c * z[j])
                    {
                        continue;
                    }
                    heap.push(Screened { first: j, second: k, likelihood_ratio, correlation: c });
                    if heap.len() > count {
                        heap.pop();
                        worst = heap.peek().map_or(worst, |pair| pair.likelihood_ratio);
                    }
                }
            }
        }
        heap.into_vec()
    };
    let tiles: Vec<usize> = (0..n).step_by(TILE).collect();
    let mut best: Vec<Screened> = tiles.par_iter().flat_map_iter(|&tile| best_of_tile(tile)).collect();
    best.sort_unstable();
    best.truncate(count);
    best
}

/// The `count` best pairs of the directions that have one column and are seen: twice as many are screened, fitted between
/// all bounds, and sorted anew (ties by position). `scores` are those of the directions, in their order.
pub fn best_pairs(prepared: &Prepared, directions: &[Direction], scores: &[Score], count: usize) -> Vec<Pair> {
    let (mut units, mut z, mut sides, mut positions) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (position, (direction, score)) in directions.iter().zip(scores).enumerate() {
        if let Projected::Single { column, norm, side } = prepared.projected(direction) {
            units.extend(column.iter().map(|x| x / norm));
            z.push(score.z);
            sides.push(side);
            positions.push(position);
        }
    }
    let screened = screen(&units, prepared.rows, &z, &sides, 2 * count + 8);
    let mut pairs: Vec<Pair> = screened
        .par_iter()
        .map(|pair| {
            let (first, second) = (positions[pair.first], positions[pair.second]);
            let column = |position: usize| {
                let direction = &directions[position];
                Column {
                    values: direction.column(0),
                    lower: direction.lower[0],
                    upper: direction.upper[0],
                    precision: 0.0,
                }
            };
            let fit = prepared.fit(&[column(first), column(second)]);
            let single = scores[first].likelihood_ratio.max(scores[second].likelihood_ratio);
            let last = fit.x.len() - 2;
            Pair {
                first,
                second,
                likelihood_ratio: fit.fall,
                gain: (fit.fall - single).max(0.0),
                correlation: pair.correlation,
                amplitudes: [fit.x[last], fit.x[last + 1]],
            }
        })
        .collect();
    sort_by(&mut pairs, |a, b| {
        b.likelihood_ratio.total_cmp(&a.likelihood_ratio).then(a.first.cmp(&b.first)).then(a.second.cmp(&b.second))
    });
    pairs.truncate(count);
    pairs
}
