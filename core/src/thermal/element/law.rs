//! Values of elements that have a sign: a conductance below 0 would move heat uphill.

use crate::expression::ExprId;

use super::{Element, ElementKind};

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

/// A value of an element that has a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// What it is: [`CONDUCTANCE`], ...
    pub what: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// The value.
    pub value: ExprId,
    /// Whether 0 is too small.
    pub above_zero: bool,
}

impl Law {
    /// Whether the value breaks it. What is not a number is another fault.
    pub fn is_broken_by(&self, value: f64) -> bool {
        value < 0.0 || (self.above_zero && value == 0.0)
    }
}

impl Element {
    /// The element's values that have a sign. Heats have a direction instead.
    pub fn laws(&self) -> Vec<Law> {
        let law = |what, unit, value, above_zero| Law { what, unit, value, above_zero };
        match &self.kind {
            ElementKind::Conductor(own) => vec![law(CONDUCTANCE, "W/K", own.conductance, false)],
            ElementKind::Radiation(own) => vec![law(EXCHANGE_AREA, "m2", own.exchange_area, false)],
            ElementKind::Cooler(own) => {
                let mut laws = vec![
                    law(COUPLE_RESISTANCE, "ohm", own.resistance, true),
                    law(COUPLE_CONDUCTANCE, "W/K", own.conductance, true),
                    law(LEADS, "ohm", own.lead_resistance, false),
                ];
                laws.extend(own.couples.iter().map(|&couples| law(COUPLES, "", couples, true)));
                laws
            }
            ElementKind::Load(_) | ElementKind::Flow(_) | ElementKind::Heater(_) => Vec::new(),
        }
    }
}
