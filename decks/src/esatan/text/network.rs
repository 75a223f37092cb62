//! Nodes and conductors of a model's text.

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::identifier::unique;
use crate::{Coupling, CouplingKind, Deck, DeckError, Group, Load, Node, NodeKind, Note, Value};

use super::Model;
use super::blocks::{Data, Statement};
use crate::arithmetic::piece::Piece;
use crate::arithmetic::quantity::{Quantity, Reader};

/// Heats of a node, which add.
const HEATS: [&str; 5] = ["QS", "QA", "QE", "QI", "QR"];
/// Most bytes of all expressions: constants are written out where they are used.
const EXPRESSION_BYTES: usize = 64 << 20;

/// Adds nodes, loads, conductors and groups.
pub(super) fn add(file: &str, statements: &[Statement], model: &Model, deck: &mut Deck, errors: &mut Vec<DeckError>) {
    let mut network = Network {
        model,
        deck,
        place: HashMap::new(),
        submodels: BTreeMap::new(),
        labels: BTreeMap::new(),
        coatings: BTreeMap::new(),
        conductors: BTreeMap::new(),
        names: HashSet::new(),
        expression_bytes: 0,
        inactive: 0,
        one_way: 0,
        heated_boundaries: 0,
    };
    for statement in statements.iter().filter(|statement| statement.data == Data::Nodes) {
        if let Err(message) = network.add_node(statement) {
            errors.push(DeckError::at(file, statement.line, message));
        }
    }
    // An end that is missing because its own line is refused would only hide that line.
    if errors.is_empty() {
        for statement in statements.iter().filter(|statement| statement.data == Data::Conductors) {
            if let Err(message) = network.add_conductor(statement) {
                errors.push(DeckError::at(file, statement.line, message));
            }
        }
    }
    if network.deck.nodes.is_empty() && errors.is_empty() {
        errors.push(DeckError::of(file, "the model has no node; expected a block $NODES with some"));
    }
    network.finish();
}

struct Network<'a> {
    model: &'a Model,
    deck: &'a mut Deck,
    /// Places of nodes by name; none for inactive ones.
    place: HashMap<String, Option<usize>>,
    submodels: BTreeMap<String, Vec<usize>>,
    labels: BTreeMap<String, Vec<usize>>,
    /// Nodes by the bits of absorptivity and emissivity.
    coatings: BTreeMap<(u64, u64), Vec<usize>>,
    /// Couplings by kind and the name in their comment.
    conductors: BTreeMap<(&'static str, String), Vec<usize>>,
    /// Names of couplings.
    names: HashSet<String>,
    expression_bytes: usize,
    inactive: usize,
    one_way: usize,
    heated_boundaries: usize,
}

