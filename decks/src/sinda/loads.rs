//! VARIABLES 0 and 1: heat that is added to a node, `SUB.Q12 = SUB.Q12 + 0.5`, or is all of its heat, `SUB.Q12 = 0.5`.
//! SOURCE DATA: `node, heat`.

use super::assembly::Assembly;
use super::card::Card;
use super::law::{At, Form, law};
use super::nodes::{fields, integer, node_name};
use crate::arithmetic::quantity::Quantity;

/// Most heats of a GEN.
const MOST_GENERATED: i64 = 100_000;
/// The comment of Thermal Desktop above the heats of a load.
const HEAT_LOAD: &str = "Heat Load-";
/// The routine that Thermal Desktop writes to interpolate heating rates.
const LOADQ: &str = "CALL LOADQ_";

/// Heat into a node before all heats of its load are known.
pub(super) struct Heat {
    /// Index of the node.
    pub(super) into: usize,
    /// Its power, in W.
    pub(super) power: Quantity,
    /// The load's name.
    pub(super) label: Option<String>,
}

/// Adds the statement of a line of VARIABLES 0.
pub(super) fn add(assembly: &mut Assembly, submodel: &str, card: &Card<'_>) -> Result<(), String> {
    let upper = card.text.to_ascii_uppercase();
    if upper.starts_with(LOADQ) {
        assembly.heating.insert(submodel.to_owned());
        return Ok(());
    }
    let refused = || {
        let name = node_name(submodel, "Q12");
        format!("`{}` is not read: expected heat added to a node, such as `{name} = {name} + 0.5`", card.text)
    };
    let (target, sum) = upper.split_once('=').ok_or_else(refused)?;
    let (target, sum) = (target.trim(), sum.trim());
    let (is_sum, power) = match sum.strip_prefix(target).map(str::trim_start) {
        Some(power) if power.starts_with(['+', '-']) => (true, power),
        Some(_) => return Err(refused()),
        None => (false, sum),
    };
    let (of, name) = target.rsplit_once('.').unwrap_or((submodel, target));
    let digits = name.strip_prefix('Q').map(|rest| rest.trim_matches(['(', ')'])).ok_or_else(refused)?;
    let is_name = of.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if digits.is_empty() || !is_name {
        return Err(refused());
    }
    let node = (of.to_owned(), integer(digits.trim()).map_err(|_| refused())?);
    let power = assembly.control.quantity(power).map_err(|message| format!("{message}; {}", refused()))?;
    if !is_sum && assembly.is_heated(&node)? {
        return Err(format!("`{}` replaces heat that was given before; write one heat alone", card.text));
    }
    let comment = card.comment.map(|comment| comment.text).filter(|text| text.starts_with(HEAT_LOAD));
    push(assembly, &node, power, comment)
}

/// Adds the heat of a line of SOURCE DATA.
pub(super) fn add_source(assembly: &mut Assembly, submodel: &str, card: &Card<'_>) -> Result<(), String> {
    let (option, fields) = fields(card.text);
    match (option.to_ascii_uppercase().as_str(), fields.as_slice()) {
        ("", fields) if fields.len() % 2 == 0 => {
            for pair in fields.chunks(2) {
                let power = assembly.control.quantity(pair[1])?;
                push(assembly, &(submodel.to_owned(), integer(pair[0])?), power, None)?;
            }
            Ok(())
        }
        ("GEN", [first, count, step, power]) => {
            let (first, count, step) = (integer(first)?, integer(count)?, integer(step)?);
            if !(1..=MOST_GENERATED).contains(&count) {
                return Err(format!("{count} heats: expected 1 to {MOST_GENERATED}"));
            }
            let power = assembly.control.quantity(power)?;
            for place in 0..count {
                let number = step.checked_mul(place).and_then(|offset| first.checked_add(offset));
                let node = (submodel.to_owned(), number.ok_or("a node's number is too large")?);
                push(assembly, &node, power.clone(), None)?;
            }
            Ok(())
        }
        ("SIV", [number, array, factor]) => {
            let node = (submodel.to_owned(), integer(number)?);
            let initial_k = assembly.initial_k(assembly.find_node(&node)?);
            let at = At { expression: "T", initial_k };
            let power = law(assembly, submodel, Form::Interpolated, array, at, factor)?;
            push(assembly, &node, power, None)
        }
        ("SIT" | "SPT" | "DIT" | "DPT" | "CYC", _) => Err(
            "heat that follows time is not read: write `node, heat` with one number, such as its mean, and let an input of the \
             imported model follow time"
                .to_owned(),
        ),
        _ => Err("expected `node, heat`, `GEN first, count, step, heat` or `SIV node, array, factor`".to_owned()),
    }
}

fn push(assembly: &mut Assembly, node: &(String, i64), power: Quantity, comment: Option<&str>) -> Result<(), String> {
    let into = assembly.find_node(node)?;
    let power = assembly.control.scaled(power, assembly.control.units.watt())?;
    let label = comment.map(|comment| assembly.label(comment, HEAT_LOAD));
    assembly.heats.push(Heat { into, power, label });
    Ok(())
}
