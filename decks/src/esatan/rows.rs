//! What varies over the rows of a result: constants and inputs, instants and cases.

use crate::identifier::Identifiers;
use crate::{Deck, Input, Note, Record, Value};

/// Values of one quantity that differ by no more than this, relative to the largest, are one constant. Results hold 16
/// digits; what is computed anew at each instant scatters in the last ones.
const RELATIVE_SCATTER: f64 = 1e-12;

/// Whether values are one number but for the scatter of their last digits.
pub(super) fn is_constant(values: &[f64]) -> bool {
    let Some(&first) = values.first() else { return true };
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    values.iter().all(|value| (value - first).abs() <= RELATIVE_SCATTER * largest)
}

/// Rows of a result that a record keeps, and what they are.
pub(super) struct Rows {
    /// Rows that stay, in order.
    pub(super) kept: Vec<usize>,
    /// Instants in s, or the number of the case; rising.
    pub(super) times_s: Vec<f64>,
    /// Whether each row is a steady case.
    pub(super) is_steady: bool,
}

/// Sorts rows into instants or cases by their times. Nodes without any capacity have steady results alone. An error is
/// what is wrong with the times.
pub(super) fn rows_of(times_s: &[f64], has_capacity: bool, notes: &mut Vec<Note>) -> Result<Rows, String> {
    if times_s.is_empty() {
        return Err("there is no row of results; write out at least one instant".to_owned());
    }
    if let Some(row) = times_s.iter().position(|time| !time.is_finite()) {
        return Err(format!("the time of row {} is not a finite number", row + 1));
    }
    let does_not_fall = times_s.windows(2).all(|pair| pair[0] <= pair[1]);
    let rises = times_s.windows(2).all(|pair| pair[0] < pair[1]);
    let mut note = |message: String| notes.push(Note::new(message));
    let count = times_s.len();
    let never_rises = count > 1 && times_s.windows(2).all(|pair| pair[0] == pair[1]);
    if count == 1 || !has_capacity || never_rises {
        if count > 1 {
            let why = if never_rises { "they have one time" } else { "no node has a capacity" };
            note(format!("The {count} rows are read as steady cases, since {why}."));
        }
        let times_s = if rises { times_s.to_vec() } else { (0..count).map(|row| row as f64).collect() };
        if !rises {
            note("Times do not rise from row to row: cases are numbered from 0 instead.".to_owned());
        }
        return Ok(Rows { kept: (0..count).collect(), times_s, is_steady: true });
    }
    if !does_not_fall {
        return Err("times fall from one row to the next; write out one solution alone".to_owned());
    }
    let kept: Vec<usize> =
        (0..count).filter(|&row| times_s.get(row + 1).is_none_or(|next| *next > times_s[row])).collect();
    if kept.len() < count {
        note(format!(
            "Of rows with one time the last is kept: {} rows left out. A step of the heats there becomes a ramp from \
             the row before.",
            count - kept.len()
        ));
    }
    let times_s = kept.iter().map(|&row| times_s[row]).collect();
    Ok(Rows { kept, times_s, is_steady: false })
}

/// The number of values that do not vary, or a new input of the deck's record for values that do.
pub(super) fn number_or_input(
    values: Vec<f64>,
    input: impl FnOnce() -> (String, &'static str, String),
    identifiers: &mut Identifiers,
    deck: &mut Deck,
) -> Value {
    if is_constant(&values) {
        return Value::Number(values.first().copied().unwrap_or(0.0));
    }
    let (name, unit, description) = input();
    let name = identifiers.make(&name);
    let nominal = values.iter().sum::<f64>() / values.len() as f64;
    deck.inputs.push(Input { name: name.clone(), unit: unit.to_owned(), nominal, description });
    deck.record.get_or_insert_with(Record::default).inputs.push(values);
    Value::Expression(name)
}
