//! Minimum of `|r(x)|^2 / 2 + penalty(x)` within bounds: Levenberg-Marquardt on the residuals with their exact Jacobian
//! (Marquardt 1963; damping after Madsen, Nielsen & Tingleff 2004; scaling after More 1978), steps cut at the bounds,
//! followed by Newton steps with a Hessian by differences of the gradient where the penalty is curved.
//!
//! Where slopes are costly, what the Jacobian alone does not tell of the curvature is learned on the way by a secant update,
//! and enters the steps while it predicts them better (Dennis, Gay & Welsch 1981, ACM TOMS 7, 348): large residuals would
//! otherwise make the steps swing about the minimum.

use nalgebra::{DMatrix, DVector};

use crate::math::cholesky;
use crate::math::dense::square;

/// An objective. Evaluations answer `None` where there is no value; such steps are shortened.
pub trait Objective {
    /// Number of variables.
    fn dimension(&self) -> usize;

    /// Number of residuals.
    fn rows(&self) -> usize;

    /// Writes the residuals and returns the penalty.
    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64>;

    /// The same, with the Jacobian (`rows x dimension`, row by row) and the penalty's gradient.
    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64>;
}

/// Bounds; infinite where there are none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

/// When a descent ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Most steps.
    pub most_iterations: u64,
    /// A step that lowers the objective by less, as predicted, is the last one; 0 for the precision of the arithmetic.
    pub least_gain: f64,
    /// An objective that an end of any use lies below; infinite where there is none. Where slopes are costly, a descent that
    /// does not lead there is left before its end.
    pub ceiling: f64,
}

/// Where a descent ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The point.
    pub x: Vec<f64>,
    /// The objective there.
    pub value: f64,
    /// Residuals there.
    pub residuals: Vec<f64>,
    /// Jacobian there.
    pub jacobian: Vec<f64>,
    /// Gradient of the objective there.
    pub gradient: Vec<f64>,
    /// Whether the penalty had a slope on the way, so that the Jacobian alone does not tell the curvature.
    pub penalised: bool,
    /// Steps taken.
    pub iterations: u64,
    /// Whether the steps became negligible, rather than ran out.
    pub converged: bool,
}

/// Least gain above which slopes are taken for costly: up to it a descent ends with Newton steps, each of which takes as many
/// slopes as there are variables, twice.
pub const COSTLY: f64 = 1e-4;

/// Share of the height above a known minimum or the ceiling; steps that are predicted to gain less do not lead below it.
const HOPELESS: f64 = 0.01;
/// Such steps in a row after which a descent is left.
const MOST_HOPELESS: u32 = 2;
/// Share of the height above a known minimum within which the linear residuals must predict it to lead there.
const SAME: f64 = 0.02;

/// Least gain above which slopes are taken for rough, as those of a record that are found on fewer rows: near the minimum no step
/// along them descends.
pub const ROUGH: f64 = 1e-2;
/// Times the least gain: an undamped step that is predicted to gain less starts so near a minimum that a parabola holds along it.
const NEAR: f64 = 10.0;
/// So small a damping that it shortens no step.
const UNDAMPED: f64 = 1e-12;
/// The nearer the lowest point of the parabola, as a share of the step, the more damping grows; below this share no more.
const LEAST_SHARE: f64 = 0.25;

/// Rows up to which a least-squares problem is made triangular at once.
const FEW_ROWS: usize = 8192;
/// Rows of longer ones that are taken together: they stay in the processor's cache.
const ROWS_TOGETHER: usize = 512;

struct Linearised {
    residuals: Vec<f64>,
    jacobian: Vec<f64>,
    penalty_gradient: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
}

fn linearise<O: Objective>(objective: &mut O, x: &[f64]) -> Option<Linearised> {
    let (n, m) = (objective.dimension(), objective.rows());
    let mut at = Linearised {
        residuals: vec![0.0; m],
        jacobian: vec![0.0; m * n],
        penalty_gradient: vec![0.0; n],
        gradient: vec![0.0; n],
        value: 0.0,
    };
    let penalty = objective.slopes(x, &mut at.residuals, &mut at.jacobian, &mut at.penalty_gradient)?;
    at.gradient.copy_from_slice(&at.penalty_gradient);
    for (row, r) in at.jacobian.chunks_exact(n).zip(&at.residuals) {
        for (g, j) in at.gradient.iter_mut().zip(row) {
            *g += r * j;
        }
    }
    at.value = half_square(&at.residuals) + penalty;
    (at.value.is_finite() && at.gradient.iter().all(|g| g.is_finite())).then_some(at)
}

