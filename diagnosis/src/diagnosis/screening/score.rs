//! How much a direction would lower the sum of squares of a bounded fit, and what the data can see of it.
//!
//! The likelihood ratio of a direction `g` with the amplitude `a` is
//! `min over d of |r - J d|^2  -  min over (d, a) of |r - J d - g a|^2`, all between their bounds (bounded: [`crate::diagnosis::linearisation::bounded`]).
//! With `P` the projection on the columns of the parameters that are free at the fit, and `g~ = (I - P) g`, the free problem
//! has the amplitude `a^ = g~'r / |g~|^2` of standard deviation `1 / |g~|` and the score `z = g~'r / |g~|`, `z^2` being its
//! likelihood ratio (Rao 1948). A parameter that the data press against a bound is not free: `P` leaves it out.
//! Of directions with several columns: `multi_column`.

use crate::diagnosis::linearisation::bounded::{Minimum, Place, minimise};
use crate::diagnosis::{Direction, Linear};
use crate::inference::null_maximum::Side;
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::sqrt;
use crate::math::scalar_products::{add_scaled, orthonormal, project_out};
use crate::math::special::{normal_cdf, normal_quantile, normal_quantile_of_ln};
use crate::watch;

/// A direction keeps at least this share of its square after the refit, or the data do not see it.
pub const SMALLEST_SHARE: f64 = 1e-6;
/// The largest plausible amplitude, in plausible ones.
pub const LARGEST_PLAUSIBLE: f64 = 3.0;
/// A column of `J` whose remainder is shorter than this share of it depends on the others.
const DEPENDENT: f64 = 1e-9;

/// A parameter that the data press against a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Pinned {
    /// Its position among the columns of `J`.
    pub parameter: usize,
    /// Whether the bound is the lower one.
    pub at_lower: bool,
    /// How strongly, in standard deviations: the root of the fall of the sum of squares were this bound released.
    pub pressure: f64,
}

/// A linear problem, prepared for many directions.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Times its plausible size by which an effect must show.
    pub(crate) largest: f64,
    pub(crate) rows: usize,
    pub(crate) readings: usize,
    /// Residuals at the bounded minimum, orthogonal to the free columns.
    pub(crate) residuals: Vec<f64>,
    /// Orthonormal columns: those of the free parameters, then what the pinned ones add.
    pub(crate) basis: Vec<f64>,
    /// Number of the former.
    pub(crate) free_rank: usize,
    step: Vec<f64>,
    places: Vec<Place>,
    pinned: Vec<Pinned>,
    /// Column of the parameter behind each column of the basis.
    behind: Vec<usize>,
    /// `basis' J`, by parameter.
    triangle: Vec<f64>,
    /// `J'J`, `J'r`.
    normal: Vec<f64>,
    slope: Vec<f64>,
    /// `J`, column by column.
    jacobian: Vec<f64>,
    /// Bounds of the step that is left.
    lower: Vec<f64>,
    upper: Vec<f64>,
    chi_square: f64,
    fall: f64,
}

/// What the data say of a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Position of the effect's candidate in the problem's list.
    pub candidate: usize,
    /// Whether the data can see it. Where not, the likelihood ratio is 0 and the probability 1.
    pub seen: bool,
    /// `|g~|^2 / |g|^2`: what the refit leaves of it (of the sum of squares of all its columns).
    pub share: f64,
    /// The fall of the (penalised) sum of squares between the bounds.
    pub likelihood_ratio: f64,
    /// The same without any bounds but those that the fit is held at: `z^2` or the sum of `w x^2`.
    pub free_ratio: f64,
    /// One column: the score with its sign. Several: the root of the free ratio.
    pub z: f64,
    /// Amplitudes without bounds, SI (penalised for several columns).
    pub amplitudes: Vec<f64>,
    /// Their standard deviations, SI (given the data, for several columns).
    pub sds: Vec<f64>,
    /// Freedom spent: 1, or the sum of the weights.
    pub freedom: f64,
    /// Probability of a larger statistic where nothing is missing: one-sided where a bound allows only one sign of the
    /// amplitude, two-sided else.
    pub p: f64,
    /// The standard normal number exceeded with that probability: comparable between directions of all kinds.
    pub equivalent: f64,
}

