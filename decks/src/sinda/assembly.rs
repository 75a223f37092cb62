//! The deck from its blocks.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::arrays::Arrays;
use super::block::{Block, Kind};
use super::card::Card;
use super::conductors::{self, Conductor, Contact};
use super::control::Control;
use super::heating::{self, Means};
use super::loads::{self, Heat};
use super::nodes::node_name;
use super::seen::Seen;
use super::units::Units;
use super::{heaters, nodes, subroutines, thermostat};
use crate::arithmetic::quantity::Quantity;
use crate::identifier::{Identifiers, unique};
use crate::{CELSIUS_ZERO_K, CouplingKind, Deck, DeckError, Group, Input, Load, Node, Note, Parameter, Record, Value};

/// How a message on a missing node ends.
const NOT_DEFINED: &str = "is not defined";

/// What several conductors or heats have in common.
pub(super) struct Label {
    /// The parameter's or input's name.
    pub(super) parameter: String,
    /// The deck's own words.
    description: String,
}

/// What was read so far.
pub(super) struct Assembly {
    /// Units and registers.
    pub(super) control: Control,
    /// Conductors in their order.
    pub(super) conductors: Vec<Conductor>,
    /// Heats in their order.
    pub(super) heats: Vec<Heat>,
    /// Submodels whose heating rates are used.
    pub(super) heating: BTreeSet<String>,
    /// What the deck's notes count.
    pub(super) seen: Seen,
    /// Arrays that options refer to.
    pub(super) arrays: Arrays,
    /// Names of the tables of arrays.
    pub(super) tables: HashMap<(String, i64), String>,
    /// Handles of the heaters that were read, and their names.
    pub(super) heater_handles: BTreeSet<String>,
    pub(super) heater_names: HashSet<String>,
    /// The deck so far.
    pub(super) deck: Deck,
    /// Names that are used.
    pub(super) identifiers: Identifiers,
    /// Index of each node by submodel and number.
    places: HashMap<(String, u64), usize>,
    /// Submodels with their nodes.
    submodels: BTreeMap<String, Vec<usize>>,
    coupling_names: HashSet<String>,
    labels: Vec<Label>,
    /// Position among the labels, by comment.
    label_places: HashMap<String, usize>,
}

/// A deck with the unit of its temperatures.
pub(super) struct Assembled {
    /// The deck.
    pub(super) deck: Deck,
    /// Its units.
    pub(super) units: Units,
    /// Whether it has heating rates that are those of an orbit's mean.
    pub(super) has_means: bool,
}

impl Assembled {
    /// Adds the temperatures of a result, at the deck's own values of the inputs.
    pub(super) fn add_record(&mut self, record: Record) {
        let inputs = self.deck.inputs.iter().map(|input| vec![input.nominal; record.times_s.len()]).collect();
        self.deck.record = Some(Record { inputs, ..record });
    }
}