fn half_square(residuals: &[f64]) -> f64 {
    0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
}

/// Descends from a start (moved into the bounds). `None` where the start has no value.
pub fn minimise<O: Objective>(objective: &mut O, start: &[f64], bounds: &Bounds, effort: Effort) -> Option<Minimum> {
    minimise_beside(objective, start, bounds, effort, None)
}

/// The same beside a minimum that is known: where slopes are costly, a descent that leads to it, or nowhere lower, is left
/// before its end.
pub fn minimise_beside<O: Objective>(
    objective: &mut O,
    start: &[f64],
    bounds: &Bounds,
    effort: Effort,
    known: Option<&Minimum>,
) -> Option<Minimum> {
    let is_costly = effort.least_gain > COSTLY;
    let is_rough = effort.least_gain > ROUGH;
    let known = known.filter(|_| is_costly);
    let aim =
        if is_costly { known.map_or(effort.ceiling, |known| known.value.min(effort.ceiling)) } else { f64::INFINITY };
    let n = objective.dimension();
    let mut x: Vec<f64> = (0..n).map(|i| start[i].max(bounds.lower[i]).min(bounds.upper[i])).collect();
    let mut at = linearise(objective, &x)?;
    let mut trial_residuals = vec![0.0; objective.rows()];
    let mut scale = vec![0.0_f64; n];
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut penalised = false;
    let (mut iterations, mut converged, mut small_gains) = (0, false, 0);
    let mut hopeless = 0;
    let mut descends = false;
    // Steps from here that did not descend, and what one without damping was predicted to gain.
    let (mut rejected, mut promised) = (0, 0.0);
    let mut second_order = is_costly.then(|| SecondOrder::new(n));
    while iterations < effort.most_iterations && !converged {
        iterations += 1;
        penalised |= at.penalty_gradient.iter().any(|g| *g != 0.0);
        let mut squares = vec![0.0; n];
        for row in at.jacobian.chunks_exact(n) {
            squares.iter_mut().zip(row).for_each(|(square, j)| *square += j * j);
        }
        for (i, s) in scale.iter_mut().enumerate() {
            let norm = squares[i].sqrt();
            // What changes nothing over its whole range, as a threshold between two levels of the data, is to stay where
            // it is: scaled by its own vanishing slope alone it would run to a bound, and take the other steps with it.
            *s = norm.max(1.0 / (bounds.upper[i] - bounds.lower[i])).max(f64::MIN_POSITIVE.sqrt());
        }
        let free = free_variables(&x, &at.gradient, bounds);
        if free.is_empty() {
            converged = true;
            break;
        }
        let of_second_order = second_order
            .as_ref()
            .filter(|own| own.is_used)
            .and_then(|own| own.step(&at, &free, &scale, damping, &x, bounds));
        let Some((step, predicted)) = of_second_order.or_else(|| damped_step(&at, &free, &scale, damping, &x, bounds))
        else {
            damping = damping.max(1e-12) * growth;
            growth *= 2.0;
            continue;
        };
        hopeless = if predicted < HOPELESS * (at.value - aim) { hopeless + 1 } else { 0 };
        if hopeless > MOST_HOPELESS || known.is_some_and(|known| at.leads_to(&x, known)) {
            break;
        }
        // Rounding must not take a step to a bound beyond it.
        let trial: Vec<f64> = (0..n).map(|i| (x[i] + step[i]).max(bounds.lower[i]).min(bounds.upper[i])).collect();
        if is_costly && predicted < effort.least_gain && (rejected == 0 || !is_rough) {
            // So near that the linear model tells what is there.
            at.advance(&step, predicted);
            x = trial;
            converged = true;
            break;
        }
        let negligible = x.iter().zip(&step).all(|(x, s)| s.abs() <= 1e-14 * x.abs());
        // After a step that was taken the next one most likely is: then its slopes are wanted at once.
        let at_once = if descends { linearise(objective, &trial) } else { None };
        let value = match &at_once {
            Some(next) => next.value,
            None if descends => f64::INFINITY,
            None => objective
                .value(&trial, &mut trial_residuals)
                .map_or(f64::INFINITY, |penalty| half_square(&trial_residuals) + penalty),
        };
        let gain = at.value - value;
        descends = gain > 0.0 && gain >= 1e-4 * predicted;
        if descends {
            let Some(next) = at_once.or_else(|| linearise(objective, &trial)) else {
                descends = false;
                damping *= growth;
                growth *= 2.0;
                continue;
            };
            // Twice in a row, lest one lucky step near a plateau end the descent.
            small_gains = if gain <= 1e-14 * at.value.abs() { small_gains + 1 } else { 0 };
            converged = small_gains >= 2 || gain.max(predicted) < effort.least_gain;
            if let Some(second_order) = &mut second_order {
                second_order.learn(&at, &next, &x, &trial);
            }
            at = next;
            x = trial;
            rejected = 0;
            let ratio = 2.0 * gain / predicted - 1.0;
            damping = (damping * (1.0 - ratio * ratio * ratio).max(1.0 / 3.0)).max(1e-20);
            growth = 2.0;
        } else {
            // Nothing to gain within rounding, or no room left for a shorter step.
            let least = f64::max(1e-15 * at.value.abs(), 1e-3 * effort.least_gain);
            converged = negligible || predicted <= least || damping > 1e30;
            if is_rough {
                if rejected == 0 {
                    // Damping makes any step's promise small.
                    let whole = damped_step(&at, &free, &scale, UNDAMPED, &x, bounds);
                    promised = whole.map_or(f64::INFINITY, |(_, predicted)| predicted);
                }
                rejected += 1;
                if value.is_finite() {
                    // The parabola with this slope through the point that was tried.
                    let along = -at.gradient.iter().zip(&step).map(|(g, s)| g * s).sum::<f64>();
                    let share = 0.5 * along / (along - gain);
                    converged |= promised <= NEAR * effort.least_gain && 0.5 * share * along < effort.least_gain;
                    damping /= share.clamp(LEAST_SHARE, 1.0);
                }
            }
            damping *= growth;
            growth *= 2.0;
        }
    }
    if penalised && !is_costly {
        (x, at) = polish(objective, x, at, bounds);
    }
    Some(Minimum {
        x,
        value: at.value,
        residuals: at.residuals,
        jacobian: at.jacobian,
        gradient: at.gradient,
        penalised,
        iterations,
        converged,
    })
}

