//! A problem with long transients on fewer rows.
//!
//! An input that changes in every row makes the integrator stop in every row, for every effect and every step of a fit. What
//! orders effects, or where a fit begins, need not be known so well. So inputs become means over several rows, and readings
//! are those of the rows that are left.

use std::cmp::Ordering;
use std::ops::Range;

use crate::diagnosis::problem::Problem;
use crate::effect::{Candidate, Site};
use crate::expression::Unit;
use crate::inference::likelihood::{FewerRows, InputError};
use crate::measurement::{InputColumn, InputTable, Measurement, Rows};

/// Rows of a transient up to which every row is kept.
const MOST_ROWS: usize = 1000;
/// Rows that are left of longer ones.
const ROWS_LEFT: usize = 500;

/// Distance of an input from its means, as a share of its spread, above which these do not follow it.
const MOST_STRAYING: f64 = 0.3;

/// A problem with fewer rows.
pub(crate) struct Thinned {
    /// The problem. Inputs have no errors of their own.
    pub problem: Problem,
    /// Of each measurement the rows that it keeps; `None` where it keeps all.
    pub kept: Vec<Option<Vec<usize>>>,
    /// Of each input whether its means do not follow it.
    is_quick: Vec<bool>,
}

impl Problem {
    /// The problem on fewer rows, whose transients may err by so many times the usual local error in a step. `None` where no
    /// transient is long.
    pub(crate) fn thinned(&self, tolerance: f64) -> Option<Thinned> {
        let kept: Vec<Option<Vec<usize>>> = self.measurements.iter().map(kept_rows).collect();
        if kept.iter().all(Option::is_none) {
            return None;
        }
        let mut is_quick = vec![false; self.model.inputs.len()];
        for (measurement, rows) in self.measurements.iter().zip(&kept) {
            if let (Rows::Transient { inputs, .. }, Some(rows)) = (&measurement.rows, rows) {
                let quick = inputs.columns.iter().filter(|column| strays(&column.values, rows) > MOST_STRAYING);
                quick.for_each(|column| is_quick[column.input] = true);
            }
        }
        let mut problem = Problem { tolerance, ..self.clone() };
        for (measurement, rows) in problem.measurements.iter_mut().zip(&kept) {
            if let Some(rows) = rows {
                thin(measurement, rows);
            }
        }
        for error in &mut problem.input_errors {
            *error = InputError { sigma: None, ..*error };
        }
        Some(Thinned { problem, kept, is_quick })
    }
}

impl Thinned {
    /// Whether fewer rows show a candidate well: it changes the network, and goes with no input that its means do not follow.
    pub fn shows(&self, position: usize) -> bool {
        let candidate = &self.problem.candidates[position];
        matches!(candidate.site, Site::Nodes(_) | Site::Pair(_) | Site::Elements(_)) && !self.is_quick(candidate)
    }

    /// Whether a fit on fewer rows leads near the fit on all: of a sensor, not where it shifts the time or lags.
    pub fn leads_to(&self, position: usize) -> bool {
        let candidate = &self.problem.candidates[position];
        let seconds = Unit::parse("s").map(|unit| unit.dimension).ok();
        let is_timed = || {
            let effect = self.problem.catalogue.get(&candidate.effect);
            let parameters = effect.map(|effect| effect.parameters(&self.problem.model, &candidate.bound));
            parameters
                .iter()
                .flatten()
                .any(|parameter| parameter.amplitude && Some(parameter.unit.dimension) == seconds)
        };
        !(self.is_quick(candidate) || matches!(candidate.site, Site::Sensors(_)) && is_timed())
    }

    /// By measurement the rows on which derivatives of a fit with these measurements, of this problem, are found; `None` where
    /// on all: of short records, and of those with an input that its means do not follow.
    pub fn slopes_on(&self, measurements: &[Measurement]) -> Vec<Option<FewerRows>> {
        let of = |(measurement, kept): (&Measurement, &Option<Vec<usize>>)| {
            let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
            let is_quick = inputs.columns.iter().any(|column| self.is_quick.get(column.input) == Some(&true));
            let rows = kept.clone().filter(|_| !is_quick)?;
            Some(FewerRows { inputs: inputs.clone(), rows, tolerance: self.problem.tolerance })
        };
        measurements.iter().zip(&self.kept).map(of).collect()
    }

