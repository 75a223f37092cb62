//! Replays a record of xija with the deck that is read from its specification.
//!
//! `cargo run --release --package bmv-decks --example xija_replay -- SPECIFICATION.json [RECORD.csv]`
//!
//! The record has a column `t` (s from 1998), one for each input of the deck, in the input's unit, and for each predicted
//! node one with xija's temperatures in degC, called as the node. An exact solution starts from the first row; the
//! largest and the mean difference are printed for each node. Without a record the notes of the deck are printed.

mod expression;
mod network;

use bmv_decks::{Deck, NodeKind};
use network::{Inputs, Network};

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
    let text = std::fs::read_to_string(&record).map_err(|error| format!("{record}: {error}"))?;
    compare(deck, &text)
}

fn compare(deck: Deck, record: &str) -> Result<(), String> {
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
    let rows = Network::new(deck)?.transient(&times, &Inputs { columns }, &start, 8);
    for (at, name, celsius) in predicted {
        // xija repeats its last but one value.
        let last = celsius.len() - 1;
        let differences = rows.iter().zip(&celsius).take(last).map(|(row, value)| (row[at] - 273.15 - value).abs());
        let (largest, sum) =
            differences.fold((0.0_f64, 0.0), |(largest, sum), value| (largest.max(value), sum + value));
        println!("  {name}: largest difference {largest:.4} K, mean {:.4} K over {last} instants", sum / last as f64);
    }
    Ok(())
}
