//! The text of an ESATAN model, `.d`: data blocks in full, code refused at its line.
//!
//! The layout follows the public models of `mlauryn/EsatanOpt`, written by ESATAN-TMS 2017 sp2.

mod blocks;
mod network;

use std::collections::BTreeMap;

use crate::CELSIUS_ZERO_K;
use crate::esatan::DEFAULT_STEFAN_BOLTZMANN;
use crate::identifier::Identifiers;
use crate::{Deck, DeckError, Note, Parameter, Value};

use crate::arithmetic::piece::Piece;
use crate::arithmetic::quantity::{Quantity, Reader};
use blocks::{Data, Statement};

/// Most errors that are reported of one file.
const MOST_ERRORS: usize = 50;

/// Reads the text of a model: blocks of constants, nodes and conductors, with submodels.
///
/// Constants that stand for numbers become parameters; those computed from others are written out where they are used.
/// Nodes of type X and their conductors are left out. Groups are labels, submodels, optical coatings, and what Workbench
/// says of conductors in comments such as `# from conductor NAME`.
///
/// # Errors
///
/// Each line that is not understood, code in `$INITIAL`, `$VARIABLES1`, `$VARIABLES2` and `$EVENTS` among them; fifty at
/// most.
pub fn read_text(name: &str, text: &str) -> Result<Deck, Vec<DeckError>> {
    let blocks = blocks::cut(name, text);
    let mut model = Model {
        constants: BTreeMap::new(),
        parameters: Vec::new(),
        identifiers: Identifiers::beside_expressions(),
        zero_k: CELSIUS_ZERO_K,
        stefan_boltzmann: None,
        controls: 0,
    };
    let mut errors = blocks.errors;
    // Constants first, whichever block stands first.
    for statement in &blocks.statements {
        if let Err(message) = model.add_constant(statement) {
            errors.push(DeckError::at(name, statement.line, message));
        }
    }
    let mut deck = Deck {
        title: blocks.title,
        tool: "ESATAN".to_owned(),
        stefan_boltzmann: Some(model.stefan_boltzmann.unwrap_or(DEFAULT_STEFAN_BOLTZMANN)),
        notes: blocks.notes,
        ..Deck::default()
    };
    network::add(name, &blocks.statements, &model, &mut deck, &mut errors);
    if !errors.is_empty() {
        errors.sort_by_key(|error| error.line);
        errors.truncate(MOST_ERRORS);
        return Err(errors);
    }
    model.finish(&mut deck);
    Ok(deck)
}

/// Constants of all models.
struct Model {
    /// By the path of their model and their name in capitals.
    constants: BTreeMap<(Vec<String>, String), Quantity>,
    parameters: Vec<Parameter>,
    identifiers: Identifiers,
    /// Temperature of 0 in the model's own scale, in K.
    zero_k: f64,
    stefan_boltzmann: Option<f64>,
    /// Control constants that are left out.
    controls: usize,
}

impl Model {
    /// What a name stands for in a model: its own constants come before those of models around it.
    fn constant(&self, model: &[String], name: &str) -> Result<Quantity, String> {
        let upper = name.to_ascii_uppercase();
        (0..=model.len())
            .rev()
            .filter_map(|depth| model.get(..depth))
            .find_map(|path| self.constants.get(&(path.to_vec(), upper.clone())))
            .cloned()
            .ok_or_else(|| format!("`{name}` is not defined as a constant; define it in $CONSTANTS or write a number"))
    }

    fn add_constant(&mut self, statement: &Statement) -> Result<(), String> {
        let is_integer = match statement.data {
            Data::Constants { is_integer } => Some(is_integer),
            Data::Control => None,
            Data::Nodes | Data::Conductors => return Ok(()),
        };
        let (name, quantity) = {
            let constant = |name: &str| self.constant(&statement.model, name);
            let mut reader = Reader::new(&statement.pieces, &constant);
            let coming = reader.coming();
            let Some(Piece::Word(name)) = reader.next() else {
                return Err(format!("expected the name of a constant instead of {coming}"));
            };
            reader.expect('=')?;
            let upper = name.to_ascii_uppercase();
            if is_integer.is_none() && !matches!(upper.as_str(), "TABS" | "STEFAN") {
                self.controls += 1;
                return Ok(());
            }
            let quantity = reader.quantity().map_err(|message| format!("{name}: {message}"))?;
            reader.end("`;`")?;
            (name.clone(), quantity)
        };
        let upper = name.to_ascii_uppercase();
        let Some(is_integer) = is_integer else {
            if !quantity.is_number() || quantity.nominal < 0.0 {
                return Err(format!("{name} has to be a number that is not negative"));
            }
            if upper == "TABS" {
                self.zero_k = quantity.nominal;
            } else {
                self.stefan_boltzmann = Some(quantity.nominal);
            }
            return Ok(());
        };
        if is_integer && quantity.nominal.fract() != 0.0 {
            return Err(format!("{name} is an integer, but its value is {}", quantity.nominal));
        }
        let key = (statement.model.clone(), upper);
        if self.constants.contains_key(&key) {
            return Err(format!("constant {name} is defined twice"));
        }
        let quantity = if is_integer && quantity.is_number() {
            Quantity::number(quantity.nominal, true)
        } else if quantity.is_number() {
            let mut path = statement.model.clone();
            path.push(name.clone());
            let parameter = self.identifiers.make(&path.join("_"));
            let mut description = format!("Constant {}", path.join(":"));
            if let Some(comment) = statement.comment.as_deref().filter(|comment| !comment.is_empty()) {
                description.push_str(&format!(": {comment}"));
            }
            let nominal = quantity.nominal;
            self.parameters.push(Parameter { name: parameter.clone(), unit: "1".to_owned(), nominal, description });
            Quantity::constant(&parameter, nominal)
        } else {
            quantity
        };
        self.constants.insert(key, quantity);
        Ok(())
    }

    /// Adds the parameters that the deck uses, and the last notes.
    fn finish(self, deck: &mut Deck) {
        let mut used = std::collections::HashSet::new();
        let capacities = deck.nodes.iter().filter_map(|node| match &node.kind {
            crate::NodeKind::Diffusion { capacity: value } | crate::NodeKind::Boundary { temperature: value } => {
                Some(value)
            }
            crate::NodeKind::Arithmetic => None,
        });
        let values = deck.couplings.iter().map(|coupling| &coupling.value).chain(deck.loads.iter().map(|l| &l.power));
        for value in values.chain(capacities) {
            match value {
                Value::Number(_) => {}
                Value::Scaled { parameter, .. } => {
                    used.insert(parameter.as_str());
                }
                Value::Expression(text) => used.extend(text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_')),
            }
        }
        let (kept, unused): (Vec<_>, Vec<_>) =
            self.parameters.into_iter().partition(|parameter| used.contains(parameter.name.as_str()));
        let mut note = |message: String| deck.notes.push(Note::new(message));
        if !unused.is_empty() {
            let names: Vec<&str> = unused.iter().take(10).map(|parameter| parameter.name.as_str()).collect();
            let more = if unused.len() > names.len() { ", ..." } else { "" };
            note(format!("{} constants that nothing uses are left out: {}{more}.", unused.len(), names.join(", ")));
        }
        if self.controls > 0 {
            note(format!("{} control constants of the solution are left out.", self.controls));
        }
        if self.stefan_boltzmann.is_none() {
            note(format!("No STEFAN is given: {DEFAULT_STEFAN_BOLTZMANN:e} W/(m2 K4) is taken, ESATAN's own."));
        }
        deck.parameters = kept;
    }
}