/// A column with what holds its amplitude.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// By row.
    pub values: &'a [f64],
    /// Lower bound of the amplitude, at most 0.
    pub lower: f64,
    /// Upper bound, at least 0.
    pub upper: f64,
    /// One over the square of its prior standard deviation; 0 without a prior.
    pub precision: f64,
}

impl Prepared {
    /// Takes the bounded least-squares step from the linearisation (next to none at a fit), finds who is free, and
    /// factorises. Cost: rows x parameters^2.
    pub fn new(linear: &Linear) -> Self {
        let (rows, p) = (linear.rows, linear.parameters());
        let mut jacobian = vec![0.0; rows * p];
        for (row, values) in linear.jacobian.chunks_exact(p.max(1)).enumerate().take(rows) {
            for (k, &value) in values.iter().enumerate() {
                jacobian[k * rows + row] = value;
            }
        }
        let column = |k: usize| &jacobian[k * rows..(k + 1) * rows];
        let mut normal = vec![0.0; p * p];
        for i in 0..p {
            for k in 0..=i {
                let product = dot(column(i), column(k));
                (normal[i * p + k], normal[k * p + i]) = (product, product);
            }
        }
        let slope: Vec<f64> = (0..p).map(|k| dot(column(k), &linear.residuals)).collect();
        let lower: Vec<f64> = linear.lower.iter().map(|x| x.min(0.0)).collect();
        let upper: Vec<f64> = linear.upper.iter().map(|x| x.max(0.0)).collect();
        let Minimum { x: mut step, places, .. } = minimise(&normal, &slope, &lower, &upper, &vec![Place::Free; p]);
        let mut residuals = linear.residuals.clone();
        for k in 0..p {
            add_scaled(&mut residuals, -step[k], column(k));
        }
        let movable = |k: usize| upper[k] > lower[k];
        let free: Vec<usize> = (0..p).filter(|&k| places[k] == Place::Free && movable(k)).collect();
        let held: Vec<usize> = (0..p).filter(|&k| places[k] != Place::Free && movable(k)).collect();
        let of = |list: &[usize]| -> Vec<&[f64]> { list.iter().map(|&k| column(k)).collect() };
        let (basis, chosen) = orthonormal(&of(&free), Vec::new(), DEPENDENT);
        let mut behind: Vec<usize> = chosen.iter().map(|&place| free[place]).collect();
        let free_rank = behind.len();
        // What rounding (and the ridge of the step) left along the free columns.
        project_out(&mut residuals, &basis);
        let mut pinned = Vec::new();
        for &parameter in &held {
            let mut left = column(parameter).to_vec();
            project_out(&mut left, &basis);
            let square = dot(&left, &left);
            let at_lower = places[parameter] == Place::AtLower;
            if square > DEPENDENT * normal[parameter * p + parameter] {
                let pull = dot(&left, &residuals) / sqrt(square);
                pinned.push(Pinned { parameter, at_lower, pressure: if at_lower { -pull } else { pull } });
            }
        }
        let (basis, chosen) = orthonormal(&of(&held), basis, DEPENDENT);
        behind.extend(chosen.iter().map(|&place| held[place]));
        let triangle: Vec<f64> = (0..p)
            .flat_map(|k| basis.chunks_exact(rows.max(1)).map(move |q| (q, k)))
            .map(|(q, k)| dot(q, column(k)))
            .collect();
        for k in 0..p {
            step[k] = step[k].max(lower[k]).min(upper[k]);
        }
        let at = |bounds: &[f64]| -> Vec<f64> { bounds.iter().zip(&step).map(|(b, s)| b - s).collect() };
        let chi_square = dot(&residuals, &residuals);
        Self {
            largest: LARGEST_PLAUSIBLE,
            rows,
            readings: linear.readings,
            slope: (0..p).map(|k| dot(column(k), &residuals)).collect(),
            lower: at(&lower),
            upper: at(&upper),
            fall: dot(&linear.residuals, &linear.residuals) - chi_square,
            chi_square,
            residuals,
            basis,
            free_rank,
            step,
            places,
            pinned,
            behind,
            triangle,
            normal,
            jacobian,
        }
    }

