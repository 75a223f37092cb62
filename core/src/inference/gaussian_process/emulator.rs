//! A process in a model's place: what it expects at many points side by side, what its error is made of, and the slopes of both.
//!
//! The error at a point `z` has the covariance `C(z, z')` of trend and smooth part. With a few anchors `z_j`, factored as
//! `C(z_i, z_j) = L L'`, it is `L^-1 C(z_j, z)` times independent standard normal numbers, one an anchor, and a rest that is
//! independent of these: so errors at near points go together, and those at distant ones do not. Both sums hold exactly at each
//! point: the squares of the parts add up to the process' variance there (the Nystrom approximation with its remainder;
//! Rasmussen & Williams 2006, section 8.3.7, eq. 2.26 and 2.42 for `C`).
//!
//! Multiplied out, a part is a sum over covariances with anchors, with points that have values, and over the trend's functions:
//! nothing is solved for it.

use super::Trend;
use super::kernel::distance_square;
use super::process::Process;
use crate::math::cholesky;

/// Points side by side; no part of any identity, since each has the bits that it has alone.
const LANES: usize = 8;
/// Least variance of what an anchor adds, against the largest of all candidates.
const LEAST: f64 = 1e-8;
/// Added to the variances of anchors against the largest, so that rounding leaves them positive.
const ROUNDING: f64 = 1e-12;
/// Share of the variance below which the rest is rounding.
const NOTHING: f64 = 1e-12;

/// What is expected at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// Mean.
    pub mean: f64,
    /// By what the error changes with the standard normal number of each anchor.
    pub parts: Vec<f64>,
    /// Standard deviation of the rest of the error, scatter included.
    pub rest: f64,
}

/// Slopes of what is expected by the coordinates of the point.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedSlopes {
    /// Of the mean.
    pub mean: Vec<f64>,
    /// Of the part of each anchor.
    pub parts: Vec<Vec<f64>>,
    /// Of the rest; 0 where there is none.
    pub rest: Vec<f64>,
}

/// The part of an anchor, multiplied out.
#[derive(Clone, Debug)]
struct Part {
    /// Weights of the covariances with the anchors.
    anchors: Vec<f64>,
    /// Weights of the covariances with the points that have values.
    points: Vec<f64>,
    /// Weights of the trend's functions.
    trend: Vec<f64>,
}

/// A process, the factor on its standard deviation, and anchors of its error.
#[derive(Clone, Debug)]
pub struct Emulator {
    process: Process,
    factor: f64,
    anchors: Vec<Vec<f64>>,
    parts: Vec<Part>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Places of at most `count` of some points, one after the other where the error that those before leave is largest: pivots of a
/// Cholesky factor of their covariance (row after row).
pub fn most_telling(covariance: &[f64], points: usize, count: usize) -> Vec<usize> {
    let mut left = covariance.to_vec();
    let largest = (0..points).map(|row| left[row * points + row]).fold(0.0, f64::max);
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(points) {
        let mut best = (0, 0.0);
        for row in 0..points {
            if left[row * points + row] > best.1 {
                best = (row, left[row * points + row]);
            }
        }
        let (point, variance) = best;
        if !(variance > LEAST * largest) {
            break;
        }
        let column: Vec<f64> = (0..points).map(|row| left[row * points + point]).collect();
        for row in 0..points {
            let share = column[row] / variance;
            left[row * points..(row + 1) * points]
                .iter_mut()
                .zip(&column)
                .for_each(|(value, own)| *value -= share * own);
        }
        chosen.push(point);
    }
    chosen
}

impl Emulator {
    /// With anchors (coordinates of points); their number is that of the error's parts.
    pub fn new(process: Process, factor: f64, anchors: &[Vec<f64>]) -> Self {
        let (m, factored) = (anchors.len(), &process.factored);
        let (_, mut covariance) = process.together(anchors);
        let largest = (0..m).map(|j| covariance[j * m + j]).fold(0.0, f64::max);
        for j in 0..m {
            covariance[j * m + j] += ROUNDING * largest;
        }
        // Anchors that rounding does not tell apart are none: the error is a rest altogether.
        let is_sound = cholesky::factor(&mut covariance, m).is_ok();
        let anchors = if is_sound { anchors.to_vec() } else { Vec::new() };
        let (of_points, of_trend): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
            anchors.iter().map(|anchor| process.whitened(anchor)).unzip();
        let part = |k: usize| {
            // Row k of L^-1: its entry in each column.
            let mut row = vec![0.0; anchors.len()];
            for (j, slot) in row.iter_mut().enumerate() {
                let mut unit = vec![0.0; anchors.len()];
                unit[j] = 1.0;
                cholesky::solve_lower(&covariance, &mut unit);
                *slot = unit[k];
            }
            let sum = |of: &[Vec<f64>], size: usize| {
                let mut sum = vec![0.0; size];
                for (weight, own) in row.iter().zip(of) {
                    sum.iter_mut().zip(own).for_each(|(slot, value)| *slot += weight * value);
                }
                sum
            };
            let mut points = sum(&of_points, process.training().len());
            let mut trend = sum(&of_trend, factored.basis.len());
            cholesky::solve_lower_transposed(&factored.coefficients, &mut trend);
            for (basis, weight) in factored.basis.iter().zip(&trend) {
                points.iter_mut().zip(basis).for_each(|(slot, value)| *slot += weight * value);
            }
            cholesky::solve_lower_transposed(&factored.lower, &mut points);
            points.iter_mut().for_each(|value| *value = -*value);
            Part { anchors: row, points, trend }
        };
        let parts = (0..anchors.len()).map(part).collect();
        Self { process, factor, anchors, parts }
    }

