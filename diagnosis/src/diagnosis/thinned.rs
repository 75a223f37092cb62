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
/// Rows that are left of longer ones: the fewest that follow all inputs, or the first where none of these does. What goes with the orbit
/// wants six rows a revolution.
const ROWS_LEFT: [usize; 4] = [500, 1000, 2000, 4000];

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
    /// Whether a transient is long: every fit of it takes its time.
    pub(crate) fn has_long_transients(&self) -> bool {
        let is_long = |own: &Measurement| last_fitted(own).is_some_and(|last| last >= MOST_ROWS);
        self.measurements.iter().any(|own| matches!(own.rows, Rows::Transient { .. }) && is_long(own))
    }

    /// The problem on fewer rows, whose transients may err by so many times the usual local error in a step. `None` where no
    /// transient is long.
    pub(crate) fn thinned(&self, tolerance: f64) -> Option<Thinned> {
        let mut is_quick = vec![false; self.model.inputs.len()];
        let kept: Vec<Option<Vec<usize>>> =
            self.measurements.iter().map(|measurement| kept_rows(measurement, &mut is_quick)).collect();
        if kept.iter().all(Option::is_none) {
            return None;
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

/// The rows that a long transient keeps: one of several, and the last with a reading to fit. `None` where all are kept. Inputs that
/// they do not follow become quick ones.
fn kept_rows(measurement: &Measurement, is_quick: &mut [bool]) -> Option<Vec<usize>> {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
    let last = last_fitted(measurement).filter(|last| *last >= MOST_ROWS)?;
    let quick = |rows: &[usize]| -> Vec<usize> {
        let strays = inputs.columns.iter().filter(|column| strays(&column.values, rows) > MOST_STRAYING);
        strays.map(|column| column.input).collect()
    };
    // Where half of the rows are kept, little is gained.
    let mut all = ROWS_LEFT.into_iter().filter(|left| 2 * left <= last).map(|left| one_of_several(last, left));
    let first = one_of_several(last, ROWS_LEFT[0]);
    let kept = all.find(|rows| quick(rows).is_empty()).unwrap_or(first);
    quick(&kept).into_iter().for_each(|input| is_quick[input] = true);
    Some(kept)
}

/// So many rows up to the last, evenly, and this.
fn one_of_several(last: usize, left: usize) -> Vec<usize> {
    (0..last).step_by(last.div_ceil(left)).chain([last]).collect()
}

/// The last row with a reading to fit.
pub(crate) fn last_fitted(measurement: &Measurement) -> Option<usize> {
    let has_reading =
        |&row: &usize| (0..measurement.sensors.len()).any(|sensor| measurement.reading(row, sensor).is_some());
    measurement.fitted_rows().rev().find(has_reading)
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
pub fn means(inputs: &InputTable, kept: &[usize]) -> InputTable {
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
pub fn strays(values: &[f64], kept: &[usize]) -> f64 {
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
