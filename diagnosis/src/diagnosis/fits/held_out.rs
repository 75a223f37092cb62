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
    test_with_prediction(problem, baseline, chosen, stated).map(|(test, _)| test)
}

/// The same, and what the set predicts.
pub(crate) fn test_with_prediction(
    problem: &Problem,
    baseline: &Refit,
    chosen: &Refit,
    stated: bool,
) -> Option<(HeldOutTest, Option<Predicted>)> {
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
    let judged = predicted(problem, chosen, &undecided);
    let p = judged.map(|judged| judged.p());
    let clearly_better = mean > CLEARLY * se.unwrap_or(0.0);
    let bad = is_bad(p, stated && !clearly_better, squares);
    let test = HeldOutTest {
        gain: mean,
        se,
        blocks: count as u64,
        chi_square: judged.map(|judged| judged.square),
        readings: judged.map_or(chosen.held_out.len(), |judged| judged.readings) as u64,
        p,
        veto: worse || bad,
    };
    Some((test, judged))
}

/// What a set predicts of held-out readings, with noise and parameters as uncertain as they are after the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Sum of squares of the errors over their covariance.
    pub square: f64,
    /// Logarithm of the determinant of this covariance over that of the noise.
    pub log_volume: f64,
    /// Readings.
    pub readings: usize,
}

impl Predicted {
    /// Probability of a larger sum of squares where nothing else is missing.
    pub fn p(&self) -> f64 {
        chi_square_sf(self.square, self.readings as f64)
    }

    /// Whether the readings reject the set by the size of its errors alone.
    pub fn is_rejected(&self) -> bool {
        self.p() < FAR
    }

    /// Whether the readings reject the set and accept another one, which is more probable with what they say of both. `log_odds` are
    /// those of this set against the other one without these readings. There is no comparison where one set leaves rows undecided.
    pub fn is_outdone_by(&self, other: &Self, log_odds: f64) -> bool {
        let falls = 0.5 * (self.square + self.log_volume - other.square - other.log_volume);
        self.is_rejected() && other.p() >= AGAINST && other.readings == self.readings && falls > log_odds
    }
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

/// What a set predicts of the held-out rows. With `r` the whitened errors, `F` the slopes of the whitened predictions, `M` the
/// information of the fit: `r' (I + F M^-1 F')^-1 r = r' r - r' F (M + F' F)^-1 F' r` (Woodbury), and
/// `|I + F M^-1 F'| = |M + F' F| / |M|`.
///
/// Parameters that press against a bound count as free: what little they can move is more than nothing.
fn predicted(problem: &Problem, chosen: &Refit, left_out: &BTreeSet<(usize, usize)>) -> Option<Predicted> {
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
    let mut information = vec![0.0; k * k];
    let add = |matrix: &mut [f64], row: &[f64]| {
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                matrix[a * k + b] += row[i] * row[j];
            }
        }
    };
    fitted.jacobian.chunks_exact(n.max(1)).for_each(|row| add(&mut information, row));
    for (a, &i) in free.iter().enumerate() {
        let width = fitted.upper[i] - fitted.lower[i];
        if width.is_finite() && width > 0.0 {
            information[a * k + a] += 12.0 / (width * width);
        }
    }
    let mut matrix = information.clone();
    predicted.jacobian.chunks_exact(n.max(1)).take(predicted.readings).for_each(|row| add(&mut matrix, row));
    let residuals = &predicted.residuals[..predicted.readings];
    let mut right = vec![0.0; k];
    for (row, r) in predicted.jacobian.chunks_exact(n.max(1)).zip(residuals) {
        for (a, &i) in free.iter().enumerate() {
            right[a] += row[i] * r;
        }
    }
    cholesky::factor(&mut matrix, k).ok()?;
    cholesky::solve_lower(&matrix, &mut right);
    let log_volume = match cholesky::factor(&mut information, k) {
        Ok(()) => cholesky::log_determinant(&matrix, k) - cholesky::log_determinant(&information, k),
        // The fitted rows leave something open altogether.
        Err(_) => f64::INFINITY,
    };
    let square = residuals.iter().map(|r| r * r).sum::<f64>() - right.iter().map(|v| v * v).sum::<f64>();
    let readings = predicted.readings;
    (readings > 0).then_some(Predicted { square: square.max(0.0), log_volume, readings })
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
