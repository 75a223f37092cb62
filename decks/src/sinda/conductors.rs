//! CONDUCTOR DATA: `number, node, node, value`; a negative number is a radiation conductor.

use std::collections::HashMap;

use super::assembly::{Assembly, Label};
use super::card::Card;
use super::nodes::{fields, integer};
use crate::arithmetic::quantity::Quantity;
use crate::{Coupling, CouplingKind};

/// The comment of Thermal Desktop above the conductors of a contact.
const CONTACT: &str = "Contact - ";
/// Most conductors of a GEN.
const MOST_GENERATED: i64 = 100_000;

/// A contact whose conductors follow one another.
#[derive(Default)]
pub(super) struct Contact {
    /// The line of its comment and its first conductor's submodels.
    open: Option<(usize, [String; 2])>,
}

/// A conductor before all values of its contact or set are known.
pub(super) struct Conductor {
    /// Its name, law and ends; the value is put in at the end.
    pub(super) coupling: Coupling,
    /// Its value.
    pub(super) value: Quantity,
    /// The contact or the set of radiation conductors.
    pub(super) label: Option<String>,
}

/// Adds the conductors of a line.
pub(super) fn add(
    assembly: &mut Assembly,
    contact: &mut Contact,
    submodel: &str,
    card: &Card<'_>,
) -> Result<(), String> {
    let (option, fields) = fields(card.text);
    match (option, fields.as_slice()) {
        ("", [number, first, second, value]) => {
            let ends = [node(first, submodel)?, node(second, submodel)?];
            one(assembly, contact, submodel, card, integer(number)?, ends, value)
        }
        ("GEN", [number, count, step, first, first_step, second, second_step, value]) => {
            let count = integer(count)?;
            if !(1..=MOST_GENERATED).contains(&count) {
                return Err(format!("GEN of {count} conductors: expected 1 to {MOST_GENERATED}"));
            }
            let number = (integer(number)?, integer(step)?);
            let (first, second) = (node(first, submodel)?, node(second, submodel)?);
            let (first_step, second_step) = (integer(first_step)?, integer(second_step)?);
            let along = |start: i64, step: i64, place: i64| {
                step.checked_mul(place).and_then(|offset| start.checked_add(offset)).ok_or("a number is too large")
            };
            for place in 0..count {
                let ends = [
                    (first.0.clone(), along(first.1, first_step, place)?),
                    (second.0.clone(), along(second.1, second_step, place)?),
                ];
                one(assembly, contact, submodel, card, along(number.0, number.1, place)?, ends, value)?;
            }
            Ok(())
        }
        ("" | "GEN", _) => Err(format!(
            "{} fields: expected `number, node, node, value`, each pair of nodes in a line of its own",
            fields.len()
        )),
        (option, _) => {
            Err(format!("`{option}` is not read here: write `number, node, node, value` with a constant value"))
        }
    }
}

fn one(
    assembly: &mut Assembly,
    contact: &mut Contact,
    submodel: &str,
    card: &Card<'_>,
    number: i64,
    ends: [(String, i64); 2],
    value: &str,
) -> Result<(), String> {
    let value = assembly.control.quantity(value).map_err(|message| format!("value: {message}"))?;
    if !(value.nominal >= 0.0) {
        return Err(format!("a value of {}: expected 0 or more", value.nominal));
    }
    let submodels = [ends[0].0.clone(), ends[1].0.clone()];
    let between = [assembly.find_node(&ends[0])?, assembly.find_node(&ends[1])?];
    let kind = if number < 0 { CouplingKind::Radiative } else { CouplingKind::Linear };
    let label = if number < 0 {
        Some(assembly.label_of_set(submodel))
    } else {
        contact.label(card, submodels).map(|comment| assembly.label(comment, CONTACT))
    };
    if between[0] == between[1] {
        assembly.joined_to_themselves += 1;
        return Ok(());
    }
    let name = assembly.coupling_name(format!("{submodel}.{}", number.unsigned_abs()));
    let coupling = Coupling { name, kind, between, value: crate::Value::Number(0.0) };
    assembly.conductors.push(Conductor { coupling, value, label });
    Ok(())
}

impl Contact {
    /// The comment of the contact that a conductor belongs to: those below it, as long as they join the same two submodels.
    /// Where both ends lie in one submodel, nothing tells where the contact ends: the first conductor alone is of it.
    fn label<'a>(&mut self, card: &Card<'a>, mut submodels: [String; 2]) -> Option<&'a str> {
        submodels.sort();
        let comment = card.comment.filter(|comment| comment.text.starts_with(CONTACT));
        let Some(comment) = comment else {
            self.open = None;
            return None;
        };
        match &self.open {
            Some((line, first)) if *line == comment.line => {
                (*first == submodels && submodels[0] != submodels[1]).then_some(comment.text)
            }
            _ => {
                self.open = Some((comment.line, submodels));
                Some(comment.text)
            }
        }
    }
}

/// A node of a conductor: `SUBMODEL.number`, or the number in the block's own submodel.
fn node(text: &str, submodel: &str) -> Result<(String, i64), String> {
    let (of, number) = match text.rsplit_once('.') {
        Some((of, number)) => (of.trim().to_ascii_uppercase(), number),
        None => (submodel.to_owned(), text),
    };
    let number = integer(number.trim()).map_err(|_| format!("`{text}`: expected a node such as `{submodel}.12`"))?;
    if number <= 0 {
        return Err(format!("`{text}`: one-way conductors are not read; expected the node's number without a sign"));
    }
    Ok((of, number))
}

/// Shares of the conductors of each label, in the order of the labels' first ones: the sum of the values.
pub(super) fn totals(conductors: &[Conductor], labels: &[Label]) -> HashMap<String, f64> {
    let mut totals: HashMap<String, f64> = labels.iter().map(|label| (label.parameter.clone(), 0.0)).collect();
    for conductor in conductors {
        if let Some(total) = conductor.label.as_ref().and_then(|label| totals.get_mut(label)) {
            *total += conductor.value.nominal;
        }
    }
    totals
}