    /// Sum of squares at the bounded minimum.
    pub fn chi_square(&self) -> f64 {
        self.chi_square
    }

    /// By how much the step to it lowered the sum: well below 1 where the linearisation was made at a fit.
    pub fn fall(&self) -> f64 {
        self.fall
    }

    /// The step to it.
    pub fn step(&self) -> &[f64] {
        &self.step
    }

    /// Rows less free parameters (those that the rows determine).
    pub fn freedom(&self) -> usize {
        self.rows.saturating_sub(self.free_rank)
    }

    /// The parameters that are pressed against a bound.
    pub fn pinned(&self) -> &[Pinned] {
        &self.pinned
    }

    /// Residuals at the minimum.
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Orthonormal columns of the free parameters.
    pub(crate) fn free_basis(&self) -> &[f64] {
        &self.basis[..self.free_rank * self.rows]
    }

    /// A column of `J`.
    pub(crate) fn parameter(&self, k: usize) -> &[f64] {
        &self.jacobian[k * self.rows..(k + 1) * self.rows]
    }

    /// A column less its components along the columns of the free parameters.
    pub fn project(&self, column: &[f64]) -> Vec<f64> {
        let mut left = column.to_vec();
        project_out(&mut left, self.free_basis());
        left
    }

    /// The score of a direction. Cost: rows x parameters for one column, unless bounds come into play.
    pub fn score(&self, direction: &Direction) -> Score {
        watch::check();
        if direction.amplitudes() == 1 { self.score_single(direction) } else { self.score_several(direction) }
    }

    fn score_single(&self, direction: &Direction) -> Score {
        let g = direction.column(0);
        let square = dot(g, g);
        let along: Vec<f64> = self.basis.chunks_exact(self.rows.max(1)).map(|q| dot(q, g)).collect();
        let mut left = square - along[..self.free_rank].iter().map(|c| c * c).sum::<f64>();
        let mut product = dot(g, &self.residuals);
        if !(left > 1e-3 * square) {
            // The difference has lost digits.
            let projected = self.project(g);
            left = dot(&projected, &projected);
            product = dot(&projected, &self.residuals);
        }
        let share = if square > 0.0 { left / square } else { 0.0 };
        let norm = sqrt(left);
        if !(share >= SMALLEST_SHARE) || !(self.largest * direction.plausible[0] * norm >= 1.0) || !norm.is_finite() {
            return Score::unseen(direction, share);
        }
        let z = product / norm;
        let (lower, upper) = (direction.lower[0].min(0.0), direction.upper[0].max(0.0));
        let amplitude = product / left;
        let side = Side::of(lower, upper);
        let ratio = if side.fold(z) <= 0.0 {
            // The sum of squares is convex: its slope at amplitude 0 leads out of the bounds.
            0.0
        } else if lower <= amplitude && amplitude <= upper && self.stays(&along, amplitude) {
            z * z
        } else {
            self.fit(&[Column { values: g, lower, upper, precision: 0.0 }]).fall
        };
        let folded = side.fold(z);
        let statistic = if folded > 0.0 { folded.min(sqrt(ratio)) } else { folded };
        let p = side.probability(statistic, |x| normal_cdf(-x));
        Score {
            candidate: direction.candidate,
            seen: true,
            share,
            likelihood_ratio: ratio,
            free_ratio: z * z,
            z,
            amplitudes: vec![amplitude],
            sds: vec![1.0 / norm],
            freedom: 1.0,
            p,
            equivalent: equivalent(side, statistic, p),
        }
    }

