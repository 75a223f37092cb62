//! `model.json` of a deck.

use std::collections::{HashMap, HashSet};

use bmv_decks::{Deck, NodeKind, Parameter, Value};

use crate::batch::next_pass::text::Item;
use crate::document::visible::escaped;
use crate::study::model::FORMAT;
use crate::thermal::element::STEFAN_BOLTZMANN;

use super::coupling::{Became, Couplings, couplings};
use super::name::{Names, identifiers};

/// Where values of an imported parameter come from, as far as the prior goes.
const NOT_ELICITED: &str = "imported, not elicited";
/// A boundary at absolute zero is written so much warmer, K: the study format has temperatures above 0 K.
const COLDEST_K: f64 = 1e-3;
/// Notes that the model's description repeats.
const MOST_NOTES: usize = 50;

/// Names of the deck as they stand in the study.
#[derive(Debug, Default)]
pub(super) struct Written {
    nodes: Vec<String>,
    /// Whether each node stands in the study.
    pub is_there: Vec<bool>,
    /// Inputs, parameters and tables that are called otherwise.
    pub symbols: HashMap<String, String>,
    nominal: HashMap<String, f64>,
}

impl Written {
    /// The name of a node.
    pub(super) fn node(&self, node: usize) -> &str {
        &self.nodes[node]
    }

    /// The name of an input, parameter or table.
    pub(super) fn symbol<'a>(&'a self, name: &'a str) -> &'a str {
        self.symbols.get(name).map_or(name, String::as_str)
    }

    /// Value of a parameter or input; 1 of what is none.
    pub(super) fn nominal(&self, name: &str) -> f64 {
        self.nominal.get(name).copied().unwrap_or(1.0)
    }
}

/// The model of a deck as a document.
pub(super) struct ModelFile {
    pub item: Item,
    pub written: Written,
    pub couplings: Couplings,
    /// What was changed or left out on the way, in sentences.
    pub notes: Vec<String>,
    /// Parameters that stand in the study, and those of the deck that nothing uses.
    pub parameters: [usize; 2],
}

/// The model of a deck. `tables` are the files of tables of conductors and radiations.
pub(super) fn model(deck: &Deck, files: &[String], tables: [&str; 2]) -> ModelFile {
    let mut notes = Vec::new();
    let written = names(deck, &mut notes);
    let area_factor = deck.stefan_boltzmann.map_or(1.0, |sigma| sigma / STEFAN_BOLTZMANN);
    let couplings = couplings(deck, &written, area_factor);
    notes.extend(couplings.notes.iter().cloned());
    let used = used(deck, &written);
    let parameters: Vec<&Parameter> =
        deck.parameters.iter().filter(|parameter| used.contains(parameter.name.as_str())).collect();
    let nodes: Vec<(String, Item)> = (0..deck.nodes.len())
        .filter(|&node| written.is_there[node])
        .map(|node| (written.node(node).to_owned(), node_item(deck, node, &written, &mut notes)))
        .collect();
    let mut load_names = Names::default();
    let loads: Vec<(String, Item)> = (deck.loads.iter())
        .map(|load| {
            let into = ("into".to_owned(), Item::text(written.node(load.into)));
            let power = ("power".to_owned(), written.scalar(&load.power, 1.0));
            (load_names.label(&load.name), Item::Object(vec![into, power]))
        })
        .collect();
    let mut heater_names = Names::default();
    let heaters: Vec<(String, Item)> = (deck.heaters.iter())
        .map(|heater| {
            let thermostat = vec![
                ("on_below".to_owned(), Item::number(heater.on_below_k)),
                ("off_above".to_owned(), Item::number(heater.off_above_k)),
            ];
            let entries = vec![
                ("into".to_owned(), Item::text(written.node(heater.into))),
                ("senses".to_owned(), Item::text(written.node(heater.senses))),
                ("power".to_owned(), written.scalar(&heater.power, 1.0)),
                ("thermostat".to_owned(), Item::Object(thermostat)),
            ];
            (heater_names.label(&heater.name), Item::Object(entries))
        })
        .collect();
    let mut source = format!("{}, imported from {}", deck.tool, files.join(", "));
    if area_factor != 1.0 {
        let sigma = deck.stefan_boltzmann.unwrap_or(STEFAN_BOLTZMANN);
        let message = format!(
            "every exchange area is multiplied by {area_factor}, so that the heat is that of the deck's \
             Stefan-Boltzmann constant {sigma:e} W/(m2 K4) instead of {STEFAN_BOLTZMANN:e} (CODATA 2018)"
        );
        source.push_str(&format!("; {message}"));
        notes.push(message);
    }
    let tabulated: Vec<(String, Item)> = (["conductors", "radiations"].into_iter().zip(tables).zip(&couplings.tables))
        .filter(|(_, table)| table.is_some())
        .map(|((member, file), _)| (member.to_owned(), Item::one("file", Item::text(file))))
        .collect();
    let [conductors, radiations] = couplings.objects.clone();
    let mut members = vec![
        ("format", Item::text(FORMAT)),
        ("title", Item::text(&escaped(&deck.title))),
        ("description", Item::text(&description(deck, &notes))),
        ("source", Item::text(&escaped(&source))),
    ];
    let tables = deck.tables.iter().filter(|table| used.contains(table.name.as_str())).map(|table| {
        let list = |values: &[f64]| Item::List(values.iter().map(|value| Item::number(*value)).collect());
        let points = vec![("x".to_owned(), list(&table.x)), ("y".to_owned(), list(&table.y))];
        (written.symbol(&table.name).to_owned(), Item::Object(points))
    });
    let sections = [
        ("inputs", deck.inputs.iter().map(|input| input_item(input, &written)).collect()),
        ("parameters", parameters.iter().map(|parameter| parameter_item(parameter, &written)).collect()),
        ("tables", tables.collect()),
        ("nodes", nodes),
        ("conductors", conductors),
        ("radiations", radiations),
        ("tabulated", tabulated),
        ("flows", couplings.flows.clone()),
        ("heaters", heaters),
        ("loads", loads),
        ("groups", groups(deck, &written, &couplings)),
    ];
    members.extend(
        sections.into_iter().filter(|(_, entries)| !entries.is_empty()).map(|(key, list)| (key, Item::Object(list))),
    );
    let item = Item::Object(members.into_iter().map(|(key, item)| (key.to_owned(), item)).collect());
    let parameters = [parameters.len(), deck.parameters.len() - parameters.len()];
    ModelFile { item, written, couplings, notes, parameters }
}

