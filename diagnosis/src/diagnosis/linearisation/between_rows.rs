//! Coordinates of columns that are drawn straight between kept rows of long records.
//!
//! Between two kept rows such a column, passed through the lag of its sensor and whitened, is a linear function of four numbers: the
//! change at either end, and the states in which lag and filter begin. So its readings there lie in the span of at most four
//! columns, and coordinates in an orthonormal basis of that span have the scalar products of the readings, of which there are many more.

use crate::diagnosis::linearisation::linear::Linear;
use crate::inference::likelihood::{Course, Filter, Whitening};
use crate::math::dense::dot_of_columns as dot;
use crate::math::scalar_products::{add_scaled, orthonormal};
use crate::measurement::lag;

/// Coordinates are no gain unless there are so many rows for each.
const LEAST_ROWS_EACH: usize = 2;
/// Columns of an interval whose remainder is shorter than this share of them depend on the others.
const DEPENDENT: f64 = 1e-10;

/// Changes at both ends of an interval, the lagged reading and the state of the filter at its beginning.
type Begin = [f64; 4];

/// A sensor over a transient between two kept rows.
#[derive(Clone, Debug, PartialEq)]
struct Interval {
    /// Its first row.
    first: usize,
    /// Number of its rows.
    rows: usize,
    /// Orthonormal columns of its rows, one after the other.
    basis: Vec<f64>,
    /// Coordinates of a unit of each number, by coordinate.
    coordinates: Vec<Begin>,
    /// The lagged reading and the state of the filter at its end, of a unit of each number.
    end: [Begin; 2],
}

/// The intervals of a sensor in a transient.
#[derive(Clone, Debug, PartialEq)]
struct SensorIntervals {
    intervals: Vec<Interval>,
    /// Position of its first coordinate.
    first: usize,
    /// Number of its coordinates.
    dimensions: usize,
}

/// Coordinates of columns that are drawn between kept rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BetweenRows {
    /// By transient and sensor, in the order of the courses.
    sensors: Vec<Vec<SensorIntervals>>,
    /// Rows that have a coordinate of their own: steady phases and priors.
    own: Vec<usize>,
    /// Position of the first of these coordinates.
    first_own: usize,
    rows: usize,
    /// Position of the first of the coordinates that are left for what residuals and slopes of a linear problem have beside the others.
    first_beside: usize,
    dimensions: usize,
}

impl BetweenRows {
    /// Of so many `rows`, those of the priors with them, and `parameters`. `None` where coordinates are no gain, or a clock that is off
    /// shows in an interval what happens in others.
    pub fn new(courses: &[Course], whitening: &Whitening, rows: usize, parameters: usize) -> Option<Self> {
        let mut sensors = courses.iter().flat_map(|course| &course.sensors);
        if sensors.any(|sensor| sensor.timing.behind_s != 0.0) {
            return None;
        }
        let mut has_own = vec![true; rows];
        let mut all = Self { rows, ..Self::default() };
        for course in courses {
            let mut sensors = Vec::with_capacity(course.sensors.len());
            for (position, sensor) in course.sensors.iter().enumerate() {
                // A sensor without a reading shares its first residual with another.
                let filter = (!sensor.rows.is_empty()).then(|| whitening.series(sensor.first)).flatten();
                let intervals = match filter {
                    Some(filter) => intervals(course, position, filter),
                    None if sensor.rows.is_empty() => Vec::new(),
                    None => return None,
                };
                has_own.get_mut(sensor.first..sensor.first + sensor.rows.len())?.fill(false);
                let dimensions = intervals.iter().map(|one| one.coordinates.len()).sum();
                sensors.push(SensorIntervals { intervals, first: all.dimensions, dimensions });
                all.dimensions += dimensions;
            }
            all.sensors.push(sensors);
        }
        all.own = (0..rows).filter(|&row| has_own[row]).collect();
        all.first_own = all.dimensions;
        all.first_beside = all.dimensions + all.own.len();
        all.dimensions = all.first_beside + parameters + 1;
        (LEAST_ROWS_EACH * all.dimensions <= rows).then_some(all)
    }

    /// Number of coordinates.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes the coordinates of what a transient adds to a sensor's readings, from its changes at the kept rows.
    pub fn of_changes(&self, transient: usize, sensor: usize, change: impl Fn(usize) -> f64, coordinates: &mut [f64]) {
        let own = &self.sensors[transient][sensor];
        let mut slots = coordinates[own.first..own.first + own.dimensions].iter_mut();
        // Where a record begins, a lag has passed.
        let (mut lagged, mut state) = (change(0), 0.0);
        for (place, interval) in own.intervals.iter().enumerate() {
            let begin = [change(place), change(place + 1), lagged, state];
            let of_begin = |unit: &Begin| unit.iter().zip(&begin).map(|(unit, value)| unit * value).sum::<f64>();
            for (unit, slot) in interval.coordinates.iter().zip(&mut slots) {
                *slot = of_begin(unit);
            }
            [lagged, state] = interval.end.each_ref().map(of_begin);
        }
    }

    /// Whether some of the first `readings` rows have a coordinate of their own.
    pub(super) fn has_own_readings(&self, readings: usize) -> bool {
        self.own.first().is_some_and(|&row| row < readings)
    }

