//! Units, the Stefan-Boltzmann constant and registers of a deck.

use std::collections::HashMap;

use super::block::{Block, Kind};
use super::card::Card;
use crate::arithmetic::piece::pieces;
use crate::arithmetic::quantity::{Quantity, Reader};
use crate::identifier::Identifiers;
use crate::{CELSIUS_ZERO_K, DeckError, Note, Parameter};

/// Stefan-Boltzmann constant that Thermal Desktop writes in SI units, in W/(m2 K4).
const THERMAL_DESKTOP_SIGMA: f64 = 5.6704e-8;
/// Absolute zero in degF; decks round it to -460.
const FAHRENHEIT_ZERO: f64 = -459.67;
/// Units of Thermal Desktop, by their names in the heading, that are read.
const SI: [(&str, &str); 4] = [("ENERGY", "J"), ("TIME", "s"), ("MASS", "kg"), ("LENGTH", "m")];

/// What holds for a whole deck.
pub(super) struct Control {
    /// What is added to the deck's temperatures, in K.
    pub(super) zero_k: f64,
    /// The deck's Stefan-Boltzmann constant in W/(m2 K4).
    pub(super) stefan_boltzmann: f64,
    /// The deck's title.
    pub(super) title: String,
    /// Registers by their names in capitals.
    registers: HashMap<String, Quantity>,
}