/// Variables that are not held at a bound by the gradient.
pub fn free_variables(x: &[f64], gradient: &[f64], bounds: &Bounds) -> Vec<usize> {
    let held =
        |i: usize| (x[i] <= bounds.lower[i] && gradient[i] > 0.0) || (x[i] >= bounds.upper[i] && gradient[i] < 0.0);
    (0..x.len()).filter(|&i| !held(i)).collect()
}

/// The damped step of the free variables by QR, cut at the bounds, and the decrease that the linear model predicts.
fn damped_step(
    at: &Linearised,
    free: &[usize],
    scale: &[f64],
    damping: f64,
    x: &[f64],
    bounds: &Bounds,
) -> Option<(Vec<f64>, f64)> {
    let k = free.len();
    let (stacked, side) = condensed(at, free, scale);
    let m = stacked.nrows();
    let mut stacked = stacked.resize_vertically(m + k, 0.0);
    for column in 0..k {
        stacked[(m + column, column)] = damping.sqrt();
    }
    let (r, mut right) = triangular(stacked, side.resize_vertically(m + k, 0.0));
    if at.penalty_gradient.iter().any(|g| *g != 0.0) {
        let pull = DVector::from_fn(k, |row, _| at.penalty_gradient[free[row]] / scale[free[row]]);
        right -= r.tr_solve_upper_triangular(&pull)?;
    }
    let solution = r.solve_upper_triangular(&right)?;
    let step = cut(solution.as_slice(), free, scale, x, bounds);
    let model = at.predicted(&step);
    (step.iter().all(|s| s.is_finite()) && model > 0.0).then_some((step, model))
}

/// Rows of the scaled free columns, and the negative residuals, that have the least-squares solutions of all: these where they are
/// few, else a triangle that grows block by block (Golub & Van Loan 2013, section 5.2.2; Demmel et al. 2012, SIAM J. Sci. Comput. 34,
/// A206).
fn condensed(at: &Linearised, free: &[usize], scale: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let (n, k) = (at.gradient.len(), free.len());
    let is_long = at.residuals.len() > FEW_ROWS;
    let together = if is_long { ROWS_TOGETHER } else { at.residuals.len().max(1) };
    let (mut matrix, mut side) = (DMatrix::zeros(0, k), DVector::zeros(0));
    for (jacobian, residuals) in at.jacobian.chunks(together * n).zip(at.residuals.chunks(together)) {
        let above = matrix.nrows();
        matrix = matrix.resize_vertically(above + residuals.len(), 0.0);
        side = side.resize_vertically(above + residuals.len(), 0.0);
        for (row, values) in jacobian.chunks_exact(n).enumerate() {
            for (column, &i) in free.iter().enumerate() {
                // Columns are divided by their scales, so that the factor is as well conditioned as it can be.
                matrix[(above + row, column)] = values[i] / scale[i];
            }
            side[above + row] = -residuals[row];
        }
        if is_long {
            (matrix, side) = triangular(matrix, side);
        }
    }
    (matrix, side)
}

