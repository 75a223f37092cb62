//! Puts the recorded temperatures of ESATAN results into the model beside them and lists the nodes that do not close:
//! `cargo run -p bmv-decks --example tmd_closure -- FILE.TMD`, or the CSV dumps of one model together.
#![allow(clippy::unwrap_used)]

#[path = "../tests/esatan/closure.rs"]
mod closure;

use bmv_decks::esatan::{Form, read_csv, read_tmd, recognises};
use bmv_decks::{CouplingKind, Deck, NodeKind};

use closure::{missing_heat_w, net_heat_w, value_at};

/// Nodes are listed whose balance misses by more, in W.
const LISTED_W: f64 = 1.0;

fn main() {
    let mut dumps = Vec::new();
    for name in std::env::args().skip(1) {
        let bytes = std::fs::read(&name).unwrap_or_else(|error| panic!("{name}: {error}"));
        match recognises(&name, &bytes) {
            Some(Form::Tmd) => match read_tmd(&name, &bytes) {
                Ok(deck) => report(&deck),
                Err(error) => println!("{error}"),
            },
            Some(Form::Csv) => dumps.push((name, String::from_utf8(bytes).unwrap())),
            _ => println!("{name}: neither a `.TMD` nor a dump as CSV"),
        }
    }
    if !dumps.is_empty() {
        match read_csv(&dumps) {
            Ok(deck) => report(&deck),
            Err(errors) => errors.iter().for_each(|error| println!("{error}")),
        }
    }
}

fn report(deck: &Deck) {
    let record = deck.record.as_ref().unwrap();
    let rows = record.times_s.len();
    let count = |kind| deck.couplings.iter().filter(|coupling| coupling.kind == kind).count();
    println!(
        "{} ({}): {} nodes, {} GL, {} GR, {} loads, {} inputs, {rows} rows{}",
        deck.title,
        deck.tool,
        deck.nodes.len(),
        count(CouplingKind::Linear),
        count(CouplingKind::Radiative),
        deck.loads.len(),
        deck.inputs.len(),
        if record.is_steady { ", steady" } else { "" },
    );
    for note in &deck.notes {
        println!("  note: {}", note.message);
    }
    let net: Vec<Vec<f64>> = (0..rows).map(|row| net_heat_w(deck, row)).collect();
    let mut worst_arithmetic = vec![0.0_f64; rows];
    let mut listed = Vec::new();
    for (node, definition) in deck.nodes.iter().enumerate() {
        let mut worst = (0.0_f64, 0);
        let mut consider = |missing: f64, row: usize| {
            if !(missing.abs() <= worst.0) {
                worst = (missing.abs(), row);
            }
        };
        match &definition.kind {
            NodeKind::Boundary { .. } => continue,
            NodeKind::Diffusion { capacity } if !record.is_steady => {
                for row in 1..rows {
                    let temperatures = [record.temperatures_k[node][row - 1], record.temperatures_k[node][row]];
                    let interval = record.times_s[row] - record.times_s[row - 1];
                    let capacity = value_at(capacity, deck, record, row);
                    consider(
                        missing_heat_w(capacity, temperatures, [net[row - 1][node], net[row][node]], interval),
                        row,
                    );
                }
            }
            _ => {
                for row in 0..rows {
                    consider(net[row][node], row);
                    worst_arithmetic[row] = worst_arithmetic[row].max(net[row][node].abs());
                }
            }
        }
        listed.push((worst.0, worst.1, node));
    }
    let steady = worst_arithmetic.iter().copied().fold(0.0, f64::max);
    println!("  arithmetic or steady nodes miss by {steady:.3e} W at most; in the first rows by");
    let first: Vec<String> = worst_arithmetic.iter().take(6).map(|missing| format!("{missing:.2e}")).collect();
    println!("    {}", first.join(" "));
    listed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let open = listed.iter().filter(|(missing, _, _)| *missing > LISTED_W).count();
    println!("  {open} of {} nodes miss by more than {LISTED_W} W; the largest:", listed.len());
    for (missing, row, node) in listed.iter().take(open.clamp(5, 40)) {
        let node = &deck.nodes[*node];
        let kind = if node.kind == NodeKind::Arithmetic { "arithmetic" } else { "diffusion" };
        let label = node.label.as_deref().unwrap_or("");
        println!("    {missing:10.3e} W at {} s, {kind} node {} {label}", record.times_s[*row], node.name);
    }
}