impl Control {
    /// Reads headings, CONTROL DATA and REGISTER DATA.
    pub(super) fn read(
        blocks: &[Block<'_>],
        identifiers: &mut Identifiers,
        parameters: &mut Vec<Parameter>,
        notes: &mut Vec<Note>,
        errors: &mut Vec<DeckError>,
    ) -> Self {
        let temperature = thermal_desktop_units(blocks, errors);
        let mut constants: HashMap<String, f64> = HashMap::new();
        let mut control = Self { zero_k: 0.0, stefan_boltzmann: 1.0, title: String::new(), registers: HashMap::new() };
        for block in blocks {
            for card in &block.cards {
                let done = match block.kind {
                    Kind::Options => control.add_title(card),
                    Kind::Control => control.add_constants(card, &mut constants),
                    Kind::Registers => control.add_registers(card, identifiers, parameters),
                    _ => Ok(()),
                };
                if let Err(message) = done {
                    errors.push(DeckError::at(card.file, card.line, message));
                }
            }
        }
        let mut note = |message: String| notes.push(Note::new(message));
        let first = blocks.first().map_or("", |block| block.file);
        control.zero_k = match (constants.get("ABSZRO"), temperature) {
            (Some(&zero), _) if (zero - FAHRENHEIT_ZERO).abs() < 0.5 => {
                errors.push(DeckError::of(first, "temperatures in degF: write the deck in SI units, K or degC"));
                0.0
            }
            (Some(&zero), Some(expected)) if (zero + expected).abs() > 0.01 => {
                let message = format!("ABSZRO = {zero} does not go with TDUNITS, whose 0 lies at {expected} K");
                errors.push(DeckError::of(first, message));
                0.0
            }
            (Some(&zero), _) => -zero,
            (None, Some(zero)) => zero,
            (None, None) => {
                let message =
                    "expected ABSZRO in CONTROL DATA: 0 for temperatures in K, -273.15 for degC; give the `.inp`";
                errors.push(DeckError::of(first, message));
                0.0
            }
        };
        control.stefan_boltzmann = match constants.get("SIGMA") {
            Some(&sigma) if sigma > 0.0 => sigma,
            Some(&sigma) => {
                errors.push(DeckError::of(first, format!("SIGMA = {sigma}: expected a number above 0")));
                1.0
            }
            None if temperature.is_some() => {
                note(format!(
                    "No SIGMA is given: {THERMAL_DESKTOP_SIGMA:e} W/(m2 K4) is assumed, as Thermal Desktop writes it."
                ));
                THERMAL_DESKTOP_SIGMA
            }
            None => {
                note("No SIGMA is given: 1 is assumed, the default, so radiation conductors contain it.".to_owned());
                1.0
            }
        };
        control
    }

    fn add_title(&mut self, card: &Card<'_>) -> Result<(), String> {
        if let Some((word, title)) = card.text.split_once(char::is_whitespace)
            && word.eq_ignore_ascii_case("TITLE")
        {
            self.title = title.trim().to_owned();
        }
        Ok(())
    }

    fn add_constants(&self, card: &Card<'_>, constants: &mut HashMap<String, f64>) -> Result<(), String> {
        for (name, value) in definitions(card.text) {
            match name.as_str() {
                "ABSZRO" | "SIGMA" => {
                    let value = self.quantity(value).map_err(|message| format!("{name}: {message}"))?;
                    constants.insert(name, value.nominal);
                }
                "UID" if !value.eq_ignore_ascii_case("SI") => {
                    return Err(format!("UID = {value}: decks in SI units are read; write it out with UID = SI"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn add_registers(
        &mut self,
        card: &Card<'_>,
        identifiers: &mut Identifiers,
        parameters: &mut Vec<Parameter>,
    ) -> Result<(), String> {
        for (name, value) in definitions(card.text) {
            let name = name.strip_prefix("INT:").or(name.strip_prefix("DP:")).unwrap_or(&name).trim().to_owned();
            let quantity = self.quantity(value).map_err(|message| format!("register {name}: {message}"))?;
            let quantity = if quantity.is_number() {
                let parameter = identifiers.make(&name);
                let nominal = quantity.nominal;
                let description = format!("Register {name}");
                parameters.push(Parameter { name: parameter.clone(), unit: "1".to_owned(), nominal, description });
                Quantity::constant(&parameter, nominal)
            } else {
                quantity
            };
            if self.registers.insert(name.clone(), quantity).is_some() {
                return Err(format!("register {name} is defined twice"));
            }
        }
        Ok(())
    }

    /// A number or an expression of registers.
    pub(super) fn quantity(&self, text: &str) -> Result<Quantity, String> {
        let pieces = pieces(text)?;
        let register = |name: &str| {
            let quantity = self.registers.get(&name.to_ascii_uppercase()).cloned();
            quantity.ok_or_else(|| format!("`{name}` is no register that was defined before; write a number"))
        };
        let mut reader = Reader::new(&pieces, &register);
        let quantity = reader.quantity()?;
        reader.end("the end of the value")?;
        Ok(quantity)
    }
}

/// `name = value` of a line, names in capitals.
fn definitions(text: &str) -> Vec<(String, &str)> {
    let parts = text.split(',').filter_map(|part| part.split_once('='));
    parts.map(|(name, value)| (name.trim().to_ascii_uppercase(), value.trim())).collect()
}

/// The temperature of 0 in K by Thermal Desktop's heading, if it has one; other units must be SI.
fn thermal_desktop_units(blocks: &[Block<'_>], errors: &mut Vec<DeckError>) -> Option<f64> {
    let mut zero_k = None;
    for (block, comment) in blocks.iter().flat_map(|block| block.comments.iter().map(move |comment| (block, comment))) {
        let Some(unit) = comment.text.strip_prefix("TDUNITS,") else { continue };
        let Some((name, unit)) = unit.split_once('=') else { continue };
        let (name, unit) = (name.trim().to_ascii_uppercase(), unit.trim());
        let mut fail = |message: String| errors.push(DeckError::at(block.file, comment.line, message));
        if name == "TEMP" {
            match unit {
                "K" => zero_k = Some(0.0),
                "C" => zero_k = Some(CELSIUS_ZERO_K),
                _ => fail(format!("temperatures in {unit}: write the deck in K or C")),
            }
        } else if let Some((_, expected)) = SI.iter().find(|(other, _)| *other == name)
            && unit != *expected
        {
            fail(format!("{} in {unit}: write the deck in SI units, {expected}", name.to_ascii_lowercase()));
        }
    }
    zero_k
}
