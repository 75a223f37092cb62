//! Variance-based sensitivity indices (Sobol 1993) from sums over the rows of Saltelli's design.
//!
//! A row has two independent points `a` and `b`, the mixed points `ab_j` (`a` with coordinate j from `b`) and, for effects
//! of second order, `ba_j`. With `f` centred by the mean over `a` and `b`, `V` the variance over both and `E` the mean over rows:
//! - main effect `S_j = E[f(b) (f(ab_j) - f(a))] / V` (Saltelli et al. 2010, table 2 b);
//! - total effect `T_j = E[(f(a) - f(ab_j))^2] / (2 V)` (Jansen 1999, eq. 12);
//! - second order `S_ij = (E[f(ba_i) f(ab_j)] - E[f(a) f(b)]) / V - S_i - S_j` (Saltelli 2002, theorem 2).
//!
//! Uncentred, a large mean inflates the error of the first and the third. Where the points `ba_j` exist, every estimate
//! is the mean of itself and of its mirror image with `a` and `b` exchanged.
//!
//! The rows of one scramble of a Sobol sequence are no independent sample, so that neither their scatter nor a bootstrap
//! tells the error; independent scrambles do: [`Estimate::of`] takes Student's t of their scatter (Owen 1998).

use serde::{Deserialize, Serialize};

use crate::math::special::student_t_quantile;
use crate::math::sum::compensated;

/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;
/// A standard deviation below this share of the largest magnitude is rounding, not variation.
const ROUNDING: f64 = 1e-10;

/// Sums over rows; those of later rows are taken in by [`SobolSums::merge`]. Values are held relative to a fixed centre, so that
/// nothing cancels where the mean is large; it should lie within some standard deviations of the values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SobolSums {
    centre: f64,
    rows: u64,
    /// Smallest and largest value.
    range: Option<[f64; 2]>,
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
    /// For each coordinate the sums of `ab_j - a`, `b (ab_j - a)`, `(ab_j - a)^2`.
    forward: Vec<[f64; 3]>,
    /// For each coordinate the sums of `ba_j - b`, `a (ba_j - b)`, `(ba_j - b)^2`; empty without the points `ba_j`.
    mirrored: Vec<[f64; 3]>,
    /// For each pair i < j, in the order of [`pairs`], the sum of `(ba_i ab_j + ba_j ab_i) / 2`.
    products: Vec<f64>,
}

/// Pairs i < j of `count` coordinates: (0, 1), (0, 2), ..., (1, 2), ...
pub fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

/// Indices from one set of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct SobolIndices {
    /// Mean of the quantity.
    pub mean: f64,
    /// Variance of the quantity.
    pub variance: f64,
    /// Main effects by coordinate.
    pub main: Vec<f64>,
    /// Total effects by coordinate.
    pub total: Vec<f64>,
    /// Second-order effects by pair; empty without the points that they need.
    pub second: Vec<f64>,
}

impl SobolSums {
    /// No rows yet, for so many coordinates.
    pub fn new(coordinates: usize, has_second_order: bool, centre: f64) -> Self {
        let mirrored = if has_second_order { coordinates } else { 0 };
        Self {
            centre,
            rows: 0,
            range: None,
            a: 0.0,
            b: 0.0,
            aa: 0.0,
            bb: 0.0,
            ab: 0.0,
            forward: vec![[0.0; 3]; coordinates],
            mirrored: vec![[0.0; 3]; mirrored],
            products: vec![0.0; mirrored * mirrored.saturating_sub(1) / 2],
        }
    }

    /// Takes in a row: the values at `a`, `b`, at each `ab_j`, and at each `ba_j` where they are asked for; all finite.
    pub fn add(&mut self, a: f64, b: f64, ab: &[f64], ba: &[f64]) {
        let (a, b) = (a - self.centre, b - self.centre);
        self.rows += 1;
        self.a += a;
        self.b += b;
        self.aa += a * a;
        self.bb += b * b;
        self.ab += a * b;
        let (mut low, mut high) = (a.min(b), a.max(b));
        let mut accumulate = |sums: &mut [[f64; 3]], mixed: &[f64], start: f64, other: f64| {
            for (sums, mixed) in sums.iter_mut().zip(mixed) {
                let mixed = mixed - self.centre;
                let step = mixed - start;
                sums[0] += step;
                sums[1] += other * step;
                sums[2] += step * step;
                low = low.min(mixed);
                high = high.max(mixed);
            }
        };
        accumulate(&mut self.forward, ab, a, b);
        accumulate(&mut self.mirrored, ba, b, a);
        for (sum, (i, j)) in self.products.iter_mut().zip(pairs(ba.len())) {
            let at = |values: &[f64], k: usize| values[k] - self.centre;
            *sum += 0.5 * (at(ba, i) * at(ab, j) + at(ba, j) * at(ab, i));
        }
        self.widen([low + self.centre, high + self.centre]);
    }

    fn widen(&mut self, [low, high]: [f64; 2]) {
        self.range = Some(self.range.map_or([low, high], |[l, h]| [l.min(low), h.max(high)]));
    }