/// Names in the study. Nodes that nothing leads to are left out: the study format refuses them.
fn names(deck: &Deck, notes: &mut Vec<String>) -> Written {
    let mut written = Written { is_there: vec![false; deck.nodes.len()], ..Written::default() };
    for coupling in deck.couplings.iter().filter(|coupling| coupling.between[0] != coupling.between[1]) {
        coupling.between.into_iter().for_each(|end| written.is_there[end] = true);
    }
    deck.loads.iter().for_each(|load| written.is_there[load.into] = true);
    let of_heaters = deck.heaters.iter().flat_map(|heater| [heater.into, heater.senses]);
    of_heaters.for_each(|node| written.is_there[node] = true);
    let mut names = Names::default();
    // `all` stands for every node in the start of a transient.
    names.label("all");
    for (index, node) in deck.nodes.iter().enumerate() {
        let name = names.label(&node.name);
        if name != node.name {
            notes.push(format!("the node `{}` is called `{name}`", escaped(&node.name)));
        }
        if !written.is_there[index] {
            if matches!(node.kind, NodeKind::Boundary { .. }) {
                written.is_there[index] = true;
            } else {
                notes.push(format!("the node `{}` is left out: nothing leads to it", escaped(&node.name)));
            }
        }
        written.nodes.push(name);
    }
    let mut names = Names::default();
    let symbols = (deck.inputs.iter().map(|entry| &entry.name))
        .chain(deck.parameters.iter().map(|entry| &entry.name))
        .chain(deck.tables.iter().map(|entry| &entry.name));
    for symbol in symbols {
        let name = names.symbol(symbol);
        // A name that means an input and a parameter keeps to the first.
        if name != *symbol && !written.symbols.contains_key(symbol) {
            notes.push(format!("`{}` is called `{name}`", escaped(symbol)));
            written.symbols.insert(symbol.clone(), name);
        }
    }
    let numbers = (deck.inputs.iter().map(|entry| (&entry.name, entry.nominal)))
        .chain(deck.parameters.iter().map(|entry| (&entry.name, entry.nominal)));
    written.nominal = numbers.map(|(name, nominal)| (name.clone(), nominal)).collect();
    written
}

/// Names of inputs, parameters and tables that the values of what stands in the study use.
fn used<'d>(deck: &'d Deck, written: &Written) -> HashSet<&'d str> {
    let of_nodes = deck.nodes.iter().zip(&written.is_there).filter(|(_, is_there)| **is_there);
    let of_nodes = of_nodes.filter_map(|(node, _)| match &node.kind {
        NodeKind::Diffusion { capacity } => Some(capacity),
        NodeKind::Boundary { temperature } => Some(temperature),
        NodeKind::Arithmetic => None,
    });
    let values = of_nodes
        .chain(deck.couplings.iter().map(|coupling| &coupling.value))
        .chain(deck.loads.iter().map(|load| &load.power))
        .chain(deck.heaters.iter().map(|heater| &heater.power));
    let mut used = HashSet::new();
    for value in values {
        match value {
            Value::Number(_) => {}
            Value::Scaled { parameter, .. } => {
                used.insert(parameter.as_str());
            }
            Value::Expression(text) => used.extend(identifiers(text)),
        }
    }
    used
}

