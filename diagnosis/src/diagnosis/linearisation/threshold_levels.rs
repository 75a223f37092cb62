//! Levels that the data have of what an effect depends on: a threshold is tried between each two of them, and the data
//! cannot tell where between two it lies.

use crate::diagnosis::Problem;
use crate::effect::{Bound, Candidate, Effect, EffectParameter, Like, Site};
use crate::expression::Symbol;
use crate::math::functions::ln;
use crate::measurement::{Measurement, Rows};
use crate::random::Distribution;

/// Most thresholds that are tried.
const MOST: usize = 24;
/// Levels nearer than this share of their range are one.
const SAME: f64 = 0.005;
/// Share of their range by which a threshold may lie beyond the levels of transients, where what it does may still show.
const REACH: f64 = 0.05;
/// The same beyond all temperatures that were read, where the node has no sensor.
const REACH_WITHOUT_SENSOR: f64 = 0.25;
/// Thresholds that are tried in what varies continuously.
const MOST_OF_COURSE: usize = 7;
/// The same of dates and of times since the start of a run: a step a thirtieth of the time off keeps nine tenths of what it explains.
const MOST_TIMES: usize = 15;

/// Values of a parameter that is a level of one of the effect's inputs or of the temperatures of its nodes, SI: the middles between
/// the levels of these in the phases that are fitted; where there are transients, and more levels than a few, evenly between the
/// least and the greatest of the rows that are fitted; for nodes without a sensor evenly over the temperatures that others had
/// there. `None` where it is no such level, and where there are no two of them.
pub(crate) fn thresholds(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
) -> Option<Vec<f64>> {
    let levels = all_levels(problem, candidate, effect, parameter);
    if let Some((ends, count)) = course(problem, candidate, effect, parameter, levels.as_deref()) {
        return Some(evenly(ends, count));
    }
    let Some(levels) = levels else {
        let Compared::Nodes(_) = compared(candidate, effect, parameter)? else { return None };
        return Some(evenly(span(problem)?, MOST));
    };
    let middles: Vec<f64> = levels.windows(2).map(|two| 0.5 * (two[0] + two[1])).collect();
    let count = middles.len().min(MOST);
    let chosen = (0..count).map(|k| middles[(2 * k + 1) * middles.len() / (2 * count)]);
    (count > 0).then(|| chosen.collect())
}

/// How far apart such values are (SI) where they are evenly spread over a course: between two of them there are others that the
/// data tell apart. `None` where each stands for a gap between two levels.
pub(crate) fn spacing_over_course(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
) -> Option<f64> {
    let levels = all_levels(problem, candidate, effect, parameter);
    let ([least, most], count) = course(problem, candidate, effect, parameter, levels.as_deref())?;
    Some((most - least) / count as f64)
}

/// Between what the values of such a parameter are evenly spread, and how many they are. `None` without transients, and where the
/// data have few levels.
fn course(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    levels: Option<&[f64]>,
) -> Option<([f64; 2], usize)> {
    if all_steady(problem) {
        return None;
    }
    let Some(levels) = levels else {
        let Compared::Nodes(_) = compared(candidate, effect, parameter)? else { return None };
        return Some((span(problem)?, MOST_OF_COURSE));
    };
    let most = if is_time(problem, candidate, effect, parameter) { MOST_TIMES } else { MOST_OF_COURSE };
    (levels.len() > most + 1).then(|| ([levels[0], levels[levels.len() - 1]], most))
}

fn evenly([least, most]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|k| least + (most - least) * (k as f64 + 0.5) / count as f64).collect()
}

/// The levels about a value (SI) of such a parameter, or the ends of its prior. `None` where it has no levels or its prior
/// is not uniform.
pub(crate) fn gap(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    value: f64,
) -> Option<[f64; 2]> {
    let Distribution::Uniform { lower, upper } = parameter.prior else { return None };
    let levels = levels(problem, candidate, effect, parameter)?;
    let below = levels.iter().copied().filter(|level| *level <= value).fold(lower, f64::max);
    let above = levels.iter().copied().filter(|level| *level > value).fold(upper, f64::min);
    Some([below, above])
}

