//! Readings beside their predictions: a table a measurement, each number once.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::job::array::{Array, Arrays};
use crate::measurement::{Measurement, Rows};
use crate::thermal::Model;

/// A reading beside its prediction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Row")]
pub struct Row<Name = String> {
    /// Measurement.
    pub measurement: Name,
    /// Phase of a steady measurement.
    pub phase: Option<Name>,
    /// Instant of a transient, s.
    pub time_s: Option<f64>,
    /// Sensor.
    pub sensor: Name,
    /// SI unit.
    pub unit: Name,
    /// Reading, SI.
    pub measured: f64,
    /// Prediction, SI.
    pub predicted: f64,
    /// Prediction of the tuned state, SI.
    #[serde(default)]
    pub predicted_tuned: Option<f64>,
    /// Kept from every fit.
    pub held_out: bool,
}

impl<Name> Row<Name> {
    /// Measured minus predicted, SI.
    pub fn deviation(&self) -> f64 {
        self.measured - self.predicted
    }

    /// Measured minus predicted of the tuned state, SI; `None` without one.
    pub fn tuned_deviation(&self) -> Option<f64> {
        Some(self.measured - self.predicted_tuned?)
    }
}

impl Row<&str> {
    /// The same with names of its own.
    pub fn to_owned(self) -> Row {
        Row {
            measurement: self.measurement.to_owned(),
            phase: self.phase.map(str::to_owned),
            sensor: self.sensor.to_owned(),
            unit: self.unit.to_owned(),
            time_s: self.time_s,
            measured: self.measured,
            predicted: self.predicted,
            predicted_tuned: self.predicted_tuned,
            held_out: self.held_out,
        }
    }
}

/// A sensor of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Sensor.
    pub sensor: String,
    /// SI unit.
    pub unit: String,
}

/// A phase or an instant of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<'t> {
    /// Phase of a steady measurement.
    pub phase: Option<&'t str>,
    /// Instant of a transient, s.
    pub time_s: Option<f64>,
    /// Kept from every fit.
    pub held_out: bool,
}

/// The readings of a measurement: a row a moment, a column a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Measurement.
    pub measurement: String,
    /// Sensors, in the order of the columns.
    pub channels: Vec<Channel>,
    /// Phase of each row; none of a transient.
    pub(super) phases: Vec<Option<String>>,
    /// Instant of each row, s; none of a steady measurement.
    pub(super) time_s: Option<Array>,
    /// 1 for each row that is kept from every fit, else 0.
    pub(super) held_out: Array,
    /// Readings, SI; NaN where none was read, or nothing predicted.
    pub(super) measured: Array,
    /// Predictions, SI.
    pub(super) predicted: Array,
    /// Predictions of the tuned state, SI; NaN where it has none.
    pub(super) tuned: Option<Array>,
}

impl Table {
    /// A measurement beside what is predicted of it, for all its rows and sensors; rows that are left out altogether are not
    /// among those of the table. What is predicted of a tuned state may be empty.
    pub fn new(measurement: &Measurement, model: &Model, predicted: &[f64], tuned: &[f64]) -> Self {
        let columns = measurement.sensors.len();
        let rows: Vec<usize> = (0..measurement.len()).filter(|&row| !measurement.ignored(row)).collect();
        let of_rows = |values: Vec<f64>| Array::new(vec![rows.len()], values);
        let (phases, time_s) = match &measurement.rows {
            Rows::Steady(phases) => (rows.iter().map(|&row| Some(phases[row].name.clone())).collect(), None),
            Rows::Transient { inputs, .. } => (Vec::new(), Some(rows.iter().map(|&row| inputs.times_s[row]).collect())),
        };
        let held_out = rows.iter().map(|&row| f64::from(u8::from(measurement.held_out(row)))).collect();
        let places = || rows.iter().flat_map(|row| row * columns..(row + 1) * columns);
        let read = |place: usize| {
            let is_predicted = predicted.get(place).is_some_and(|value| value.is_finite());
            measurement.readings.get(place).copied().flatten().filter(|_| is_predicted)
        };
        let of = |values: &[f64]| -> Vec<f64> {
            let at = |place: usize| values.get(place).copied().filter(|v| v.is_finite() && read(place).is_some());
            places().map(|place| at(place).unwrap_or(f64::NAN)).collect()
        };
        let tuned = of(tuned);
        let shape = || vec![rows.len(), columns];
        Self {
            measurement: measurement.name.clone(),
            channels: (measurement.sensors.iter())
                .map(|sensor| Channel {
                    sensor: sensor.name.clone(),
                    unit: model.quantities[sensor.quantity].unit.clone(),
                })
                .collect(),
            phases,
            time_s: time_s.map(of_rows),
            held_out: of_rows(held_out),
            measured: Array::new(shape(), places().map(|place| read(place).unwrap_or(f64::NAN)).collect()),
            predicted: Array::new(shape(), of(predicted)),
            tuned: tuned.iter().any(|value| !value.is_nan()).then(|| Array::new(shape(), tuned)),
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.held_out.numbers().len()
    }

    /// Whether it has no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// When a row was read.
    pub fn moment(&self, row: usize) -> Moment<'_> {
        let of = |array: &Array| array.numbers().get(row).copied();
        Moment {
            phase: self.phases.get(row).and_then(Option::as_deref),
            time_s: self.time_s.as_ref().and_then(of).filter(|value| !value.is_nan()),
            held_out: of(&self.held_out) == Some(1.0),
        }
    }