fn node_item(deck: &Deck, index: usize, written: &Written, notes: &mut Vec<String>) -> Item {
    let node = &deck.nodes[index];
    let mut entries = Vec::new();
    match &node.kind {
        NodeKind::Diffusion { capacity: Value::Number(capacity) } if *capacity <= 0.0 => {
            notes.push(format!(
                "the node `{}` stores no heat: the deck gives it a heat capacity of {capacity} J/K",
                escaped(&node.name)
            ));
        }
        NodeKind::Diffusion { capacity } => entries.push(("capacity", written.scalar(capacity, 1.0))),
        NodeKind::Boundary { temperature: Value::Number(0.0) } => {
            notes.push(format!("the boundary `{}` has {COLDEST_K} K, in the deck 0 K", escaped(&node.name)));
            entries.push(("boundary", Item::number(COLDEST_K)));
        }
        NodeKind::Boundary { temperature } => entries.push(("boundary", written.scalar(temperature, 1.0))),
        NodeKind::Arithmetic => {}
    }
    if written.node(index) != node.name {
        entries.push(("alias", Item::text(&escaped(&node.name))));
    }
    if let Some(label) = &node.label {
        entries.push(("description", Item::text(&escaped(label))));
    }
    Item::Object(entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect())
}

fn unit(text: &str) -> Item {
    Item::text(if text.is_empty() { "1" } else { text })
}

fn input_item(input: &bmv_decks::Input, written: &Written) -> (String, Item) {
    let entries = [
        ("unit", unit(&input.unit)),
        ("nominal", Item::number(input.nominal)),
        ("description", Item::text(&escaped(&input.description))),
    ];
    let entries = entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect();
    (written.symbol(&input.name).to_owned(), Item::Object(entries))
}

/// A parameter with a wide prior: a deck says nothing of how well its numbers are known.
fn parameter_item(parameter: &Parameter, written: &Written) -> (String, Item) {
    let object = |entries: [(&str, Item); 2]| {
        Item::Object(entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect())
    };
    let nominal = parameter.nominal;
    let prior = if nominal > 0.0 {
        let entries = [("median", Item::number(nominal)), ("factor", Item::number(2.0))];
        Some(Item::one("lognormal", object(entries)))
    } else {
        let entries = [("mean", Item::number(nominal)), ("sd", Item::number(0.5 * nominal.abs()))];
        (nominal < 0.0).then(|| Item::one("normal", object(entries)))
    };
    let source =
        if prior.is_some() { NOT_ELICITED.to_owned() } else { format!("{NOT_ELICITED}; without a prior: it is 0") };
    let mut entries = vec![("unit", unit(&parameter.unit)), ("nominal", Item::number(nominal))];
    entries.extend(prior.map(|prior| ("prior", prior)));
    entries.push(("description", Item::text(&escaped(&parameter.description))));
    entries.push(("source", Item::text(&source)));
    let entries = entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect();
    (written.symbol(&parameter.name).to_owned(), Item::Object(entries))
}

/// Groups of nodes that are no boundaries, each with weight 1, and of couplings of one kind.
fn groups(deck: &Deck, written: &Written, couplings: &Couplings) -> Vec<(String, Item)> {
    let mut names = Names::default();
    let mut groups = Vec::new();
    for group in &deck.groups {
        let is_inner =
            |node: &usize| written.is_there[*node] && !matches!(deck.nodes[*node].kind, NodeKind::Boundary { .. });
        let mut nodes: Vec<usize> = group.nodes.iter().copied().filter(is_inner).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut members: [Vec<Item>; 2] = [Vec::new(), Vec::new()];
        let mut listed = HashSet::new();
        for &coupling in group.couplings.iter().filter(|coupling| listed.insert(**coupling)) {
            match &couplings.became[coupling] {
                Became::Conductor(name) => members[0].push(Item::text(name)),
                Became::Radiation(name) => members[1].push(Item::text(name)),
                Became::Flow | Became::Nothing => {}
            }
        }
        let [conductors, radiations] = members;
        let item = if !nodes.is_empty() {
            let weights = nodes.iter().map(|&node| (written.node(node).to_owned(), Item::number(1.0)));
            Item::one("nodes", Item::Object(weights.collect()))
        } else if conductors.len() >= radiations.len() && !conductors.is_empty() {
            Item::one("conductors", Item::List(conductors))
        } else if !radiations.is_empty() {
            Item::one("radiations", Item::List(radiations))
        } else {
            continue;
        };
        groups.push((names.label(&group.name), item));
    }
    groups
}

/// What the reader and the import say of the deck.
fn description(deck: &Deck, notes: &[String]) -> String {
    let of_reader = deck.notes.iter().map(|note| match &note.place {
        Some(place) => format!("{place}: {}", note.message),
        None => note.message.clone(),
    });
    let all: Vec<String> = of_reader.chain(notes.iter().cloned()).collect();
    let mut text = format!("Imported from {}.", deck.tool);
    for note in all.iter().take(MOST_NOTES) {
        text.push(' ');
        text.push_str(note.trim_end_matches('.'));
        text.push('.');
    }
    if all.len() > MOST_NOTES {
        text.push_str(&format!(" {} further notes were printed by the import.", all.len() - MOST_NOTES));
    }
    escaped(&text).into_owned()
}