    /// Takes in the sums of later rows of the same design.
    pub fn merge(&mut self, later: &Self) {
        self.rows += later.rows;
        self.a += later.a;
        self.b += later.b;
        self.aa += later.aa;
        self.bb += later.bb;
        self.ab += later.ab;
        let both = [(&mut self.forward, &later.forward), (&mut self.mirrored, &later.mirrored)];
        for (mine, theirs) in both {
            for (mine, theirs) in mine.iter_mut().zip(theirs) {
                mine.iter_mut().zip(theirs).for_each(|(sum, value)| *sum += value);
            }
        }
        self.products.iter_mut().zip(&later.products).for_each(|(sum, value)| *sum += value);
        if let Some(range) = later.range {
            self.widen(range);
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Smallest and largest value of all rows.
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }

    /// Whether there is nothing to divide among the coordinates: no rows, or no variation beyond rounding.
    pub fn is_constant(&self) -> bool {
        let Some([low, high]) = self.range else { return true };
        let (_, variance) = self.mean_and_variance();
        // Written so that a NaN counts as constant.
        !(variance.max(0.0).sqrt() > ROUNDING * low.abs().max(high.abs()))
    }

    /// Mean relative to the centre, and variance, over `a` and `b`.
    fn mean_and_variance(&self) -> (f64, f64) {
        let twice = 2.0 * self.rows as f64;
        let mean = (self.a + self.b) / twice;
        (mean, (self.aa + self.bb) / twice - mean * mean)
    }

    /// The indices; `None` where the quantity is constant.
    pub fn indices(&self) -> Option<SobolIndices> {
        if self.is_constant() {
            return None;
        }
        let n = self.rows as f64;
        let (mean, variance) = self.mean_and_variance();
        let has_mirror = !self.mirrored.is_empty();
        let averaged = |of: &dyn Fn(&[f64; 3]) -> f64| -> Vec<f64> {
            let forward = self.forward.iter().map(of);
            if has_mirror {
                forward.zip(self.mirrored.iter().map(of)).map(|(x, y)| 0.5 * (x + y)).collect()
            } else {
                forward.collect()
            }
        };
        let main = averaged(&|sums| (sums[1] - mean * sums[0]) / n / variance);
        let total = averaged(&|sums| 0.5 * sums[2] / n / variance);
        // Sums of `ab_j` and of `ba_j` from those of their differences.
        let forward = |j: usize| self.a + self.forward[j][0];
        let mirrored = |j: usize| self.b + self.mirrored[j][0];
        let joint = self.ab / n - mean * mean;
        let second = self
            .products
            .iter()
            .zip(pairs(self.mirrored.len()))
            .map(|(&products, (i, j))| {
                let sums = 0.5 * (forward(i) + forward(j) + mirrored(i) + mirrored(j));
                let closed = (products - mean * sums) / n + mean * mean;
                (closed - joint) / variance - main[i] - main[j]
            })
            .collect();
        Some(SobolIndices { mean: self.centre + mean, variance, main, total, second })
    }

    /// How far an index could move if the rows that were left out had values within the range of those that were not.
    ///
    /// With `R` that range, `n` rows and `m` left out: such a row adds at most `R^2` to the sum of products behind a main
    /// effect, either way, `R^2 / 2` to the sum of squares behind a total effect, and at most `R^2` to `n V`. Of the main
    /// and the total effect, smallest and largest value.
    pub fn bounds(&self, left_out: u64, main: f64, total: f64) -> Option<[[f64; 2]; 2]> {
        let [low, high] = self.range?;
        let (_, variance) = self.mean_and_variance();
        let (n, share) = (self.rows as f64 * variance, left_out as f64 * (high - low) * (high - low));
        let least_main = (main * n - share) / if main * n > share { n + share } else { n };
        Some([[least_main, (main * n + share) / n], [total * n / (n + share), (total * n + 0.5 * share) / n]])
    }
}

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Estimate {
    /// Mean over the replicates. An index near 0 may come out slightly negative: it is not cut off, which would bias it.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
}

impl Estimate {
    /// Mean of independent replicates with Student's 95 % interval from their scatter; an interval without end for fewer
    /// than two.
    pub fn of(replicates: &[f64]) -> Self {
        let n = replicates.len() as f64;
        let value = compensated(replicates.iter().copied()) / n;
        let squares = compensated(replicates.iter().map(|x| (x - value) * (x - value)));
        let reach = if replicates.len() < 2 {
            f64::INFINITY
        } else {
            student_t_quantile(0.5 + 0.5 * CONFIDENCE, n - 1.0) * (squares / (n - 1.0) / n).sqrt()
        };
        Self { value, lower: value - reach, upper: value + reach }
    }

    /// Length of the interval.
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }

    /// Whether the intervals of two estimates meet.
    pub fn meets(&self, other: &Self) -> bool {
        self.lower <= other.upper && other.lower <= self.upper
    }
}

/// A place in a ranking: best and worst place, counted from 1, that the intervals allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Place {
    /// One more than the number of estimates that lie wholly above.
    pub best: usize,
    /// The number of estimates less those that lie wholly below.
    pub worst: usize,
}

/// The places of estimates, largest first; two whose intervals meet are not told apart.
pub fn places(estimates: &[Estimate]) -> Vec<Place> {
    let count = |keep: &dyn Fn(&Estimate) -> bool| estimates.iter().filter(|other| keep(other)).count();
    let place = |mine: &Estimate| Place {
        best: 1 + count(&|other| other.lower > mine.upper),
        worst: estimates.len() - count(&|other| other.upper < mine.lower),
    };
    estimates.iter().map(place).collect()
}
