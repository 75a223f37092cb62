//! Heaters as Thermal Desktop writes them into VARIABLES 1: a thermostat in a transient, and in a steady state power that falls
//! from all of it at the temperature of switching on to none at that of switching off.

use super::assembly::Assembly;
use super::block::Block;
use super::card::Card;
use super::nodes::integer;
use crate::identifier::unique;
use crate::{DeckError, Heater, Value};

/// Statements of a heater, with its handle as `#`: what a line has to be, or to begin with where it ends in `...`.
const BEFORE: [&str; 15] = [
    "O__TD=...",
    "F__TD=...",
    "D__TD=F__TD-O__TD",
    "IF(T__TD.LT.F__TD.AND.D__TD.NE.0.)THEN",
    "X__TD=(F__TD-T__TD)/(D__TD)",
    "IF(X__TD.GT.1.)X__TD=1.",
    "ELSE",
    "X__TD=0.",
    "ENDIF",
    "X__TD=XP#+(X__TD-XP#)*...",
    "IF(X__TD.LT..001)X__TD=0.",
    "IF(X__TD.GT..999)X__TD=1.",
    "PO#=PO#*X__TD",
    "XP#=X__TD",
    "Q",
];
/// The same for transients, behind the temperatures.
const BEHIND: [&str; 10] = [
    "IF(T__TD.LT.O__TD.OR.(HT#.EQ.1.AND.T__TD.LT.F__TD))THEN",
    "IF(HT#.EQ.0)CH#=1+CH#",
    "HT#=1",
    "Q",
    "ELSE",
    "HT#=0",
    "PO#=0.",
    "ENDIF",
    "ENDIF",
    "SO#=O__TD",
];
/// What heaters count beside: on-times, energies and cycles, which change nothing.
const COUNTS: [&str; 5] = ["IF(HT#.EQ.1)THEN", "OT#=OT#+DTIMEU", "TP#=TP#+DTIMEU*PO#", "ENDIF", "SF#=F__TD"];

/// A heated node with its share of the power.
type Share = ((String, i64), f64);