/// Values of such a parameter in the middles of the gaps before and after that of a value (SI). None beyond the outermost
/// levels: there all rows lie on one side.
pub(crate) fn beside(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    value: f64,
) -> [Option<f64>; 2] {
    let Some(levels) = levels(problem, candidate, effect, parameter) else { return [None; 2] };
    let above = levels.partition_point(|level| *level <= value);
    let middle = |gap: usize| Some(0.5 * (levels.get(gap)? + levels.get(gap + 1)?));
    [above.checked_sub(2).and_then(middle), middle(above)]
}

/// Whether there are levels on both sides of a value (SI) of such a parameter; so where it has none, and of a time.
pub fn is_crossed(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    value: f64,
) -> bool {
    if is_time(problem, candidate, effect, parameter) {
        return true;
    }
    // What melts, or a switch with a hysteresis, acts before its level is reached.
    let reach = if all_steady(problem) { 0.0 } else { REACH };
    let ends = match (all_levels(problem, candidate, effect, parameter), compared(candidate, effect, parameter)) {
        (Some(levels), _) => levels.first().copied().zip(levels.last().copied()).map(|ends| (ends, reach)),
        // Nodes without a sensor may be somewhat warmer or colder than all that have one.
        (None, Some(Compared::Nodes(_))) => span(problem).map(|[least, most]| ((least, most), REACH_WITHOUT_SENSOR)),
        (None, _) => None,
    };
    ends.is_none_or(|((least, greatest), reach)| {
        let margin = reach * (greatest - least);
        least <= value + margin && greatest > value - margin
    })
}

/// Whether such a parameter is a date or a time since the start of a run.
fn is_time(problem: &Problem, candidate: &Candidate, effect: &Effect, parameter: &EffectParameter) -> bool {
    matches!(compared(candidate, effect, parameter),
        Some(Compared::Input(input)) if Bound::Input(input).is_clock(&problem.model))
}

/// Logarithm of the share of the prior that lies between these levels.
pub(crate) fn log_share(parameter: &EffectParameter, [below, above]: [f64; 2]) -> f64 {
    let (lower, upper) = parameter.prior.support();
    ln(((above - below) / (upper - lower)).clamp(SAME, 1.0))
}

/// The values of what such a parameter is compared with in a row of a measurement: an input of a phase, or the readings of
/// sensors on the nodes, one of each.
pub(crate) fn levels_of_row(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
    measurement: &Measurement,
    row: usize,
) -> Vec<f64> {
    let Rows::Steady(_) = &measurement.rows else { return Vec::new() };
    match compared(candidate, effect, parameter) {
        Some(Compared::Input(input)) => measurement.level(&problem.model, row, input).into_iter().collect(),
        Some(Compared::Nodes(nodes)) => {
            let read = |node: usize| {
                on_node(problem, measurement, node).into_iter().find_map(|sensor| measurement.reading(row, sensor))
            };
            nodes.into_iter().filter_map(read).collect()
        }
        None => Vec::new(),
    }
}

/// What a parameter is compared with.
enum Compared {
    /// An input of the model.
    Input(usize),
    /// Temperatures of nodes: of one that is bound, or of all on which the effect acts.
    Nodes(Vec<usize>),
}

fn compared(candidate: &Candidate, effect: &Effect, parameter: &EffectParameter) -> Option<Compared> {
    let form = &effect.form.parameters.iter().find(|form| form.name == parameter.written)?.value;
    match (effect.like(form)?, &candidate.site) {
        (Like::Input(input), _) => candidate.bound.get(input).map(|bound| match *bound {
            Bound::Input(input) => Compared::Input(input),
            Bound::Node(node) => Compared::Nodes(vec![node]),
        }),
        (Like::OwnTemperature, Site::Nodes(nodes)) => {
            Some(Compared::Nodes(nodes.iter().map(|&(node, _)| node).collect()))
        }
        (Like::OwnTemperature, _) => None,
    }
}

