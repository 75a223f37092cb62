//! ARRAY DATA: lists of numbers that options of nodes and conductors refer to, as `SUBMODEL.A3` or `A3`.

use std::collections::HashMap;

use super::block::{Block, Kind};
use super::control::Control;

/// Arrays by submodel and number, with their values or the reason why they have none.
#[derive(Default)]
pub(super) struct Arrays {
    lists: HashMap<(String, i64), Result<Vec<f64>, String>>,
}

impl Arrays {
    /// Reads all blocks of arrays. What is wrong with an array is reported where something refers to it.
    pub(super) fn read(blocks: &[Block<'_>], control: &Control) -> Self {
        let mut arrays = Self::default();
        for block in blocks.iter().filter(|block| block.kind == Kind::Arrays) {
            // The array that is open; none below a name, to which nothing refers by number.
            let mut open: Option<(String, i64)> = None;
            for card in &block.cards {
                let mut rest = card.text;
                if let Some((name, values)) = card.text.split_once('=') {
                    open = name.trim().parse().ok().map(|number| (block.submodel.clone(), number));
                    rest = values;
                }
                for word in rest.split([',', ' ', '\t']).filter(|word| !word.is_empty()) {
                    if block.is_numbered && word.eq_ignore_ascii_case("END") {
                        open = None;
                    } else if block.is_numbered && open.is_none() {
                        open = word.parse().ok().map(|number| (block.submodel.clone(), number));
                    } else if let Some(key) = &open {
                        arrays.add(key, word, control);
                    }
                }
            }
        }
        arrays
    }

    fn add(&mut self, key: &(String, i64), word: &str, control: &Control) {
        let list = self.lists.entry(key.clone()).or_insert_with(|| Ok(Vec::new()));
        let value = control.quantity(word).and_then(|quantity| {
            if quantity.is_number() { Ok(quantity.nominal) } else { Err(format!("`{word}` is no number")) }
        });
        match (list.as_mut(), value) {
            (Ok(values), Ok(value)) => values.push(value),
            (Ok(_), Err(message)) => *list = Err(message),
            (Err(_), _) => {}
        }
    }

    /// The array that a reference means, with its key.
    ///
    /// # Errors
    /// What is no reference, an array that is not there, and one that is not of numbers.
    pub(super) fn find(&self, submodel: &str, reference: &str) -> Result<((String, i64), &[f64]), String> {
        let (of, name) = match reference.rsplit_once('.') {
            Some((of, name)) => (of.trim().to_ascii_uppercase(), name.trim()),
            None => (submodel.to_owned(), reference),
        };
        let number = name.strip_prefix(['A', 'a']).unwrap_or(name).trim();
        let number =
            number.parse().map_err(|_| format!("`{reference}`: expected an array such as `A3` or `{submodel}.A3`"))?;
        let key = (of, number);
        match self.lists.get(&key) {
            Some(Ok(values)) => Ok((key, values)),
            Some(Err(message)) => Err(format!("array {reference}: {message}; write its values as numbers")),
            None => Err(format!("array {reference} is not among ARRAY DATA: give the file that holds it")),
        }
    }
}

/// Abscissae and ordinates of a piecewise linear function.
///
/// # Errors
/// An odd number of values, less than a point, and abscissae that do not rise.
pub(super) fn points(reference: &str, values: &[f64]) -> Result<(Vec<f64>, Vec<f64>), String> {
    if values.is_empty() || !values.len().is_multiple_of(2) {
        return Err(format!("array {reference} has {} values: expected pairs of temperature and value", values.len()));
    }
    let x: Vec<f64> = values.iter().step_by(2).copied().collect();
    let y = values.iter().skip(1).step_by(2).copied().collect();
    if let Some(pair) = x.windows(2).find(|pair| !(pair[0] < pair[1])) {
        return Err(format!("array {reference}: temperature {} does not rise above {}", pair[1], pair[0]));
    }
    Ok((x, y))
}
