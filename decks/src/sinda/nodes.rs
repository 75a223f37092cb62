//! NODE DATA: `number, temperature, capacity`. A negative number is a boundary, a negative capacity an arithmetic node.
//! Options make several nodes (GEN, SIM, SPM) and capacities that depend on temperature (SIV, SPV, DIV) or are products (CAL).

use super::assembly::Assembly;
use super::card::Card;
use super::law::{At, Form, law};
use crate::arithmetic::quantity::Quantity;
use crate::{Node, NodeKind};

/// So far below absolute zero lies what decks write for it, such as -460 degF, in K.
const ROUNDED_ZERO_K: f64 = -0.3;
/// Most nodes of a GEN.
const MOST_GENERATED: i64 = 100_000;

/// What a line says of a capacity.
enum Capacity<'a> {
    /// A number, the product of some, or nothing.
    Product(&'a [&'a str]),
    /// An array and a factor, by pairs that add.
    Laws(Form, &'a [&'a str]),
}

/// Adds the nodes of a line.
pub(super) fn add(assembly: &mut Assembly, submodel: &str, card: &Card<'_>) -> Result<(), String> {
    let (option, fields) = fields(card.text);
    let option = option.to_ascii_uppercase();
    let alone = |rest| (integer(fields[0]), Ok(1), Ok(0), rest);
    let several = |rest| (integer(fields[0]), integer(fields[1]), integer(fields[2]), rest);
    let (first, count, step, rest) = match (option.as_str(), fields.len()) {
        ("", 2 | 3) => alone(1),
        // Several nodes of three fields each may stand in a line.
        ("", length) if length % 3 == 0 => {
            for fields in fields.chunks(3) {
                let numbers = (integer(fields[0])?, 1, 0);
                generate(assembly, submodel, numbers, fields[1], &Capacity::Product(&fields[2..]))?;
            }
            return Ok(());
        }
        ("CAL", 6) | ("SIV" | "SPV", 4) | ("DIV" | "DPV", 6) => alone(1),
        ("GEN", 5 | 8) | ("SIM" | "SPM", 6) | ("DIM" | "DPM", 8) => several(3),
        ("" | "CAL" | "GEN" | "SIV" | "SPV" | "SIM" | "SPM" | "DIV" | "DPV" | "DIM" | "DPM", length) => {
            return Err(format!(
                "{length} fields{}: expected `number, temperature, capacity`, `GEN first, count, step, temperature, capacity` \
                 or `SIV number, temperature, array, factor`",
                if option.is_empty() { String::new() } else { format!(" of {option}") }
            ));
        }
        _ => {
            return Err(format!(
                "`{option}` is not read here: write `number, temperature, capacity` with constant values; a temperature that \
                 follows time becomes one number, and an input of the imported model"
            ));
        }
    };
    let numbers = (first?, count?, step?);
    let capacity = match option.as_str() {
        "SIV" | "SIM" | "DIV" | "DIM" => Capacity::Laws(Form::Interpolated, &fields[rest + 1..]),
        "SPV" | "SPM" | "DPV" | "DPM" => Capacity::Laws(Form::Polynomial, &fields[rest + 1..]),
        _ => Capacity::Product(&fields[rest + 1..]),
    };
    generate(assembly, submodel, numbers, fields[rest], &capacity)
}

/// Adds nodes whose numbers are a step apart.
fn generate(
    assembly: &mut Assembly,
    submodel: &str,
    (first, count, step): (i64, i64, i64),
    temperature: &str,
    capacity: &Capacity<'_>,
) -> Result<(), String> {
    if !(1..=MOST_GENERATED).contains(&count) {
        return Err(format!("{count} nodes: expected 1 to {MOST_GENERATED}"));
    }
    for place in 0..count {
        let number = step.checked_mul(place).and_then(|offset| first.checked_add(offset));
        one(assembly, submodel, number.ok_or("a node's number is too large")?, temperature, capacity)?;
    }
    Ok(())
}

