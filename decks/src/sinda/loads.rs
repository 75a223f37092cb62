//! VARIABLES 0: heat that is added to a node, `SUB.Q12 = SUB.Q12 + 0.5`. SOURCE DATA: `node, heat`.

use super::assembly::Assembly;
use super::card::Card;
use super::nodes::{fields, integer};
use crate::arithmetic::quantity::Quantity;

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
        format!(
            "`{}` is not read: expected heat added to a node, such as `{submodel}.Q12 = {submodel}.Q12 + 0.5`",
            card.text
        )
    };
    let (target, sum) = upper.split_once('=').ok_or_else(refused)?;
    let target = target.trim();
    let power = sum.trim().strip_prefix(target).map(str::trim_start).ok_or_else(refused)?;
    let is_sum = power.starts_with(['+', '-']);
    let (of, name) = target.rsplit_once('.').unwrap_or((submodel, target));
    let digits = name.strip_prefix('Q').map(|rest| rest.trim_matches(['(', ')'])).ok_or_else(refused)?;
    if !is_sum || digits.is_empty() {
        return Err(refused());
    }
    let node = (of.trim().to_owned(), integer(digits.trim()).map_err(|_| refused())?);
    let power = assembly.control.quantity(power)?;
    let comment = card.comment.map(|comment| comment.text).filter(|text| text.starts_with(HEAT_LOAD));
    push(assembly, &node, power, comment)
}

/// Adds the heat of a line of SOURCE DATA.
pub(super) fn add_source(assembly: &mut Assembly, submodel: &str, card: &Card<'_>) -> Result<(), String> {
    match fields(card.text) {
        ("", fields) if fields.len() == 2 => {
            let power = assembly.control.quantity(fields[1])?;
            push(assembly, &(submodel.to_owned(), integer(fields[0])?), power, None)
        }
        _ => Err("expected `node, heat` with a constant heat in W".to_owned()),
    }
}

fn push(assembly: &mut Assembly, node: &(String, i64), power: Quantity, comment: Option<&str>) -> Result<(), String> {
    let into = assembly.find_node(node)?;
    let power = assembly.control.scaled(power, assembly.control.units.watt())?;
    let label = comment.map(|comment| assembly.label(comment, HEAT_LOAD));
    assembly.heats.push(Heat { into, power, label });
    Ok(())
}
