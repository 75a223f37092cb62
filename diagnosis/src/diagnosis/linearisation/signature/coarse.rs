//! Directions of effects on nodes over long records, from transients of fewer rows.
//!
//! What an effect at a node would change is smoother than the readings and needs to be known to a few per cent only, since it
//! orders effects and begins fits. So it is drawn straight between the rows of a thinned problem. Residuals and Jacobian keep
//! every row, as do effects on sensors, which see the quickest changes, and effects that go with an input which its means do
//! not follow, such as a switch.

use std::collections::HashMap;

use super::blank::blank;
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::linear::Direction;
use crate::diagnosis::thinned::{Thinned, times};
use crate::inference::likelihood::Likelihood;
use crate::measurement::Rows;

/// Times the usual local error that a step may have: some hundredths of a kelvin.
const TOLERANCE: f64 = 100.0;

/// A problem with fewer rows, whose residuals are predictions.
pub(super) struct Coarse {
    thinned: Thinned,
    likelihood: Likelihood,
    unknowns: Vec<f64>,
    /// Of each reading of the original the coarse readings before and after it, and the share of the one after.
    places: Vec<Place>,
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
        let Some(mut thinned) = base.problem.thinned(TOLERANCE) else { return Ok(None) };
        for (measurement, rows) in thinned.problem.measurements.iter_mut().zip(&thinned.kept) {
            *measurement = blank(measurement);
            if let (Rows::Transient { held_out, ignored, .. }, Some(_)) = (&mut measurement.rows, rows) {
                // A direction is drawn between all rows that are left.
                held_out.fill(false);
                ignored.fill(None);
            }
        }
        let (data, kept) = (base.likelihood.data(), &thinned.kept);
        let problem = &thinned.problem;
        let likelihood = problem.hypothesis(&[], 1.0)?.likelihood(problem)?;
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
        Ok((places.len() == data.len()).then_some(Self { thinned, likelihood, unknowns, places }))
    }

    /// By measurement the rows that are left; `None` where all are.
    pub fn kept(&self) -> &[Option<Vec<usize>>] {
        &self.thinned.kept
    }

    /// Whether a candidate is to be found on fewer rows.
    pub fn takes(&self, position: usize) -> bool {
        self.thinned.shows(position)
    }

    /// The baseline model on fewer rows.
    pub fn base(&self) -> Result<Base<'_>, FitError> {
        Base::new(&self.thinned.problem, &self.likelihood, &self.unknowns)
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
