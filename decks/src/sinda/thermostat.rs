//! Thermostats of SINDA/G in VARIABLES 1: `TRMSTD(T600, 18.3, 32.2, K4, 0, K3, Q600)` heats node 600 by the constant 3 below
//! 18.3 degrees until 32.2 degrees; constant 4 keeps its state. Constants are set above by `XK3 = 11.3`.

use std::collections::HashMap;

use super::assembly::Assembly;
use super::card::Card;
use super::nodes::{integer, node_name};
use crate::identifier::unique;
use crate::{Heater, Value};

/// Constants that statements of a block have set, by number.
pub(super) type Constants = HashMap<i64, f64>;

/// Reads a line that sets a constant or is a thermostat; nothing where it is neither.
pub(super) fn add(assembly: &mut Assembly, constants: &mut Constants, card: &Card<'_>) -> Option<Result<(), String>> {
    let plain: String = card.text.split_whitespace().collect::<String>().to_ascii_uppercase();
    if let Some((name, value)) = plain.split_once('=') {
        let number = integer(name.strip_prefix("XK")?).ok()?;
        return Some(value.parse::<f64>().ok().filter(|value| value.is_finite()).map_or_else(
            || Err(format!("`{}`: a constant is read where it is set to a number", card.text)),
            |value| {
                constants.insert(number, value);
                Ok(())
            },
        ));
    }
    let arguments = plain.strip_prefix("CALL").unwrap_or(&plain).strip_prefix("TRMSTD(")?.strip_suffix(')')?;
    let arguments: Vec<&str> = arguments.split(',').collect();
    Some(heater(assembly, constants, &arguments).ok_or_else(|| {
        format!(
            "`{}` is not read: expected `TRMSTD(T1, on, off, K1, 0, power, Q1)` with numbers, off above on, and a power that is \
             a number or a constant set above, as by `XK2 = 5.`; leave it out and add the heater to `heaters` of the imported \
             model",
            card.text
        )
    }))
}

fn heater(assembly: &mut Assembly, constants: &Constants, arguments: &[&str]) -> Option<()> {
    let [senses, on, off, state, "0", power, into] = arguments else { return None };
    integer(state.strip_prefix('K')?).ok()?;
    let node = |text: &str, letter: char| {
        let number = integer(text.strip_prefix(letter)?).ok()?;
        Some((number, assembly.find_node(&(String::new(), number)).ok()?))
    };
    let ((_, senses), (number, into)) = (node(senses, 'T')?, node(into, 'Q')?);
    let power: f64 = match power.strip_prefix('K') {
        Some(constant) => *constants.get(&integer(constant).ok()?)?,
        None => power.parse().ok()?,
    };
    let units = assembly.control.units;
    let [on, off] = [on, off].map(|text| text.parse::<f64>().map_or(f64::NAN, |degrees| units.kelvin(degrees)));
    if !(on < off && power.is_finite()) {
        return None;
    }
    let name = unique(&mut assembly.heater_names, format!("TRMSTD {}", node_name("", number)), "#");
    let power = Value::Number(power * units.watt());
    assembly.deck.heaters.push(Heater { name, into, senses, power, on_below_k: on, off_above_k: off });
    Some(())
}
