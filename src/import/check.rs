//! Whether a deck holds together: indices of nodes that exist, as many values as there are rows, numbers that are
//! finite. What a reader gives is held to this, so that nothing behind it has to ask.

use std::collections::HashSet;

use bmv_decks::{Deck, NodeKind, Value};

/// What is wrong with a deck, in words.
pub(super) fn fault(deck: &Deck) -> Option<String> {
    let nodes = deck.nodes.len();
    if nodes == 0 {
        return Some("it has no nodes".to_owned());
    }
    let node = |index: usize, what: String| {
        (index >= nodes).then(|| format!("{what} names node {index} of {nodes}, counted from 0"))
    };
    let number = |value: &Value, what: String| match value {
        Value::Number(number) | Value::Scaled { factor: number, .. } if !number.is_finite() => {
            Some(format!("{what} is {number}"))
        }
        Value::Number(_) | Value::Scaled { .. } | Value::Expression(_) => None,
    };
    let plain = |value: f64, what: String| (!value.is_finite()).then(|| format!("{what} is {value}"));
    let of_nodes = deck.nodes.iter().find_map(|entry| match &entry.kind {
        NodeKind::Diffusion { capacity } => number(capacity, format!("the heat capacity of `{}`", entry.name)),
        NodeKind::Boundary { temperature } => number(temperature, format!("the temperature of `{}`", entry.name)),
        NodeKind::Arithmetic => None,
    });
    let of_couplings = deck.couplings.iter().find_map(|entry| {
        let what = || format!("the coupling `{}`", entry.name);
        let lost = entry.between.into_iter().find_map(|end| node(end, what()));
        lost.or_else(|| number(&entry.value, what()))
    });
    let of_loads = deck.loads.iter().find_map(|entry| {
        let what = || format!("the load `{}`", entry.name);
        node(entry.into, what()).or_else(|| number(&entry.power, what()))
    });
    let of_heaters = deck.heaters.iter().find_map(|entry| {
        let what = || format!("the heater `{}`", entry.name);
        let lost = [entry.into, entry.senses].into_iter().find_map(|index| node(index, what()));
        let lost = lost.or_else(|| number(&entry.power, what()));
        lost.or_else(|| [entry.on_below_k, entry.off_above_k].into_iter().find_map(|at| plain(at, what())))
    });
    let of_groups = deck.groups.iter().find_map(|entry| {
        let what = || format!("the group `{}`", entry.name);
        let lost = entry.couplings.iter().find(|index| **index >= deck.couplings.len());
        let lost = lost.map(|index| format!("{} names coupling {index} of {}", what(), deck.couplings.len()));
        entry.nodes.iter().find_map(|&index| node(index, what())).or(lost)
    });
    let of_numbers = (deck.parameters.iter().map(|entry| (entry.nominal, "parameter", &entry.name)))
        .chain(deck.inputs.iter().map(|entry| (entry.nominal, "input", &entry.name)))
        .find_map(|(value, what, name)| plain(value, format!("the {what} `{name}`")));
    let mut symbols = HashSet::new();
    let of_symbols = (deck.inputs.iter().map(|entry| &entry.name))
        .chain(deck.parameters.iter().map(|entry| &entry.name))
        .chain(deck.tables.iter().map(|entry| &entry.name))
        .find(|name| !symbols.insert(name.as_str()))
        .map(|name| format!("two of its inputs, parameters and tables are called `{name}`"));
    let sigma = deck.stefan_boltzmann.filter(|sigma| !(*sigma > 0.0 && sigma.is_finite()));
    let of_sigma = sigma.map(|sigma| format!("its Stefan-Boltzmann constant is {sigma}"));
    let of_numbers = of_numbers.or(of_symbols);
    of_nodes
        .or(of_couplings)
        .or(of_loads)
        .or(of_heaters)
        .or(of_groups)
        .or(of_numbers)
        .or(of_sigma)
        .or_else(|| of_record(deck))
}

fn of_record(deck: &Deck) -> Option<String> {
    let record = deck.record.as_ref()?;
    let rows = record.times_s.len();
    let lists = [("inputs", &record.inputs, deck.inputs.len()), ("nodes", &record.temperatures_k, deck.nodes.len())];
    for (what, lists, expected) in lists {
        if lists.len() != expected {
            return Some(format!("its record has values of {} {what}, the deck has {expected}", lists.len()));
        }
        if let Some(list) = lists.iter().find(|list| !list.is_empty() && list.len() != rows) {
            return Some(format!("its record has {rows} rows, and {} values of one of the {what}", list.len()));
        }
    }
    if record.inputs.iter().flatten().any(|value| !value.is_finite()) {
        return Some("an input of its record is no finite number".to_owned());
    }
    let times = &record.times_s;
    let is_rising = record.is_steady || times.windows(2).all(|pair| pair[0] < pair[1]);
    (!is_rising || times.iter().any(|time| !time.is_finite()))
        .then(|| "the instants of its record do not rise".to_owned())
}
