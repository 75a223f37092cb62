//! Inputs that move together: an effect that goes with one of them may be one of another.

use crate::diagnosis::Problem;
use crate::diagnosis::verdict::trend::correlation;
use crate::math::sort::sort_by;

/// Correlation from which two inputs move together: what one leaves of the other is less than a fifth of its variance.
const TOGETHER: f64 = 0.9;
/// Fewest rows of which that is said.
const LEAST_ROWS: usize = 8;
/// Inputs that are named.
const MOST: usize = 4;

/// What is said of the inputs of a set's effects.
pub(crate) fn warnings(problem: &Problem, effects: &[usize]) -> Vec<String> {
    let values = values(problem);
    let mut said = Vec::new();
    for &effect in effects {
        let candidate = &problem.candidates[effect];
        for own in candidate.inputs(&problem.model) {
            let mut others = together(&values, own);
            let more = others.len().saturating_sub(MOST);
            others.truncate(MOST);
            if others.is_empty() {
                continue;
            }
            let name = |input: usize| &problem.model.inputs[input].name;
            let list: Vec<String> = others.iter().map(|(other, r)| format!("`{}` ({r:.2})", name(*other))).collect();
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            said.push(format!(
                "`{}` goes with `{}`, with which {}{more} moves (correlation): these data hardly tell which of these inputs it is",
                candidate.id,
                name(own),
                list.join(", "),
            ));
        }
    }
    said
}

/// What each input is in the rows that are fitted.
fn values(problem: &Problem) -> Vec<Vec<f64>> {
    let model = &problem.model;
    let mut values = vec![Vec::new(); model.inputs.len()];
    for measurement in &problem.measurements {
        for row in measurement.fitted_rows() {
            for (input, values) in values.iter_mut().enumerate().filter(|(input, _)| !model.clocks.has(*input)) {
                values.push(measurement.level(model, row, input).unwrap_or(f64::NAN));
            }
        }
    }
    values
}

/// The other inputs that move with one, and their correlations, closest first. None where a row lacks one of the two.
pub fn together(values: &[Vec<f64>], own: usize) -> Vec<(usize, f64)> {
    let mut others: Vec<(usize, f64)> = (0..values.len())
        .filter(|&other| other != own && values[other].len() == values[own].len() && values[own].len() >= LEAST_ROWS)
        .map(|other| (other, correlation(&values[own], &values[other])))
        .filter(|(_, correlation)| correlation.abs() >= TOGETHER)
        .collect();
    sort_by(&mut others, |a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    others
}