/// Reads all blocks: nodes before what joins and heats them, whichever stands first.
pub(super) fn assemble(blocks: &[Block<'_>], errors: &mut Vec<DeckError>) -> Assembled {
    let mut deck = Deck { tool: tool(blocks), ..Deck::default() };
    let mut identifiers = Identifiers::beside_expressions();
    let control = Control::read(blocks, &mut identifiers, &mut deck.parameters, &mut deck.notes, errors);
    deck.title.clone_from(&control.title);
    deck.stefan_boltzmann = Some(control.stefan_boltzmann);
    let arrays = Arrays::read(blocks, &control);
    let mut assembly = Assembly {
        control,
        arrays,
        tables: HashMap::new(),
        heater_handles: BTreeSet::new(),
        heater_names: HashSet::new(),
        conductors: Vec::new(),
        heats: Vec::new(),
        heating: BTreeSet::new(),
        seen: Seen::default(),
        deck,
        identifiers,
        places: HashMap::new(),
        submodels: BTreeMap::new(),
        coupling_names: HashSet::new(),
        labels: Vec::new(),
        label_places: HashMap::new(),
    };
    assembly.read(blocks, Kind::Nodes, errors, |assembly, block, card| nodes::add(assembly, &block.submodel, card));
    if assembly.deck.nodes.is_empty() && errors.is_empty() {
        let file = blocks.first().map_or("", |block| block.file);
        errors.push(DeckError::of(file, "the deck has no nodes: expected a block HEADER NODE DATA"));
    }
    // A node that is missing because its own line is refused would only hide that line.
    let before = errors.len();
    let mut contact = Contact::default();
    assembly.read(blocks, Kind::Conductors, errors, |assembly, block, card| {
        conductors::add(assembly, &mut contact, &block.submodel, card)
    });
    assembly.read(blocks, Kind::Sources, errors, |assembly, block, card| {
        loads::add_source(assembly, &block.submodel, card)
    });
    for block in blocks.iter().filter(|block| block.kind == Kind::Heats) {
        let mut constants = thermostat::Constants::new();
        for card in heaters::add(&mut assembly, block, errors) {
            let done = block.is_numbered.then(|| thermostat::add(&mut assembly, &mut constants, card)).flatten();
            if let Err(message) = done.unwrap_or_else(|| loads::add(&mut assembly, &block.submodel, card)) {
                errors.push(DeckError::at(card.file, card.line, message));
                // Below the first line that is not understood stands more of the same.
                break;
            }
        }
    }
    if before > 0 {
        let mut place = 0;
        errors.retain(|error| {
            place += 1;
            place <= before || !error.message.ends_with(NOT_DEFINED)
        });
    }
    for block in blocks {
        let Some(card) = block.cards.first() else { continue };
        let what = match block.kind {
            Kind::Logic if heaters::is_counting(&assembly, block) => continue,
            Kind::Logic => "statements behind each step are not read; write constant values in their place",
            Kind::Refused => "this block is not read; leave it out, with what it does written as heats and boundaries",
            _ => continue,
        };
        errors.push(DeckError::at(card.file, card.line, format!("`{}`: {what}", card.text)));
    }
    blocks.iter().filter(|block| block.kind == Kind::Subroutines).for_each(|block| {
        subroutines::check(block, &assembly.heater_handles, errors);
    });
    assembly.add_heating(blocks, errors);
    assembly.finish()
}

/// `SINDA/FLUINT data created with Thermal Desktop 6.2 Patch 15` as a name.
fn tool(blocks: &[Block<'_>]) -> String {
    let comments = blocks.iter().flat_map(|block| &block.comments);
    let version = comments.filter_map(|comment| comment.text.split_once(" with Thermal Desktop ")).next();
    let plain = if blocks.iter().any(|block| block.is_numbered) { "SINDA/G" } else { "SINDA/FLUINT" };
    version.map_or(plain.to_owned(), |(_, version)| format!("Thermal Desktop {}", version.trim()))
}

impl Assembly {
    /// Hands the lines of all blocks of a kind on; of a line that is refused the place is reported.
    fn read(
        &mut self,
        blocks: &[Block<'_>],
        kind: Kind,
        errors: &mut Vec<DeckError>,
        mut add: impl FnMut(&mut Self, &Block<'_>, &Card<'_>) -> Result<(), String>,
    ) {
        for block in blocks.iter().filter(|block| block.kind == kind) {
            if !block.is_numbered && block.submodel.is_empty() && !block.cards.is_empty() {
                errors.push(DeckError::at(block.file, block.line, "expected the submodel's name behind a comma"));
                continue;
            }
            for card in &block.cards {
                if let Err(message) = add(self, block, card) {
                    errors.push(DeckError::at(card.file, card.line, message));
                }
            }
        }
    }

    /// Adds a node.
    pub(super) fn add_node(&mut self, submodel: &str, number: u64, node: Node) -> Result<(), String> {
        let place = self.deck.nodes.len();
        if self.places.insert((submodel.to_owned(), number), place).is_some() {
            return Err(format!("node {} is defined twice", node.name));
        }
        self.submodels.entry(submodel.to_owned()).or_default().push(place);
        self.deck.nodes.push(node);
        Ok(())
    }

    /// Index of a node.
    pub(super) fn find_node(&self, (submodel, number): &(String, i64)) -> Result<usize, String> {
        let key = (submodel.clone(), number.unsigned_abs());
        self.places.get(&key).copied().ok_or_else(|| format!("node {} {NOT_DEFINED}", node_name(submodel, number)))
    }

    /// Whether a node has heat already.
    pub(super) fn is_heated(&self, node: &(String, i64)) -> Result<bool, String> {
        let place = self.find_node(node)?;
        Ok(self.heats.iter().any(|heat| heat.into == place))
    }

    /// Temperature of a node at the start, in K.
    pub(super) fn initial_k(&self, place: usize) -> f64 {
        self.deck.nodes.get(place).and_then(|node| node.initial_temperature_k).unwrap_or(CELSIUS_ZERO_K)
    }

    /// A unique name of a coupling.
    pub(super) fn coupling_name(&mut self, name: String) -> String {
        unique(&mut self.coupling_names, name, "#")
    }

    /// The parameter of what a comment names: `Contact - Face Contactor-NAME[SUB][1]::4F`.
    pub(super) fn label(&mut self, comment: &str, prefix: &str) -> String {
        let rest = comment.strip_prefix(prefix).unwrap_or(comment);
        let name = rest.split(['[', ':']).next().unwrap_or(rest).trim();
        // Behind the kind of the contact stands the name that somebody gave it.
        let name = name.split_once('-').map_or(name, |(_, name)| name).trim();
        self.labelled(comment, if name.is_empty() { rest } else { name })
    }

    /// The scale of a set of radiation conductors.
    pub(super) fn label_of_set(&mut self, submodel: &str) -> String {
        if submodel.is_empty() {
            return self.labelled("Scale of the radiation conductors", "radiation");
        }
        let description = format!("Scale of the radiation conductors of {submodel}");
        self.labelled(&description, &format!("radiation_{submodel}"))
    }

    fn labelled(&mut self, description: &str, name: &str) -> String {
        if let Some(label) = self.label_places.get(description).and_then(|&place| self.labels.get(place)) {
            return label.parameter.clone();
        }
        let parameter = self.identifiers.make(name);
        self.label_places.insert(description.to_owned(), self.labels.len());
        self.labels.push(Label { parameter: parameter.clone(), description: description.to_owned() });
        parameter
    }

    /// Adds the mean heats of an orbit.
    fn add_heating(&mut self, blocks: &[Block<'_>], errors: &mut Vec<DeckError>) {
        let mut used = BTreeSet::new();
        for block in blocks.iter().filter(|block| block.kind == Kind::Arrays) {
            let means = match heating::means(block) {
                None => {
                    let is_used = self.seen.arrays.contains(&block.submodel);
                    let is_empty = block.cards.iter().all(|card| card.text.eq_ignore_ascii_case("END"));
                    if !is_empty && !is_used {
                        let place = format!("{}:{}", block.file, block.line);
                        let message = "Arrays are not read: nothing that is read refers to them.".to_owned();
                        self.deck.notes.push(Note::at(place, message));
                    }
                    continue;
                }
                Some(Err((line, message))) => {
                    errors.push(DeckError::at(block.file, line, message));
                    continue;
                }
                Some(Ok(means)) => means,
            };
            if !self.heating.contains(&block.submodel) {
                let message = format!("The heating rates of {} are not used: nothing calls for them.", block.submodel);
                self.deck.notes.push(Note::at(block.file, message));
                continue;
            }
            used.insert(block.submodel.clone());
            if let Err(message) = self.add_means(&block.submodel, means) {
                errors.push(DeckError::at(block.file, block.line, message));
            }
        }
        for submodel in self.heating.difference(&used) {
            let file = blocks.first().map_or("", |block| block.file);
            let message = format!("the heating rates of {submodel} are called for and not there: give its `.hra`");
            errors.push(DeckError::of(file, message));
        }
    }

    fn add_means(&mut self, submodel: &str, means: Means) -> Result<(), String> {
        let name = self.identifiers.make(&format!("heating_{submodel}"));
        let description = format!("Scale of the mean heating rates of {submodel}");
        let count = means.len();
        for (node, mean) in means {
            let power = Quantity::constant(&name, 1.0).join('*', Quantity::number(mean, false))?;
            let into = self.find_node(&node)?;
            self.heats.push(Heat { into, power, label: None });
        }
        self.deck.parameters.push(Parameter { name, unit: "1".to_owned(), nominal: 1.0, description });
        let message = format!(
            "The heating rates of {submodel} are those of its orbit's mean, as a steady state takes them: {count} nodes."
        );
        self.deck.notes.push(Note::new(message));
        Ok(())
    }

    fn finish(mut self) -> Assembled {
        let totals = conductors::totals(&self.conductors, &self.labels);
        let mut of_label: BTreeMap<String, (CouplingKind, Vec<usize>)> = BTreeMap::new();
        for (place, conductor) in self.conductors.into_iter().enumerate() {
            let Conductor { mut coupling, value, label } = conductor;
            coupling.value = match &label {
                Some(parameter) if value.is_number() => {
                    let total = totals.get(parameter).copied().unwrap_or(0.0);
                    let is_set = coupling.kind == CouplingKind::Radiative;
                    let factor = if is_set || total == 0.0 { value.nominal } else { value.nominal / total };
                    Value::Scaled { parameter: parameter.clone(), factor }
                }
                Some(parameter) => match value.clone().join('*', Quantity::constant(parameter, 1.0)) {
                    Ok(scaled) if coupling.kind == CouplingKind::Radiative => scaled.into_value(),
                    Ok(_) | Err(_) => value.into_value(),
                },
                None => value.into_value(),
            };
            if let Some(parameter) = label {
                of_label.entry(parameter).or_insert((coupling.kind, Vec::new())).1.push(place);
            }
            self.deck.couplings.push(coupling);
        }
        let mut load_names = HashSet::new();
        let mut heat_totals: BTreeMap<String, f64> = BTreeMap::new();
        for heat in &self.heats {
            if let Some(input) = &heat.label {
                *heat_totals.entry(input.clone()).or_default() += heat.power.nominal;
            }
        }
        for heat in self.heats {
            let name = self.deck.nodes.get(heat.into).map_or("", |node| node.name.as_str());
            let (name, power) = match &heat.label {
                Some(input) if heat.power.is_number() => {
                    let total = heat_totals.get(input).copied().unwrap_or(0.0);
                    let share = if total == 0.0 { 0.0 } else { heat.power.nominal / total };
                    (format!("{input} into {name}"), Value::Expression(format!("{share:?} * {input}")))
                }
                _ => (format!("heat into {name}"), heat.power.into_value()),
            };
            let name = unique(&mut load_names, name, "#");
            self.deck.loads.push(Load { name, into: heat.into, power });
        }
        for Label { parameter, description } in self.labels {
            if let Some(&nominal) = heat_totals.get(&parameter) {
                self.deck.inputs.push(Input { name: parameter, unit: "W".to_owned(), nominal, description });
                continue;
            }
            let Some((kind, couplings)) = of_label.remove(&parameter) else { continue };
            let (unit, nominal) = match kind {
                CouplingKind::Radiative => ("1", 1.0),
                CouplingKind::Linear | CouplingKind::OneWay => ("W/K", totals.get(&parameter).copied().unwrap_or(0.0)),
            };
            self.deck.groups.push(Group { name: parameter.clone(), nodes: Vec::new(), couplings });
            self.deck.parameters.push(Parameter { name: parameter, unit: unit.to_owned(), nominal, description });
        }
        let submodels = self.submodels.into_iter().map(|(name, nodes)| Group { name, nodes, couplings: Vec::new() });
        self.deck.groups.extend(submodels);
        self.deck.notes.extend(self.seen.notes());
        if of_contacts(&self.deck.parameters) {
            self.deck.notes.push(Note::new(
                "Conductors below a comment `Contact - ...` are taken for the contact's as long as they join the same two \
                 submodels. A contact's value is the sum of its conductors."
                    .to_owned(),
            ));
        }
        Assembled { units: self.control.units, has_means: !self.heating.is_empty(), deck: self.deck }
    }
}

fn of_contacts(parameters: &[Parameter]) -> bool {
    parameters.iter().any(|parameter| parameter.unit == "W/K")
}