fn one(
    assembly: &mut Assembly,
    submodel: &str,
    number: i64,
    temperature: &str,
    capacity: &Capacity<'_>,
) -> Result<(), String> {
    if number == 0 {
        return Err("a node of number 0: expected a number that is not 0".to_owned());
    }
    let units = assembly.control.units;
    let temperature = assembly.control.quantity(temperature).map_err(|message| format!("temperature: {message}"))?;
    let kelvin = assembly.control.scaled(temperature, units.kelvin_per_degree)?;
    let kelvin = kelvin.join('+', Quantity::number(units.zero_k, false))?;
    let is_rounded = kelvin.is_number() && (ROUNDED_ZERO_K..0.0).contains(&kelvin.nominal);
    assembly.seen.rounded_zeros += usize::from(is_rounded);
    let kelvin = if is_rounded { Quantity::number(0.0, false) } else { kelvin };
    if kelvin.nominal < 0.0 && assembly.control.are_units_known {
        return Err(format!("a temperature of {} K, below absolute zero", kelvin.nominal));
    }
    let initial_k = kelvin.nominal;
    let kind = if number < 0 {
        NodeKind::Boundary { temperature: kelvin.into_value() }
    } else {
        let capacity = self::capacity(assembly, submodel, capacity, initial_k)?;
        let capacity = assembly.control.scaled(capacity, units.joule / units.kelvin_per_degree)?;
        if capacity.nominal > 0.0 {
            NodeKind::Diffusion { capacity: capacity.into_value() }
        } else if capacity.nominal < 0.0 {
            NodeKind::Arithmetic
        } else {
            return Err("a capacity of 0: write -1 for an arithmetic node".to_owned());
        }
    };
    let node = Node {
        name: node_name(submodel, number.unsigned_abs()),
        label: None,
        kind,
        initial_temperature_k: Some(initial_k),
    };
    assembly.add_node(submodel, number.unsigned_abs(), node)
}

/// A capacity in the deck's units.
fn capacity(
    assembly: &mut Assembly,
    submodel: &str,
    capacity: &Capacity<'_>,
    initial_k: f64,
) -> Result<Quantity, String> {
    let mut whole: Option<Quantity> = None;
    match capacity {
        Capacity::Product(factors) => {
            assembly.seen.has_products |= factors.len() > 1;
            for factor in *factors {
                let factor = assembly.control.quantity(factor).map_err(|message| format!("capacity: {message}"))?;
                whole = Some(match whole {
                    Some(product) => product.join('*', factor)?,
                    None => factor,
                });
            }
        }
        Capacity::Laws(form, pairs) => {
            let at = At { expression: "T", initial_k };
            for pair in pairs.chunks_exact(2) {
                let part = law(assembly, submodel, *form, pair[0], at, pair[1])?;
                whole = Some(match whole {
                    Some(sum) => sum.join('+', part)?,
                    None => part,
                });
            }
        }
    }
    whole.ok_or_else(|| "expected a capacity as the third field, -1 for an arithmetic node".to_owned())
}

/// `SUBMODEL.12`, or `12` in a deck without submodels.
pub(super) fn node_name(submodel: &str, number: impl std::fmt::Display) -> String {
    if submodel.is_empty() { number.to_string() } else { format!("{submodel}.{number}") }
}

/// The option before the first field, in capitals, and the fields.
pub(super) fn fields(text: &str) -> (&str, Vec<&str>) {
    let (option, rest) = match text.split_once(char::is_whitespace) {
        Some((word, rest)) if word.chars().all(|c| c.is_ascii_alphabetic()) => (word, rest),
        _ => ("", text),
    };
    // A comma may end a line.
    let rest = rest.trim().trim_end_matches(',');
    (option, rest.split(',').map(str::trim).collect())
}

/// A whole number; spaces may stand behind its sign.
pub(super) fn integer(text: &str) -> Result<i64, String> {
    let joined: String = text.split_whitespace().collect();
    let is_whole = joined.len() == text.len() || text.starts_with(['-', '+']);
    joined.parse().ok().filter(|_| is_whole).ok_or(text).map_err(|_| format!("`{text}`: expected a whole number"))
}
