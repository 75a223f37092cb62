//! Readings put together from single rows, whose order is kept.

use super::readings::{Channel, Readings, Row, Table};
use crate::job::array::Array;

/// Phase, instant, and whether it is held out.
type Moment = (Option<String>, Option<f64>, bool);

/// A table that grows reading by reading.
struct Growing {
    measurement: String,
    channels: Vec<Channel>,
    moments: Vec<Moment>,
    /// Row, column and numbers of each reading, in order: measured, predicted, predicted of the tuned state.
    cells: Vec<(usize, usize, [f64; 3])>,
}

impl Growing {
    fn new(measurement: String) -> Self {
        Self { measurement, channels: Vec::new(), moments: Vec::new(), cells: Vec::new() }
    }

    /// Adds a reading behind all that are there: to the last row, where it is of the same moment and stands right of the
    /// others, else to a new one.
    fn add(&mut self, row: Row) {
        let numbers = [row.measured, row.predicted, row.predicted_tuned.unwrap_or(f64::NAN)];
        let channel = Channel { sensor: row.sensor, unit: row.unit };
        let moment = (row.phase, row.time_s, row.held_out);
        let is_same = self.moments.last() == Some(&moment);
        let after = self.cells.last().filter(|_| is_same).map_or(0, |last| last.1 + 1);
        let mut right = self.channels.iter().skip(after);
        let (column, is_in_row) = match right.position(|own| *own == channel) {
            Some(at) => (after + at, is_same),
            None => match self.channels.iter().position(|own| *own == channel) {
                Some(at) => (at, false),
                None => {
                    self.channels.insert(after, channel);
                    self.cells.iter_mut().filter(|cell| cell.1 >= after).for_each(|cell| cell.1 += 1);
                    (after, is_same)
                }
            },
        };
        if !is_in_row {
            self.moments.push(moment);
        }
        self.cells.push((self.moments.len() - 1, column, numbers));
    }

    fn finished(self) -> Table {
        let [rows, columns] = [self.moments.len(), self.channels.len()];
        let of_readings = |which: usize| {
            let mut values = vec![f64::NAN; rows * columns];
            for (row, column, numbers) in &self.cells {
                values[row * columns + column] = numbers[which];
            }
            Array::new(vec![rows, columns], values)
        };
        let of_rows = |value: fn(&Moment) -> f64| Array::new(vec![rows], self.moments.iter().map(value).collect());
        let has = |is: fn(&Moment) -> bool| self.moments.iter().any(is);
        let is_tuned = self.cells.iter().any(|(_, _, numbers)| !numbers[2].is_nan());
        Table {
            time_s: has(|moment| moment.1.is_some()).then(|| of_rows(|moment| moment.1.unwrap_or(f64::NAN))),
            held_out: of_rows(|moment| f64::from(u8::from(moment.2))),
            measured: of_readings(0),
            predicted: of_readings(1),
            tuned: is_tuned.then(|| of_readings(2)),
            phases: if has(|moment| moment.0.is_some()) {
                self.moments.into_iter().map(|moment| moment.0).collect()
            } else {
                Vec::new()
            },
            measurement: self.measurement,
            channels: self.channels,
        }
    }
}

impl FromIterator<Row> for Readings {
    fn from_iter<T: IntoIterator<Item = Row>>(rows: T) -> Self {
        let mut tables: Vec<Growing> = Vec::new();
        for row in rows {
            if tables.last().is_none_or(|table| table.measurement != row.measurement) {
                tables.push(Growing::new(row.measurement.clone()));
            }
            if let Some(table) = tables.last_mut() {
                table.add(row);
            }
        }
        tables.into_iter().map(Growing::finished).collect()
    }
}