    /// Sets the coordinates of the rows that have their own.
    pub(super) fn of_own_rows(&self, column: &[f64], coordinates: &mut [f64]) {
        for (slot, &row) in coordinates[self.first_own..self.first_beside].iter_mut().zip(&self.own) {
            *slot = column.get(row).copied().unwrap_or(0.0);
        }
    }

    /// The rows that coordinates stand for.
    pub fn rows_of(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut column = vec![0.0; self.rows];
        let mut place = 0;
        for interval in self.sensors.iter().flatten().flat_map(|sensor| &sensor.intervals) {
            let rows = &mut column[interval.first..interval.first + interval.rows];
            for basis in interval.basis.chunks_exact(interval.rows.max(1)) {
                add_scaled(rows, coordinates[place], basis);
                place += 1;
            }
        }
        for (&row, value) in self.own.iter().zip(&coordinates[self.first_own..self.first_beside]) {
            column[row] = *value;
        }
        column
    }

    /// The coordinates of the part of a column that lies in the span of the intervals; what is left of the column stays in it.
    fn take_out(&self, column: &mut [f64]) -> Vec<f64> {
        let mut coordinates = Vec::with_capacity(self.dimensions);
        for interval in self.sensors.iter().flatten().flat_map(|sensor| &sensor.intervals) {
            let rows = &mut column[interval.first..interval.first + interval.rows];
            for basis in interval.basis.chunks_exact(interval.rows.max(1)) {
                let along = dot(rows, basis);
                add_scaled(rows, -along, basis);
                coordinates.push(along);
            }
        }
        for &row in &self.own {
            coordinates.push(std::mem::replace(&mut column[row], 0.0));
        }
        coordinates
    }

    /// A linear problem in coordinates: those of this basis, and those of what residuals and slopes have beside it. Columns of
    /// this basis have zeros there. Its rows have another order, so that none of them is known to be that of a prior.
    pub fn linear(&self, linear: &Linear) -> Linear {
        let p = linear.parameters();
        let mut columns: Vec<Vec<f64>> =
            (0..p).map(|k| linear.jacobian.iter().skip(k).step_by(p.max(1)).copied().collect()).collect();
        columns.push(linear.residuals.clone());
        let inside: Vec<Vec<f64>> = columns.iter_mut().map(|column| self.take_out(column)).collect();
        let left: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let (basis, _) = orthonormal(&left, Vec::new(), DEPENDENT);
        let mut all: Vec<Vec<f64>> = (inside.into_iter().zip(&left))
            .map(|(mut inside, left)| {
                inside.extend(basis.chunks_exact(self.rows.max(1)).map(|q| dot(q, left)));
                inside.resize(self.dimensions, 0.0);
                inside
            })
            .collect();
        let residuals = all.pop().unwrap_or_default();
        let rows = residuals.len();
        let jacobian = (0..rows).flat_map(|row| all.iter().map(move |column| column[row])).collect();
        Linear { rows, readings: rows, residuals, jacobian, ..linear.clone() }
    }
}

/// The intervals of a sensor of a transient.
fn intervals(course: &Course, sensor: usize, filter: &Filter) -> Vec<Interval> {
    let own = &course.sensors[sensor];
    let times_s = &course.inputs.times_s[..course.rows];
    let mut first = 0;
    let interval = |ends: &[usize]| {
        let (from, to) = (ends[0], ends[1]);
        // The row at which a record begins belongs to its first interval.
        let begins = if from == 0 { 0 } else { from + 1 };
        let rows = own.rows[first..].partition_point(|&row| row <= to);
        let readings = &own.rows[first..first + rows];
        let span_s = times_s[to] - times_s[from];
        let mut columns = Vec::with_capacity(4);
        let mut end = [Begin::default(); 2];
        for number in 0..4 {
            let mut begin = Begin::default();
            begin[number] = 1.0;
            let [before, after, mut lagged, mut state] = begin;
            let truth = |row: usize| before + (after - before) * (times_s[row] - times_s[from]) / span_s;
            let mut column = Vec::with_capacity(rows);
            for row in begins..=to {
                if row > from {
                    let truth = [truth(row - 1), truth(row)];
                    lagged = lag::after_step(times_s[row] - times_s[row - 1], own.timing.lag_s, truth, lagged);
                }
                if readings.get(column.len()) == Some(&row) {
                    column.push(filter.step(first + column.len(), lagged, &mut state));
                }
            }
            columns.push(column);
            (end[0][number], end[1][number]) = (lagged, state);
        }
        let of_columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let basis = if rows > 0 { orthonormal(&of_columns, Vec::new(), DEPENDENT).0 } else { Vec::new() };
        let of_basis = |basis: &[f64]| {
            let mut coordinates = Begin::default();
            for (coordinate, column) in coordinates.iter_mut().zip(&of_columns) {
                *coordinate = dot(basis, column);
            }
            coordinates
        };
        let coordinates = basis.chunks_exact(rows.max(1)).map(of_basis).collect();
        let interval = Interval { first: own.first + first, rows, basis, coordinates, end };
        first += rows;
        interval
    };
    course.kept.windows(2).map(interval).collect()
}
