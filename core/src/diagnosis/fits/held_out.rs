//! What the held-out rows say of a set of effects: a paired test of the squared errors, in blocks.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnosis::linearisation::signature::linearise;
use crate::diagnosis::linearisation::threshold_levels::{gap, levels_of_row};
use crate::diagnosis::output::HeldOutTest;
use crate::diagnosis::{Linear, Problem, Refit};
use crate::math::cholesky;
use crate::math::special::{chi_square_sf, student_t_cdf};
use crate::measurement::{Measurement, Rows};

/// How the warning of a set with a threshold that they place begins.
pub(crate) const SAYS_MOVED: &str = "a threshold lies where the held-out rows allow it, not in the gap between two levels that fits \
                                slightly better and fails on them; they have taken part in the choice:";
/// Probability below which the test speaks against a set.
const AGAINST: f64 = 0.01;
/// Probability of the errors' size below which it speaks against a set that is not clearly better.
const FAR: f64 = 1e-3;
/// Standard errors by which a set is clearly better.
const CLEARLY: f64 = 2.0;
/// Times by which the squared errors have grown where a set is far worse: its RMSE is twice as large.
const FAR_WORSE: f64 = 4.0;
/// Correlation times of a block.
const TIMES_OF_BLOCK: f64 = 3.0;
/// Fewest blocks that are tested.
const LEAST_BLOCKS: usize = 4;

/// Tests whether a set predicts the held-out rows worse than the baseline model, or predicts them badly without being
/// clearly better; with twice the error and beyond what the parameters leave open it is worse however few blocks there are. A block
/// is a phase, or three correlation times of a transient. `None` without held-out rows, and where errors are so many times
/// the noise that their squares are no numbers.
/// `stated`: all noise is stated, so that the size of the errors itself can be judged.
pub(crate) fn test(problem: &Problem, baseline: &Refit, chosen: &Refit, stated: bool) -> Option<HeldOutTest> {
    let mut blocks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let undecided = undecided(problem, chosen);
    let mut squares = [0.0; 2];
    for (before, after) in baseline.held_out.iter().zip(&chosen.held_out) {
        if undecided.contains(&(before.measurement, before.row)) {
            continue;
        }
        if before.sigma > 0.0 && before.error.is_finite() && after.error.is_finite() {
            let gain = (before.error * before.error - after.error * after.error) / (before.sigma * before.sigma);
            squares[0] += before.error * before.error / (before.sigma * before.sigma);
            squares[1] += after.error * after.error / (before.sigma * before.sigma);
            *blocks.entry((before.measurement, block(problem, before.measurement, before.row))).or_default() += gain;
        }
    }
    let count = blocks.len();
    let gains: Vec<f64> = blocks.into_values().collect();
    let (mean, se) = mean_gain(&gains)?;
    let is_against = |se: f64| se > 0.0 && student_t_cdf(mean / se, (count - 1) as f64) < AGAINST;
    let worse = count >= LEAST_BLOCKS && se.is_some_and(is_against);
    let judged = chi_square(problem, chosen, &undecided);
    let p = judged.map(|(square, readings)| chi_square_sf(square, readings as f64));
    let clearly_better = mean > CLEARLY * se.unwrap_or(0.0);
    let bad = is_bad(p, stated && !clearly_better, squares);
    Some(HeldOutTest {
        gain: mean,
        se,
        blocks: count as u64,
        chi_square: judged.map(|(square, _)| square),
        readings: judged.map_or(chosen.held_out.len(), |(_, readings)| readings) as u64,
        p,
        veto: worse || bad,
    })
}

/// Whether the held-out rows reject a set, but not another one, and say more for that than the fitted rows for the set by `log_odds`.
/// Where all noise is stated; a set with fewer readings that it decides on has an advantage that does not count.
pub fn is_outdone(own: &HeldOutTest, other: &HeldOutTest, log_odds: f64) -> bool {
    let falls = own.chi_square.zip(other.chi_square).map(|(own, other)| 0.5 * (own - other));
    is_rejected(own)
        && other.p.is_some_and(|p| p >= AGAINST)
        && other.readings >= own.readings
        && falls.is_some_and(|falls| falls > log_odds)
}

/// Whether the size of the errors alone speaks against a set.
pub fn is_rejected(test: &HeldOutTest) -> bool {
    test.p.is_some_and(|p| p < FAR)
}

/// Mean of the blocks' gains and its standard error, which one block does not have; `None` without a block, or where they are
/// no numbers.
pub fn mean_gain(gains: &[f64]) -> Option<(f64, Option<f64>)> {
    let count = gains.len();
    let mean = gains.iter().sum::<f64>() / count as f64;
    let square = gains.iter().map(|gain| (gain - mean) * (gain - mean)).sum::<f64>();
    let se = (count > 1).then(|| (square / (count * (count - 1)) as f64).sqrt());
    (mean.is_finite() && se.is_none_or(f64::is_finite)).then_some((mean, se))
}

/// Whether the errors are beyond what noise and fit allow (`p`), and either `judged` by that alone or twice as large as before;
/// from the sums of their squares before and after.
pub fn is_bad(p: Option<f64>, judged: bool, [before, after]: [f64; 2]) -> bool {
    p.is_some_and(|p| p < FAR) && (judged || after > FAR_WORSE * before)
}