    /// The process.
    pub fn process(&self) -> &Process {
        &self.process
    }

    /// Factor on the process' standard deviation.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// The variance that parts leave to the rest, and what it is made of at most.
    fn rest_square(&self, variance: f64, parts: &[f64]) -> f64 {
        let named = self.process.named();
        let whole = self.factor * self.factor * (variance.max(0.0) + named.scatter);
        let rest = whole - parts.iter().map(|part| part * part).sum::<f64>();
        let largest = self.factor * self.factor * (named.variance + named.scatter);
        if rest > NOTHING * largest { rest } else { 0.0 }
    }

    /// What is expected at points. Cost: a point takes as many operations as half of the square of the values' number.
    pub fn at(&self, points: &[Vec<f64>]) -> Vec<Predicted> {
        points.chunks(LANES).flat_map(|points| self.side_by_side(points)).collect()
    }

    fn side_by_side(&self, points: &[Vec<f64>]) -> Vec<Predicted> {
        let (training, named, factored) = (self.process.training(), self.process.named(), &self.process.factored);
        let n = training.len();
        // Lanes without a point stay 0.
        let mut columns = vec![[0.0_f64; LANES]; n];
        for (i, column) in columns.iter_mut().enumerate() {
            for (slot, point) in column.iter_mut().zip(points) {
                *slot = self.covariance(point, training.point(i)).0;
            }
        }
        let over = |weights: &[f64]| {
            let mut sum = [0.0_f64; LANES];
            for (column, weight) in columns.iter().zip(weights) {
                sum.iter_mut().zip(column).for_each(|(slot, value)| *slot += weight * value);
            }
            sum
        };
        let smooth = over(&factored.weights);
        let of_parts: Vec<[f64; LANES]> = self.parts.iter().map(|part| over(&part.points)).collect();
        for i in 0..n {
            let (before, behind) = columns.split_at_mut(i);
            let Some(own) = behind.first_mut() else { continue };
            let row = &factored.lower[i * n..(i + 1) * n];
            let mut sum = *own;
            for (column, weight) in before.iter().zip(row) {
                sum.iter_mut().zip(column).for_each(|(slot, value)| *slot -= weight * value);
            }
            *own = sum.map(|value| value / row[i]);
        }
        let mut seen = [0.0_f64; LANES];
        for column in &columns {
            seen.iter_mut().zip(column).for_each(|(slot, value)| *slot += value * value);
        }
        let predicted = |(lane, point): (usize, &Vec<f64>)| {
            let basis = self.process.form().trend.at(point);
            let mut unseen = basis.clone();
            for (u, own) in unseen.iter_mut().zip(&factored.basis) {
                *u -= own.iter().zip(&columns).map(|(h, column)| h * column[lane]).sum::<f64>();
            }
            cholesky::solve_lower(&factored.coefficients, &mut unseen);
            let variance = (named.variance - seen[lane]).max(0.0) + dot(&unseen, &unseen);
            let near: Vec<f64> = self.anchors.iter().map(|anchor| self.covariance(point, anchor).0).collect();
            let of_part = |(part, over): (&Part, &[f64; LANES])| {
                self.factor * (dot(&part.anchors, &near) + over[lane] + dot(&part.trend, &basis))
            };
            let parts: Vec<f64> = self.parts.iter().zip(&of_parts).map(of_part).collect();
            let rest = self.rest_square(variance, &parts).sqrt();
            Predicted { mean: dot(&basis, &factored.beta) + smooth[lane], parts, rest }
        };
        points.iter().enumerate().map(predicted).collect()
    }

