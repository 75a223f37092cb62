//! Units, the Stefan-Boltzmann constant and registers of a deck.

use std::collections::HashMap;

use super::block::{Block, Kind};
use super::card::Card;
use super::units::{self, Stated, Units};
use crate::arithmetic::piece::pieces;
use crate::arithmetic::quantity::{Quantity, Reader};
use crate::identifier::Identifiers;
use crate::{DeckError, Note, Parameter};

/// Stefan-Boltzmann constant that Thermal Desktop writes in SI units, in W/(m2 K4).
const THERMAL_DESKTOP_SIGMA: f64 = 5.6704e-8;
/// Absolute zero in degF; decks round it to -460.
const FAHRENHEIT_ZERO: f64 = -459.67;
/// What to write where the units are not stated.
const STATE_UNITS: &str = "state the units in comments at the top, such as `C TDUNITS, Energy = BTU`, `C TDUNITS, Time = hr` \
                           and `C TDUNITS, Temp = F`; in SI units J, s and C or K";

/// What holds for a whole deck.
pub(super) struct Control {
    /// The deck's units.
    pub(super) units: Units,
    /// Whether they are known, so that temperatures mean something.
    pub(super) are_units_known: bool,
    /// What exchange areas are multiplied by to be in m2.
    pub(super) square_metre: f64,
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
        let stated = units::stated(blocks, errors);
        let mut constants: HashMap<String, f64> = HashMap::new();
        let mut control = Self {
            units: Units::SI,
            are_units_known: true,
            square_metre: 1.0,
            stefan_boltzmann: 1.0,
            title: String::new(),
            registers: HashMap::new(),
        };
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
        let first = blocks.first().map_or("", |block| block.file);
        let is_numbered = blocks.iter().any(|block| block.is_numbered);
        match units(&constants, stated, is_numbered) {
            Ok(units) => control.units = units,
            Err(message) => {
                control.are_units_known = false;
                errors.push(DeckError::of(first, message));
            }
        }
        let sigma = match constants.get("SIGMA") {
            Some(&sigma) if sigma > 0.0 => Some(sigma),
            Some(&sigma) => {
                errors.push(DeckError::of(first, format!("SIGMA = {sigma}: expected a number above 0")));
                None
            }
            None => None,
        };
        let units = control.units;
        let (degree, watt) = (units.kelvin_per_degree, units.watt());
        control.stefan_boltzmann = match sigma {
            None if stated.temperature.is_some() && !is_numbered => {
                notes.push(Note::new(format!(
                    "No SIGMA is given: {THERMAL_DESKTOP_SIGMA:e} W/(m2 K4) is assumed, as Thermal Desktop writes it."
                )));
                control.square_metre = units.metre * units.metre;
                THERMAL_DESKTOP_SIGMA
            }
            None => {
                let message = "No SIGMA is given: 1 is assumed, the default, so radiation conductors contain it.";
                notes.push(Note::new(message));
                watt / (degree * degree * degree * degree)
            }
            Some(sigma) => {
                // Where the constant is 1, exchange areas contain it and are none.
                control.square_metre = if sigma == 1.0 { 1.0 } else { units.metre * units.metre };
                sigma * watt / (degree * degree * degree * degree) / control.square_metre
            }
        };
        if units != (Units { zero_k: units.zero_k, ..Units::SI }) {
            notes.push(Note::new(format!(
                "The deck's units are converted: energy {} J, time {} s, length {} m, a degree {} K.",
                units.joule, units.second, units.metre, degree
            )));
        }
        control
    }

    fn add_title(&mut self, card: &Card<'_>) -> Result<(), String> {
        if let Some((word, title)) = card.text.split_once(char::is_whitespace)
            && word.eq_ignore_ascii_case("TITLE")
        {
            self.title = title.trim().to_owned();
        } else if self.title.is_empty()
            && let Some(title) = card.text.strip_prefix("BCD 9")
        {
            self.title = title.trim().to_owned();
        }
        Ok(())
    }

    fn add_constants(&self, card: &Card<'_>, constants: &mut HashMap<String, f64>) -> Result<(), String> {
        for (name, value) in definitions(card.text) {
            match name.as_str() {
                "ABSZRO" | "SIGMA" | "TMPZRO" => {
                    let value = self.quantity(value).map_err(|message| format!("{name}: {message}"))?;
                    constants.insert(name, value.nominal);
                }
                "UID" if !value.eq_ignore_ascii_case("SI") => {
                    constants.insert(name, 1.0);
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

    /// A conductance, a capacity or a heat in SI units.
    pub(super) fn scaled(&self, quantity: Quantity, factor: f64) -> Result<Quantity, String> {
        if factor == 1.0 { Ok(quantity) } else { quantity.join('*', Quantity::number(factor, false)) }
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

/// The units by the constants and by what comments state.
fn units(constants: &HashMap<String, f64>, stated: Stated, is_numbered: bool) -> Result<Units, String> {
    // SINDA/G calls it TMPZRO, with the other sign.
    let absolute_zero = constants.get("ABSZRO").copied().or_else(|| constants.get("TMPZRO").map(|zero| -zero));
    let is_fahrenheit = absolute_zero.is_some_and(|zero| (zero - FAHRENHEIT_ZERO).abs() < 0.5);
    let are_stated = stated.joule.is_some() && stated.second.is_some() && stated.temperature.is_some();
    let is_english = constants.contains_key("UID");
    if (is_fahrenheit || is_numbered || is_english) && !are_stated {
        let what = match (is_fahrenheit, is_english) {
            (true, _) => "temperatures in degF",
            (_, true) => "a UID other than SI",
            _ => "a deck without units",
        };
        return Err(format!("{what}: {STATE_UNITS}"));
    }
    let (kelvin_per_degree, zero_k) = match (absolute_zero, stated.temperature) {
        (Some(zero), Some((degree, expected))) if (zero * degree + expected).abs() > 0.3 => {
            return Err(format!("an absolute zero of {zero} does not go with TDUNITS, whose 0 lies at {expected} K"));
        }
        // What the deck computes with, rounded as it is.
        (Some(zero), Some((degree, _))) if zero != FAHRENHEIT_ZERO => (degree, -zero * degree),
        (_, Some(stated)) => stated,
        (Some(zero), None) => (1.0, -zero),
        (None, None) => {
            return Err(format!(
                "expected ABSZRO in CONTROL DATA: 0 for temperatures in K, -273.15 for degC; give the `.inp`, or {STATE_UNITS}"
            ));
        }
    };
    Ok(Units {
        joule: stated.joule.unwrap_or(1.0),
        second: stated.second.unwrap_or(1.0),
        metre: stated.metre.unwrap_or(1.0),
        kelvin_per_degree,
        zero_k,
    })
}