/// Sensors that read the temperature of a node.
fn on_node(problem: &Problem, measurement: &Measurement, node: usize) -> Vec<usize> {
    let is_on = |sensor: &usize| {
        let quantity = problem.model.quantities.get(measurement.sensors[*sensor].quantity);
        let symbol = u32::try_from(node).ok().map(Symbol::Node);
        quantity.zip(symbol).is_some_and(|(quantity, symbol)| {
            problem.model.graph.symbols(quantity.value.expression()).into_iter().eq([symbol])
        })
    };
    (0..measurement.sensors.len()).filter(is_on).collect()
}

/// The fitted readings of some sensors of a measurement, SI.
fn fitted_readings(measurement: &Measurement, sensors: Vec<usize>) -> impl Iterator<Item = f64> + '_ {
    let of_row = move |row| sensors.clone().into_iter().filter_map(move |sensor| measurement.reading(row, sensor));
    measurement.fitted_rows().flat_map(of_row)
}

/// The least and the greatest of some numbers. `None` without any.
pub(crate) fn ends(mut numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let first = numbers.next()?;
    Some(numbers.fold([first; 2], |[least, most], one| [least.min(one), most.max(one)]))
}

/// The least and the greatest fitted reading of a node's temperature, K. `None` without a sensor.
pub(crate) fn temperatures_read(problem: &Problem, node: usize) -> Option<[f64; 2]> {
    let of = |measurement| fitted_readings(measurement, on_node(problem, measurement, node));
    ends(problem.measurements.iter().flat_map(of))
}

/// The fitted readings in transients, K, of the nodes whose temperature a parameter is compared with, each with its measurement and row.
/// `None` where it is compared with anything else.
pub(crate) fn readings_in_transients(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
) -> Option<Vec<(usize, usize, f64)>> {
    let Compared::Nodes(nodes) = compared(candidate, effect, parameter)? else { return None };
    let mut found = Vec::new();
    for (index, measurement) in problem.measurements.iter().enumerate() {
        if matches!(measurement.rows, Rows::Steady(_)) {
            continue;
        }
        let sensors: Vec<usize> = nodes.iter().flat_map(|&node| on_node(problem, measurement, node)).collect();
        for row in measurement.fitted_rows() {
            let readings = sensors.iter().filter_map(|&sensor| measurement.reading(row, sensor));
            found.extend(readings.map(|reading| (index, row, reading)));
        }
    }
    Some(found)
}

/// Distinct levels in steady phases. `None` where there are transients: there the likelihood tells where a threshold is.
fn levels(problem: &Problem, candidate: &Candidate, effect: &Effect, parameter: &EffectParameter) -> Option<Vec<f64>> {
    all_levels(problem, candidate, effect, parameter).filter(|_| all_steady(problem))
}

/// Distinct levels, ascending, of what a parameter is compared with, in the rows that are fitted. `None` where it is compared with
/// nothing, and without any level.
fn all_levels(
    problem: &Problem,
    candidate: &Candidate,
    effect: &Effect,
    parameter: &EffectParameter,
) -> Option<Vec<f64>> {
    let compared = compared(candidate, effect, parameter)?;
    let mut levels = Vec::new();
    for measurement in &problem.measurements {
        match &compared {
            Compared::Input(input) => {
                let rows = measurement.fitted_rows();
                levels.extend(rows.filter_map(|row| measurement.level(&problem.model, row, *input)));
            }
            Compared::Nodes(nodes) => {
                let sensors = nodes.iter().flat_map(|&node| on_node(problem, measurement, node)).collect();
                levels.extend(fitted_readings(measurement, sensors));
            }
        }
    }
    levels.sort_by(f64::total_cmp);
    let range = levels.last()? - levels.first()?;
    levels.dedup_by(|b, a| *b - *a <= SAME * range);
    Some(levels)
}

fn all_steady(problem: &Problem) -> bool {
    problem.measurements.iter().all(|measurement| matches!(measurement.rows, Rows::Steady(_)))
}

/// The least and the greatest of the fitted temperatures, K. `None` where they are one, or none.
fn span(problem: &Problem) -> Option<[f64; 2]> {
    let of = |measurement| fitted_readings(measurement, measurement.sensors_in_kelvin(&problem.model));
    ends(problem.measurements.iter().flat_map(of)).filter(|[least, most]| least < most)
}