    fn is_quick(&self, candidate: &Candidate) -> bool {
        candidate.inputs(&self.problem.model).into_iter().any(|input| self.is_quick[input])
    }
}

/// Instants of a transient, s.
pub(crate) fn times(measurement: &Measurement) -> &[f64] {
    match &measurement.rows {
        Rows::Steady(_) => &[],
        Rows::Transient { inputs, .. } => &inputs.times_s,
    }
}

/// The rows that a long transient keeps: one of several, and the last with a reading to fit. `None` where all are kept.
fn kept_rows(measurement: &Measurement) -> Option<Vec<usize>> {
    let is_fitted = |row: &usize| {
        let has_reading = || (0..measurement.sensors.len()).any(|sensor| measurement.reading(*row, sensor).is_some());
        !measurement.ignored(*row) && !measurement.held_out(*row) && has_reading()
    };
    let last = (0..measurement.len()).rev().find(is_fitted)?;
    if times(measurement).is_empty() || last < MOST_ROWS {
        return None;
    }
    let mut rows: Vec<usize> = (0..last).step_by(last.div_ceil(ROWS_LEFT)).collect();
    rows.push(last);
    Some(rows)
}

/// Leaves some rows of a transient, with the inputs' means about them.
fn thin(measurement: &mut Measurement, kept: &[usize]) {
    let sensors = measurement.sensors.len();
    let readings =
        kept.iter().flat_map(|&row| measurement.readings[row * sensors..(row + 1) * sensors].iter().copied());
    measurement.readings = readings.collect();
    if let Rows::Transient { inputs, held_out, ignored, .. } = &mut measurement.rows {
        *inputs = means(inputs, kept);
        *held_out = kept.iter().map(|&row| held_out[row]).collect();
        *ignored = kept.iter().map(|&row| ignored[row].clone()).collect();
    }
}

/// Means of the inputs over time: of constant ones until the next row that is kept, of linear ones about each, weighted less
/// the nearer they are to the next one.
fn means(inputs: &InputTable, kept: &[usize]) -> InputTable {
    let times_s = &inputs.times_s;
    let of_column = |column: &InputColumn| {
        let mean = |place: usize| {
            let row = kept[place];
            let next = kept.get(place + 1).copied();
            if column.hold {
                return mean_of(row..next.unwrap_or(row + 1), &column.values, |row| lasts(times_s, row));
            }
            let before = place.checked_sub(1).map_or(row, |before| kept[before]);
            let next = next.unwrap_or(row);
            let weight = |other: usize| match other.cmp(&row) {
                Ordering::Equal => 1.0,
                Ordering::Less => (times_s[other] - times_s[before]) / (times_s[row] - times_s[before]),
                Ordering::Greater => (times_s[next] - times_s[other]) / (times_s[next] - times_s[row]),
            };
            mean_of(before..next + 1, &column.values, weight)
        };
        InputColumn { values: (0..kept.len()).map(mean).collect(), ..column.clone() }
    };
    InputTable {
        times_s: kept.iter().map(|&row| times_s[row]).collect(),
        columns: inputs.columns.iter().map(of_column).collect(),
        base: inputs.base.clone(),
    }
}

/// Root mean square distance of values from their means between rows that are kept, as a share of their standard deviation.
fn strays(values: &[f64], kept: &[usize]) -> f64 {
    let square = |part: &[f64]| {
        let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
        part.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>()
    };
    let of_parts: f64 = kept.windows(2).map(|ends| square(&values[ends[0]..ends[1]])).sum();
    let of_all = square(&values[..kept.last().map_or(0, |last| last + 1)]);
    if of_all > 0.0 { (of_parts / of_all).sqrt() } else { 0.0 }
}

/// How long a row's constant values hold, s; any time for the last one.
fn lasts(times_s: &[f64], row: usize) -> f64 {
    times_s.get(row + 1).map_or(1.0, |next| next - times_s[row])
}

