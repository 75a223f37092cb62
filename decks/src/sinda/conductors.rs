//! CONDUCTOR DATA: `number, node, node, value`; a negative number is a radiation conductor. Options make several (GEN, SIM,
//! SPM), values that depend on temperature (SIV and SPV at the mean of both ends, DIV and DPV at each end), and products (CAL).

use std::collections::HashMap;

use super::assembly::{Assembly, Label};
use super::card::Card;
use super::law::{At, Form, in_series, law};
use super::nodes::{fields, integer, node_name};
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

/// What a line says of a value.
enum Law<'a> {
    /// A number.
    Constant(&'a str),
    /// `X Y Z / W`.
    Ratio(&'a [&'a str]),
    /// An array and a factor at the mean temperature.
    AtMean(Form, &'a [&'a str]),
    /// An array and a factor at each end, in series.
    AtEnds(Form, &'a [&'a str]),
}

/// Adds the conductors of a line.
pub(super) fn add(
    assembly: &mut Assembly,
    contact: &mut Contact,
    submodel: &str,
    card: &Card<'_>,
) -> Result<(), String> {
    let (option, fields) = fields(card.text);
    let option = option.to_ascii_uppercase();
    // Positions of the first and the second node, and of the value.
    let (is_several, start) = match (option.as_str(), fields.len()) {
        ("", 4) | ("CAL", 7) | ("SIV" | "SPV", 5) | ("DIV" | "DPV", 7) => (false, 3),
        ("GEN", 8 | 11) | ("SIM" | "SPM", 9) | ("DIM" | "DPM", 11) => (true, 7),
        ("" | "CAL" | "GEN" | "SIV" | "SPV" | "SIM" | "SPM" | "DIV" | "DPV" | "DIM" | "DPM", length) => {
            return Err(format!(
                "{length} fields{}: expected `number, node, node, value` or `SIV number, node, node, array, factor`, each pair \
                 of nodes in a line of its own",
                if option.is_empty() { String::new() } else { format!(" of {option}") }
            ));
        }
        _ => {
            return Err(format!(
                "`{option}` is not read here: write `number, node, node, value` with a constant value"
            ));
        }
    };
    let rest = &fields[start..];
    let law = match option.as_str() {
        "SIV" | "SIM" => Law::AtMean(Form::Interpolated, rest),
        "SPV" | "SPM" => Law::AtMean(Form::Polynomial, rest),
        "DIV" | "DIM" => Law::AtEnds(Form::Interpolated, rest),
        "DPV" | "DPM" => Law::AtEnds(Form::Polynomial, rest),
        _ if rest.len() == 4 => Law::Ratio(rest),
        _ => Law::Constant(rest[0]),
    };
    let mut build = Build { assembly, contact, submodel, card, law };
    let number = integer(fields[0])?;
    if !is_several {
        return build.one(number, [node(fields[1], submodel)?, node(fields[2], submodel)?]);
    }
    let (count, step) = (integer(fields[1])?, integer(fields[2])?);
    if !(1..=MOST_GENERATED).contains(&count) {
        return Err(format!("{count} conductors: expected 1 to {MOST_GENERATED}"));
    }
    let (first, second) = (node(fields[3], submodel)?, node(fields[5], submodel)?);
    let (first_step, second_step) = (integer(fields[4])?, integer(fields[6])?);
    let along = |start: i64, step: i64, place: i64| {
        step.checked_mul(place).and_then(|offset| start.checked_add(offset)).ok_or("a number is too large")
    };
    for place in 0..count {
        let ends = [
            (first.0.clone(), along(first.1, first_step, place)?),
            (second.0.clone(), along(second.1, second_step, place)?),
        ];
        build.one(along(number, step, place)?, ends)?;
    }
    Ok(())
}

/// A line whose conductors are built.
struct Build<'a, 'c> {
    assembly: &'a mut Assembly,
    contact: &'a mut Contact,
    submodel: &'a str,
    card: &'a Card<'c>,
    law: Law<'a>,
}

impl Build<'_, '_> {
    fn one(&mut self, number: i64, ends: [(String, i64); 2]) -> Result<(), String> {
        let between = [self.assembly.find_node(&ends[0])?, self.assembly.find_node(&ends[1])?];
        let kind = if number < 0 { CouplingKind::Radiative } else { CouplingKind::Linear };
        let value = self.value(kind, between)?;
        if kind == CouplingKind::Linear && value.is_number() && value.nominal < 0.0 {
            let first = format!("{}:{}", self.card.file, self.card.line);
            self.assembly.seen.negative.get_or_insert((first, 0)).1 += 1;
        } else if !(value.nominal >= 0.0) {
            return Err(format!("a value of {}: expected 0 or more", value.nominal));
        }
        let units = self.assembly.control.units;
        let factor = match kind {
            CouplingKind::Radiative => self.assembly.control.square_metre,
            CouplingKind::Linear | CouplingKind::OneWay => units.watt() / units.kelvin_per_degree,
        };
        let value = self.assembly.control.scaled(value, factor)?;
        let submodels = ends.map(|(submodel, _)| submodel);
        let label = if number < 0 {
            Some(self.assembly.label_of_set(self.submodel))
        } else {
            let label = self.contact.label(self.card, submodels).filter(|_| !value.is_expression());
            label.map(|comment| self.assembly.label(comment, CONTACT))
        };
        if between[0] == between[1] {
            self.assembly.seen.joined_to_themselves += 1;
            return Ok(());
        }
        // A conductor that is switched off: what hangs on it alone has no balance.
        if value.is_number() && value.nominal == 0.0 {
            self.assembly.seen.zeros += 1;
            return Ok(());
        }
        let name = self.assembly.coupling_name(node_name(self.submodel, number.unsigned_abs()));
        let coupling = Coupling { name, kind, between, value: crate::Value::Number(0.0) };
        self.assembly.conductors.push(Conductor { coupling, value, label });
        Ok(())
    }

    /// The value in the deck's units.
    fn value(&mut self, kind: CouplingKind, between: [usize; 2]) -> Result<Quantity, String> {
        let initial = between.map(|place| self.assembly.initial_k(place));
        let (assembly, submodel) = (&mut *self.assembly, self.submodel);
        match self.law {
            Law::Constant(value) => assembly.control.quantity(value).map_err(|message| format!("value: {message}")),
            Law::Ratio(fields) => {
                assembly.seen.has_products = true;
                let mut value = assembly.control.quantity(fields[0])?;
                for field in &fields[1..3] {
                    value = value.join('*', assembly.control.quantity(field)?)?;
                }
                value.join('/', assembly.control.quantity(fields[3])?)
            }
            Law::AtMean(form, fields) => {
                let at = At { expression: "(Ta + Tb) / 2", initial_k: 0.5 * (initial[0] + initial[1]) };
                law(assembly, submodel, form, fields[0], at, fields[1])
            }
            Law::AtEnds(_, _) if kind == CouplingKind::Radiative => {
                Err("a radiation conductor with an array at each end is not read: write its value as a number"
                    .to_owned())
            }
            Law::AtEnds(form, fields) => {
                let first = At { expression: "Ta", initial_k: initial[0] };
                let second = At { expression: "Tb", initial_k: initial[1] };
                let first = law(assembly, submodel, form, fields[0], first, fields[1])?;
                in_series(first, law(assembly, submodel, form, fields[2], second, fields[3])?)
            }
        }
    }
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
