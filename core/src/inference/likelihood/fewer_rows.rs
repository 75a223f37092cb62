//! Derivatives of a long transient from fewer rows.
//!
//! What a parameter does to a reading is smoother than the reading, and a descent needs its derivatives to a few per cent only:
//! the values, which decide where the descent ends, keep every row. So derivatives are found on fewer rows, with the inputs'
//! means there, and drawn straight in between.

use crate::measurement::InputTable;

/// The rows of a transient on which derivatives are found.
#[derive(Clone, Debug)]
pub struct FewerRows {
    /// Inputs at these rows.
    pub inputs: InputTable,
    /// The rows, ascending; the first and the last that are used are among them.
    pub rows: Vec<usize>,
    /// Times the usual local error that a step may have.
    pub tolerance: f64,
}

/// The same with the place of each row among those.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The kept rows.
    pub fewer: FewerRows,
    /// Of each row the position of the last kept one up to it, and the share of the next one.
    places: Vec<(usize, f64)>,
}

impl Drawn {
    /// Derivatives at rows with these instants, s, beyond the last kept row as there; `None` where the kept rows do not span so many rows.
    pub fn new(fewer: FewerRows, times_s: &[f64], spanned: usize) -> Option<Self> {
        let rows = &fewer.rows;
        if rows.len() < 2 || rows.len() != fewer.inputs.times_s.len() || rows.last()? + 1 < spanned {
            return None;
        }
        let place = |row: usize| {
            let before = rows.partition_point(|&kept| kept <= row).checked_sub(1)?;
            let Some(&next) = rows.get(before + 1) else { return Some((before, 0.0)) };
            let (from, to) = (times_s.get(rows[before])?, times_s.get(next)?);
            Some((before, (times_s[row] - from) / (to - from)))
        };
        let places: Option<Vec<(usize, f64)>> = (0..times_s.len()).map(place).collect();
        Some(Self { places: places?, fewer })
    }

    /// Draws a column on all rows through its values at those that are kept.
    pub fn draw(&self, kept: impl Fn(usize) -> f64, column: &mut [f64]) {
        for (value, &(before, share)) in column.iter_mut().zip(&self.places) {
            *value = kept(before);
            if share > 0.0 {
                *value += share * (kept(before + 1) - *value);
            }
        }
    }
}
