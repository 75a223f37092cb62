//! Heat balances of a deck at the temperatures of its own record.

use bmv_decks::{CouplingKind, Deck, Record, Value};

/// CODATA 2018, for decks that state no constant of their own.
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// A value in a row: a number, or an input by its name. Results hold no other expressions.
pub fn value_at(value: &Value, deck: &Deck, record: &Record, row: usize) -> f64 {
    match value {
        Value::Number(number) => *number,
        Value::Expression(name) => {
            let input = deck.inputs.iter().position(|input| input.name == *name);
            record.inputs[input.unwrap_or_else(|| panic!("`{name}` is no input"))][row]
        }
        Value::Scaled { parameter, .. } => panic!("a parameter `{parameter}` in a result"),
    }
}

/// Net heat into each node in W, in the order of the nodes, at the recorded temperatures of a row.
pub fn net_heat_w(deck: &Deck, row: usize) -> Vec<f64> {
    let record = deck.record.as_ref().expect("a result holds a record");
    let sigma = deck.stefan_boltzmann.unwrap_or(STEFAN_BOLTZMANN);
    let temperature_k = |node: usize| record.temperatures_k[node][row];
    let mut net = vec![0.0; deck.nodes.len()];
    for load in &deck.loads {
        net[load.into] += value_at(&load.power, deck, record, row);
    }
    for coupling in &deck.couplings {
        let [from, to] = coupling.between;
        let (warm, cold) = (temperature_k(from), temperature_k(to));
        let difference = match coupling.kind {
            CouplingKind::Linear | CouplingKind::OneWay => warm - cold,
            CouplingKind::Radiative => {
                let (warm_2, cold_2) = (warm * warm, cold * cold);
                sigma * (warm_2 * warm_2 - cold_2 * cold_2)
            }
        };
        let heat = value_at(&coupling.value, deck, record, row) * difference;
        net[to] += heat;
        if coupling.kind != CouplingKind::OneWay {
            net[from] -= heat;
        }
    }
    net
}

/// What is missing from a diffusion node's balance over an interval between rows: stored heat less the mean of the net
/// heats at its ends, in W.
pub fn missing_heat_w(capacity: f64, temperatures_k: [f64; 2], net_w: [f64; 2], interval_s: f64) -> f64 {
    capacity * (temperatures_k[1] - temperatures_k[0]) / interval_s - 0.5 * (net_w[0] + net_w[1])
}
