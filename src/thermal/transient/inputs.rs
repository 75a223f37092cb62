//! Inputs over time, as measured or prescribed: linear between rows or constant from row to row.

/// Values of one input over time.
#[derive(Clone, Debug, PartialEq)]
pub struct InputColumn {
    /// Index of the input in the model's list.
    pub input: usize,
    /// One value a row of the table, SI.
    pub values: Vec<f64>,
    /// Constant from each row to the next (a step) instead of linear between rows.
    pub hold: bool,
}

/// Inputs over time: the columns given, and fixed values for the others.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct InputTable {
    /// Instants, s, strictly increasing.
    pub times_s: Vec<f64>,
    /// Inputs that vary.
    pub columns: Vec<InputColumn>,
    /// Value of every input of the model, SI; overridden by the columns.
    pub base: Vec<f64>,
}