    /// The reading of a row and a column; `None` where there is none.
    pub fn at(&self, row: usize, column: usize) -> Option<Row<&str>> {
        let (channel, moment) = (self.channels.get(column)?, self.moment(row));
        let place = row * self.channels.len() + column;
        let of = |array: &Array| array.numbers().get(place).copied();
        Some(Row {
            measurement: &self.measurement,
            phase: moment.phase,
            time_s: moment.time_s,
            sensor: &channel.sensor,
            unit: &channel.unit,
            measured: of(&self.measured).filter(|value| !value.is_nan())?,
            predicted: of(&self.predicted)?,
            predicted_tuned: self.tuned.as_ref().and_then(of).filter(|value| !value.is_nan()),
            held_out: moment.held_out,
        })
    }

    /// The readings of some rows, row by row.
    pub fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = Row<&str>> {
        rows.flat_map(move |row| (0..self.channels.len()).filter_map(move |column| self.at(row, column)))
    }

    /// The readings, row by row.
    pub fn iter(&self) -> impl Iterator<Item = Row<&str>> {
        self.rows(0..self.len())
    }

    /// The readings of a column.
    pub fn column(&self, column: usize) -> impl Iterator<Item = Row<&str>> {
        (0..self.len()).filter_map(move |row| self.at(row, column))
    }

    /// The readings of a sensor.
    pub fn of(&self, sensor: &str) -> impl Iterator<Item = Row<&str>> {
        let columns = (0..self.channels.len()).filter(move |&column| self.channels[column].sensor == sensor);
        columns.flat_map(|column| self.column(column))
    }

    /// The moments with a reading.
    pub fn moments_read(&self) -> impl Iterator<Item = Moment<'_>> {
        let is_read = |row: &usize| self.rows(*row..row + 1).next().is_some();
        (0..self.len()).filter(is_read).map(|row| self.moment(row))
    }

    /// The sensors with a reading, in the order of their first ones.
    pub fn channels_read(&self) -> Vec<&Channel> {
        let first_row = |column: usize| (0..self.len()).find(|&row| self.at(row, column).is_some());
        let columns = 0..self.channels.len();
        let mut read: Vec<(usize, usize)> = columns.filter_map(|column| Some((first_row(column)?, column))).collect();
        read.sort_unstable();
        read.into_iter().map(|(_, column)| &self.channels[column]).collect()
    }

    fn count(&self) -> usize {
        self.measured.numbers().iter().filter(|value| !value.is_nan()).count()
    }
}

/// The readings of a comparison, measurement by measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// A table a measurement.
    pub(super) tables: Vec<Table>,
}

impl Readings {
    /// The tables.
    pub fn tables(&self) -> &[Table] {
        &self.tables
    }

    /// The tables of a measurement: one, unless the readings of several were mixed.
    pub fn of_measurement(&self, measurement: &str) -> impl Iterator<Item = &Table> {
        self.tables.iter().filter(move |table| table.measurement == measurement)
    }

    /// Number of readings.
    pub fn len(&self) -> usize {
        self.tables.iter().map(Table::count).sum()
    }

    /// Whether there is no reading.
    pub fn is_empty(&self) -> bool {
        self.first().is_none()
    }

    /// The first reading.
    pub fn first(&self) -> Option<Row<&str>> {
        self.iter().next()
    }

    /// The readings, measurement by measurement and row by row.
    pub fn iter(&self) -> impl Iterator<Item = Row<&str>> {
        self.tables.iter().flat_map(Table::iter)
    }

    /// The readings of a sensor in a measurement.
    pub fn of(&self, measurement: &str, sensor: &str) -> impl Iterator<Item = Row<&str>> {
        self.of_measurement(measurement).flat_map(move |table| table.of(sensor))
    }

    /// The arrays, each with a name, that do not stand in the JSON of the readings; none of a few readings.
    pub fn arrays(&self) -> Vec<(String, Array)> {
        if !is_long(self.len()) {
            return Vec::new();
        }
        let of_table = |table: &Table| {
            let arrays = [
                ("time", table.time_s.as_ref()),
                ("held-out", Some(&table.held_out)),
                ("measured", Some(&table.measured)),
                ("predicted", Some(&table.predicted)),
                ("tuned", table.tuned.as_ref()),
            ];
            let name = |what: &str| format!("{what} {}", table.measurement);
            arrays.map(|(what, array)| Some((name(what), array?.clone())))
        };
        self.tables.iter().flat_map(of_table).flatten().collect()
    }

    /// Puts numbers that were read beside the JSON into their places.
    ///
    /// # Errors
    /// The hash of an array that is not among these.
    pub fn fill(&mut self, arrays: &Arrays) -> Result<(), String> {
        let of_table = |table: &mut Table| {
            let Table { time_s, held_out, measured, predicted, tuned, .. } = table;
            let optional = time_s.iter_mut().chain(tuned);
            [held_out, measured, predicted].into_iter().chain(optional).try_for_each(|array| arrays.fill(array))
        };
        self.tables.iter_mut().try_for_each(of_table)
    }
}

/// Readings up to which all of them stand in JSON, a row each.
const MOST_ROWS: usize = 20_000;

/// Whether so many readings stand as arrays beside the JSON.
pub fn is_long(readings: usize) -> bool {
    readings > MOST_ROWS
}

impl FromIterator<Table> for Readings {
    fn from_iter<T: IntoIterator<Item = Table>>(tables: T) -> Self {
        Self { tables: tables.into_iter().collect() }
    }
}