/// The triangle of a matrix and the right side that goes with it.
fn triangular(matrix: DMatrix<f64>, mut side: DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let rows = matrix.nrows().min(matrix.ncols());
    let qr = matrix.qr();
    qr.q_tr_mul(&mut side);
    (qr.r(), side.resize_vertically(rows, 0.0))
}

/// A step of the scaled free variables as one of all variables, cut at the bounds.
fn cut(solution: &[f64], free: &[usize], scale: &[f64], x: &[f64], bounds: &Bounds) -> Vec<f64> {
    let mut step = vec![0.0; x.len()];
    for (column, &i) in free.iter().enumerate() {
        let wanted = x[i] + solution[column] / scale[i];
        step[i] = wanted.max(bounds.lower[i]).min(bounds.upper[i]) - x[i];
    }
    step
}

impl Linearised {
    /// Whether a minimum lies where, and as deep as, the linear residuals say.
    fn leads_to(&self, x: &[f64], known: &Minimum) -> bool {
        let depth = self.value - known.value;
        let way: Vec<f64> = known.x.iter().zip(x).map(|(to, from)| to - from).collect();
        let predicted = self.predicted(&way);
        depth > 0.0 && (predicted - depth).abs() < SAME * depth
    }

    /// Goes a step on as far as the linear residuals tell; `gain` is by how much the objective falls.
    fn advance(&mut self, step: &[f64], gain: f64) {
        for (row, residual) in self.jacobian.chunks_exact(step.len()).zip(&mut self.residuals) {
            let along: f64 = row.iter().zip(step).map(|(j, s)| j * s).sum();
            *residual += along;
            self.gradient.iter_mut().zip(row).for_each(|(g, j)| *g += j * along);
        }
        self.value -= gain;
    }

    /// By how much a step lowers the objective according to the linear residuals.
    fn predicted(&self, step: &[f64]) -> f64 {
        let mut model = 0.0;
        for (row, residual) in self.jacobian.chunks_exact(step.len()).zip(&self.residuals) {
            let along: f64 = row.iter().zip(step).map(|(j, s)| j * s).sum();
            model -= along * (residual + 0.5 * along);
        }
        model - self.penalty_gradient.iter().zip(step).map(|(g, s)| g * s).sum::<f64>()
    }
}

/// Curvature of the objective beyond that of the linear residuals: `sum r_i r_i''` and the penalty's.
struct SecondOrder {
    matrix: DMatrix<f64>,
    /// Whether it predicted the last step better than the linear residuals alone.
    is_used: bool,
}

impl SecondOrder {
    fn new(n: usize) -> Self {
        Self { matrix: DMatrix::zeros(n, n), is_used: false }
    }

    /// The damped step with it; `None` where the curvature is not positive.
    fn step(
        &self,
        at: &Linearised,
        free: &[usize],
        scale: &[f64],
        damping: f64,
        x: &[f64],
        bounds: &Bounds,
    ) -> Option<(Vec<f64>, f64)> {
        let n = x.len();
        // All products in one pass: a long Jacobian does not stay in the processor's cache.
        let mut products = vec![0.0; n * n];
        for row in at.jacobian.chunks_exact(n) {
            for (products, value) in products.chunks_exact_mut(n).zip(row) {
                products.iter_mut().zip(row).for_each(|(product, other)| *product += value * other);
            }
        }
        let scaled = |i: usize, j: usize| (products[i * n + j] + self.matrix[(i, j)]) / (scale[i] * scale[j]);
        let k = free.len();
        let mut curvature = square(k, |a, b| scaled(free[a], free[b]) + if a == b { damping } else { 0.0 });
        let mut step: Vec<f64> = free.iter().map(|&i| -at.gradient[i] / scale[i]).collect();
        cholesky::factor(&mut curvature, k).ok()?;
        cholesky::solve(&curvature, &mut step);
        let step = cut(&step, free, scale, x, bounds);
        let model = at.predicted(&step) - 0.5 * self.along(&step);
        (step.iter().all(|s| s.is_finite()) && model > 0.0).then_some((step, model))
    }

