//! Least squares between bounds, on products: the least `x' H x - 2 b' x` for `lower <= x <= upper`.
//!
//! A primal active-set method (Stark & Parker 1995, Bounded-variable least squares; Lawson & Hanson 1974, chapter 23):
//! every iterate is inside the bounds and none is worse than the one before, so that an answer cut off is still a valid one.

use crate::math::cholesky;

/// Added to each diagonal element, as a share of it: where the data do not decide, the shortest step is taken.
const RIDGE: f64 = 1e-12;
/// A multiplier counts as wrong beyond this, in units of the column's length times that of the data.
const TOLERANCE: f64 = 1e-9;

/// Where a variable stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Between its bounds.
    Free,
    /// At its lower bound, which the minimum presses on.
    AtLower,
    /// At its upper bound.
    AtUpper,
}

/// A minimum between bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The variables.
    pub x: Vec<f64>,
    /// Where each stands.
    pub places: Vec<Place>,
    /// `2 b' x - x' H x`, at least 0: the fall of the sum of squares from `x = 0`.
    pub fall: f64,
    /// Whether the conditions of a minimum hold (else the limit of steps was met, and a better point may exist).
    pub converged: bool,
}

/// The minimum, from `x = 0`, which must lie between the bounds, with a first guess of who stands where.
///
/// `h` is symmetric and positive semi-definite, n x n, row after row. A variable that is guessed to stand at a bound must
/// have it at 0. Cost: some n^3 / 3 operations for each change of a place.
pub fn minimise(h: &[f64], b: &[f64], lower: &[f64], upper: &[f64], places: &[Place]) -> Minimum {
    let n = b.len();
    let mut state = State {
        n,
        h,
        b,
        x: vec![0.0; n],
        places: places.to_vec(),
        fixed: (0..n).map(|i| !(upper[i] > lower[i]) || !(h[i * n + i] > 0.0)).collect(),
    };
    let largest = (0..n).filter(|&i| h[i * n + i] > 0.0).map(|i| b[i].abs() / h[i * n + i].sqrt()).fold(0.0, f64::max);
    let mut converged = false;
    // The variable released last: pushed straight back by rounding, it must not be released again at this point.
    let mut released: Option<usize> = None;
    let mut refused = vec![false; n];
    for _ in 0..20 + 6 * n {
        let free: Vec<usize> = (0..n).filter(|&i| state.places[i] == Place::Free && !state.fixed[i]).collect();
        let Some(target) = state.solve(&free) else { break };
        let (mut share, mut blocking) = (1.0, None);
        for (&i, &to) in free.iter().zip(&target) {
            let bound = if to < lower[i] {
                lower[i]
            } else if to > upper[i] {
                upper[i]
            } else {
                continue;
            };
            let part = (bound - state.x[i]) / (to - state.x[i]);
            if part < share {
                (share, blocking) = (part.max(0.0), Some((i, bound)));
            }
        }
        for (&i, &to) in free.iter().zip(&target) {
            let step = share * (to - state.x[i]);
            state.x[i] = (state.x[i] + step).max(lower[i]).min(upper[i]);
        }
        if let Some((i, bound)) = blocking {
            state.x[i] = bound;
            state.places[i] = if bound == lower[i] { Place::AtLower } else { Place::AtUpper };
            if released == Some(i) && share == 0.0 {
                refused[i] = true;
            }
            if share > 0.0 {
                refused.fill(false);
            }
            continue;
        }
        // The multipliers of those at their bounds.
        let (mut worst, mut release) = (TOLERANCE * largest, None);
        for i in (0..n).filter(|&i| state.places[i] != Place::Free && !state.fixed[i] && !refused[i]) {
            let pull = state.pull(i) / h[i * n + i].sqrt();
            let inwards = if state.places[i] == Place::AtLower { pull } else { -pull };
            if inwards > worst {
                (worst, release) = (inwards, Some(i));
            }
        }
        let Some(i) = release else {
            converged = true;
            break;
        };
        state.places[i] = Place::Free;
        released = Some(i);
    }
    let fall: f64 = (0..n).map(|i| state.x[i] * (b[i] + state.pull(i))).sum();
    Minimum { x: state.x, places: state.places, fall: fall.max(0.0), converged }
}

struct State<'a> {
    n: usize,
    h: &'a [f64],
    b: &'a [f64],
    x: Vec<f64>,
    places: Vec<Place>,
    fixed: Vec<bool>,
}

impl State<'_> {
    /// Half the slope downwards: `b - H x`.
    fn pull(&self, i: usize) -> f64 {
        let row = &self.h[i * self.n..(i + 1) * self.n];
        self.b[i] - row.iter().zip(&self.x).map(|(h, x)| h * x).sum::<f64>()
    }

    /// The minimum over the free variables with the others where they are.
    fn solve(&self, free: &[usize]) -> Option<Vec<f64>> {
        let (n, k) = (self.n, free.len());
        let scale: Vec<f64> = free.iter().map(|&i| 1.0 / self.h[i * n + i].sqrt()).collect();
        let mut factor = vec![0.0; k * k];
        for (row, &i) in free.iter().enumerate() {
            for (column, &j) in free[..=row].iter().enumerate() {
                factor[row * k + column] = self.h[i * n + j] * scale[row] * scale[column];
            }
            factor[row * k + row] += RIDGE;
        }
        // Steps from where they are: the ridge then pulls towards the point reached.
        let mut step: Vec<f64> = free.iter().zip(&scale).map(|(&i, s)| s * self.pull(i)).collect();
        let mut ridge = 10.0 * RIDGE;
        let diagonal: Vec<f64> = factor.clone();
        while cholesky::factor(&mut factor, k).is_err() {
            if !(ridge < 1e-3) {
                return None;
            }
            factor.copy_from_slice(&diagonal);
            (0..k).for_each(|i| factor[i * k + i] += ridge);
            ridge *= 10.0;
        }
        cholesky::solve(&factor, &mut step);
        Some(free.iter().zip(&scale).zip(&step).map(|((&i, s), step)| self.x[i] + s * step).collect())
    }
}