/// Statements of a block: lines without spaces, in capitals, continued ones joined, each with its first line.
fn statements<'b, 'c>(cards: &'b [Card<'c>]) -> Vec<(&'b Card<'c>, String)> {
    let mut statements: Vec<(&Card<'_>, String)> = Vec::new();
    for card in cards {
        let plain: String = card.text.split_whitespace().collect::<String>().to_ascii_uppercase();
        match (plain.strip_prefix('+'), statements.last_mut()) {
            (Some(rest), Some((_, before))) => before.push_str(rest),
            _ => statements.push((card, plain)),
        }
    }
    statements
}

/// Adds the heaters of a block of VARIABLES 1 and returns its other lines; none where the block is refused.
pub(super) fn add<'b, 'c>(
    assembly: &mut Assembly,
    block: &'b Block<'c>,
    errors: &mut Vec<DeckError>,
) -> Vec<&'b Card<'c>> {
    if !block.cards.iter().any(|card| handle(card).is_some()) {
        return block.cards.iter().collect();
    }
    let mut others = Vec::new();
    let statements = statements(&block.cards);
    let mut rest = statements.as_slice();
    while let [(card, _), behind @ ..] = rest {
        let Some(handle) = handle(card) else {
            others.push(*card);
            rest = behind;
            continue;
        };
        let mut reading = Reading { rest, handle, assembly: &mut *assembly, line: card.line };
        match reading.heater(block) {
            Ok(()) => rest = reading.rest,
            Err(message) => {
                errors.push(DeckError::at(card.file, reading.line, message));
                return Vec::new();
            }
        }
    }
    others
}

/// Whether a block of VARIABLES 2 only counts what its heaters do.
pub(super) fn is_counting(assembly: &Assembly, block: &Block<'_>) -> bool {
    statements(&block.cards).iter().all(|(_, statement)| {
        assembly.heater_handles.iter().any(|handle| COUNTS.iter().any(|form| form.replace('#', handle) == *statement))
    })
}

/// The handle of a heater that begins at a line `HY343 = 3.`.
fn handle(card: &Card<'_>) -> Option<String> {
    let (name, _) = card.text.split_once('=')?;
    let upper = name.trim().to_ascii_uppercase();
    let handle = upper.strip_prefix("HY")?;
    (!handle.is_empty() && handle.chars().all(|c| c.is_ascii_hexdigit())).then(|| handle.to_owned())
}

struct Reading<'r, 'a, 'b, 'c> {
    rest: &'r [(&'b Card<'c>, String)],
    handle: String,
    assembly: &'a mut Assembly,
    /// The line that is read.
    line: usize,
}

impl Reading<'_, '_, '_, '_> {
    fn next(&mut self) -> Option<String> {
        let ((card, statement), rest) = self.rest.split_first()?;
        self.line = card.line;
        self.rest = rest;
        Some(statement.clone())
    }

    /// What stands behind a form's beginning in the next statement, or nothing where that is the form.
    fn expect(&mut self, form: &str) -> Result<String, String> {
        let form = form.replace('#', &self.handle);
        let statement = self.next().unwrap_or_default();
        let rest = match form.strip_suffix("...") {
            Some(start) => statement.strip_prefix(start),
            None => (statement == form).then_some(""),
        };
        rest.map(str::to_owned).ok_or_else(|| {
            format!(
                "`{statement}` in heater {}: expected `{form}`, as Thermal Desktop writes its heaters; leave the heater out \
                 and add it to `heaters` of the imported model",
                self.handle
            )
        })
    }

    fn number(&self, text: &str) -> Result<f64, String> {
        let quantity = self.assembly.control.quantity(text)?;
        if quantity.is_number() {
            return Ok(quantity.nominal);
        }
        Err(format!("`{text}` in heater {}: expected a number", self.handle))
    }

    /// The node that is sensed: the only one, with weight 1.
    fn sensed(&mut self, submodel: &str) -> Result<(String, i64), String> {
        let text = self.expect("T__TD=...")?;
        let node = text.split_once('*').filter(|(weight, _)| weight.parse() == Ok(1.0)).and_then(|(_, node)| {
            let (of, name) = node.rsplit_once('.').unwrap_or((submodel, node));
            Some((of.to_owned(), integer(name.strip_prefix('T')?).ok()?))
        });
        let node = node.ok_or_else(|| {
            format!(
                "heater {} senses `{text}`: a single node is read; leave the heater out and add it to `heaters` of the \
                 imported model",
                self.handle
            )
        })?;
        self.expect("ST#=T__TD")?;
        Ok(node)
    }

    /// The heated nodes with their shares: statements `SUB.Q1 = SUB.Q1 + PO343 * 1.`, one at least.
    fn heated(&mut self, submodel: &str) -> Result<Vec<Share>, String> {
        let mut heated = Vec::new();
        let power = format!("+PO{}*", self.handle);
        while let Some((_, statement)) = self.rest.first() {
            let Some((target, sum)) = statement.split_once('=') else { break };
            let Some(share) = sum.strip_prefix(target).and_then(|rest| rest.strip_prefix(power.as_str())) else {
                break;
            };
            let (of, name) = target.rsplit_once('.').unwrap_or((submodel, target));
            let Some(number) = name.strip_prefix('Q').and_then(|digits| integer(digits).ok()) else { break };
            heated.push(((of.to_owned(), number), self.number(share)?));
            self.next();
        }
        if heated.is_empty() { self.expect("Q... = Q... + PO# * 1.").map(|_| heated) } else { Ok(heated) }
    }

    fn heater(&mut self, block: &Block<'_>) -> Result<(), String> {
        let comment =
            block.comments.iter().rfind(|comment| comment.line < self.line && comment.text.starts_with("Heater"));
        let label = comment.map_or_else(|| format!("Heater {}", self.handle), |comment| comment.text.to_owned());
        self.next();
        let power = self.expect("PO#=...")?;
        let power = self.number(&power)?;
        self.expect("IF(NSOL.LE.1)THEN")?;
        let senses = self.sensed(&block.submodel)?;
        let mut temperatures = Vec::new();
        let mut heated = Vec::new();
        for form in BEFORE {
            if form == "Q" {
                heated = self.heated(&block.submodel)?;
                continue;
            }
            let rest = self.expect(form)?;
            if matches!(form, "O__TD=..." | "F__TD=...") {
                temperatures.push(self.number(&rest)?);
            }
        }
        self.expect("ELSE")?;
        let again = self.sensed(&block.submodel)?;
        for (form, before) in ["O__TD=...", "F__TD=..."].into_iter().zip(&temperatures) {
            let rest = self.expect(form)?;
            if self.number(&rest)? != *before {
                return Err(format!("heater {} has other temperatures in transients; write one pair", self.handle));
            }
        }
        for form in BEHIND {
            if form == "Q" {
                if self.heated(&block.submodel)? != heated || again != senses {
                    return Err(format!("heater {} heats or senses other nodes in transients", self.handle));
                }
            } else {
                self.expect(form)?;
            }
        }
        self.expect("SF#=F__TD")?;
        let units = self.assembly.control.units;
        let [on, off] = [0, 1].map(|at: usize| units.kelvin(temperatures.get(at).copied().unwrap_or(f64::NAN)));
        if !(on < off) {
            return Err(format!(
                "heater {} switches off at {off} K, not above {on} K, where it switches on",
                self.handle
            ));
        }
        let senses = self.assembly.find_node(&senses)?;
        for (node, share) in heated {
            let into = self.assembly.find_node(&node)?;
            let name = unique(&mut self.assembly.heater_names, label.clone(), "#");
            let power = Value::Number(power * share * units.watt());
            self.assembly.deck.heaters.push(Heater { name, into, senses, power, on_below_k: on, off_above_k: off });
        }
        self.assembly.heater_handles.insert(self.handle.clone());
        Ok(())
    }
}