fn mean_of(rows: Range<usize>, values: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
    let weights: f64 = rows.clone().map(&weight).sum();
    rows.map(|row| weight(row) * values[row]).sum::<f64>() / weights
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::document::Diagnostics;
    use crate::effect::Catalogue;
    use crate::inference::likelihood::Likelihood;
    use crate::inference::target::{LeastSquares, Target};
    use crate::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

    /// A ramp over ten rows in blocks of two: it strays little; a switch strays wholly.
    #[test]
    fn a_switch_strays_from_its_means_and_a_ramp_does_not() {
        let kept = [0, 2, 4, 6, 8, 9];
        let ramp: Vec<f64> = (0..10).map(f64::from).collect();
        // Squares of 1/2 in four blocks, 0 in the last one and in the last row, over 82.5.
        assert!((strays(&ramp, &kept) - (2.0_f64 / 82.5).sqrt()).abs() < 1e-12);
        let switch: Vec<f64> = (0..10).map(|row| f64::from(row % 2)).collect();
        assert!(strays(&switch, &kept) > 0.8);
        assert_eq!(strays(&[3.0; 10], &kept), 0.0);
    }

    /// Constant values count by their time, the value of a kept row between kept rows; linear ones by their rows about it.
    #[test]
    fn inputs_become_means_about_the_rows_that_are_kept() {
        let column = |hold| InputColumn { input: 0, values: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0], hold };
        let table = |hold| InputTable {
            times_s: vec![0.0, 1.0, 3.0, 4.0, 5.0, 6.0],
            columns: vec![column(hold)],
            base: vec![0.0],
        };
        let held = means(&table(true), &[0, 2, 4, 5]);
        assert_eq!(held.times_s, [0.0, 3.0, 5.0, 6.0]);
        // (1 x 1 + 2 x 2) / 3, (4 + 8) / 2, 16, 32.
        assert_eq!(held.columns[0].values, [5.0 / 3.0, 6.0, 16.0, 32.0]);
        let linear = means(&table(false), &[0, 2, 4, 5]);
        // Weights 1 and 2/3 of rows 0 and 1; 1/3, 1 and 1/2 of rows 1 to 3; 1/2 and 1 of rows 3 and 4; 1 of row 5.
        let expected = [1.4, 52.0 / 11.0, 40.0 / 3.0, 32.0];
        for (value, expected) in linear.columns[0].values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-12, "{value} for {expected}");
        }
    }

    /// Of an orbit: derivatives drawn between every third row are those on all rows to a few per cent of each column, residuals are
    /// the same.
    #[test]
    fn derivatives_on_fewer_rows_are_near_those_on_all() {
        let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
        let recipe = Recipe::of(Topology::Star, TestKind::Orbit, InjectionRequest::default());
        let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
        let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
        let fewer = |measurement: &Measurement| {
            let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
            let last = likelihood.data().iter().map(|datum| datum.row).max()?;
            let rows: Vec<usize> = (0..last).step_by(3).chain([last]).collect();
            Some(FewerRows { inputs: means(inputs, &rows), rows, tolerance: 1.0 })
        };
        let fewer: Vec<Option<FewerRows>> = problem.measurements.iter().map(fewer).collect();
        let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
        let evaluate = |likelihood: &Likelihood| {
            let (rows, n) = (likelihood.residual_count(), likelihood.dimension());
            let (mut residuals, mut jacobian) = (vec![0.0; rows], vec![0.0; rows * n]);
            let mut memory = likelihood.workspace();
            likelihood.jacobian(&unknowns, &mut memory, &mut residuals, &mut jacobian, &mut vec![0.0; n]).unwrap();
            (residuals, jacobian)
        };
        let (residuals, exact) = evaluate(&likelihood);
        let (same, drawn) = evaluate(&likelihood.clone().with_slopes_on(&fewer));
        assert_eq!(residuals, same);
        assert_ne!(exact, drawn);
        let n = likelihood.dimension();
        for (place, name) in likelihood.names().iter().enumerate() {
            let norm = |value: &dyn Fn(usize) -> f64| {
                (place..exact.len()).step_by(n).map(|at| value(at) * value(at)).sum::<f64>().sqrt()
            };
            let (off, size) = (norm(&|at| drawn[at] - exact[at]), norm(&|at| exact[at]));
            assert!(off < 0.05 * size, "{name}: {off} of {size}");
        }
    }
}
