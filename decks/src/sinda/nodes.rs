//! NODE DATA: `number, temperature, capacity`. A negative number is a boundary, a negative capacity an arithmetic node.

use super::assembly::Assembly;
use super::card::Card;
use crate::arithmetic::quantity::Quantity;
use crate::{Node, NodeKind};

/// Most nodes of a GEN.
const MOST_GENERATED: i64 = 100_000;

/// Adds the nodes of a line.
pub(super) fn add(assembly: &mut Assembly, submodel: &str, card: &Card<'_>) -> Result<(), String> {
    let (option, fields) = fields(card.text);
    match (option, fields.as_slice()) {
        ("", [number, temperature, rest @ ..]) if rest.len() < 2 => {
            one(assembly, submodel, integer(number)?, temperature, rest.first().copied())
        }
        ("GEN", [first, count, step, temperature, capacity]) => {
            let (first, count, step) = (integer(first)?, integer(count)?, integer(step)?);
            if !(1..=MOST_GENERATED).contains(&count) {
                return Err(format!("GEN of {count} nodes: expected 1 to {MOST_GENERATED}"));
            }
            for place in 0..count {
                let number = step.checked_mul(place).and_then(|offset| first.checked_add(offset));
                let number = number.ok_or("a node's number is too large")?;
                one(assembly, submodel, number, temperature, Some(capacity))?;
            }
            Ok(())
        }
        ("" | "GEN", _) => Err(format!(
            "{} fields: expected `number, temperature, capacity` or `GEN first, count, step, temperature, capacity`",
            fields.len()
        )),
        (option, _) => {
            Err(format!("`{option}` is not read here: write `number, temperature, capacity` with constant values"))
        }
    }
}

fn one(
    assembly: &mut Assembly,
    submodel: &str,
    number: i64,
    temperature: &str,
    capacity: Option<&str>,
) -> Result<(), String> {
    if number == 0 {
        return Err("a node of number 0: expected a number that is not 0".to_owned());
    }
    let temperature = assembly.control.quantity(temperature).map_err(|message| format!("temperature: {message}"))?;
    let kelvin = temperature.join('+', Quantity::number(assembly.control.zero_k, false))?;
    if kelvin.nominal < 0.0 {
        return Err(format!("a temperature of {} K, below absolute zero", kelvin.nominal));
    }
    let initial = kelvin.nominal;
    let kind = if number < 0 {
        NodeKind::Boundary { temperature: kelvin.into_value() }
    } else {
        let capacity = capacity.ok_or("expected a capacity as the third field, -1 for an arithmetic node")?;
        let capacity = assembly.control.quantity(capacity).map_err(|message| format!("capacity: {message}"))?;
        if capacity.nominal > 0.0 {
            NodeKind::Diffusion { capacity: capacity.into_value() }
        } else if capacity.nominal < 0.0 {
            NodeKind::Arithmetic
        } else {
            return Err("a capacity of 0: write -1 for an arithmetic node".to_owned());
        }
    };
    let node = Node {
        name: format!("{submodel}.{}", number.unsigned_abs()),
        label: None,
        kind,
        initial_temperature_k: Some(initial),
    };
    assembly.add_node(submodel, number.unsigned_abs(), node)
}

/// The option before the first field, in capitals, and the fields.
pub(super) fn fields(text: &str) -> (&str, Vec<&str>) {
    let (option, rest) = match text.split_once(char::is_whitespace) {
        Some((word, rest)) if word.chars().all(|c| c.is_ascii_alphabetic()) => (word, rest),
        _ => ("", text),
    };
    (option, rest.split(',').map(str::trim).collect())
}

/// A whole number.
pub(super) fn integer(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| format!("`{text}`: expected a whole number"))
}
