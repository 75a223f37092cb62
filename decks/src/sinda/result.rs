//! Printed results (`.out`): the last steady state, or else the instants of a transient.

use std::collections::HashMap;

use super::SindaFile;
use super::units::Units;
use crate::{DeckError, Node, Note, Record};

/// Routines that end in a steady state.
const STEADY: [&str; 3] = ["STEADY", "FASTIC", "STDSTL"];
/// What SINDA/G prints at the head of its pages.
const SINDA_G: &str = "J.D.GASKI";

/// Temperatures by node.
type Temperatures = Vec<(String, f64)>;

/// What a text has printed, in the deck's units.
pub(super) enum Printed {
    /// The last steady state.
    Steady(Temperatures),
    /// Instants of a transient, rising, with their temperatures.
    Transient(Vec<(f64, Temperatures)>),
}

/// Whether a text is what SINDA/FLUINT or SINDA/G printed.
pub(super) fn is_printed(text: &str) -> bool {
    ["S I N D A", "SYSTEMS IMPROVED NUMERICAL DIFFERENCING ANALYZER", SINDA_G].iter().any(|mark| text.contains(mark))
}

/// Temperatures of the last steady state that was printed, in the deck's unit, by node (`SUBMODEL.number`), in the order
/// of the print.
///
/// # Errors
/// A text without a steady state.
pub fn read_result(name: &str, text: &str) -> Result<Vec<(String, f64)>, DeckError> {
    match printed(name, text)? {
        Printed::Steady(temperatures) => Ok(temperatures),
        Printed::Transient(_) => Err(DeckError::of(name, NOTHING)),
    }
}

const NOTHING: &str = "no printed temperatures of a steady state, nor two instants of a transient: let TPRINT write them, or \
                       leave the file out";

/// What is printed at one time.
#[derive(Default)]
struct Frame {
    time: f64,
    is_steady: bool,
    temperatures: Temperatures,
    places: HashMap<String, usize>,
}

impl Frame {
    fn set(&mut self, node: String, value: f64) {
        match self.places.get(&node) {
            Some(&place) => self.temperatures[place].1 = value,
            None => {
                self.places.insert(node.clone(), self.temperatures.len());
                self.temperatures.push((node, value));
            }
        }
    }
}

/// Reads a print.
pub(super) fn printed(name: &str, text: &str) -> Result<Printed, DeckError> {
    let is_sinda_g = text.contains(SINDA_G);
    let mut frames: Vec<Frame> = Vec::new();
    let (mut submodel, mut is_steady, mut is_below_model) = (String::new(), false, false);
    let mut time = 0.0;
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if is_below_model {
            is_steady = words.first().is_some_and(|word| STEADY.contains(word));
        }
        is_below_model = words.starts_with(&["MODEL", "="]);
        if words.starts_with(&["SUBMODEL", "NAME", "="]) {
            submodel = words.get(3).map(|name| format!("{}.", name.to_ascii_uppercase())).unwrap_or_default();
        }
        let instant = match words.as_slice() {
            ["PROBLEM", "TIME", "TIMEN", "=", value, ..] => Some(value),
            ["TIME=", value, ..] if is_sinda_g => Some(value),
            _ => None,
        };
        if let Some(value) = instant {
            time = value.trim_end_matches(',').parse().unwrap_or(time);
        }
        if words.first() != Some(&"T") {
            continue;
        }
        for (node, value) in values(line) {
            let node = format!("{submodel}{node}");
            let value = value.map_err(|text| {
                DeckError::at(name, number, format!("node {node} has the temperature `{text}`, no number"))
            })?;
            if frames.last().is_none_or(|frame| frame.time != time || frame.is_steady != is_steady) {
                frames.push(Frame { time, is_steady, ..Frame::default() });
            }
            if let Some(frame) = frames.last_mut() {
                frame.set(node, value);
            }
        }
    }
    // SINDA/G prints no name of the routine that a reader could rely on; a steady state does not move in time.
    if is_sinda_g && frames.len() == 1 {
        frames.iter_mut().for_each(|frame| frame.is_steady = true);
    }
    if let Some(place) = frames.iter().rposition(|frame| frame.is_steady) {
        return Ok(Printed::Steady(frames.swap_remove(place).temperatures));
    }
    let rows: Vec<(f64, Temperatures)> = frames.into_iter().map(|frame| (frame.time, frame.temperatures)).collect();
    if rows.len() < 2 {
        return Err(DeckError::of(name, NOTHING));
    }
    if let Some(pair) = rows.windows(2).find(|pair| !(pair[0].0 < pair[1].0)) {
        let message = format!(
            "it prints the time {} below the time {}: several runs stand in it; give that of one",
            pair[1].0, pair[0].0
        );
        return Err(DeckError::of(name, message));
    }
    Ok(Printed::Transient(rows))
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

/// The printed result as a record of the nodes. A transient does not go with heating rates that are read as their mean.
pub(super) fn record(
    file: &SindaFile<'_>,
    nodes: &[Node],
    units: Units,
    has_means: bool,
) -> Result<(Record, Vec<Note>), DeckError> {
    let (times, rows, is_steady) = match printed(file.name, file.text)? {
        Printed::Steady(row) => (vec![0.0], vec![row], true),
        Printed::Transient(_) if has_means => {
            let message = "it is of a transient, and the deck's heating rates are read as their mean over the orbit: leave \
                           it out, or print a steady state";
            return Err(DeckError::of(file.name, message));
        }
        Printed::Transient(rows) => {
            let (times, rows) = rows.into_iter().unzip();
            (times, rows, false)
        }
    };
    let rows: Vec<HashMap<String, f64>> = rows.into_iter().map(|row| row.into_iter().collect()).collect();
    let of_node = |node: &Node| {
        let column: Option<Vec<f64>> =
            rows.iter().map(|row| row.get(&node.name).map(|value| units.kelvin(*value))).collect();
        column.unwrap_or_default()
    };
    let temperatures_k: Vec<Vec<f64>> = nodes.iter().map(of_node).collect();
    let missing: Vec<&str> = (nodes.iter().zip(&temperatures_k))
        .filter(|(_, column)| column.is_empty())
        .map(|(node, _)| node.name.as_str())
        .collect();
    if missing.len() == nodes.len() {
        return Err(DeckError::of(file.name, "it prints none of the deck's nodes: give the result of this deck"));
    }
    let mut notes = Vec::new();
    if let [first, ..] = missing.as_slice() {
        let message = format!("{} nodes have no printed temperature, {first} among them.", missing.len());
        notes.push(Note::at(file.name, message));
    }
    let times_s = times.into_iter().map(|time| time * units.second).collect();
    Ok((Record { times_s, is_steady, inputs: Vec::new(), held: false, temperatures_k }, notes))
}
