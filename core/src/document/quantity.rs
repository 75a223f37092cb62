//! Scalars as written: a number (SI, or in the entry's own unit), an expression, or a value with its unit.
//!
//! They keep their places and are converted to SI by who knows the dimension that is expected, and whether an
//! absolute value or a difference is meant: 20 degC are 293.15 K on a thermometer and 20 K as a standard deviation.

use serde_json::json;

use crate::expression::{Dimension, Unit};

use super::code;
use super::declare::written_struct;
use super::diagnostic::{Diagnostic, Diagnostics};
use super::json::{Node, Value};
use super::schema::Schemas;
use super::source::Place;
use super::written::{Spanned, Written, wrong_type};

/// Whether a value stands on a scale or is a distance on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// A place on the scale: degC has its offset.
    Absolute,
    /// A difference, a standard deviation, a rate: degC means K.
    Difference,
}

/// A unit with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenUnit {
    /// The unit.
    pub unit: Unit,
    /// Where it stands.
    pub place: Place,
}

impl Written for WrittenUnit {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        let Value::String(text) = &node.value else { return wrong_type(node, &Self::expected(), diagnostics) };
        let unit = parse_unit(text, &node.place, 0, diagnostics)?;
        Some(Self { unit, place: node.place.clone() })
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        schemas.define("Unit", |_| {
            json!({
                "type": "string",
                "description": "A product of SI units with prefixes and powers: W/K, W/(m2 K), mW, W/K^1.25; 1, %, degC, min, h, d, bar, mbar, deg, rad, sr.",
                "examples": ["W/K", "W", "degC", "1", "J/K", "m2"],
            })
        })
    }
    fn expected() -> String {
        "a unit such as \"W/K\", \"degC\" or \"1\"".to_owned()
    }
}

/// Parses a unit that stands at byte `offset` of the decoded string at `place` (or of a place that is no string). A coulomb
/// is an error.
pub fn parse_unit(text: &str, place: &Place, offset: usize, diagnostics: &mut Diagnostics) -> Option<Unit> {
    match Unit::parse(text) {
        Ok(unit) => match unit.without_coulomb() {
            None => Some(unit),
            Some(meant) => {
                let place_in_unit =
                    if unit.text == "C" { String::new() } else { format!(" in the unit `{}`", unit.text) };
                let message = format!("`C`{place_in_unit} is the coulomb, not the degree Celsius");
                let help = format!("write `{meant}`; an electric charge is written in `A s`");
                diagnostics
                    .push(Diagnostic::error(&code::COULOMB, place, message).expected(format!("`{meant}`")).help(help));
                // It is read as it was meant, so that no other error follows from it.
                Some(Unit::parse(&meant).unwrap_or(unit))
            }
        },
        Err(error) => {
            let code = if error.unknown { &code::UNKNOWN_UNIT } else { &code::UNIT_SYNTAX };
            let place = place.inside_string(offset + error.start, offset + error.end);
            let mut diagnostic =
                Diagnostic::error(code, &place, error.message).expected("units look like W/K, W/(m2 K), mW, degC, 1");
            diagnostic.help = error.help;
            diagnostics.push(diagnostic);
            None
        }
    }
}

written_struct! {
    /// A number with its unit.
    struct ValueWithUnit: "an object {\"value\": ..., \"unit\": ...}" {
        /// The number, in the unit.
        required value: f64,
        /// The unit.
        required unit: WrittenUnit,
    }
}

/// A known value: a number (SI, or in the entry's own unit), or `{"value": 20, "unit": "degC"}`.
#[derive(Clone, Debug, PartialEq)]
pub struct Amount {
    /// The number as written.
    pub value: f64,
    /// The unit, where one stands beside it.
    pub unit: Option<WrittenUnit>,
    /// Where it stands.
    pub place: Place,
}

impl Amount {
    /// The value in SI. A bare number is in `entry_unit`, or in SI where the entry states no unit of its own.
    /// A unit of another dimension than `expected` is reported.
    pub fn si(
        &self,
        expected: Dimension,
        entry_unit: Option<&Unit>,
        sense: Sense,
        diagnostics: &mut Diagnostics,
    ) -> Option<f64> {
        let unit = match &self.unit {
            Some(written) => {
                if written.unit.dimension != expected {
                    report_dimension(&written.unit, &written.place, expected, diagnostics);
                    return None;
                }
                &written.unit
            }
            None => match entry_unit {
                Some(unit) => unit,
                None => return Some(self.value),
            },
        };
        let value = match sense {
            Sense::Absolute => unit.to_si(self.value),
            Sense::Difference => unit.difference_to_si(self.value),
        };
        if !value.is_finite() {
            let message = format!("{} {} is beyond the range of a float in SI", self.value, unit.text);
            diagnostics.push(Diagnostic::error(&code::NUMBER_RANGE, &self.place, message));
            return None;
        }
        Some(value)
    }
}

/// Reports a unit of the wrong dimension.
pub fn report_dimension(unit: &Unit, place: &Place, expected: Dimension, diagnostics: &mut Diagnostics) {
    let message = match unit.dimension.to_string() {
        same if same == unit.text => format!("the unit `{same}` does not fit here"),
        si => format!("the unit `{}` does not fit here: in SI it is {si}", unit.text),
    };
    diagnostics
        .push(Diagnostic::error(&code::WRONG_DIMENSION, place, message).expected(format!("a unit of {expected}")));
}

impl Written for Amount {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Number(n) => Some(Self { value: n.as_f64(), unit: None, place: node.place.clone() }),
            Value::Object(_) => {
                let ValueWithUnit { value, unit } = ValueWithUnit::read(node, diagnostics)?;
                Some(Self { value, unit: Some(unit), place: node.place.clone() })
            }
            Value::String(_) => {
                diagnostics.push(
                    Diagnostic::error(
                        &code::NEEDS_NUMBER,
                        &node.place,
                        "a string cannot stand here: the value must be known",
                    )
                    .expected(Self::expected()),
                );
                None
            }
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [{"type": "number"}, ValueWithUnit::schema(schemas)]})
    }
    fn expected() -> String {
        "a number, or {\"value\": 20, \"unit\": \"degC\"}".to_owned()
    }
}

/// A part of a model: a known value, or an expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Scalar {
    /// A known value.
    Amount(Amount),
    /// An expression, SI throughout.
    Expression(Spanned<String>),
}

impl Scalar {
    /// Where it stands.
    pub fn place(&self) -> &Place {
        match self {
            Self::Amount(amount) => &amount.place,
            Self::Expression(text) => &text.place,
        }
    }
}

impl Written for Scalar {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::String(_) => Spanned::read(node, diagnostics).map(Self::Expression),
            Value::Number(_) | Value::Object(_) => Amount::read(node, diagnostics).map(Self::Amount),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        schemas.define("Scalar", |schemas| {
            json!({
                "description": "A number in SI units, an expression in SI units, or a value with its unit.",
                "anyOf": [{"type": "number"}, {"type": "string"}, ValueWithUnit::schema(schemas)],
            })
        })
    }
    fn expected() -> String {
        "a number, an expression, or {\"value\": 20, \"unit\": \"degC\"}".to_owned()
    }
}
