//! Replays a record of xija with the deck that is read from its specification.
//!
//! `cargo run --release --package bmv-decks --example xija_replay -- SPECIFICATION.json [RECORD.csv]`
//!
//! The record has a column `t` (s from 1998), one for each input of the deck, in the input's unit, and for each predicted
//! node one with xija's temperatures in degC, called as the node. From the first row on, the differences to an exact
//! solution of the deck are printed for each node, and those to the deck under xija's own rule of integration. Without a record the notes of the deck are printed.

mod expression;
mod network;

use bmv_decks::{Deck, NodeKind};
use network::{Inputs, Network, Rule};

fn main() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let specification = arguments.next().ok_or("usage: xija_replay SPECIFICATION.json [RECORD.csv]")?;
    let text = std::fs::read_to_string(&specification).map_err(|error| format!("{specification}: {error}"))?;
    let deck = match bmv_decks::xija::read(&specification, &text) {
        Ok(deck) => deck,
        Err(errors) => return Err(errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")),
    };
    let (nodes, parameters) = (deck.nodes.len(), deck.parameters.len());
    let (couplings, loads, inputs) = (deck.couplings.len(), deck.loads.len(), deck.inputs.len());
    println!(
        "{specification}: {nodes} nodes, {couplings} couplings, {loads} loads, {inputs} inputs, {parameters} parameters"
    );
    let Some(record) = arguments.next() else {
        for note in &deck.notes {
            println!("  {}{}", note.place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default(), note.message);
        }
        return Network::new(deck).map(|_| ());
    };
    let record = std::fs::read_to_string(&record).map_err(|error| format!("{record}: {error}"))?;
    compare(deck, &text, &record)
}

fn compare(deck: Deck, document: &str, record: &str) -> Result<(), String> {
    let mut lines = record.lines();
    let names: Vec<&str> = lines.next().ok_or("the record is empty")?.split(',').map(str::trim).collect();
    let rows =
        lines.map(|line| line.split(',').map(|cell| cell.trim().parse::<f64>()).collect::<Result<Vec<f64>, _>>());
    let rows = rows.collect::<Result<Vec<Vec<f64>>, _>>().map_err(|error| error.to_string())?;
    let column = |name: &str| -> Result<Vec<f64>, String> {
        let at = names.iter().position(|other| *other == name).ok_or(format!("the record has no column `{name}`"))?;
        rows.iter().map(|row| row.get(at).copied().ok_or("a row is too short".to_owned())).collect()
    };
    let times = column("t")?;
    let columns = deck.inputs.iter().map(|input| column(&input.name)).collect::<Result<Vec<_>, _>>()?;
    let mut start = vec![0.0; deck.nodes.len()];
    let mut predicted = Vec::new();
    for (at, node) in deck.nodes.iter().enumerate() {
        if matches!(node.kind, NodeKind::Diffusion { .. }) {
            let celsius = column(&node.name)?;
            start[at] = celsius[0] + 273.15;
            predicted.push((at, node.name.clone(), celsius));
        }
    }
    let (rule, rate_factor) = rule_of(document)?;
    // The midpoint and classical rules take heats linear between rows.
    let inputs = Inputs { columns, holds_states: rule == Rule::Pairs };
    let mut network = Network::new(deck)?;
    let exact = network.transient(&times, &inputs, &start, 8);
    let replay = network.replay(rule, rate_factor, &times, &inputs, &start);
    // xija repeats its last but one value.
    let last = times.len() - 1;
    for (at, name, celsius) in predicted {
        let difference = |rows: &[Vec<f64>]| {
            let differences = rows.iter().zip(&celsius).take(last).map(|(row, value)| (row[at] - 273.15 - value).abs());
            let (largest, sum) =
                differences.fold((0.0_f64, 0.0), |(largest, sum), value| (largest.max(value), sum + value));
            (largest, sum / last as f64)
        };
        let ((largest, mean), (replayed, _)) = (difference(&exact), difference(&replay));
        println!(
            "  {name}: exact solution {largest:.4} K off at most, {mean:.4} K in the mean; xija's rule {replayed:.1e} K off"
        );
    }
    Ok(())
}

/// The solver of a specification, with the factor that the deck's capacities carry.
fn rule_of(specification: &str) -> Result<(Rule, f64), String> {
    let document: serde_json::Value = serde_json::from_str(specification).map_err(|error| error.to_string())?;
    let number = |key: &str| document.get(key).and_then(serde_json::Value::as_u64);
    Ok(match (number("evolve_method"), number("rk4")) {
        (Some(2), Some(1)) => (Rule::Classical, 1.0),
        (Some(2), _) => (Rule::Midpoint, 1.0),
        _ => (Rule::Pairs, 1.5),
    })
}
