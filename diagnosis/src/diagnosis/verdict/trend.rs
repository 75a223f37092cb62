//! Inputs that rise or fall throughout a transient: an effect that goes with one may stand for whatever changes with time.

use crate::diagnosis::Problem;
use crate::math::functions::sqrt;
use crate::math::sort::sort_by;
use crate::measurement::Rows;

/// Rank correlation with time (Spearman 1904) from which an input follows it.
const FOLLOWS: f64 = 0.9;
/// Fewest rows of which that is said.
const LEAST_ROWS: usize = 8;

/// What is said of the inputs of a set's effects.
pub(crate) fn warnings(problem: &Problem, effects: &[usize]) -> Vec<String> {
    let mut said = Vec::new();
    for &effect in effects {
        let candidate = &problem.candidates[effect];
        let own = candidate.inputs(&problem.model);
        let inputs = (0..problem.model.inputs.len()).filter(|input| own.contains(input));
        for input in inputs.filter(|&input| follows_time(problem, input)) {
            said.push(format!(
                "`{}` goes with `{}`, which goes with time in this test: the effect may stand for anything else that changed with time",
                candidate.id, problem.model.inputs[input].name
            ));
        }
    }
    said
}

/// Whether an input follows time in every transient; not where there are steady phases, whose order says nothing.
fn follows_time(problem: &Problem, input: usize) -> bool {
    let follows = |rows: &Rows| match rows {
        Rows::Steady(_) => false,
        Rows::Transient { inputs, .. } => {
            let values: Vec<f64> = (0..inputs.times_s.len()).map(|row| inputs.in_row(row, input)).collect();
            values.len() >= LEAST_ROWS && correlation(&ranks(&values), &ranks(&inputs.times_s)).abs() >= FOLLOWS
        }
    };
    !problem.measurements.is_empty() && problem.measurements.iter().all(|measurement| follows(&measurement.rows))
}

/// Ranks from 0; equal values share the mean of theirs.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    sort_by(&mut order, |&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for same in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let mean = first as f64 + 0.5 * (same.len() - 1) as f64;
        same.iter().for_each(|&place| ranks[place] = mean);
        first += same.len();
    }
    ranks
}

/// 0 where either does not vary.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (of_a, of_b) = (mean(a), mean(b));
    let product = |x: &[f64], of_x: f64, y: &[f64], of_y: f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - of_x) * (y - of_y)).sum()
    };
    let scale = sqrt(product(a, of_a, a, of_a) * product(b, of_b, b, of_b));
    if scale > 0.0 { product(a, of_a, b, of_b) / scale } else { 0.0 }
}