/// Sum of squares of the held-out errors over the covariance of noise and of the parameters after the fit, and their
/// number: with `F` the slopes of the whitened predictions, `M` the information of the fit,
/// `r' (I + F M^-1 F')^-1 r = r' r - r' F (M + F' F)^-1 F' r` (Woodbury).
///
/// Parameters that press against a bound count as free: what little they can move is more than nothing.
fn chi_square(problem: &Problem, chosen: &Refit, left_out: &BTreeSet<(usize, usize)>) -> Option<(f64, usize)> {
    let with = problem.with(chosen).ok()?;
    let fitted = linear(&with, chosen)?;
    let mut exchanged = with;
    // These rows may take any number of times the steps of the fitted ones.
    exchanged.most_steps.clear();
    for (index, measurement) in exchanged.measurements.iter_mut().enumerate() {
        exchange(measurement);
        let width = measurement.sensors.len();
        for &(_, row) in left_out.iter().filter(|(of_measurement, _)| *of_measurement == index) {
            measurement.readings[row * width..(row + 1) * width].fill(None);
        }
    }
    let predicted = linear(&exchanged, chosen)?;
    let n = fitted.parameters();
    let free: Vec<usize> = (0..n).filter(|&i| fitted.lower[i] < fitted.upper[i]).collect();
    let k = free.len();
    let mut matrix = vec![0.0; k * k];
    let slopes = fitted.jacobian.chunks_exact(n.max(1));
    for row in slopes.chain(predicted.jacobian.chunks_exact(n.max(1)).take(predicted.readings)) {
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                matrix[a * k + b] += row[i] * row[j];
            }
        }
    }
    for (a, &i) in free.iter().enumerate() {
        let width = fitted.upper[i] - fitted.lower[i];
        if width.is_finite() && width > 0.0 {
            matrix[a * k + a] += 12.0 / (width * width);
        }
    }
    let residuals = &predicted.residuals[..predicted.readings];
    let mut right = vec![0.0; k];
    for (row, r) in predicted.jacobian.chunks_exact(n.max(1)).zip(residuals) {
        for (a, &i) in free.iter().enumerate() {
            right[a] += row[i] * r;
        }
    }
    cholesky::factor(&mut matrix, k).ok()?;
    cholesky::solve_lower(&matrix, &mut right);
    let square = residuals.iter().map(|r| r * r).sum::<f64>() - right.iter().map(|v| v * v).sum::<f64>();
    (predicted.readings > 0).then_some((square.max(0.0), predicted.readings))
}

/// Held-out rows on which the fitted rows do not decide: those between the two levels where a set has a threshold.
fn undecided(problem: &Problem, chosen: &Refit) -> BTreeSet<(usize, usize)> {
    let fitted_values = chosen.by_name();
    let mut rows = BTreeSet::new();
    for &position in &chosen.effects {
        let candidate = &problem.candidates[position];
        let Some(effect) = problem.catalogue.get(&candidate.effect) else { continue };
        for parameter in effect.parameters(&problem.model, &candidate.bound) {
            let value = fitted_values.get(&format!("{}.{}", candidate.id, parameter.name));
            let gap = value.and_then(|value| gap(problem, candidate, effect, &parameter, *value));
            let Some([below, above]) = gap else { continue };
            for (index, measurement) in problem.measurements.iter().enumerate() {
                for row in (0..measurement.len()).filter(|&row| measurement.held_out(row)) {
                    let levels = levels_of_row(problem, candidate, effect, &parameter, measurement, row);
                    if levels.iter().any(|level| below < *level && *level < above) {
                        rows.insert((index, row));
                    }
                }
            }
        }
    }
    rows
}

fn linear(problem: &Problem, chosen: &Refit) -> Option<Linear> {
    let likelihood = problem.hypothesis(&[], 1.0).ok()?.likelihood(problem).ok()?;
    let fitted_values = chosen.by_name();
    let at: Vec<f64> =
        likelihood.unknowns().names.iter().map(|name| fitted_values.get(name).copied()).collect::<Option<_>>()?;
    linearise(&likelihood, &at).ok()
}

/// Lets the held-out rows be the fitted ones, and these be none.
fn exchange(measurement: &mut Measurement) {
    let width = measurement.sensors.len();
    for row in 0..measurement.len() {
        if !measurement.held_out(row) {
            measurement.readings[row * width..(row + 1) * width].fill(None);
        }
    }
    match &mut measurement.rows {
        Rows::Steady(phases) => phases.iter_mut().for_each(|phase| phase.held_out = false),
        Rows::Transient { held_out, .. } => held_out.fill(false),
    }
}

/// Number of the block of a row.
fn block(problem: &Problem, measurement: usize, row: usize) -> usize {
    let measurement = &problem.measurements[measurement];
    match &measurement.rows {
        Rows::Steady(_) => row,
        Rows::Transient { inputs, .. } => {
            let times = measurement.sensors.iter().filter_map(|s| s.correlation_time_s.as_ref().map(|t| t.nominal()));
            let longest = times.fold(0.0, f64::max);
            let span = inputs.times_s.last().unwrap_or(&0.0) - inputs.times_s.first().unwrap_or(&0.0);
            // Errors of a model are correlated where its noise is not: at least a fiftieth of the whole.
            let length = (TIMES_OF_BLOCK * longest).max(0.02 * span).max(f64::MIN_POSITIVE);
            ((inputs.times_s[row] - inputs.times_s.first().unwrap_or(&0.0)) / length) as usize
        }
    }
}
