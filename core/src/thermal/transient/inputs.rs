//! Inputs over time, as measured or prescribed: linear between rows or constant from row to row.

use serde::Serialize;

/// Values of one input over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InputColumn {
    /// Index of the input in the model's list.
    pub input: usize,
    /// One value a row of the table, SI.
    pub values: Vec<f64>,
    /// Constant from each row to the next (a step) instead of linear between rows.
    pub hold: bool,
}

/// Inputs over time: the columns given, and fixed values for the others.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct InputTable {
    /// Instants, s, strictly increasing.
    pub times_s: Vec<f64>,
    /// Inputs that vary.
    pub columns: Vec<InputColumn>,
    /// Value of every input of the model, SI; overridden by the columns.
    pub base: Vec<f64>,
}

impl InputTable {
    /// The instant farthest from zero, s.
    pub fn longest_s(&self) -> f64 {
        self.times_s.iter().fold(0.0, |longest, time_s| longest.max(time_s.abs()))
    }

    /// Value of an input from a row on, SI.
    pub fn in_row(&self, row: usize, input: usize) -> f64 {
        match self.columns.iter().find(|column| column.input == input) {
            Some(column) => column.values[row],
            None => self.base[input],
        }
    }
}

/// Inputs over time as the integrator reads them: corners known, rows found quickly.
#[derive(Clone, Debug)]
pub struct InputReader<'a> {
    table: &'a InputTable,
    /// Rows at which a column has a corner or a step, in order.
    corners: Vec<usize>,
    /// Row from which constant columns take their value.
    held: usize,
    /// The first row after the instant that was read last.
    after: usize,
}

impl<'a> InputReader<'a> {
    /// A reader at the table's beginning.
    pub fn new(table: &'a InputTable) -> Self {
        let rows = table.times_s.len();
        let corners =
            (0..rows).filter(|&row| table.columns.iter().any(|c| c.has_corner(&table.times_s, row))).collect();
        Self { table, corners, held: 0, after: 0 }
    }

    /// Whether any input varies.
    pub fn varies(&self) -> bool {
        !self.table.columns.is_empty() && !self.table.times_s.is_empty()
    }

    /// The first corner after an instant.
    pub fn next_corner(&self, time_s: f64) -> Option<f64> {
        let at = self.corners.partition_point(|&row| self.table.times_s[row] <= time_s);
        self.corners.get(at).map(|&row| self.table.times_s[row])
    }

    /// Whether the value of a constant column steps at the row of an instant.
    pub fn steps_at(&self, time_s: f64) -> bool {
        let row = self.table.times_s.partition_point(|&t| t < time_s);
        let steps = |column: &InputColumn| column.hold && column.has_corner(&self.table.times_s, row);
        self.table.times_s.get(row) == Some(&time_s) && self.table.columns.iter().any(steps)
    }

    /// From now on constant columns take the value that holds right after this instant.
    pub fn enter(&mut self, time_s: f64) {
        self.held = self.table.times_s.partition_point(|&t| t <= time_s).saturating_sub(1);
    }

    /// Writes the inputs at an instant over the base values in `out`.
    pub fn read(&mut self, time_s: f64, out: &mut [f64]) {
        if !self.varies() {
            return;
        }
        let times = &self.table.times_s;
        // Instants come one after another, so the row is near the last one.
        while times.get(self.after).is_some_and(|&t| t <= time_s) {
            self.after += 1;
        }
        while self.after > 0 && times[self.after - 1] > time_s {
            self.after -= 1;
        }
        let after = self.after;
        for column in &self.table.columns {
            let Some(slot) = out.get_mut(column.input) else { continue };
            *slot = if column.hold {
                column.values[self.held]
            } else if after == 0 {
                column.values[0]
            } else if after == times.len() {
                column.values[after - 1]
            } else {
                let (t0, t1) = (times[after - 1], times[after]);
                let (v0, v1) = (column.values[after - 1], column.values[after]);
                v0 + (v1 - v0) * ((time_s - t0) / (t1 - t0))
            };
        }
    }
}

impl InputColumn {
    /// Whether the column's slope changes (or its value steps) at a row.
    fn has_corner(&self, times: &[f64], row: usize) -> bool {
        let v = &self.values;
        if self.hold {
            return row > 0 && v[row] != v[row - 1];
        }
        let slope = |a: usize, b: usize| (v[b] - v[a]) / (times[b] - times[a]);
        let before = if row == 0 { 0.0 } else { slope(row - 1, row) };
        let after = if row + 1 == times.len() { 0.0 } else { slope(row, row + 1) };
        let span = if row + 1 < times.len() { times[row + 1] - times[row] } else { 1.0 };
        // A change below rounding of the values is none.
        (after - before).abs() * span > 1e-12 * v[row].abs().max(1e-300)
    }
}
