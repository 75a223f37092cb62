//! Directions of effects on nodes over long records, from transients of fewer rows.
//!
//! An input that changes in every row makes the integrator stop in every row, for every effect. What an effect at a node
//! would change is smoother than the readings and needs to be known to a few per cent only, since it orders effects and
//! begins fits. So inputs become means over several rows, and directions are drawn straight between these. Residuals,
//! Jacobian and all fits keep every row, as do effects on sensors, which see the quickest changes, and effects that go with an
//! input which its means do not follow, such as a switch.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::Range;

use super::blank::blank;
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::linear::Direction;
use crate::diagnosis::problem::Problem;
use crate::effect::Site;
use crate::inference::likelihood::{Datum, InputError, Likelihood};
use crate::measurement::{InputColumn, InputTable, Measurement, Rows};

/// Rows of a transient up to which every row is kept.
const MOST_ROWS: usize = 1000;
/// Rows that are left of longer ones.
const ROWS_LEFT: usize = 500;

/// Times the usual local error that a step may have: some hundredths of a kelvin.
const TOLERANCE: f64 = 100.0;

/// Distance of an input from its means, as a share of its spread, above which these do not follow it.
const MOST_STRAYING: f64 = 0.3;

/// A problem with fewer rows, whose residuals are predictions.
pub(super) struct Coarse {
    problem: Problem,
    likelihood: Likelihood,
    unknowns: Vec<f64>,
    /// Of each reading of the original the coarse readings before and after it, and the share of the one after.
    places: Vec<Place>,
    /// Of each input whether its means do not follow it.
    is_quick: Vec<bool>,
}

#[derive(Clone, Copy)]
struct Place {
    before: usize,
    after: usize,
    share: f64,
}

impl Coarse {
    /// `None` where no transient is long.
    pub fn new(base: &Base<'_>) -> Result<Option<Self>, FitError> {
        let data = base.likelihood.data();
        let kept: Vec<Option<Vec<usize>>> = (base.problem.measurements.iter().enumerate())
            .map(|(measurement, own)| kept_rows(own, measurement, data))
            .collect();
        if kept.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut is_quick = vec![false; base.problem.model.inputs.len()];
        for (measurement, rows) in base.problem.measurements.iter().zip(&kept) {
            if let (Rows::Transient { inputs, .. }, Some(rows)) = (&measurement.rows, rows) {
                let quick = inputs.columns.iter().filter(|column| strays(&column.values, rows) > MOST_STRAYING);
                quick.for_each(|column| is_quick[column.input] = true);
            }
        }
        let mut problem = Problem { tolerance: TOLERANCE, ..base.problem.clone() };
        for (measurement, rows) in problem.measurements.iter_mut().zip(&kept) {
            if let Some(rows) = rows {
                thin(measurement, rows);
            }
            *measurement = blank(measurement);
        }
        for error in &mut problem.input_errors {
            *error = InputError { sigma: None, ..*error };
        }
        let likelihood = problem.hypothesis(&[], 1.0)?.likelihood(&problem)?;
        let unknowns = base.carried(&likelihood);
        let coarse: HashMap<(usize, usize, usize), usize> = (likelihood.data().iter().enumerate())
            .map(|(position, datum)| ((datum.measurement, datum.row, datum.sensor), position))
            .collect();
        let places = data.iter().filter_map(|datum| {
            let position = |row: usize| coarse.get(&(datum.measurement, row, datum.sensor)).copied();
            let Some(rows) = &kept[datum.measurement] else {
                let same = position(datum.row)?;
                return Some(Place { before: same, after: same, share: 0.0 });
            };
            let after = rows.partition_point(|&row| row < datum.row);
            let before = if rows[after] == datum.row { after } else { after - 1 };
            let times_s = times(&base.problem.measurements[datum.measurement]);
            let share = if before == after {
                0.0
            } else {
                (times_s[datum.row] - times_s[rows[before]]) / (times_s[rows[after]] - times_s[rows[before]])
            };
            Some(Place { before: position(before)?, after: position(after)?, share })
        });
        let places: Vec<Place> = places.collect();
        // A reading without a place would shift all others.
        Ok((places.len() == data.len()).then_some(Self { problem, likelihood, unknowns, places, is_quick }))
    }

    /// Whether a candidate is to be found on fewer rows.
    pub fn takes(&self, position: usize) -> bool {
        let candidate = &self.problem.candidates[position];
        matches!(candidate.site, Site::Nodes(_) | Site::Pair(_) | Site::Elements(_))
            && !candidate.inputs(&self.problem.model).into_iter().any(|input| self.is_quick[input])
    }

    /// The baseline model on fewer rows.
    pub fn base(&self) -> Result<Base<'_>, FitError> {
        Base::new(&self.problem, &self.likelihood, &self.unknowns)
    }

    /// Directions on all rows, whitened as the original's, from those on fewer rows.
    pub fn on_all_rows(&self, base: &Base<'_>, found: Found) -> Found {
        found?.into_iter().map(|direction| self.one_on_all_rows(base, direction)).collect()
    }

    fn one_on_all_rows(&self, base: &Base<'_>, direction: Direction) -> Result<Direction, FitError> {
        let mut columns = Vec::with_capacity(direction.amplitudes() * base.rows);
        let mut column = vec![0.0; base.residuals.len()];
        for amplitude in 0..direction.amplitudes() {
            let coarse = direction.column(amplitude);
            for (value, place) in column.iter_mut().zip(&self.places) {
                *value = coarse[place.before] + place.share * (coarse[place.after] - coarse[place.before]);
            }
            base.whitening.apply(&mut column)?;
            columns.extend(&column);
            columns.resize((amplitude + 1) * base.rows, 0.0);
        }
        Ok(Direction { columns, ..direction })
    }
}

fn times(measurement: &Measurement) -> &[f64] {
    match &measurement.rows {
        Rows::Steady(_) => &[],
        Rows::Transient { inputs, .. } => &inputs.times_s,
    }
}

/// The rows that a long transient keeps: one of several, and the last with a reading to fit. `None` where all are kept.
fn kept_rows(measurement: &Measurement, position: usize, data: &[Datum]) -> Option<Vec<usize>> {
    let last = data.iter().filter(|datum| datum.measurement == position).map(|datum| datum.row).max()?;
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
    measurement.readings.truncate(kept.len() * sensors);
    if let Rows::Transient { inputs, held_out, ignored, .. } = &mut measurement.rows {
        *inputs = means(inputs, kept);
        *held_out = vec![false; kept.len()];
        *ignored = vec![None; kept.len()];
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
    use super::*;

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
}