    /// Covariance of the smooth part at two points, and by what a difference of theirs in squared lengths is to be multiplied for
    /// its slope by the first.
    fn covariance(&self, a: &[f64], b: &[f64]) -> (f64, f64) {
        let named = self.process.named();
        match self.process.form().kernel {
            Some(kernel) => {
                let (value, slope) = kernel.correlation(distance_square(a, b, &named.lengths));
                (named.variance * value, -named.variance * slope)
            }
            None => (0.0, 0.0),
        }
    }

    /// Slopes by the coordinates at a point.
    pub fn slopes(&self, point: &[f64]) -> PredictedSlopes {
        let (training, named, factored) = (self.process.training(), self.process.named(), &self.process.factored);
        let mut expected = self.side_by_side(std::slice::from_ref(&point.to_vec()));
        let Predicted { parts, rest, .. } =
            expected.pop().unwrap_or(Predicted { mean: f64::NAN, parts: Vec::new(), rest: 0.0 });
        let of = |other: &[f64]| self.covariance(point, other).1;
        let near: Vec<f64> = (0..training.len()).map(|i| of(training.point(i))).collect();
        let by_anchor: Vec<f64> = self.anchors.iter().map(|anchor| of(anchor)).collect();
        let is_linear = self.process.form().trend == Trend::Linear;
        let trend =
            |weights: &[f64], axis: usize| if is_linear { weights.get(axis + 1).copied().unwrap_or(0.0) } else { 0.0 };
        // Sum of weights times the slopes of covariances with the points that have values.
        let over = |weights: &[f64], axis: usize, length: f64| -> f64 {
            let slope = |i: usize| weights[i] * near[i] * (point[axis] - training.point(i)[axis]);
            (0..training.len()).map(slope).sum::<f64>() / (length * length)
        };
        let functional = self.process.functional(point);
        let (_, mut unseen) = self.process.whitened(point);
        cholesky::solve_lower_transposed(&factored.coefficients, &mut unseen);
        let mut slopes = PredictedSlopes { mean: Vec::new(), parts: vec![Vec::new(); parts.len()], rest: Vec::new() };
        for (axis, &length) in named.lengths.iter().enumerate() {
            slopes.mean.push(trend(&factored.beta, axis) + over(&factored.weights, axis, length));
            let variance = 2.0 * (trend(&unseen, axis) - over(&functional.weights, axis, length));
            let mut square = self.factor * self.factor * variance;
            for ((part, value), own) in self.parts.iter().zip(&parts).zip(&mut slopes.parts) {
                let anchors = part.anchors.iter().zip(&by_anchor).zip(&self.anchors);
                let of_anchor = |((weight, slope), anchor): ((&f64, &f64), &Vec<f64>)| {
                    weight * slope * (point[axis] - anchor[axis]) / (length * length)
                };
                let anchors: f64 = anchors.map(of_anchor).sum();
                let slope = self.factor * (anchors + over(&part.points, axis, length) + trend(&part.trend, axis));
                square -= 2.0 * value * slope;
                own.push(slope);
            }
            slopes.rest.push(if rest > 0.0 { square / (2.0 * rest) } else { 0.0 });
        }
        slopes
    }
}
