//! What the other tool computed, as a measurement: `data/record.csv`, and its entry in the pass.

use bmv_decks::{Deck, NodeKind, Record};

use crate::batch::next_pass::text::Item;
use crate::document::visible::escaped;

use super::coupling::{cell, number};
use super::model::Written;
use super::resolution::step_k;

/// The file of the record in the study.
pub(super) const FILE: &str = "data/record.csv";
/// Most cells of the record's file; of a longer record every so many rows stand there.
const MOST_CELLS: usize = 4_000_000;
/// Least standard deviation in a transient, K: two integrations of one model differ by what their steps err, here about
/// 1e-4 K a step at room temperature.
const INTEGRATION_K: f64 = 1e-3;
/// Start of a node of which the deck tells none, K.
const ROOM_K: f64 = 293.15;

/// A record as a measurement.
pub(super) struct Measured {
    /// The measurement's entry in the pass.
    pub item: Item,
    /// The text of the file.
    pub csv: String,
    /// Rows of the deck's record that stand in the file.
    pub rows: Vec<usize>,
    /// The step of the printed temperatures, K.
    pub step_k: f64,
    /// Sensors.
    pub sensors: usize,
    /// What was assumed, in sentences.
    pub notes: Vec<String>,
}

/// The record of a deck; nothing where it has no temperature of a node that is no boundary.
pub(super) fn measured(deck: &Deck, record: &Record, written: &Written) -> Option<Measured> {
    let has_reading = |node: usize| record.temperatures_k[node].iter().any(|value| is_reading(*value));
    let nodes: Vec<usize> = (0..deck.nodes.len())
        .filter(|&node| written.is_there[node] && !matches!(deck.nodes[node].kind, NodeKind::Boundary { .. }))
        .filter(|&node| has_reading(node))
        .collect();
    if nodes.is_empty() {
        return None;
    }
    let is_steady = record.is_steady || record.times_s.len() == 1;
    let inputs: Vec<usize> = (0..deck.inputs.len()).filter(|&input| !record.inputs[input].is_empty()).collect();
    let mut notes = Vec::new();
    let rows = rows(record.times_s.len(), 1 + inputs.len() + nodes.len(), &mut notes);
    let names: Vec<String> = nodes.iter().map(|&node| sensor_name(deck, written, node)).collect();
    let csv = csv(deck, record, written, (&rows, &inputs, &nodes, &names), is_steady);
    let step_k = step_k(nodes.iter().flat_map(|&node| &record.temperatures_k[node]).copied());
    // Rounding to a step spreads evenly over it.
    let sigma_k = (step_k / 12.0_f64.sqrt()).max(if is_steady { 0.0 } else { INTEGRATION_K });
    let sigma = Item::Object(vec![("value".to_owned(), Item::number(sigma_k)), ("unit".to_owned(), Item::text("K"))]);
    let sensor = |(&node, name): (&usize, &String)| {
        let mut entries =
            vec![("measures".to_owned(), Item::text(written.node(node))), ("sigma".to_owned(), sigma.clone())];
        if let Some(label) = &deck.nodes[node].label {
            entries.push(("description".to_owned(), Item::text(&escaped(label))));
        }
        (name.clone(), Item::Object(entries))
    };
    let sensors = Item::Object(nodes.iter().zip(&names).map(sensor).collect());
    let description = format!(
        "What {} computed. The sensors' sigma is the rounding of the printed temperatures, a step of {} K{}.",
        deck.tool,
        number(step_k),
        if is_steady { "" } else { ", but at least 0.001 K: two integrations differ" }
    );
    let mut entries = vec![("description", Item::text(&escaped(&description))), ("file", Item::text(FILE))];
    if !is_steady {
        entries.push(("initial", Item::one("temperatures", start(deck, record, written, rows[0], &mut notes))));
        if record.held && !inputs.is_empty() {
            let held = inputs.iter().map(|&input| Item::text(written.symbol(&deck.inputs[input].name)));
            entries.push(("hold", Item::List(held.collect())));
        }
    }
    entries.push(("sensors", sensors));
    let form = Item::Object(entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect());
    let item = Item::one(if is_steady { "steady" } else { "transient" }, form);
    Some(Measured { item, csv, rows, step_k, sensors: nodes.len(), notes })
}

