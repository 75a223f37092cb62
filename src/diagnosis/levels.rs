//! Levels that the data have of what an effect depends on: a threshold is tried between each two of them, and the data
//! cannot tell where between two it lies.

use super::Problem;
use crate::effect::{Bound, Candidate, Effect, EffectParameter};
use crate::expression::Symbol;
use crate::inference::measurement::Rows;
use crate::math::functions::ln;
use crate::random::Distribution;

/// Most thresholds that are tried.
const MOST: usize = 24;
/// Levels nearer than this share of their range are one.
const SAME: f64 = 0.005;

/// Values of a parameter that has the unit of one of the effect's inputs, SI: the middles between the input's levels in the
/// phases that are fitted. `None` where it has no such unit, in transients, and where there are no two levels.
pub(super) fn thresholds(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
) -> Option<Vec<f64>> {
    let levels = levels(problem, candidate, effect, parameter)?;
    let middles: Vec<f64> = levels.windows(2).map(|two| 0.5 * (two[0] + two[1])).collect();
    if middles.is_empty() {
        return None;
    }
    let count = middles.len().min(MOST);
    Some((0..count).map(|k| middles[(2 * k + 1) * middles.len() / (2 * count)]).collect())
}

/// Logarithm of the share of a uniform prior that lies between the levels about a value (SI) of such a parameter. `None`
/// where it has no levels or another prior.
pub(super) fn log_share(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    value: f64,
) -> Option<f64> {
    let Distribution::Uniform { lower, upper } = parameter.prior else { return None };
    let levels = levels(problem, candidate, effect, parameter)?;
    let below = levels.iter().copied().filter(|level| *level <= value).fold(lower, f64::max);
    let above = levels.iter().copied().filter(|level| *level > value).fold(upper, f64::min);
    Some(ln(((above - below) / (upper - lower)).clamp(SAME, 1.0)))
}

/// Distinct levels, ascending, of the input whose unit a parameter has.
fn levels(problem: &Problem, candidate: &Candidate, effect: &Effect, parameter: &EffectParameter) -> Option<Vec<f64>> {
    let form = &effect.form.parameters.iter().find(|form| form.name == parameter.written)?.value;
    let like = &form.unit_of.as_ref()?.value;
    let position = effect.form.inputs.iter().position(|input| input.name == *like)?;
    let mut levels = of_bound(problem, *candidate.bound.get(position)?)?;
    levels.sort_by(f64::total_cmp);
    let range = levels.last()? - levels.first()?;
    levels.dedup_by(|b, a| *b - *a <= SAME * range);
    Some(levels)
}

/// Values of an input in the phases; of a node the readings of the sensors on it.
fn of_bound(problem: &Problem, bound: Bound) -> Option<Vec<f64>> {
    let mut found = Vec::new();
    for measurement in &problem.measurements {
        let Rows::Steady(phases) = &measurement.rows else { return None };
        let fitted = (0..phases.len()).filter(|&row| !measurement.held_out(row) && !measurement.ignored(row));
        match bound {
            Bound::Input(input) => found.extend(fitted.filter_map(|row| phases[row].inputs.get(input).copied())),
            Bound::Node(node) => {
                let on_node = |quantity: usize| {
                    let value = problem.model.quantities.get(quantity).map(|own| own.value.expression());
                    let symbol = u32::try_from(node).ok().map(Symbol::Node);
                    value
                        .zip(symbol)
                        .is_some_and(|(value, symbol)| problem.model.graph.symbols(value).into_iter().eq([symbol]))
                };
                let sensors: Vec<usize> = (0..measurement.sensors.len())
                    .filter(|&sensor| on_node(measurement.sensors[sensor].quantity))
                    .collect();
                for row in fitted {
                    found.extend(sensors.iter().filter_map(|&sensor| measurement.reading(row, sensor)));
                }
            }
        }
    }
    Some(found)
}