    /// Whether the free fit with this amplitude stays between the bounds and leaves the pinned parameters pinned.
    fn stays(&self, along: &[f64], amplitude: f64) -> bool {
        let (p, rank) = (self.slope.len(), self.behind.len());
        let free = self.free_rank;
        let moves = |k: &usize| self.upper[*k] > self.lower[*k] && self.normal[k * p + k] > 0.0;
        if free < (0..p).filter(moves).filter(|&k| self.places[k] == Place::Free).count() {
            // Columns that depend on each other share their steps in many ways: one of them may be inside the bounds.
            return false;
        }
        // Back-substitution in the columns' order.
        let mut change: Vec<f64> = along[..free].iter().map(|c| -c * amplitude).collect();
        for i in (0..free).rev() {
            for k in i + 1..free {
                change[i] -= self.triangle[self.behind[k] * rank + i] * change[k];
            }
            change[i] /= self.triangle[self.behind[i] * rank + i];
            let k = self.behind[i];
            if !(self.lower[k] <= change[i] && change[i] <= self.upper[k]) {
                return false;
            }
        }
        (0..p).filter(|&k| self.places[k] != Place::Free && self.upper[k] > self.lower[k]).all(|k| {
            let tilted: f64 = (free..rank).map(|i| self.triangle[k * rank + i] * along[i]).sum();
            let pull = self.slope[k] - amplitude * tilted;
            if self.places[k] == Place::AtLower { pull <= 0.0 } else { pull >= 0.0 }
        })
    }

    /// The fit with columns added, all between their bounds: amplitudes are the last variables of the minimum. Its fall is
    /// of the penalised sum of squares, from the fit without them.
    pub fn fit(&self, columns: &[Column<'_>]) -> Minimum {
        let (p, k) = (self.slope.len(), columns.len());
        let n = p + k;
        let mut h = vec![0.0; n * n];
        for i in 0..p {
            h[i * n..i * n + p].copy_from_slice(&self.normal[i * p..(i + 1) * p]);
        }
        let (mut b, mut lower, mut upper) = (self.slope.clone(), self.lower.clone(), self.upper.clone());
        let mut places = self.places.clone();
        for (a, column) in columns.iter().enumerate() {
            let row = p + a;
            for i in 0..p {
                let product = dot(self.parameter(i), column.values);
                (h[row * n + i], h[i * n + row]) = (product, product);
            }
            for (other, second) in columns[..=a].iter().enumerate() {
                let product = dot(column.values, second.values);
                (h[row * n + p + other], h[(p + other) * n + row]) = (product, product);
            }
            h[row * n + row] += column.precision;
            b.push(dot(column.values, &self.residuals));
            lower.push(column.lower.min(0.0));
            upper.push(column.upper.max(0.0));
            places.push(Place::Free);
        }
        // At the fit the free parameters have no slope left; rounding must not make them one.
        for i in 0..p {
            if self.places[i] == Place::Free {
                b[i] = 0.0;
            }
        }
        minimise(&h, &b, &lower, &upper, &places)
    }
}

/// The standard normal number exceeded with the probability, without underflow for one column.
fn equivalent(side: Side, statistic: f64, p: f64) -> f64 {
    if side != Side::Two {
        return statistic;
    }
    if statistic < 30.0 {
        return -normal_quantile(p.clamp(1e-300, 1.0 - 1e-16));
    }
    -normal_quantile_of_ln(std::f64::consts::LN_2 + crate::math::special::ln_normal_cdf(-statistic))
}

impl Score {
    pub(crate) fn unseen(direction: &Direction, share: f64) -> Self {
        Self {
            candidate: direction.candidate,
            seen: false,
            share,
            likelihood_ratio: 0.0,
            free_ratio: 0.0,
            z: 0.0,
            amplitudes: vec![0.0; direction.amplitudes()],
            sds: direction.plausible.clone(),
            freedom: 0.0,
            p: 1.0,
            equivalent: -normal_quantile(1.0 - 1e-16),
        }
    }
}