/// Whether a value of the record can be a reading.
fn is_reading(temperature_k: f64) -> bool {
    temperature_k.is_finite() && temperature_k > 0.0
}

/// Rows that are written: all, or every so many where that would be too much.
fn rows(count: usize, columns: usize, notes: &mut Vec<String>) -> Vec<usize> {
    let most = (MOST_CELLS / columns).max(2);
    let stride = count.div_ceil(most).max(1);
    if stride > 1 {
        notes.push(format!("the record is thinned: every {stride}th of its {count} rows stands in `{FILE}`"));
    }
    (0..count).step_by(stride).collect()
}

/// A node's name as the name of a sensor: inputs and the rows' own column have columns too.
fn sensor_name(deck: &Deck, written: &Written, node: usize) -> String {
    let name = written.node(node);
    let is_input = deck.inputs.iter().any(|input| written.symbol(&input.name) == name);
    if is_input || matches!(name, "time" | "phase") { format!("node {name}") } else { name.to_owned() }
}

type Columns<'a> = (&'a [usize], &'a [usize], &'a [usize], &'a [String]);

fn csv(deck: &Deck, record: &Record, written: &Written, parts: Columns, is_steady: bool) -> String {
    let (rows, inputs, nodes, names) = parts;
    let mut text = if is_steady { "phase".to_owned() } else { "time [s]".to_owned() };
    for &input in inputs {
        let input_of_deck = &deck.inputs[input];
        let unit = if input_of_deck.unit.is_empty() { "1" } else { &input_of_deck.unit };
        text.push_str(&format!(",{}", cell(&format!("{} [{unit}]", written.symbol(&input_of_deck.name)))));
    }
    for name in names {
        text.push_str(&format!(",{}", cell(&format!("{name} [K]"))));
    }
    text.push('\n');
    let width = rows.len().to_string().len();
    for (position, &row) in rows.iter().enumerate() {
        if is_steady {
            text.push_str(&format!("P{:0width$}", position + 1));
        } else {
            text.push_str(&number(record.times_s[row]));
        }
        for &input in inputs {
            text.push(',');
            text.push_str(&number(record.inputs[input][row]));
        }
        for &node in nodes {
            text.push(',');
            let reading = record.temperatures_k[node][row];
            if is_reading(reading) {
                text.push_str(&number(reading));
            }
        }
        text.push('\n');
    }
    text
}

/// Start temperatures of the nodes that store heat: the record's first ones, else those that the deck states.
fn start(deck: &Deck, record: &Record, written: &Written, row: usize, notes: &mut Vec<String>) -> Item {
    let (mut entries, mut without, mut sum) = (Vec::new(), 0_usize, 0.0);
    for (index, node) in deck.nodes.iter().enumerate() {
        let stores = match &node.kind {
            NodeKind::Diffusion { capacity: bmv_decks::Value::Number(capacity) } => *capacity > 0.0,
            NodeKind::Diffusion { .. } => true,
            NodeKind::Arithmetic | NodeKind::Boundary { .. } => false,
        };
        if !stores || !written.is_there[index] {
            continue;
        }
        let first = record.temperatures_k[index].get(row).copied().filter(|value| is_reading(*value));
        match first.or(node.initial_temperature_k.filter(|value| is_reading(*value))) {
            Some(start_k) => {
                sum += start_k;
                entries.push((written.node(index).to_owned(), Item::number(start_k)));
            }
            None => without += 1,
        }
    }
    if without > 0 || entries.is_empty() {
        let start_k = if entries.is_empty() { ROOM_K } else { sum / entries.len() as f64 };
        if without > 0 {
            notes.push(format!("{without} nodes of which the deck tells no start begin at {start_k:.2} K"));
        }
        entries.insert(0, ("all".to_owned(), Item::number(start_k)));
    }
    // One entry says what all have in common.
    let first = entries.first().map(|(_, item)| item.clone());
    if let Some(first) = first
        && entries.len() > 1
        && entries.iter().all(|(_, item)| *item == first)
    {
        entries = vec![("all".to_owned(), first)];
    }
    Item::Object(entries)
}
