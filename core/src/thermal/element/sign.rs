//! Signs that values of elements must have: a conductance below 0 would move heat uphill.

use crate::expression::ExprId;

/// Conductance of a conductor.
pub const CONDUCTANCE: &str = "conductance";
/// Exchange area of a radiation.
pub const EXCHANGE_AREA: &str = "exchange area";
/// Resistance of a cooler's couple.
pub const COUPLE_RESISTANCE: &str = "couple's resistance";
/// Conductance of a cooler's couple.
pub const COUPLE_CONDUCTANCE: &str = "couple's conductance";
/// Couples of a cooler's stage.
pub const COUPLES: &str = "number of couples";
/// Resistance of a cooler's leads.
pub const LEADS: &str = "leads' resistance";

/// A value of an element that must not be below 0, or must be above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignConstraint {
    /// What it is: [`CONDUCTANCE`], ...
    pub what: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// The value.
    pub value: ExprId,
    /// Whether 0 is too small.
    pub above_zero: bool,
}

impl SignConstraint {
    /// Of a value that may be 0.
    pub fn at_least_zero(what: &'static str, unit: &'static str, value: ExprId) -> Self {
        Self { what, unit, value, above_zero: false }
    }

    /// Of a value that may not.
    pub fn above_zero(what: &'static str, unit: &'static str, value: ExprId) -> Self {
        Self { what, unit, value, above_zero: true }
    }

    /// Whether the value breaks it. What is not a number is another fault.
    pub fn is_broken_by(&self, value: f64) -> bool {
        value < 0.0 || (self.above_zero && value == 0.0)
    }
}