    /// `s' S s`.
    fn along(&self, step: &[f64]) -> f64 {
        let step = DVector::from_column_slice(step);
        step.dot(&(&self.matrix * &step))
    }

    /// Learns from a step that was taken.
    fn learn(&mut self, at: &Linearised, next: &Linearised, from: &[f64], to: &[f64]) {
        let n = from.len();
        let step = DVector::from_fn(n, |i, _| to[i] - from[i]);
        let gain = at.value - next.value;
        let linear = at.predicted(step.as_slice());
        self.is_used = (linear - 0.5 * self.along(step.as_slice()) - gain).abs() < (linear - gain).abs();
        let change = DVector::from_fn(n, |i, _| next.gradient[i] - at.gradient[i]);
        let mut beyond = DVector::from_fn(n, |i, _| next.penalty_gradient[i] - at.penalty_gradient[i]);
        let rows = next.jacobian.chunks_exact(n).zip(at.jacobian.chunks_exact(n)).zip(&next.residuals);
        for ((after, before), residual) in rows {
            for i in 0..n {
                beyond[i] += (after[i] - before[i]) * residual;
            }
        }
        let (known, seen) = (self.along(step.as_slice()).abs(), step.dot(&beyond).abs());
        if known > seen {
            // What was learned far away is too large here.
            self.matrix *= seen / known;
        }
        let along = change.dot(&step);
        if along > f64::EPSILON * change.norm() * step.norm() {
            let missing = beyond - &self.matrix * &step;
            let square = missing.dot(&step) / along;
            self.matrix += (&missing * change.transpose() + &change * missing.transpose()
                - &change * change.transpose() * square)
                / along;
        }
    }
}

/// Newton steps on the free variables while they lower the objective.
fn polish<O: Objective>(
    objective: &mut O,
    mut x: Vec<f64>,
    mut at: Linearised,
    bounds: &Bounds,
) -> (Vec<f64>, Linearised) {
    for _ in 0..20 {
        let free = free_variables(&x, &at.gradient, bounds);
        let Some(hessian) = hessian(objective, &x, bounds) else { break };
        let n = x.len();
        let mut factor = square(free.len(), |i, j| hessian[free[i] * n + free[j]]);
        if cholesky::factor(&mut factor, free.len()).is_err() {
            break;
        }
        let mut step: Vec<f64> = free.iter().map(|&i| -at.gradient[i]).collect();
        cholesky::solve(&factor, &mut step);
        let mut improved = false;
        let mut share = 1.0;
        for _ in 0..8 {
            let mut trial = x.clone();
            for (place, &i) in free.iter().enumerate() {
                trial[i] = (x[i] + share * step[place]).max(bounds.lower[i]).min(bounds.upper[i]);
            }
            if let Some(next) = linearise(objective, &trial)
                && next.value < at.value
            {
                improved = at.value - next.value > 1e-13 * at.value.abs();
                x = trial;
                at = next;
                break;
            }
            share *= 0.3;
        }
        if !improved {
            break;
        }
    }
    (x, at)
}

/// Hessian of the objective by central differences of its gradient, over a thousandth of the spread that the Jacobian
/// suggests (one-sided at a bound). `None` where the objective has no value near by.
pub fn hessian<O: Objective>(objective: &mut O, x: &[f64], bounds: &Bounds) -> Option<Vec<f64>> {
    let n = x.len();
    let at = linearise(objective, x)?;
    let mut hessian = vec![0.0; n * n];
    for j in 0..n {
        let norm = at.jacobian.iter().skip(j).step_by(n).map(|v| v * v).sum::<f64>().sqrt();
        let room = bounds.upper[j] - bounds.lower[j];
        let spread = if norm > 0.0 { 1.0 / norm } else { x[j].abs().max(1e-3) };
        let step = 1e-3 * if room.is_finite() { spread.min(room) } else { spread };
        let (mut above, mut below) = (x.to_vec(), x.to_vec());
        above[j] = (x[j] + step).min(bounds.upper[j]);
        below[j] = (x[j] - step).max(bounds.lower[j]);
        let (high, low) = (linearise(objective, &above)?, linearise(objective, &below)?);
        for i in 0..n {
            hessian[i * n + j] = (high.gradient[i] - low.gradient[i]) / (above[j] - below[j]);
        }
    }
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (hessian[i * n + j] + hessian[j * n + i]);
            hessian[i * n + j] = mean;
            hessian[j * n + i] = mean;
        }
    }
    Some(hessian)
}
