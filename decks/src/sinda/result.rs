//! The printed result of a steady state (`.out`).

use std::collections::HashMap;

use super::SindaFile;
use super::units::Units;
use crate::{DeckError, Node, Note, Record};

/// Routines that end in a steady state.
const STEADY: [&str; 3] = ["STEADY", "FASTIC", "STDSTL"];

/// Whether a text is what SINDA/FLUINT printed.
pub(super) fn is_printed(text: &str) -> bool {
    text.contains("S I N D A") || text.contains("SYSTEMS IMPROVED NUMERICAL DIFFERENCING ANALYZER")
}

/// Temperatures of the last steady state that was printed, in the deck's unit, by node (`SUBMODEL.number`), in the order
/// of the print.
///
/// # Errors
/// A text without a steady state.
pub fn read_result(name: &str, text: &str) -> Result<Vec<(String, f64)>, DeckError> {
    let mut temperatures: Vec<(String, f64)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let (mut submodel, mut is_steady, mut is_below_model) = (String::new(), false, false);
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if is_below_model {
            is_steady = words.first().is_some_and(|word| STEADY.contains(word));
        }
        is_below_model = words.starts_with(&["MODEL", "="]);
        if words.starts_with(&["SUBMODEL", "NAME", "="]) {
            submodel = words.get(3).map(|name| name.to_ascii_uppercase()).unwrap_or_default();
        }
        if !is_steady || words.first() != Some(&"T") {
            continue;
        }
        for (node, value) in values(line) {
            let value = value.map_err(|text| {
                DeckError::at(name, number, format!("node {submodel}.{node} has the temperature `{text}`, no number"))
            })?;
            let node = format!("{submodel}.{node}");
            match places.get(&node) {
                Some(&place) => temperatures[place].1 = value,
                None => {
                    places.insert(node.clone(), temperatures.len());
                    temperatures.push((node, value));
                }
            }
        }
    }
    if temperatures.is_empty() {
        let message = "no printed temperatures of a steady state: let TPRINT write them, or leave the file out";
        return Err(DeckError::of(name, message));
    }
    Ok(temperatures)
}

/// `T 12= 293.15` of a line: numbers of nodes with their values.
fn values(line: &str) -> Vec<(u64, Result<f64, String>)> {
    let spaced = line.replace('=', " = ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let entry = |words: &[&str]| match words {
        ["T", node, "=", value] => {
            let number = value.parse::<f64>().ok().filter(|value| value.is_finite());
            Some((node.parse().ok()?, number.ok_or_else(|| (*value).to_owned())))
        }
        _ => None,
    };
    words.windows(4).filter_map(entry).collect()
}

/// The printed steady state as a record of the nodes.
pub(super) fn record(file: &SindaFile<'_>, nodes: &[Node], units: Units) -> Result<(Record, Vec<Note>), DeckError> {
    let printed: HashMap<String, f64> = read_result(file.name, file.text)?.into_iter().collect();
    let temperatures_k: Vec<Vec<f64>> =
        nodes.iter().map(|node| printed.get(&node.name).map(|value| units.kelvin(*value)).into_iter().collect()).collect();
    let missing: Vec<&str> =
        nodes.iter().filter(|node| !printed.contains_key(&node.name)).map(|node| node.name.as_str()).collect();
    if missing.len() == nodes.len() {
        return Err(DeckError::of(file.name, "it prints none of the deck's nodes: give the result of this deck"));
    }
    let mut notes = Vec::new();
    if let [first, ..] = missing.as_slice() {
        let message = format!("{} nodes have no printed temperature, {first} among them.", missing.len());
        notes.push(Note::at(file.name, message));
    }
    let record = Record { times_s: vec![0.0], is_steady: true, inputs: Vec::new(), held: false, temperatures_k };
    Ok((record, notes))
}