impl Network<'_> {
    fn value(&mut self, quantity: Quantity) -> Result<Value, String> {
        let value = quantity.into_value();
        if let Value::Expression(text) = &value {
            self.expression_bytes += text.len();
            if self.expression_bytes > EXPRESSION_BYTES {
                return Err("expressions are too long in all; write constants as numbers".to_owned());
            }
        }
        Ok(value)
    }

    fn add_node(&mut self, statement: &Statement) -> Result<(), String> {
        let model = self.model;
        let constant = |name: &str| model.constant(&statement.model, name);
        let mut reader = Reader::new(&statement.pieces, &constant);
        let coming = reader.coming();
        let (letter, number) = match reader.next() {
            Some(Piece::Word(word)) => word.split_at(1),
            _ => return Err(format!("expected a node such as `D12` instead of {coming}")),
        };
        let number = number.parse::<u32>().map_err(|_| format!("expected a node such as `D12` instead of {coming}"))?;
        let letter = letter.to_ascii_uppercase();
        if !matches!(letter.as_str(), "D" | "B" | "X") {
            return Err(format!("{coming} is a node of type {letter}; D, B and X are read"));
        }
        let name = node_name(&statement.model, number);
        let mut label = None;
        if reader.accept('=') {
            let coming = reader.coming();
            let Some(Piece::Text(text)) = reader.next() else {
                return Err(format!("node {name}: expected a label in quotes instead of {coming}"));
            };
            label = Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        }
        let mut attributes: BTreeMap<String, Quantity> = BTreeMap::new();
        while reader.accept(',') {
            let coming = reader.coming();
            let attribute = match reader.next() {
                Some(Piece::Word(word)) => word.to_ascii_uppercase(),
                _ => return Err(format!("node {name}: expected a quantity such as `T` instead of {coming}")),
            };
            let is_read = matches!(attribute.as_str(), "T" | "C" | "A" | "ALP" | "EPS" | "FX" | "FY" | "FZ");
            if !is_read && !HEATS.contains(&attribute.as_str()) {
                return Err(format!(
                    "node {name}: {coming} is not read; T, C, QS, QA, QE, QI, QR, A, ALP, EPS, FX, FY and FZ are"
                ));
            }
            reader.expect('=')?;
            let quantity = reader.quantity().map_err(|message| format!("node {name}, {attribute}: {message}"))?;
            if attributes.insert(attribute.clone(), quantity).is_some() {
                return Err(format!("node {name}: {attribute} is given twice"));
            }
        }
        reader.end("`;`").map_err(|message| format!("node {name}: {message}"))?;
        if self.place.contains_key(&name) {
            return Err(format!("node {name} is defined twice"));
        }
        if letter == "X" {
            self.inactive += 1;
            self.place.insert(name, None);
            return Ok(());
        }
        let zero_k = self.model.zero_k;
        let temperature = attributes.remove("T");
        let initial_temperature_k = temperature.as_ref().map(|celsius| celsius.nominal + zero_k);
        if initial_temperature_k.is_some_and(|kelvin| kelvin < 0.0) {
            return Err(format!("node {name}: T is below absolute zero"));
        }
        let kind = if letter == "B" {
            let temperature = temperature.ok_or_else(|| format!("boundary node {name} has no T; write `T = ...`"))?;
            let kelvin = temperature.join('+', Quantity::number(zero_k, false))?;
            NodeKind::Boundary { temperature: self.value(kelvin)? }
        } else {
            match attributes.remove("C") {
                Some(capacity) if !(capacity.nominal >= 0.0) => return Err(format!("node {name}: C is negative")),
                Some(capacity) if capacity.nominal > 0.0 => NodeKind::Diffusion { capacity: self.value(capacity)? },
                _ => NodeKind::Arithmetic,
            }
        };
        let place = self.deck.nodes.len();
        for heat in HEATS {
            let Some(power) = attributes.remove(heat) else { continue };
            if power.is_number() && power.nominal == 0.0 {
                continue;
            }
            if letter == "B" {
                self.heated_boundaries += 1;
                continue;
            }
            let power = self.value(power)?;
            self.deck.loads.push(Load { name: format!("{heat}({name})"), into: place, power });
        }
        let nominal = |attribute: &str| attributes.get(attribute).map_or(0.0, |quantity| quantity.nominal);
        let [absorptivity, emissivity] = [nominal("ALP"), nominal("EPS")];
        if letter == "D" && (absorptivity > 0.0 || emissivity > 0.0) {
            self.coatings.entry((absorptivity.to_bits(), emissivity.to_bits())).or_default().push(place);
        }
        if !statement.model.is_empty() {
            self.submodels.entry(statement.model.join(".")).or_default().push(place);
        }
        if let Some(label) = &label {
            self.labels.entry(label.clone()).or_default().push(place);
        }
        self.place.insert(name.clone(), Some(place));
        self.deck.nodes.push(Node { name, label, kind, initial_temperature_k });
        Ok(())
    }

    fn add_conductor(&mut self, statement: &Statement) -> Result<(), String> {
        let model = self.model;
        let constant = |name: &str| model.constant(&statement.model, name);
        let mut reader = Reader::new(&statement.pieces, &constant);
        let coming = reader.coming();
        let (short, kind) = match reader.next() {
            Some(Piece::Word(word)) if word.eq_ignore_ascii_case("GL") => ("GL", CouplingKind::Linear),
            Some(Piece::Word(word)) if word.eq_ignore_ascii_case("GR") => ("GR", CouplingKind::Radiative),
            Some(Piece::Word(word)) if word.eq_ignore_ascii_case("GF") => ("GF", CouplingKind::OneWay),
            _ => return Err(format!("expected a conductor GL, GR or GF instead of {coming}")),
        };
        reader.expect('(')?;
        let from = self.end(&mut reader, &statement.model)?;
        reader.expect(',')?;
        let to = self.end(&mut reader, &statement.model)?;
        reader.expect(')')?;
        reader.expect('=')?;
        let quantity = reader.quantity().map_err(|message| format!("{short}({},{}): {message}", from.0, to.0))?;
        reader.end("`;`")?;
        if from.0 == to.0 {
            return Err(format!("{short} joins node {} to itself", from.0));
        }
        if quantity.nominal < 0.0 {
            return Err(format!("{short}({},{}) is negative", from.0, to.0));
        }
        let (Some(start), Some(end)) = (from.1, to.1) else { return Ok(()) };
        self.one_way += usize::from(kind == CouplingKind::OneWay);
        let value = self.value(quantity)?;
        let name = unique(&mut self.names, format!("{short}({},{})", from.0, to.0), "#");
        if let Some(origin) = statement.comment.as_deref().and_then(|comment| comment.strip_prefix("from ")) {
            let members = self.conductors.entry((short, origin.trim().to_owned())).or_default();
            members.push(self.deck.couplings.len());
        }
        self.deck.couplings.push(Coupling { name, kind, between: [start, end], value });
        Ok(())
    }

    /// One end of a conductor, `12` or `SUB:12`: its name and its place, none if it is inactive.
    fn end(&self, reader: &mut Reader, model: &[String]) -> Result<(String, Option<usize>), String> {
        let mut path = Vec::new();
        let number = loop {
            let coming = reader.coming();
            match reader.next() {
                Some(Piece::Word(word)) => {
                    path.push(word.clone());
                    reader.expect(':')?;
                }
                Some(Piece::Number(number, true)) => break *number,
                _ => return Err(format!("expected the number of a node instead of {coming}")),
            }
        };
        // A path starts at the model itself or at one around it.
        for depth in (0..=model.len()).rev() {
            let full: Vec<String> = model.iter().take(depth).chain(&path).cloned().collect();
            let name = node_name(&full, number);
            if let Some(place) = self.place.get(&name) {
                return Ok((name, *place));
            }
            if path.is_empty() {
                break;
            }
        }
        Err(format!("node {} is not defined", node_name(&path, number)))
    }

    fn finish(self) {
        let mut used = HashSet::new();
        let coatings = self.coatings.into_iter().map(|((absorptivity, emissivity), nodes)| {
            (format!("alpha {} epsilon {}", f64::from_bits(absorptivity), f64::from_bits(emissivity)), nodes)
        });
        for (name, nodes) in self.submodels.into_iter().chain(self.labels).chain(coatings) {
            let name = unique(&mut used, name, "#");
            self.deck.groups.push(Group { name, nodes, couplings: Vec::new() });
        }
        for ((short, origin), couplings) in self.conductors {
            let name = unique(&mut used, format!("{short} {origin}"), "#");
            self.deck.groups.push(Group { name, nodes: Vec::new(), couplings });
        }
        let mut note = |count: usize, message: &str| {
            if count > 0 {
                self.deck.notes.push(Note::new(format!("{count} {message}")));
            }
        };
        note(self.inactive, "inactive nodes (type X) are left out with their conductors.");
        note(self.heated_boundaries, "heats into boundary nodes change nothing and are left out.");
        note(self.one_way, "conductors GF carry heat into their second node alone, from their first.");
    }
}

/// `SUB.12`, or `12` in the model at the top.
fn node_name(model: &[String], number: impl std::fmt::Display) -> String {
    if model.is_empty() { number.to_string() } else { format!("{}.{number}", model.join(".")) }
}
